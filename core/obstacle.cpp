#include "core/obstacle.h"

#include <algorithm>
#include <cmath>

namespace wick {

namespace {

DistanceSample sample(const SphereShape& sphere, const Vec3& x) {
  const Vec3 d = x - sphere.center;
  const double length = d.norm();
  // At the exact centre every direction is outward; up is as good as any.
  return {length - sphere.radius, length > 0.0 ? Vec3(d / length) : Vec3(0, 0, 1)};
}

DistanceSample sample(const BoxShape& box, const Vec3& x) {
  const Vec3 center = 0.5 * (box.lower + box.upper);
  const Vec3 half = 0.5 * (box.upper - box.lower);
  const Vec3 local = x - center;
  const Vec3 excess = local.cwiseAbs() - half;
  const Vec3 sign = local.unaryExpr([](double c) { return c < 0.0 ? -1.0 : 1.0; });
  int axis = 0;
  const double deepest = excess.maxCoeff(&axis);
  if (deepest <= 0.0) return {deepest, Vec3(Vec3::Unit(axis) * sign[axis])};
  const Vec3 outside = excess.cwiseMax(0.0);
  const double distance = outside.norm();
  return {distance, Vec3(outside.cwiseProduct(sign) / distance)};
}

DistanceSample sample(const PlaneShape& plane, const Vec3& x) {
  return {(x - plane.point).dot(plane.normal), plane.normal};
}

DistanceSample sample(const SampledShape& grid, const Vec3& x) {
  Vec3 t = (x - grid.origin) / grid.spacing;
  const Vec3 top(grid.nodes[0] - 1, grid.nodes[1] - 1, grid.nodes[2] - 1);
  const Vec3 inside = t.cwiseMax(0.0).cwiseMin(top);
  const Vec3 excess = (t - inside) * grid.spacing;
  int base[3];
  double f[3];
  for (int a = 0; a < 3; ++a) {
    base[a] = std::clamp(static_cast<int>(inside[a]), 0, std::max(grid.nodes[a] - 2, 0));
    f[a] = inside[a] - base[a];
  }
  const auto node = [&](int i, int j, int k) {
    const std::size_t index =
        (base[0] + i) + std::size_t(grid.nodes[0]) * ((base[1] + j) + std::size_t(grid.nodes[1]) * (base[2] + k));
    return static_cast<double>(grid.distance[index]);
  };
  double value = 0.0;
  Vec3 gradient = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const int c[3] = {corner & 1, (corner >> 1) & 1, corner >> 2};
    double weight[3], slope[3];
    for (int a = 0; a < 3; ++a) {
      weight[a] = c[a] ? f[a] : 1.0 - f[a];
      slope[a] = c[a] ? 1.0 : -1.0;
    }
    const double v = node(c[0], c[1], c[2]);
    value += weight[0] * weight[1] * weight[2] * v;
    gradient += v * Vec3(slope[0] * weight[1] * weight[2], weight[0] * slope[1] * weight[2],
                         weight[0] * weight[1] * slope[2]);
  }
  const double out = excess.norm();
  if (out > 0.0) return {value + out, Vec3(excess / out)};
  const double length = gradient.norm();
  return {value, length > 0.0 ? Vec3(gradient / length) : Vec3(0, 0, 1)};
}

bool meets(const SphereShape& sphere, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  const double nearest = square > 0.0 ? std::clamp((sphere.center - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (a + nearest * along - sphere.center).norm() < sphere.radius;
}

bool meets(const BoxShape& box, const Vec3& a, const Vec3& b) {
  double enter = 0.0, leave = 1.0;  // share of the way within all slabs so far
  for (int axis = 0; axis < 3; ++axis) {
    const double way = b[axis] - a[axis];
    double low = box.lower[axis] - a[axis], high = box.upper[axis] - a[axis];
    if (way == 0.0) {
      if (low >= 0.0 || high <= 0.0) return false;
      continue;
    }
    if (way < 0.0) std::swap(low, high);
    enter = std::max(enter, low / way);
    leave = std::min(leave, high / way);
  }
  return enter < leave || (enter == leave && sample(box, a + enter * (b - a)).distance < 0.0);
}

bool meets(const PlaneShape& plane, const Vec3& a, const Vec3& b) {
  return std::min(sample(plane, a).distance, sample(plane, b).distance) < 0.0;
}

bool meets(const SampledShape& grid, const Vec3& a, const Vec3& b) {
  const double length = (b - a).norm(), least = 0.25 * grid.spacing;
  const Vec3 top = grid.origin + grid.spacing * Vec3(grid.nodes[0] - 1, grid.nodes[1] - 1, grid.nodes[2] - 1);
  for (double way = 0.0;;) {
    const Vec3 x = length > 0.0 ? Vec3(a + way / length * (b - a)) : a;
    const double distance = sample(grid, x).distance;
    if (distance < 0.0) return true;
    if (way >= length) return false;
    // Beyond the samples the value is no lower bound; the distance to their box and what that leaves of it are.
    const double out = (x - x.cwiseMax(grid.origin).cwiseMin(top)).norm();
    way = std::min(length, way + std::max(least, out > 0.0 ? std::max(out, distance - 2.0 * out) : distance));
  }
}

}  // namespace

Mat3 Obstacle::turn_in(double dt) const {
  const double rate = spin.norm();
  return rate > 0.0 ? Eigen::AngleAxisd(rate * dt, spin / rate).toRotationMatrix() : Mat3(Mat3::Identity());
}

Vec3 Obstacle::rewound(const Vec3& x, double dt) const {
  const Vec3 shifted = x - dt * velocity;
  return spin.isZero(0.0) ? shifted : Vec3(turn_in(dt).transpose() * (shifted - pivot) + pivot);
}

void Obstacle::advance(double dt) {
  const Mat3 turn = turn_in(dt);
  pose.shift = turn * (pose.shift - pivot) + pivot + dt * velocity;
  pose.turn = turn * pose.turn;
  pivot += dt * velocity;
}

DistanceSample sample_distance(const Obstacle& obstacle, const Vec3& x) {
  const Vec3 local = obstacle.pose.body(x);
  DistanceSample found = std::visit([&](const auto& shape) { return sample(shape, local); }, obstacle.shape);
  found.gradient = obstacle.pose.turn * found.gradient;
  return found;
}

bool segment_meets(const Obstacle& obstacle, const Vec3& a, const Vec3& b) {
  const Vec3 from = obstacle.pose.body(a), to = obstacle.pose.body(b);
  return std::visit([&](const auto& shape) { return meets(shape, from, to); }, obstacle.shape);
}

}  // namespace wick
