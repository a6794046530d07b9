#pragma once
/// How much of a closed mesh its sampled distance has kept.
#include <vector>

#include "core/obstacle.h"

namespace wick::coupling {

/// Compares the samples with the mesh at points of its surface, about one a spacing squared.
struct MeshResolution {
  double lost_area = 0.0;     ///< of thin parts that are missing in the samples, or nearly so [m2]
  double thickness = 0.0;     ///< least of those parts [m]
  Vec3 where = Vec3::Zero();  ///< on the thinnest [m]
  double rounding = 0.0;      ///< farthest that the sampled surface lies inside a vertex of what is kept [m]
};

/// A part counts as thin where the far side of the mesh is less than two spacings behind its surface and faces the
/// other way, unless a sharp edge is near (below 60 degrees, within 6 spacings or a twentieth of the body): a blade
/// is thin at its edge at any spacing. It counts as lost where the sampled solid has not begun a quarter of a
/// spacing behind the surface. Thicker parts lose edges and corners at most. (A plate along the planes of nodes is
/// sampled rightly from 3/2 spacings on.) `body` is the mesh sampled at `spacing` [m]; the mesh must be closed, and
/// either orientation will do.
MeshResolution resolution_of(const Obstacle& body, double spacing, const std::vector<Vec3>& positions,
                             const std::vector<Int3>& triangles);

}  // namespace wick::coupling
