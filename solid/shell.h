#pragma once
/// Thin shell in small-step XPBD [Macklin 2016, 2019]: one sweep of coloured Gauss-Seidel over the
/// constraints per substep.
///   predict x^ = x + h v + h2 M^-1 f;   project each constraint once;   v = (x+ - x)/h
#include <memory>
#include <optional>

#include "core/obstacle.h"
#include "core/report.h"
#include "core/state.h"
#include "solid/lanes.h"
#include "solid/shell_mesh.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::solid {

struct ShellParams {
  double thickness = 2e-4;         ///< t [m]
  double density = 700.0;          ///< [kg/m3]; areal mass is density * thickness
  double young_warp = 2e8;         ///< Y along material x [Pa]
  double young_weft = 2e8;         ///< Y along material y [Pa]
  double poisson = 0.3;            ///< nu
  double shear = 0.0;              ///< in-plane shear modulus [Pa]; 0: isotropic value
  double bending = 0.0;            ///< flexural rigidity B per width [N m]; 0: Y t^3/(12 (1 - nu^2))
  double damping = 1e-3;           ///< Rayleigh b [s]
  double air_drag = 0.1;           ///< rate at which velocity relative to the wind decays [1/s]
  int substeps = 60;               ///< per 1/60 s
  bool weaken_with_delta = false;  ///< multiply membrane stiffness by 1/(1+delta) (methods 2.9)
};
void describe(ParameterVisitor& visitor, ShellParams& params);

struct ShellState {
  std::vector<Vec3> x, v;  ///< [m], [m/s]
};
void visit(StateVisitor& visitor, ShellState& state);

/// Everything about the material that may change from step to step; filled by the world, or left at
/// make_shell_inputs(). Sizes V, T, H (hinges).
struct ShellInputs {
  std::vector<double> mass;             ///< per vertex [kg]; 0 = orphan, not moved by constraints
  std::vector<double> rest_scale;       ///< per triangle: rest lengths are multiplied by this
  std::vector<double> stiffness_scale;  ///< per triangle: membrane and bending stiffness are multiplied by this
  std::vector<double> rest_angle;       ///< per hinge [rad]; signed as the dihedral angle of solid/bending.h
  double membrane_factor = 1.0;  ///< membrane stiffness alone is multiplied by this: 1/(1+delta) when weakened
};
ShellInputs make_shell_inputs(const ShellMesh& mesh, const ShellParams& params);

/// Vertices that do not move freely. A pin follows `target` (vertex position at the end of the step).
struct Pins {
  std::vector<std::int32_t> vertex;
  std::vector<Vec3> target;  ///< [m]
};

struct ShellStepReport {
  int substeps = 0;
  std::size_t contacts = 0;  ///< vertices touched by an obstacle in the last substep
  double max_stretch = 0.0;  ///< largest edge strain (current/rest - 1) after the step
  double max_speed = 0.0;    ///< [m/s]
  std::size_t limited = 0;   ///< times that a vertex was slowed to the largest speed, or was not finite
  double seconds = 0.0;
};

/// What a step is made for; lives through the step.
struct ShellLoads {
  const ShellInputs& inputs;
  const Pins& pins;
  const std::vector<Obstacle>& obstacles;  ///< where they are at the start of the step; move with their velocity
  const std::vector<Vec3>& force;          ///< held over the step, V [N]
  const std::vector<Vec3>& wind;           ///< velocity of the air for the drag [m/s], V, or empty for still air
  Vec3 gravity;                            ///< [m/s2]
};

/// Keeps the colouring and the constraint data of one topology alive.
class ShellSolver {
 public:
  ShellSolver(const ShellMesh& mesh, const ShellParams& params);
  ~ShellSolver();
  ShellSolver(ShellSolver&&) noexcept;
  ShellSolver& operator=(ShellSolver&&) noexcept;

  /// Advances the shell by dt, without contact between sheets.
  ShellStepReport step(ShellState& state, const ShellMesh& mesh, const ShellLoads& loads, double dt);

  // The same in parts, so that sheets that touch each other advance side by side (solid/sheet_group.h): begin, for
  // each substep the three in their order, end.
  void begin(const ShellState& state, const ShellLoads& loads, double dt, int substeps);
  void deform(int substep);
  void meet_obstacles(int substep);
  void end_substep();
  ShellStepReport end(ShellState& state, const ShellMesh& mesh);

  /// Positions and inverse masses of the vertices, between the parts of a substep. One row more than vertices.
  [[nodiscard]] std::vector<Row>& positions();
  /// Per vertex: moved by an obstacle in this substep, after meet_obstacles().
  [[nodiscard]] const std::vector<std::uint8_t>& touched() const;
  /// Tells that a contact with a sheet has moved vertex i, which was at `start` at the start of the substep, after
  /// meet_obstacles().
  void note_contact(std::size_t i, const Row& start);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Substeps that a step of dt takes: params.substeps per 1/60 s, rounded up, at least one.
int substep_count(const ShellParams& params, double dt);

/// Elastic energy of the shell: stretching and bending [J], for tests and metrics.
struct ShellEnergy {
  double stretching = 0.0, bending = 0.0;
};
ShellEnergy elastic_energy(const ShellMesh& mesh, const ShellParams& params, const ShellInputs& inputs,
                           const std::vector<Vec3>& x);

}  // namespace wick::solid
