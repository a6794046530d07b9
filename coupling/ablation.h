#pragma once
/// What has burnt to ash leaves the sheet along the isocontour of what is left of its mass [Jeong, Kim and Kim
/// 2011; Losasso et al. 2006 for the cut].
#include "coupling/sheet.h"

namespace wick::coupling {

/// What one sheet lost in one cut.
struct Ablated {
  bool any = false;   ///< the mesh has changed
  double mass = 0.0;  ///< [kg]
  double heat = 0.0;  ///< [J]
};

/// Cuts away what has less of its mass left than world.burning->removal, and rebuilds the sheet's mesh, solvers and
/// inputs where anything changed. `push` [N], one per vertex or empty, goes with the vertices. Sheets with a motion
/// of their own, and those of a scene with whole triangles, lose the triangles none of whose corners has more left.
Ablated ablate(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push);

}  // namespace wick::coupling
