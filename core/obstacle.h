#pragma once
/// Rigid obstacles as signed distances: what sheets collide with and what fluid flows around.
#include <string>
#include <variant>
#include <vector>

#include "core/types.h"

namespace wick {

struct SphereShape {
  Vec3 center = Vec3::Zero();  ///< [m]
  double radius = 0.1;         ///< [m]
};
struct BoxShape {
  Vec3 lower = Vec3::Constant(-0.1);  ///< [m]
  Vec3 upper = Vec3::Constant(0.1);   ///< [m]
};
/// Half space: solid where (x - point).normal < 0.
struct PlaneShape {
  Vec3 point = Vec3::Zero();    ///< [m]
  Vec3 normal = Vec3(0, 0, 1);  ///< unit length
};
/// Signed distance sampled at nodes, trilinear between them, x fastest; outside the box the distance to
/// the box is added, so the value stays positive and grows.
struct SampledShape {
  Vec3 origin = Vec3::Zero();  ///< position of node (0,0,0) [m]
  double spacing = 0.01;       ///< [m]
  Int3 nodes = {0, 0, 0};
  std::vector<float> distance;  ///< [m]
};

struct Obstacle {
  std::string name;
  std::variant<SphereShape, BoxShape, PlaneShape, SampledShape> shape;
  double friction = 0.3;             ///< Coulomb coefficient, static and kinetic alike
  Vec3 velocity = Vec3::Zero();      ///< rigid translation [m/s]
  Vec3 displacement = Vec3::Zero();  ///< how far it has moved since the start [m]
};

struct DistanceSample {
  double distance;  ///< negative inside [m]
  Vec3 gradient;    ///< outward direction, unit length where the distance is smooth
};

/// Signed distance from `x` to the obstacle where it is now.
DistanceSample sample_distance(const Obstacle& obstacle, const Vec3& x);

/// Whether the segment from `a` to `b` passes through the inside of the obstacle where it is now. Exact for
/// spheres, boxes and planes; of a sampled shape chords shorter than a quarter of its spacing may be missed.
bool segment_meets(const Obstacle& obstacle, const Vec3& a, const Vec3& b);

}  // namespace wick
