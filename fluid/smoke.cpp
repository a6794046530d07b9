#include "fluid/smoke.h"

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/forces.h"
#include "fluid/implicit_diffusion.h"
#include "fluid/smoke_state.h"
#include "fluid/window.h"

namespace wick::fluid {

namespace {

/// Sides as transport sees them: nothing is carried through those where a window ends inside the box.
Sides transport_sides(const SmokeParams& box, const Window& window, const SmokeParams& whole) {
  Sides sides = box.sides;
  for (int a = 0; a < 3; ++a) {
    if (window.low[a] > 0) sides[2 * a] = Side::closed;
    if (window.high[a] < whole.resolution[a]) sides[2 * a + 1] = Side::closed;
  }
  return sides;
}

/// One box of air: the whole, or the active window of it. Keeps solvers and work arrays alive.
struct AirBox {
  SmokeParams params;
  Window window;
  Grid grid;
  SideMotion motion;
  Transport transport;
  Confinement confinement;
  PressureSolver pressure;
  Padded lift_field;
  DiffusionWork diffusion_work;
  std::vector<double> departed;

  AirBox(const SmokeParams& whole, const Window& part)
      : params(window_params(whole, part)),
        window(part),
        grid(smoke_grid(params)),
        motion{params.no_slip, params.side_velocity},
        transport(grid, transport_sides(params, part, whole), motion),
        confinement(grid, params.sides),
        pressure(grid, params.sides, params.pressure) {
    lift_field.reshape({grid.nx, grid.ny, grid.nz}, {1, 1, 1});
  }

  void add_forces(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt);
  void diffuse_all(SmokeState& state, const Walls& walls, double dt, SmokeStepReport& report);
  void carry_scalars(SmokeState& state, SmokeStepReport& report);
  SolveReport project(SmokeState& state, const ProjectionInput& input, bool half_done, std::vector<Vec3>* impulse);
  SmokeStepReport step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                       const MovableWalls* movable, std::vector<Vec3>* impulse);
};

void AirBox::add_forces(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt) {
  lift(state, params, lift_field);
  lift_field.fill_ghosts(scalar_ghosts(params.sides));
  add_buoyancy(state.velocity, lift_field, sources, grid, walls, dt);
  confinement.add(state.velocity, transport.flow(), walls, params.vorticity, dt);
}

void AirBox::diffuse_all(SmokeState& state, const Walls& walls, double dt, SmokeStepReport& report) {
  const DiffusionInput momentum = {.coefficient = params.viscosity, .dt = dt};
  report.diffusion = diffuse(grid, params.sides, motion, walls, momentum, state.velocity, diffusion_work);
  const DiffusionInput scalars = {.coefficient = params.diffusivity, .dt = dt};
  for (CellField* field : {&state.density, &state.temperature}) {
    const SolveReport solve = diffuse(grid, params.sides, walls, scalars, *field, diffusion_work);
    if (solve.iterations > report.diffusion.iterations || !solve.converged) report.diffusion = solve;
  }
}

void AirBox::carry_scalars(SmokeState& state, SmokeStepReport& report) {
  const double volume = cell_volume(params), capacity = heat_capacity(params);
  const double smoke = sum(state.density), heat = sum(state.temperature);
  CellField* const fields[] = {&state.density, &state.temperature, &state.flame};
  const TransportReport carried = transport.carry(fields, params.scalar_advection);
  report.transport_substeps = carried.substeps;
  report.smoke_out += volume * carried.out[0];
  report.heat_out += capacity * carried.out[1];
  // Flame is an indicator, not a stuff: beside walls that close in, transport would pile it above 1.
  parallel_for(state.flame.size(), 1 << 16,
               [&](std::size_t c) { state.flame[c] = std::clamp(state.flame[c], 0.0F, 1.0F); });
  report.smoke_advection = volume * (sum(state.density) - smoke + carried.out[0]);
  report.heat_advection = capacity * (sum(state.temperature) - heat + carried.out[1]);
}

SolveReport AirBox::project(SmokeState& state, const ProjectionInput& input, bool half_done,
                            std::vector<Vec3>* impulse) {
  if (!half_done) return pressure.project(state.velocity, state.pressure, input, impulse);
  std::vector<double>& half = departed;
  half = state.pressure;
  for (double& p : half) p *= 0.5;
  state.pressure = half;
  const SolveReport report = pressure.project(state.velocity, state.pressure, input, impulse);
  parallel_for(half.size(), 65536, [&](std::size_t c) { state.pressure[c] += half[c]; });
  return report;
}

SmokeStepReport AirBox::step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                             const MovableWalls* movable, std::vector<Vec3>* impulse) {
  SmokeStepReport report;
  report.active_cells = grid.cells();

  // Beside walls all of the pressure acts on arrival: pressures from before a wall moved are not those of its
  // present sides, and the impulse on the wall must be that of one solve.
  const bool half_pressure = !walls.any;

  // Keep the flow of the last projection: it carries everything below.
  impose_walls(grid, params.sides, walls, state.velocity);
  transport.set_flow(state.velocity, walls, dt);
  {
    // Sources: what is there fades, then the step's smoke, heat and flame are added.
    StageTimer timer(report.seconds, "forces");
    const Faded faded = fade(state, params, dt);
    report.smoke_out += faded.smoke, report.heat_out += faded.heat;
    add_sources(state, sources, params);
    // Forces: buoyancy of the gas as it is now, body forces, confinement.
    add_forces(state, sources, walls, dt);
    impose_walls(grid, params.sides, walls, state.velocity);
  }
  {
    // Diffusion, implicit in time.
    StageTimer timer(report.seconds, "diffuse");
    diffuse_all(state, walls, dt, report);
  }
  {
    // Advection of the forced velocity by the kept flow.
    StageTimer timer(report.seconds, "advect_velocity");
    if (half_pressure) {
      add_half_pressure(state.velocity, state.pressure, lift_field, grid, params.sides, params.air_density, dt);
    }
    transport.carry(state.velocity, params.velocity_advection);
    impose_walls(grid, params.sides, walls, state.velocity);
  }
  {
    // Advection of smoke, heat and flame by the kept flow.
    StageTimer timer(report.seconds, "advect_scalars");
    carry_scalars(state, report);
  }
  {
    // Projection to t + dt.
    StageTimer timer(report.seconds, "pressure");
    const ProjectionInput input = {.density = params.air_density, .dt = dt, .walls = &walls, .movable = movable};
    report.pressure = project(state, input, half_pressure, impulse);
  }
  report.max_divergence = max_divergence(grid, state.velocity, &walls, nullptr);
  report.max_speed = fastest(state.velocity);
  return report;
}

