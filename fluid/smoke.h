#pragma once
/// One step of smoke: Stable Fluids [Stam 1999] on a staggered grid with the forces of Fedkiw, Stam and
/// Jensen [2001].
///
///   du/dt + u.grad u = -grad p / rho + nu lap u + buoyancy + confinement,   div u = expansion
///   dq/dt + u.grad q = k lap q + sources                    q = density, temperature, flame
///
/// Order of one step, all at time t unless said: sources, forces, diffusion (implicit), advection of velocity
/// and scalars by the projected velocity of the last step, projection to t + dt.
#include <array>
#include <memory>

#include "core/report.h"
#include "core/state.h"
#include "fluid/pressure.h"
#include "fluid/walls.h"

namespace wick::fluid {

enum class Advection { semi_lagrangian, maccormack, conservative };

struct SmokeParams {
  Int3 resolution = {64, 64, 64};  ///< cells
  Vec3 lower = Vec3::Zero();       ///< lower corner of the box [m]
  double width = 1.0;              ///< extent of the box along x [m]; cells are cubes of width/nx
  Sides sides = {Side::closed, Side::closed, Side::closed, Side::closed, Side::closed, Side::open};
  double cfl = 2.0;  ///< cells the fastest flow may cross in one step
  Advection velocity_advection = Advection::maccormack;
  Advection scalar_advection = Advection::conservative;
  double air_density = 1.2;             ///< rho [kg/m3]
  double air_heat_capacity = 1005;      ///< c_p [J/(kg K)]
  double ambient_temperature = 293.15;  ///< T_amb [K]
  double buoyancy_heat = 1.0;           ///< b: multiplies the lift g (T - T_amb)/T [-]; 1 is the physical value
  double buoyancy_smoke = 1.0;          ///< a: multiplies the weight g rho_s/rho of the smoke carried [-]
  double vorticity = 0.1;               ///< confinement eps [-]
  double viscosity = 0.0;               ///< nu [m2/s]
  double diffusivity = 0.0;             ///< of density and temperature, k [m2/s]
  double dissipation = 0.0;             ///< rate at which smoke density fades [1/s], booked as a flow out
  double cooling = 0.0;                 ///< rate at which gas loses its excess heat [1/s], booked
  double flame_life = 0.15;             ///< time in which the reaction coordinate decays [s]
  bool no_slip = false;                 ///< closed sides hold the air beside them instead of letting it slip
  std::array<Vec3, 6> side_velocity = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),   ///< of closed sides that do not
                                       Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< slip; only along them [m/s]
  bool active_window = true;
  PressureParams pressure;
};
void describe(ParameterVisitor& visitor, SmokeParams& params);

struct SmokeState {
  FaceField velocity;            ///< [m/s]
  std::vector<double> pressure;  ///< of the last projection: first guess of the next [Pa]
  CellField density;             ///< smoke carried [kg/m3]
  CellField temperature;         ///< excess over ambient, T - T_amb [K]
  CellField flame;               ///< reaction coordinate in [0, 1], for rendering
  std::vector<std::int32_t>
      window;  ///< active window of the last step: low and high corner [cells]; empty: the box
};
void visit(StateVisitor& visitor, SmokeState& state);

/// What the world puts into the gas during a step. Amounts are totals for the step.
struct SmokeSources {
  std::vector<std::int64_t> cell;
  std::vector<double> smoke;  ///< [kg], per entry
  std::vector<double> heat;   ///< [J], per entry
  std::vector<double> flame;  ///< raises flame to at least this value, per entry
  Vec3 gravity = Vec3(0, 0, -9.81);
  const FaceField* body_force = nullptr;  ///< acceleration on faces [m/s2]; null: none
};

/// What crossed the boundary of the gas in one step, and what the scheme itself changed.
struct SmokeStepReport {
  SolveReport pressure, diffusion;
  double smoke_out = 0.0;        ///< through open sides and by dissipation [kg]
  double smoke_advection = 0.0;  ///< made (+) or lost (-) by advection inside the box [kg]; 0 when conservative
  double heat_out = 0.0;         ///< [J]
  double heat_advection = 0.0;   ///< [J]
  double max_speed = 0.0;        ///< largest |component| of velocity, after the step [m/s]
  double max_divergence = 0.0;   ///< [1/s], after the projection
  std::size_t active_cells = 0;
  int transport_substeps = 1;  ///< of conservative transport
  StageSeconds seconds;        ///< forces, advect_velocity, advect_scalars, diffuse, pressure
};

/// Refuses parameters that contradict each other.
void check(const SmokeParams& params);

Grid smoke_grid(const SmokeParams& params);
SmokeState make_smoke_state(const SmokeParams& params);

/// Largest step that keeps the flow under params.cfl cells, forces of the step included; infinite when still.
double stable_dt(const SmokeState& state, const SmokeParams& params, const Vec3& gravity);

double total_smoke(const SmokeState& state, const SmokeParams& params);  ///< [kg]
double total_heat(const SmokeState& state, const SmokeParams& params);   ///< [J] over ambient

/// Makes the velocity of closed sides and walls what it must be, and the two copies on periodic sides equal.
void impose_walls(const Grid& grid, const Sides& sides, const Walls& walls, FaceField& velocity);

/// Keeps the pressure solver and the work arrays alive between steps.
class SmokeSolver {
 public:
  explicit SmokeSolver(const SmokeParams& params);
  ~SmokeSolver();
  SmokeSolver(SmokeSolver&&) noexcept;

  /// Advances `state` by dt. `movable` and `impulse` as in PressureSolver::project.
  SmokeStepReport step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                       const MovableWalls* movable = nullptr, std::vector<Vec3>* impulse = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::fluid
