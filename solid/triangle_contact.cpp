#include "solid/triangle_contact.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "solid/contact.h"
#include "solid/proximity.h"

namespace wick::solid {

namespace {

constexpr std::size_t kGrain = 1024;  ///< triangles that one thread takes at a time
constexpr double kTolerance = 1e-3;   ///< of the offset: contact is as good as this

Vec3 vector(const Row& r) {
  return {r.x, r.y, r.z};
}
void set(Row& r, const Vec3& v) {
  r.x = v.x(), r.y = v.y(), r.z = v.z();
}

Vec3 point_of(const std::array<Vec3, 3>& corner, const std::array<double, 3>& weight) {
  return weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2];
}

/// Takes the point of the triangle at `weight` if it is deeper than the deepest so far.
void take_deeper(const Obstacle& obstacle, const std::array<Vec3, 3>& corner, const std::array<double, 3>& weight,
                 DeepestPoint& best) {
  const double distance = sample_distance(obstacle, point_of(corner, weight)).distance;
  if (distance < best.distance) best = {weight, distance};
}

/// `from` moved towards corner k by the share in [0, 1] at which the slope of the distance changes its sign, if it
/// is downwards at `from`; `from` itself otherwise.
std::array<double, 3> walk_towards(int k, const Obstacle& obstacle, const std::array<Vec3, 3>& corner,
                                   const std::array<double, 3>& from) {
  constexpr int kHalvings = 12;  // the share to a four-thousandth
  const Vec3 begin = point_of(corner, from), way = corner[k] - begin;
  const auto downwards = [&](double share) {
    return sample_distance(obstacle, begin + share * way).gradient.dot(way) < 0.0;
  };
  double low = 0.0, high = 1.0;
  if (!downwards(low)) return from;
  if (downwards(high)) low = high;
  for (int n = 0; n < kHalvings && low < high; ++n) {
    const double share = 0.5 * (low + high);
    (downwards(share) ? low : high) = share;
  }
  const double share = 0.5 * (low + high);
  std::array<double, 3> weight;
  for (int c = 0; c < 3; ++c) weight[c] = (1.0 - share) * from[c] + (c == k ? share : 0.0);
  return weight;
}

/// Corners of the triangle against the obstacle's faces, its edges against the obstacle's edges, and its face
/// against the obstacle's corners: where a convex obstacle that has not gone through yet is deepest, one of them
/// is.
DeepestPoint deepest_feature(const Obstacle& obstacle, const std::array<Vec3, 3>& corner) {
  DeepestPoint best = {{1.0, 0.0, 0.0}, INFINITY};
  constexpr std::array<std::array<double, 3>, 3> at = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  for (const auto& weight : at) take_deeper(obstacle, corner, weight, best);
  for (int k = 0; k < 3; ++k)
    take_deeper(obstacle, corner, walk_towards((k + 1) % 3, obstacle, corner, at[k]), best);
  take_deeper(obstacle, corner, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, best);
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape))
    for (int n = 0; n < 8; ++n) {
      const Vec3 tip((n & 1 ? box->upper : box->lower).x(), (n & 2 ? box->upper : box->lower).y(),
                     (n & 4 ? box->upper : box->lower).z());
      take_deeper(obstacle, corner, closest_weights(corner, obstacle.pose.place(tip)), best);
    }
  return best;
}

/// Goes down from the deepest feature: peaks of a sampled shape have no corners to ask for.
DeepestPoint descend(const Obstacle& obstacle, const std::array<Vec3, 3>& corner) {
  constexpr int kRounds = 4;
  DeepestPoint best = deepest_feature(obstacle, corner);
  for (int round = 0; round < kRounds; ++round) {
    const DeepestPoint from = best;
    const Vec3 p = point_of(corner, from.weight), slope = sample_distance(obstacle, p).gradient;
    int down = 0;
    for (int k = 1; k < 3; ++k)
      if (slope.dot(corner[k]) < slope.dot(corner[down])) down = k;
    if (!(slope.dot(corner[down] - p) < 0.0)) break;
    take_deeper(obstacle, corner, walk_towards(down, obstacle, corner, from.weight), best);
    if (!(best.distance < from.distance)) break;
  }
  return best;
}

/// A lower bound of the distance over the triangle, from the planes that touch a convex distance at the corners; of
/// a sphere the least distance itself.
double least_distance(const Obstacle& obstacle, const std::array<Vec3, 3>& corner) {
  if (std::holds_alternative<SphereShape>(obstacle.shape)) return deepest_point(obstacle, corner).distance;
  double bound = -INFINITY;
  for (int i = 0; i < 3; ++i) {
    const DistanceSample s = sample_distance(obstacle, corner[i]);
    double least = s.distance;
    for (int j = 0; j < 3; ++j) least = std::min(least, s.distance + s.gradient.dot(corner[j] - corner[i]));
    bound = std::max(bound, least);
  }
  return bound;
}

