#include "fluid/smoke.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/forces.h"
#include "fluid/implicit_diffusion.h"

namespace wick::fluid {

namespace {

constexpr std::size_t cell_grain = 32768;

double sum(const CellField& field) {
  return parallel_sum(field.size(), cell_grain, [&](std::size_t begin, std::size_t end) {
    double total = 0.0;
    for (std::size_t i = begin; i < end; ++i) total += field[i];
    return total;
  });
}

/// Largest |value|, whatever its sign.
double largest(const std::vector<float>& field) {
  return parallel_max(field.size(), cell_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    float most = 0.0F;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(field[i]));
    return double(most);
  });
}

double fastest(const FaceField& velocity) {
  return std::max({largest(velocity[0]), largest(velocity[1]), largest(velocity[2])});
}

double cell_volume(const SmokeParams& p) {
  const double h = smoke_grid(p).h;
  return h * h * h;
}
double heat_capacity(const SmokeParams& p) {
  return p.air_density * p.air_heat_capacity * cell_volume(p);
}

}  // namespace

void visit(StateVisitor& visitor, SmokeState& state) {
  visitor.array("velocity_x", state.velocity[0]);
  visitor.array("velocity_y", state.velocity[1]);
  visitor.array("velocity_z", state.velocity[2]);
  visitor.array("pressure", state.pressure);
  visitor.array("density", state.density);
  visitor.array("temperature", state.temperature);
  visitor.array("flame", state.flame);
}

Grid smoke_grid(const SmokeParams& p) {
  return {p.resolution[0], p.resolution[1], p.resolution[2], p.width / p.resolution[0], p.lower};
}

SmokeState make_smoke_state(const SmokeParams& params) {
  const Grid grid = smoke_grid(params);
  SmokeState state;
  state.velocity = make_face_field(grid);
  state.pressure.assign(grid.cells(), 0.0);
  for (CellField* field : {&state.density, &state.temperature, &state.flame}) field->assign(grid.cells(), 0.0F);
  return state;
}

double stable_dt(const SmokeState& state, const SmokeParams& params, const Vec3& gravity) {
  // The speed at the end of the step is v + a dt: solve (v + a dt) dt = cfl h.
  const double v = fastest(state.velocity), path = params.cfl * smoke_grid(params).h;
  const double lift = parallel_max(state.density.size(), cell_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    double most = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double t = state.temperature[i];
      const double pull = params.buoyancy_heat * t / std::max(params.ambient_temperature + t, 1.0) -
                          params.buoyancy_smoke * state.density[i] / params.air_density;
      most = std::max(most, std::abs(pull));
    }
    return most;
  });
  // The curl of a flow of speed v is at most about 4 v/h, so confinement pushes with at most 4 ε v.
  const double a = lift * gravity.cwiseAbs().maxCoeff() + 4.0 * params.vorticity * v;
  if (v == 0.0 && a == 0.0) return std::numeric_limits<double>::infinity();
  return 2.0 * path / (v + std::sqrt(v * v + 4.0 * a * path));
}

double total_smoke(const SmokeState& state, const SmokeParams& params) {
  return cell_volume(params) * sum(state.density);
}

double total_heat(const SmokeState& state, const SmokeParams& params) {
  return heat_capacity(params) * sum(state.temperature);
}

void impose_walls(const Grid& grid, const Sides& sides, const Walls& walls, FaceField& velocity) {
  for (int s = 0; s < 6; ++s) {
    if (sides[s] != Side::closed) continue;
    const int a = s / 2;
    Int3 low = {0, 0, 0}, high = lattice_size(grid, a);
    low[a] = s % 2 ? grid.size(a) : 0;
    high[a] = low[a] + 1;
    for (int k = low[2]; k < high[2]; ++k) {
      for (int j = low[1]; j < high[1]; ++j) {
        for (int i = low[0]; i < high[0]; ++i) velocity[a][grid.face(a, i, j, k)] = 0.0F;
      }
    }
  }
  for (int a = 0; walls.any && a < 3; ++a) {
    parallel_for(velocity[a].size(), cell_grain, [&](std::size_t f) {
      if (walls.closed[a][f]) velocity[a][f] = walls.velocity[a][f];
    });
  }
  join_periodic_faces(grid, sides, velocity);
}

struct SmokeSolver::Impl {
  SmokeParams params;
  Grid grid;
  SideMotion motion;
  Transport transport;
  Confinement confinement;
  PressureSolver pressure;
  Padded lift_field;

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
  report.diffusion = diffuse(grid, params.sides, motion, walls, momentum, state.velocity);
  const DiffusionInput scalars = {.coefficient = params.diffusivity, .dt = dt};
  for (CellField* field : {&state.density, &state.temperature}) {
    const SolveReport solve = diffuse(grid, params.sides, walls, scalars, *field);
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

SmokeStepReport SmokeSolver::step(SmokeState& state, const SmokeSources& sources, const Walls& walls, double dt,
                                  const MovableWalls* movable, std::vector<Vec3>* impulse) {
  Impl& s = *impl_;
  SmokeStepReport report;
  report.active_cells = s.grid.cells();

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
    report.pressure = s.pressure.project(state.velocity, state.pressure, input, impulse);
  }
  report.max_divergence = max_divergence(s.grid, state.velocity, &walls, nullptr);
  report.max_speed = fastest(state.velocity);
  return report;
}

}  // namespace wick::fluid
