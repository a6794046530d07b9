#include "solid/proximity.h"

#include <algorithm>
#include <cmath>

namespace wick::solid {

namespace {

/// Directions are parallel up to rounding if the square of their sine is below this.
constexpr double kParallel = 1e-10;

/// Share in [0, 1] of the way from a to b at which it is closest to p.
double share_towards(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const double length2 = way.squaredNorm();
  return length2 > 0.0 ? std::clamp(way.dot(p - a) / length2, 0.0, 1.0) : 0.0;
}

/// Shares of two edges at their closest points.
struct EdgeShares {
  double first, second;
};

/// Of parallel edges an end is closest.
EdgeShares closest_by_an_end(const std::array<Vec3, 4>& x) {
  EdgeShares best{};
  double least = INFINITY;
  const auto take = [&](double s, double t) {
    const double d2 = (x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])).squaredNorm();
    if (d2 < least) best = {s, t}, least = d2;
  };
  take(0.0, share_towards(x[0], x[2], x[3]));
  take(1.0, share_towards(x[1], x[2], x[3]));
  take(share_towards(x[2], x[0], x[1]), 0.0);
  take(share_towards(x[3], x[0], x[1]), 1.0);
  return best;
}

/// The lines meet their common normal where two linear equations hold; where that is beyond an end of an edge, the
/// end takes its place [Ericson 2005, 5.1.9].
EdgeShares closest_of_edges(const std::array<Vec3, 4>& x) {
  const Vec3 u = x[1] - x[0], v = x[3] - x[2], r = x[0] - x[2];
  const double a = u.squaredNorm(), e = v.squaredNorm(), b = u.dot(v), c = u.dot(r), f = v.dot(r);
  const double denominator = a * e - b * b;
  if (!(denominator > kParallel * a * e)) return closest_by_an_end(x);
  const double s = std::clamp((b * f - c * e) / denominator, 0.0, 1.0), t = (b * s + f) / e;
  if (t < 0.0) return {std::clamp(-c / a, 0.0, 1.0), 0.0};
  if (t > 1.0) return {std::clamp((b - c) / a, 0.0, 1.0), 1.0};
  return {s, t};
}

/// Of a triangle that is a line or a point, up to rounding.
std::array<double, 3> closest_on_rim(const std::array<Vec3, 3>& corner, const Vec3& p) {
  std::array<double, 3> best{};
  double least = INFINITY;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const double share = share_towards(p, corner[k], corner[next]);
    const double d2 = (corner[k] + share * (corner[next] - corner[k]) - p).squaredNorm();
    if (!(d2 < least)) continue;
    least = d2;
    best = {};
    best[k] = 1.0 - share;
    best[next] = share;
  }
  return best;
}

}  // namespace

std::array<double, 3> closest_weights(const std::array<Vec3, 3>& corner, const Vec3& p) {
  const Vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0];
  if (!(ab.cross(ac).squaredNorm() > kParallel * ab.squaredNorm() * ac.squaredNorm()))
    return closest_on_rim(corner, p);
  const Vec3 ap = p - corner[0], bp = p - corner[1], cp = p - corner[2];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    const double t = d1 / (d1 - d3);
    return {1.0 - t, t, 0.0};
  }
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    const double t = d2 / (d2 - d6);
    return {1.0 - t, 0.0, t};
  }
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0.0, 1.0 - t, t};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

Separation closest(FeaturePair kind, const std::array<Vec3, 4>& x) {
  Separation s;
  if (kind == FeaturePair::vertex_triangle) {
    const std::array<double, 3> w = closest_weights({x[1], x[2], x[3]}, x[0]);
    s.weight = {1.0, -w[0], -w[1], -w[2]};
  } else {
    const EdgeShares share = closest_of_edges(x);
    s.weight = {1.0 - share.first, share.first, share.second - 1.0, -share.second};
  }
  // Differences first: far from the origin the products would lose the digits of a small distance.
  const Vec3 way = s.weight[1] * (x[1] - x[0]) + s.weight[2] * (x[2] - x[0]) + s.weight[3] * (x[3] - x[0]);
  s.distance = way.norm();
  s.direction = s.distance > 0.0 ? Vec3(way / s.distance) : Vec3::Zero();
  return s;
}

double gap_along(FeaturePair kind, const std::array<Vec3, 4>& x, const Vec3& direction) {
  double low = 0.0, high = -INFINITY;
  for (int k = 1; k < 4; ++k) {
    const double height = direction.dot(x[k] - x[0]);
    if (k < first_count(kind))
      low = std::min(low, height);
    else
      high = std::max(high, height);
  }
  return low - high;
}

bool stay_apart(FeaturePair kind, const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to, double least) {
  constexpr int kMostSteps = 64;
  constexpr double kNear = 1.05;  // of `least`: nearer is too near, so that steps do not shrink for ever
  std::array<Vec3, 4> way;
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < 4; ++k) mean += 0.25 * (to[k] - from[k]);
  double fastest[2] = {0.0, 0.0};
  for (int k = 0; k < 4; ++k) {
    way[k] = to[k] - from[k] - mean;
    double& side = fastest[k < first_count(kind) ? 0 : 1];
    side = std::max(side, way[k].norm());
  }
  const double speed = fastest[0] + fastest[1];
  double t = 0.0;
  for (int n = 0; n < kMostSteps; ++n) {
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) x[k] = from[k] + t * way[k];
    const double distance = closest(kind, x).distance;
    if (distance < kNear * least) return false;
    if (!(speed * (1.0 - t) > distance - least)) return true;
    t += (distance - least) / speed;
  }
  return false;
}

}  // namespace wick::solid