/// The first point of a moving triangle that comes to `offset` from the obstacle, by steps that the nearest
/// distance allows; the deepest point at the end where none does.
DeepestPoint first_touch(const Obstacle& obstacle, double offset, const std::array<Vec3, 3>& from,
                         const std::array<Vec3, 3>& to) {
  constexpr double kLeastStep = 1.0 / 32.0;
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, (to[k] - from[k]).norm());
  for (double t = 0.0; t < 1.0;) {
    std::array<Vec3, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = from[k] + t * (to[k] - from[k]);
    double room = least_distance(obstacle, corner) - offset;
    if (room <= kTolerance * offset) {
      const DeepestPoint p = deepest_point(obstacle, corner);
      room = p.distance - offset;
      if (room <= kTolerance * offset) return p;
    }
    t += std::max(room / (steepest_slope(obstacle) * longest), kLeastStep);
  }
  return deepest_point(obstacle, to);
}

/// How far a triangle with edges of `edge` can sink between its corners.
bool reaches_between(const Obstacle& obstacle, double edge, double offset) {
  if (std::holds_alternative<PlaneShape>(obstacle.shape)) return false;
  // An equilateral triangle whose corners lie on a sphere sinks in by e²/(6 R): a quarter of the thickness goes
  // unseen.
  if (const auto* sphere = std::get_if<SphereShape>(&obstacle.shape))
    return edge * edge > 6.0 * offset * sphere->radius;
  return true;
}

}  // namespace

DeepestPoint deepest_point(const Obstacle& obstacle, const std::array<Vec3, 3>& corner) {
  const auto* sphere = std::get_if<SphereShape>(&obstacle.shape);
  if (sphere == nullptr) return descend(obstacle, corner);
  const std::array<double, 3> weight = closest_weights(corner, obstacle.pose.place(sphere->center));
  return {weight, sample_distance(obstacle, point_of(corner, weight)).distance};
}

TriangleContact::TriangleContact(const ShellMesh& mesh, double offset)
    : triangles_(mesh.triangles), offset_(offset), clearance_(mesh.triangle_count()) {
  for (const double l : mesh.rest_length) longest_edge_ = std::max(longest_edge_, l);
  found_.resize((triangles_.size() + kGrain - 1) / kGrain);
}

void TriangleContact::begin_step(const std::vector<Obstacle>& obstacles) {
  obstacles_.clear();
  steepest_ = 1.0;
  for (const Obstacle& o : obstacles) {
    if (!reaches_between(o, longest_edge_, offset_)) continue;
    obstacles_.push_back(&o);
    steepest_ = std::max(steepest_, steepest_slope(o));
  }
  std::fill(clearance_.begin(), clearance_.end(), 0.0);
}

void TriangleContact::find(std::size_t triangle, double start, double h, const std::vector<Row>& position,
                           const std::vector<Row>& previous, std::vector<Touch>& found) {
  const Int3& v = triangles_[triangle];
  std::array<Vec3, 3> x;
  for (int k = 0; k < 3; ++k) x[k] = vector(position[v[k]]);
  const Vec3 center = (x[0] + x[1] + x[2]) / 3.0;
  double radius = 0.0, way = 0.0, nearest = INFINITY;
  for (int k = 0; k < 3; ++k) {
    radius = std::max(radius, (x[k] - center).norm());
    way = std::max(way, (x[k] - vector(previous[v[k]])).norm());
  }
  double fastest = 0.0;
  for (const Obstacle* o : obstacles_) fastest = std::max(fastest, o->speed_at(center) + o->spin.norm() * radius);
  way += h * fastest;
  const bool fast = way > offset_;
  for (const Obstacle* o : obstacles_) {
    const double slope = steepest_slope(*o), end = start + h;
    // Less than the nearest distance of the triangle, and then the more costly bounds.
    double room = sample_distance(*o, o->rewound(center, end)).distance - slope * radius - offset_;
    if (room <= (fast ? slope * way : 0.0)) {
      std::array<Vec3, 3> from, to;
      for (int k = 0; k < 3; ++k) {
        from[k] = o->rewound(vector(previous[v[k]]), start);
        to[k] = o->rewound(x[k], end);
      }
      room = std::max(room, least_distance(*o, to) - offset_);
      // Corners that rest on a plane, or on a surface that is nearly one, keep the whole triangle out.
      if (fast || room < -kTolerance * offset_) {
        const DeepestPoint p = fast ? first_touch(*o, offset_, from, to) : deepest_point(*o, to);
        if (fast || p.distance < offset_ * (1.0 - kTolerance))
          found.push_back({static_cast<std::int32_t>(triangle), o, p.weight});
      }
    }
    nearest = std::min(nearest, room);
  }
  clearance_[triangle] = nearest;
}

