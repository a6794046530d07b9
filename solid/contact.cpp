#include "solid/contact.h"

#include <algorithm>

namespace wick::solid {

double resolve_contact(const Obstacle& obstacle, double start, double h, double offset, Vec3& x, Vec3& previous) {
  const DistanceSample sample = sample_distance(obstacle, x - (start + h) * obstacle.velocity);
  const double depth = offset - sample.distance;
  if (!(depth > 0.0)) return -depth;
  const Vec3& normal = sample.gradient;
  x += depth * normal;

  // Overlap from before the substep moves the starting point along.
  const double old_depth =
      std::clamp(offset - sample_distance(obstacle, previous - start * obstacle.velocity).distance, 0.0, depth);
  previous += old_depth * normal;

  // Stick, or slide with the friction impulse that the normal impulse allows.
  const Vec3 motion = x - previous - h * obstacle.velocity;
  const Vec3 sliding = motion - normal * normal.dot(motion);
  const double length = sliding.norm();
  const double allowed = obstacle.friction * (depth - old_depth);
  if (length > 0.0) x -= sliding * std::min(1.0, allowed / length);
  return 0.0;
}

}  // namespace wick::solid
