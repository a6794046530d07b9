#pragma once
/// What is common to all that changes a sheet's mesh as it is simulated: everything that a vertex carries goes
/// along.
#include "coupling/sheet.h"
#include "solid/mesh_cut.h"

namespace wick::coupling {

/// Lets everything follow after the sheet's triangles, places at rest, snapping distances, mass and heat have been
/// changed: other values at vertices as `blends` tell, forces (`push` [N], one a vertex or empty, among them),
/// pins, what the mesh derives, solvers, inputs.
void follow_mesh(Sheet& sheet, const WorldParams& world, const std::vector<solid::Blend>& blends,
                 std::vector<Vec3>& push);

/// Takes the triangles without keep[t] out of the sheet. Returns whether there were any.
bool drop_triangles(Sheet& sheet, const WorldParams& world, const std::vector<std::uint8_t>& keep,
                    std::vector<Vec3>& push);

}  // namespace wick::coupling
