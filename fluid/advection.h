#pragma once
/// Transport of cell values and of staggered velocity by a staggered flow.
///
///   semi_lagrangian  q'(x) = q(x_b),  x_b = x - dt u(x - dt/2 u(x))                      [Stam 1999]
///   maccormack       q^ = A q,  q' = q^ + (q - A⁻¹ q^)/2, held within the values around x_b   [Selle 2008]
///   conservative     q' = q - dt div(u q), axis by axis, fluxes limited in slope [van Leer 1974, Strang 1968]
///
/// Closed sides cut paths, open sides bring in ambient air (0, and at rest), periodic sides continue at the
/// other end. Paths and samples near walls follow wall_paths.h; there, and where a path leaves the box,
/// MacCormack is the first-order value.
#include <span>
#include <vector>

#include "fluid/padded.h"
#include "fluid/smoke.h"
#include "fluid/sweeps.h"
#include "fluid/wall_map.h"

namespace wick::fluid {

/// Tangential velocities of the six sides [m/s]; only seen by `no_slip` boxes.
struct SideMotion {
  bool no_slip = false;
  std::array<Vec3, 6> velocity{};
};

/// Ghosts of velocity component `axis`, in the same unit as `factor` makes the field.
GhostRules velocity_ghosts(const Sides& sides, int axis, const SideMotion& motion, double factor);

/// Ghosts of velocity component `axis` when it is carried: the air outside open sides rests.
GhostRules carried_velocity_ghosts(const Sides& sides, int axis, const SideMotion& motion);

/// Makes the two copies of the faces on periodic sides the same.
void join_periodic_faces(const Grid& grid, const Sides& sides, FaceField& velocity);

/// What went out through open sides (in is negative), one entry a field, in units of field x cell.
struct TransportReport {
  std::vector<double> out;
  int substeps = 1;
};

/// Keeps the padded copies that the kernels work on alive between steps.
class Transport {
 public:
  Transport(const Grid& grid, const Sides& sides, const SideMotion& motion);

  /// Takes the flow that everything is carried by until the next call. Closed faces of `walls` must hold the
  /// velocity of the wall. `walls` must outlive the use.
  void set_flow(const FaceField& velocity, const Walls& walls, double dt);

  /// Carries cell values. Outflow is exact for `conservative`, an upwind estimate for the others.
  TransportReport carry(std::span<CellField* const> fields, Advection method);
  /// Carries velocity; closed faces keep what they hold. Not `conservative`.
  void carry(FaceField& velocity, Advection method);

  /// The flow with ghosts, in cells a step.
  [[nodiscard]] const std::array<Padded, 3>& flow() const { return flow_; }

 private:
  struct Kernel;
  void reshape_work(std::size_t fields, int lattice);
  TransportReport carry_conservative(std::span<CellField* const> fields);
  void take_courant_numbers();
  void spend_head_of_inflow(FaceField& velocity) const;
  [[nodiscard]] double upwind_outflow(const CellField& field) const;

  Grid grid_;
  Sides sides_;
  SideMotion motion_;
  const Walls* walls_ = nullptr;
  double scale_ = 0.0;  ///< cells a step per m/s
  std::array<Padded, 3> flow_;
  WallMap map_;  ///< of the walls, if there are any
  bool short_paths_ = false;
  std::vector<Padded> source_, first_, low_, high_;
  Courant courant_;
};

}  // namespace wick::fluid
