#include "solid/contact.h"

#include <algorithm>

namespace wick::solid {

namespace {

/// The least part of a way that the search for its first touch steps over: it bounds the search where the way runs
/// along a surface.
constexpr double kLeastStep = 1.0 / 64.0;

/// How much of the way from `from`, which is outside, to `to` leads inwards from where it first comes to `offset`
/// from the obstacle [m], and the normal there: steps of the distance itself [Hart 1996].
struct Entry {
  double depth = 0.0;
  Vec3 normal = Vec3::Zero();
};
Entry first_entry(const Obstacle& obstacle, double offset, const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  const double length = way.norm(), slope = steepest_slope(obstacle), tolerance = 1e-3 * offset;
  for (double t = 0.0; t < 1.0;) {
    const DistanceSample s = sample_distance(obstacle, from + t * way);
    const double gap = s.distance - offset, inwards = -s.gradient.dot(way);
    if (gap <= tolerance && inwards > 0.0) return {(1.0 - t) * inwards, s.gradient};
    t += std::max(gap / (slope * length), kLeastStep);
  }
  return {};
}

}  // namespace

double steepest_slope(const Obstacle& obstacle) {
  return std::holds_alternative<SampledShape>(obstacle.shape) ? 2.0 : 1.0;
}

double resolve_contact(const Obstacle& obstacle, double start, double h, double offset, Vec3& x, Vec3& previous) {
  const Vec3 from = obstacle.rewound(previous, start);
  Vec3 to = obstacle.rewound(x, start + h);
  const bool turns = !obstacle.spin.isZero(0.0);
  const Mat3 turned = turns ? obstacle.turn_in(start + h) : Mat3(Mat3::Identity());

  // What goes far goes on along the surface that it meets first. What is no deeper than the sheet is thick has come
  // in on this side.
  Entry entry;
  if ((to - from).squaredNorm() > offset * offset && sample_distance(obstacle, from).distance > -offset)
    entry = first_entry(obstacle, offset, from, to);
  x += turned * (entry.depth * entry.normal);
  to += entry.depth * entry.normal;

  const DistanceSample end = sample_distance(obstacle, to);
  const double depth = offset - end.distance;
  if (!(depth > 0.0) && entry.depth == 0.0) return -depth;
  const Vec3 normal = turned * (depth > 0.0 ? end.gradient : entry.normal);
  const double pushed = std::max(depth, 0.0);
  x += pushed * normal;

  // Overlap from before the substep moves the starting point along.
  const double old_depth = std::clamp(offset - sample_distance(obstacle, from).distance, 0.0, pushed);
  previous += old_depth * normal;

  // Stick, or slide with the friction impulse that the normal impulse allows.
  const Vec3 carried =
      turns ? Vec3(h * obstacle.velocity_at(x - start * obstacle.velocity)) : Vec3(h * obstacle.velocity);
  const Vec3 motion = x - previous - carried;
  const Vec3 sliding = motion - normal * normal.dot(motion);
  const double length = sliding.norm();
  const double allowed = obstacle.friction * (entry.depth + pushed - old_depth);
  if (length > 0.0) x -= sliding * std::min(1.0, allowed / length);
  return 0.0;
}

}  // namespace wick::solid
