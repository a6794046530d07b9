#pragma once
/// Pressure projection on the staggered grid.
///
///   div u = s,   u = u* - (dt/rho) grad p
///   =>  (dt/(rho h^2)) sum_f open_f (p_c - p_nb) = s_c - (1/h) sum_f sign_f u*_f          (per fluid cell)
///
/// Closed faces carry the wall's velocity and are not in the matrix. Open sides hold p = 0 on the face
/// itself (half a cell from the centre). A group of cells with no open side is singular: its right-hand
/// side is made compatible by taking out the mean, which the report names.
///
/// An empty box is solved exactly by fast cosine/sine/Fourier transforms; anything else by conjugate
/// gradients in double with a float multigrid V-cycle as preconditioner, coarsened along walls.
#include <memory>

#include "core/report.h"
#include "fluid/walls.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::fluid {

struct PressureParams {
  double tolerance = 1e-5;  ///< relative 2-norm of the true residual
  int max_iterations = 200;
};
void describe(ParameterVisitor& visitor, PressureParams& params);

struct ProjectionInput {
  double density = 1.2;                   ///< rho [kg/m3]
  double dt = 0.0;                        ///< [s], > 0
  const Walls* walls = nullptr;           ///< null or !any: empty box
  const CellField* expansion = nullptr;   ///< s, wanted divergence [1/s]; null: 0
  const MovableWalls* movable = nullptr;  ///< null: walls move as given (partitioned)
};

class PressureSolver {
 public:
  PressureSolver(const Grid& grid, const Sides& sides, const PressureParams& params);
  ~PressureSolver();
  PressureSolver(PressureSolver&&) noexcept;
  PressureSolver& operator=(PressureSolver&&) noexcept;

  /// Makes `velocity` divergence-free (or equal to the expansion). `pressure` [Pa] has one value a cell:
  /// first guess on entry, solution on return. With `movable`, the wall faces named there are updated to the
  /// velocity of their masses after the pressure impulse, and `impulse` (3 per dof [N s]) receives it.
  SolveReport project(FaceField& velocity, std::vector<double>& pressure, const ProjectionInput& input,
                      std::vector<Vec3>* impulse = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Largest |div u - s| over the fluid cells [1/s]: what the projection must bring to (about) zero.
double max_divergence(const Grid& grid, const FaceField& velocity, const Walls* walls, const CellField* expansion);

}  // namespace wick::fluid
