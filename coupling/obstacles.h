#pragma once
/// The rigid bodies of a scene, built and checked against the sheets.
#include <string>
#include <vector>

#include "core/obstacle.h"
#include "coupling/sheet.h"

namespace wick::coupling {

/// The scene's rigid bodies, meshes sampled to signed distances. Throws Refusal with the pointer of the parameter
/// at fault; what is worth saying and no fault is added to `warnings`, each with its pointer in front.
std::vector<Obstacle> build_obstacles(const WorldParams& world, std::vector<std::string>& warnings);

/// Gives the obstacle, which is where it is at time t, the velocity and the spin of its next dt.
void aim(Obstacle& obstacle, const ObstacleParams& params, double t, double dt);

void visit(StateVisitor& visitor, Obstacle& obstacle);

/// Throws Refusal where a free sheet lies wholly or partly inside an obstacle: no push out of it would be the right
/// one.
void require_outside(const std::vector<Sheet>& sheets, const std::vector<Obstacle>& obstacles);

/// Signed distance of a closed triangle mesh on a grid with `spacing` [m], a few cells wider than the mesh.
/// `pointer` is that of the obstacle's section.
SampledShape sample_mesh_distance(const std::vector<Vec3>& positions, const std::vector<Int3>& triangles,
                                  double spacing, const std::string& pointer);

}  // namespace wick::coupling
