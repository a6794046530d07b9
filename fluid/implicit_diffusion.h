#pragma once
/// Implicit diffusion on the grid, of cell values and of staggered velocity:
///
///   q⁺ - q = c Δ q⁺  with c = D dt/h² and Δ the seven-point sum of differences
///   =>  (I - c Δ) δ = c Δ q,   q⁺ = q + δ
///
/// symmetric positive definite, solved for the change δ by conjugate gradients in double, so that rounding is
/// relative to the change. Nothing diffuses through walls, closed or open sides. Velocity on closed faces is
/// given; along closed sides it slips freely, or takes the velocity of the side (no_slip).
#include "core/report.h"
#include "fluid/advection.h"

namespace wick::fluid {

struct DiffusionInput {
  double coefficient = 0.0;  ///< D [m²/s], >= 0
  double dt = 0.0;           ///< [s]
  double tolerance = 1e-6;   ///< of the residual, relative to the right-hand side
  int max_iterations = 500;
};

/// Arrays of the solve, kept between steps.
struct DiffusionWork {
  std::vector<double> values, rhs, delta, residual, direction, image;
};

/// Diffuses a cell value. Its sum stays the same up to rounding.
SolveReport diffuse(const Grid& grid, const Sides& sides, const Walls& walls, const DiffusionInput& input,
                    CellField& field, DiffusionWork& work);

/// Diffuses the three components of velocity one after another; the report is that of the slowest.
SolveReport diffuse(const Grid& grid, const Sides& sides, const SideMotion& motion, const Walls& walls,
                    const DiffusionInput& input, FaceField& velocity, DiffusionWork& work);

}  // namespace wick::fluid