Window whole_box(const SmokeParams& p) {
  return {{0, 0, 0}, p.resolution};
}

}  // namespace

struct SmokeSolver::Impl {
  SmokeParams params;
  std::optional<AirBox> box;  ///< of the last step

  explicit Impl(const SmokeParams& p) : params(p) { check(p); }
};

SmokeSolver::SmokeSolver(const SmokeParams& params) : impl_(std::make_unique<Impl>(params)) {}
SmokeSolver::~SmokeSolver() = default;
SmokeSolver::SmokeSolver(SmokeSolver&&) noexcept = default;

SmokeStepReport SmokeSolver::step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                                  const MovableWalls* movable, std::vector<Vec3>* impulse) {
  Impl& s = *impl_;
  const std::optional<Window> part = choose_window(state, s.params, sources, walls);
  const Window window = part.value_or(whole_box(s.params));
  if (!s.box || !(s.box->window == window)) s.box.emplace(s.params, window);
  if (!part) {
    state.window.clear();
    return s.box->step(state, sources, walls, dt, movable, impulse);
  }

  // Step a copy of the window as a box of its own.
  const Grid grid = smoke_grid(s.params);
  SmokeState air = crop(state, grid, window);
  const Walls inner_walls = crop(walls, grid, window);
  MovableWalls inner_movable;
  if (movable) inner_movable = crop(*movable, grid, window);
  const SmokeStepReport report =
      s.box->step(air, crop(sources, grid, window), inner_walls, dt, movable ? &inner_movable : nullptr, impulse);
  paste(air, grid, window, state);
  const auto& [low, high] = window;
  state.window = {low[0], low[1], low[2], high[0], high[1], high[2]};
  return report;
}

}  // namespace wick::fluid
