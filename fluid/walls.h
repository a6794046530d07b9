#pragma once
/// What sheets and obstacles are to the fluid: cells that are solid, and faces that nothing passes.
/// The fluid never hears of triangles.
///
/// A closed face between two fluid cells is a zero-thickness wall. Sides are told apart by
/// connectivity alone: two cells are on the same side where a path of open faces joins them within the
/// stencil in question. A sheet whose blocked faces come from watertight segment tests is therefore
/// airtight for anything that moves from cell to cell through open faces only.
#include <cstdint>
#include <vector>

#include "fluid/grid.h"

namespace wick::fluid {

struct Walls {
  bool any = false;                                 ///< false: the box is empty and the arrays below are empty too
  std::vector<std::uint8_t> solid;                  ///< per cell: 1 = inside an obstacle
  std::array<std::vector<std::uint8_t>, 3> closed;  ///< per face: 1 = no flow through (solid neighbours included)
  FaceField velocity;              ///< normal velocity of the wall at closed faces [m/s], 0 elsewhere
  std::vector<std::uint8_t> near;  ///< per cell: 1 = a closed face lies within two cells in any direction
                                   ///< (stencils and back-traces of under one cell from cells with 0 see none)
};

/// Lumped masses that move behind closed faces: velocity of wall face r is
///   sum_k weight[r][k] * (velocity of mass dof[r][k] along axis[r]),
/// and a pressure impulse on the face acts back on the masses with the same weights (the transpose).
/// This is all that the simultaneous pressure solve [Chentanez 2006] needs to know of a sheet.
struct MovableWalls {
  std::vector<std::uint8_t> axis;  ///< per row: 0, 1, 2
  std::vector<std::int64_t> face;  ///< per row: index of the face among those of its axis
  std::vector<std::array<std::int32_t, 3>> dof;
  std::vector<std::array<double, 3>> weight;  ///< sums to 1 a row
  std::vector<double> inverse_mass;           ///< per dof [1/kg]; 0 = held
};

/// Gives the closed faces of `axis` the velocity of their wall.
void move_with_walls(const Walls& walls, int axis, std::vector<float>& velocity);

/// Marks `near` from `closed`; call after filling the other arrays.
void mark_near_walls(const Grid& grid, const Sides& sides, Walls& walls);

}  // namespace wick::fluid