/// x_k += w_k b_k/(Σ w b²) Δp: the point at b moves by Δp, with the least kinetic energy. False if it is not in
/// contact.
bool TriangleContact::push_point(const Touch& touch, double start, double h, std::vector<Row>& position,
                                 std::vector<Row>& previous) const {
  const Int3& v = triangles_[touch.triangle];
  Vec3 p = Vec3::Zero(), old = Vec3::Zero();
  double mobility = 0.0;
  for (int k = 0; k < 3; ++k) {
    // A held corner is a lever: beside it the others would be thrown by many times the depth.
    if (!(position[v[k]].w > 0.0)) return false;
    p += touch.weight[k] * vector(position[v[k]]);
    old += touch.weight[k] * vector(previous[v[k]]);
    mobility += position[v[k]].w * touch.weight[k] * touch.weight[k];
  }
  if (!(mobility > 0.0)) return false;
  const Vec3 p_found = p, old_found = old;
  if (resolve_contact(*touch.obstacle, start, h, offset_, p, old) > 0.0) return false;
  for (int k = 0; k < 3; ++k) {
    const double share = position[v[k]].w * touch.weight[k] / mobility;
    if (!(share > 0.0)) continue;
    Vec3 x = vector(position[v[k]]) + share * (p - p_found),
         origin = vector(previous[v[k]]) + share * (old - old_found);
    resolve_contact(*touch.obstacle, start, h, offset_, x, origin);
    set(position[v[k]], x);
    set(previous[v[k]], origin);
  }
  return true;
}

std::size_t TriangleContact::push_out(Touch touch, double start, double h, std::vector<Row>& position,
                                      std::vector<Row>& previous, std::vector<Row>& velocity,
                                      std::vector<std::uint8_t>& touched) const {
  // A triangle pushed at one point turns about it, and another point may then be the deepest.
  constexpr int kRounds = 4;
  const Int3& v = triangles_[touch.triangle];
  for (int round = 0; round < kRounds; ++round) {
    if (!push_point(touch, start, h, position, previous)) {
      if (round == 0) return 0;
      break;
    }
    std::array<Vec3, 3> x;
    for (int k = 0; k < 3; ++k) x[k] = vector(position[v[k]]) - (start + h) * touch.obstacle->velocity;
    const DeepestPoint deepest = deepest_point(*touch.obstacle, x);
    if (deepest.distance >= offset_ * (1.0 - kTolerance)) break;
    touch.weight = deepest.weight;
  }
  std::size_t newly_touched = 0;
  for (const std::int32_t i : v) {
    if (!(position[i].w > 0.0)) continue;
    set(velocity[i], (vector(position[i]) - vector(previous[i])) / h);
    newly_touched += touched[i] == 0;
    touched[i] = 1;
  }
  return newly_touched;
}

/// Of the obstacles at the vertices, and so on the triangles between them [m/s].
double TriangleContact::fastest(const std::vector<Row>& position) const {
  double most = 0.0;
  for (const Obstacle* o : obstacles_) {
    const double reach = o->spin.isZero(0.0)
                             ? 0.0
                             : parallel_max(position.size(), kGrain, 0.0, [&](std::size_t begin, std::size_t end) {
                                 double farthest2 = 0.0;
                                 for (std::size_t i = begin; i < end; ++i)
                                   farthest2 = std::max(farthest2, (vector(position[i]) - o->pivot).squaredNorm());
                                 return std::sqrt(farthest2);
                               });
    most = std::max(most, o->velocity.norm() + o->spin.norm() * reach);
  }
  return most;
}

std::size_t TriangleContact::resolve(double start, double h, std::vector<Row>& position, std::vector<Row>& previous,
                                     std::vector<Row>& velocity, std::vector<std::uint8_t>& touched) {
  if (obstacles_.empty()) return 0;
  const double farthest = parallel_max(position.size(), kGrain, 0.0, [&](std::size_t begin, std::size_t end) {
    double farthest2 = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      farthest2 = std::max(farthest2, (vector(position[i]) - vector(previous[i])).squaredNorm());
    return std::sqrt(farthest2);
  });
  const double approach = steepest_ * (farthest + h * fastest(position));
  parallel_chunks(triangles_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Touch>& found = found_[begin / kGrain];
    found.clear();
    for (std::size_t t = begin; t < end; ++t) {
      clearance_[t] -= approach;
      if (!(clearance_[t] > 0.0)) find(t, start, h, position, previous, found);
    }
  });
  // Few triangles are touched, and they share corners: one after the other, in their order, and once more for what
  // the later ones moved.
  std::size_t newly_touched = 0;
  for (int sweep = 0; sweep < 2; ++sweep)
    for (const std::vector<Touch>& found : found_)
      for (const Touch& touch : found)
        newly_touched += push_out(touch, start, h, position, previous, velocity, touched);
  return newly_touched;
}

}  // namespace wick::solid
