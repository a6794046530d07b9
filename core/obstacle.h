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

/// Where a rigid body is: what is at X in its own frame is at turn X + shift.
struct Pose {
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();  ///< [m]

  [[nodiscard]] Vec3 place(const Vec3& body) const { return turn * body + shift; }
  [[nodiscard]] Vec3 body(const Vec3& place) const { return turn.transpose() * (place - shift); }
  bool operator==(const Pose&) const = default;
};
/// Where what is carried along from one pose to another goes.
inline Pose between(const Pose& from, const Pose& to) {
  const Mat3 turn = to.turn * from.turn.transpose();
  return {turn, to.shift - turn * from.shift};
}

struct Obstacle {
  std::string name;
  std::variant<SphereShape, BoxShape, PlaneShape, SampledShape> shape;
  double friction = 0.3;         ///< Coulomb coefficient, static and kinetic alike
  Vec3 velocity = Vec3::Zero();  ///< of its pivot [m/s]
  Vec3 spin = Vec3::Zero();      ///< angular velocity about the pivot [rad/s]
  Vec3 pivot = Vec3::Zero();     ///< where it is now [m]
  Pose pose = {};                     ///< where the body is now, relative to its shape as given

  [[nodiscard]] Vec3 velocity_at(const Vec3& x) const { return velocity + spin.cross(x - pivot); }
  /// More than any speed of the body at x [m/s].
  [[nodiscard]] double speed_at(const Vec3& x) const { return velocity.norm() + spin.norm() * (x - pivot).norm(); }
  /// How the body turns in a time dt from now on.
  [[nodiscard]] Mat3 turn_in(double dt) const;
  /// Where what the body carries past x after a time dt is now.
  [[nodiscard]] Vec3 rewound(const Vec3& x, double dt) const;
  /// Moves it by dt.
  void advance(double dt);
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
