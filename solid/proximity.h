#pragma once
/// Closest points of a vertex and a triangle, and of two edges: what contact between sheets is made of.
#include <array>
#include <cstdint>

#include "core/types.h"

namespace wick::solid {

/// Weights of the point of a triangle closest to p, by the Voronoi regions of its corners and edges [Ericson
/// 2005, 5.1.5]. The triangle may be a line or a point.
std::array<double, 3> closest_weights(const std::array<Vec3, 3>& corner, const Vec3& p);

/// Which of four vertices are the first feature and which the second.
enum class FeaturePair : std::uint8_t { vertex_triangle, edge_edge };
/// Vertices of the first feature: the others are the second.
constexpr int first_count(FeaturePair kind) {
  return kind == FeaturePair::vertex_triangle ? 1 : 2;
}

/// The shortest way from the second feature to the first.
struct Separation {
  std::array<double, 4> weight;  ///< way = sum of weight * x; 1 in all over the first feature, -1 over the second
  Vec3 direction;                ///< of the way, unit length; zero where the features touch
  double distance;               ///< [m]
};
/// Features may be degenerate. The plane across the way separates them: features are convex.
Separation closest(FeaturePair kind, const std::array<Vec3, 4>& x);

/// How far apart the features are along a direction [m]; negative where their shadows overlap.
double gap_along(FeaturePair kind, const std::array<Vec3, 4>& x, const Vec3& direction);

/// Whether the features stay at least `least` [m] apart while their vertices move straight from `from` to `to`; by
/// steps that the distance itself allows [additive advancement, Li 2021]. False also where that takes too many.
bool stay_apart(FeaturePair kind, const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& to, double least);

}  // namespace wick::solid
