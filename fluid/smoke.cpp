#include "fluid/smoke.h"

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/forces.h"
#include "fluid/implicit_diffusion.h"
#include "fluid/smoke_state.h"

namespace wick::fluid {

struct SmokeSolver::Impl {
  SmokeParams params;
  Grid grid;
  SideMotion motion;
  Transport transport;
  Confinement confinement;
  PressureSolver pressure;
  Padded lift_field;
  DiffusionWork diffusion_work;
  std::vector<double> departed;

  explicit Impl(const SmokeParams& p)
      : params((check(p), p)),
        grid(smoke_grid(p)),
        motion{p.no_slip, p.side_velocity},
        transport(grid, p.sides, motion),
        confinement(grid, p.sides),
        pressure(grid, p.sides, p.pressure) {
    lift_field.reshape({grid.nx, grid.ny, grid.nz}, {1, 1, 1});
  }

  void add_forces(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt);
  void diffuse_all(SmokeState& state, const Walls& walls, double dt, SmokeStepReport& report);
  void carry_scalars(SmokeState& state, SmokeStepReport& report);
  SolveReport project(SmokeState& state, const ProjectionInput& input, bool half_done, std::vector<Vec3>* impulse);
};

SmokeSolver::SmokeSolver(const SmokeParams& params) : impl_(std::make_unique<Impl>(params)) {}
SmokeSolver::~SmokeSolver() = default;
SmokeSolver::SmokeSolver(SmokeSolver&&) noexcept = default;

void SmokeSolver::Impl::add_forces(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt) {
  lift(state, params, lift_field);
  lift_field.fill_ghosts(scalar_ghosts(params.sides));
  add_buoyancy(state.velocity, lift_field, sources, grid, walls, dt);
  confinement.add(state.velocity, transport.flow(), walls, params.vorticity, dt);
}

void SmokeSolver::Impl::diffuse_all(SmokeState& state, const Walls& walls, double dt, SmokeStepReport& report) {
  const DiffusionInput momentum = {.coefficient = params.viscosity, .dt = dt};
  report.diffusion = diffuse(grid, params.sides, motion, walls, momentum, state.velocity, diffusion_work);
  const DiffusionInput scalars = {.coefficient = params.diffusivity, .dt = dt};
  for (CellField* field : {&state.density, &state.temperature}) {
    const SolveReport solve = diffuse(grid, params.sides, walls, scalars, *field, diffusion_work);
    if (solve.iterations > report.diffusion.iterations || !solve.converged) report.diffusion = solve;
  }
}

void SmokeSolver::Impl::carry_scalars(SmokeState& state, SmokeStepReport& report) {
  const double volume = cell_volume(params), capacity = heat_capacity(params);
  const double smoke = sum(state.density), heat = sum(state.temperature);
  CellField* const fields[] = {&state.density, &state.temperature, &state.flame};
  const TransportReport carried = transport.carry(fields, params.scalar_advection);
  report.transport_substeps = carried.substeps;
  report.smoke_out += volume * carried.out[0];
  report.heat_out += capacity * carried.out[1];
  report.smoke_advection = volume * (sum(state.density) - smoke + carried.out[0]);
  report.heat_advection = capacity * (sum(state.temperature) - heat + carried.out[1]);
}

SolveReport SmokeSolver::Impl::project(SmokeState& state, const ProjectionInput& input, bool half_done,
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

SmokeStepReport SmokeSolver::step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                                  const MovableWalls* movable, std::vector<Vec3>* impulse) {
  Impl& s = *impl_;
  SmokeStepReport report;
  report.active_cells = s.grid.cells();

  // Beside walls all of the pressure acts on arrival: pressures from before a wall moved are not those of its
  // present sides, and the impulse on the wall must be that of one solve.
  const bool half_pressure = !walls.any;

  // Keep the flow of the last projection: it carries everything below.
  impose_walls(s.grid, s.params.sides, walls, state.velocity);
  s.transport.set_flow(state.velocity, walls, dt);
  {
    // Sources: what is there fades, then the step's smoke, heat and flame are added.
    StageTimer timer(report.seconds, "forces");
    const Faded faded = fade(state, s.params, dt);
    report.smoke_out += faded.smoke, report.heat_out += faded.heat;
    add_sources(state, sources, s.params);
    // Forces: buoyancy of the gas as it is now, body forces, confinement.
    s.add_forces(state, sources, walls, dt);
    impose_walls(s.grid, s.params.sides, walls, state.velocity);
  }
  {
    // Diffusion, implicit in time.
    StageTimer timer(report.seconds, "diffuse");
    s.diffuse_all(state, walls, dt, report);
  }
  {
    // Advection of the forced velocity by the kept flow.
    StageTimer timer(report.seconds, "advect_velocity");
    if (half_pressure) {
      add_half_pressure(state.velocity, state.pressure, s.lift_field, s.grid, s.params.sides, s.params.air_density,
                        dt);
    }
    s.transport.carry(state.velocity, s.params.velocity_advection);
    impose_walls(s.grid, s.params.sides, walls, state.velocity);
  }
  {
    // Advection of smoke, heat and flame by the kept flow.
    StageTimer timer(report.seconds, "advect_scalars");
    s.carry_scalars(state, report);
  }
  {
    // Projection to t + dt.
    StageTimer timer(report.seconds, "pressure");
    const ProjectionInput input = {.density = s.params.air_density, .dt = dt, .walls = &walls, .movable = movable};
    report.pressure = s.project(state, input, half_pressure, impulse);
  }
  report.max_divergence = max_divergence(s.grid, state.velocity, &walls, nullptr);
  report.max_speed = fastest(state.velocity);
  return report;
}

}  // namespace wick::fluid
