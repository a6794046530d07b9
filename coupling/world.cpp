/// The frame as the data flows: World::Impl::substep lists the stages in order, each is one function below it.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/require.h"
#include "coupling/ablation.h"
#include "coupling/idle_parameters.h"
#include "coupling/obstacles.h"
#include "coupling/runaway.h"
#include "coupling/tearing.h"
#include "coupling/world_impl.h"
#include "fluid/smoke_state.h"

namespace wick::coupling {

World::Impl::Impl(const WorldParams& p) : params(p) {
  check_world(params);
  warnings = idle_parameters(params);
  ambient = params.ambient_temperature();
  kelvin = params.temperature_scale();

  for (std::size_t n = 0; n < params.shells.size(); ++n)
    sheets.push_back(build_sheet(params.shells[n], "/shells/" + std::to_string(n), params, warnings));
  look_for_crossings();
  obstacles = build_obstacles(params, warnings);
  aim_obstacles(0.0, params.coupling.max_step);
  require_outside(sheets, obstacles);
  if (params.smoke) {
    gas = fluid::make_smoke_state(*params.smoke);
    gas_solver = std::make_unique<fluid::SmokeSolver>(*params.smoke);
    raster = std::make_unique<Raster>(fluid::smoke_grid(*params.smoke), params.smoke->sides);
  }
  see_sheets();
  if (params.smoke) {
    for (std::string& line : sources_without_gas(params, obstacles, raster->grid()))
      warnings.push_back(std::move(line));
    if (params.diffusion)
      for (std::string& line : sheets_outside(sheets, raster->grid())) warnings.push_back(std::move(line));
  }
  begin_ledgers();
}

void World::Impl::begin_ledgers() {
  if (params.burning) ledgers["solid"];
  if (params.smoke) ledgers["smoke"];
  if (params.smoke || params.diffusion) ledgers["heat"];
  audit();
  for (auto& [quantity, ledger] : ledgers) ledger.open();
}

std::vector<SheetSurface> World::Impl::surfaces() const {
  std::vector<SheetSurface> all;
  for (const Sheet& sheet : sheets) all.push_back(sheet.surface());
  return all;
}

/// Splits what is left of the frame into equal steps, none longer than the fastest part bears.
double World::Impl::longest_step(double left) const {
  double dt = params.coupling.max_step;
  if (params.smoke) {
    dt = std::min(dt, fluid::stable_dt(*gas, *params.smoke, params.gravity));
    const double speed = std::max(fastest_in_box(sheets, raster->grid()),
                                  fastest_in_box(obstacles, raster->grid(), params.coupling.max_step));
    if (speed > 0.0) dt = std::min(dt, params.coupling.sheet_cells * raster->grid().h / speed);
  }
  return left / std::max(1.0, std::ceil(left / dt * (1.0 - 1e-9)));
}

void World::Impl::substep(double dt, FrameReport& report) {
  // The frame as the data flows; each line reads what the lines above have left.
  {
    const StageTimer timer(report.seconds, "smoke");
    move_gas(dt, report);
  }
  {
    const StageTimer timer(report.seconds, "exchange");
    exchange(dt);
  }
  {
    const StageTimer timer(report.seconds, "diffusion");
    diffuse(dt, report);
  }
  {
    const StageTimer timer(report.seconds, "burning");
    react(dt);
    shed_ash();
    move_embers(dt);
  }
  {
    const StageTimer timer(report.seconds, "shell");
    move_sheets(dt, report);
  }
  // The gas is to see the speeds of the step that comes.
  aim_obstacles(time + dt, params.coupling.max_step);
  // Seeing the moved sheet comes last, so that the gas that is written agrees with the meshes that are written.
  {
    const StageTimer timer(report.seconds, "see");
    see_sheets();
  }
  time += dt;
  ++report.substeps;
}

/// Closes the faces that sheets and obstacles cross now, hands over what swept cells hold, and lets out the heat
/// that was squeezed into cells.
void World::Impl::see_sheets() {
  if (!raster || (sheets.empty() && obstacles.empty())) return;
  raster->see(surfaces(), obstacles);
  hand_over();
  stencils.assign(sheets.size(), {});
  for (std::size_t s = 0; s < sheets.size() && params.diffusion; ++s)
    stencils[s] = vertex_stencils(*raster, static_cast<std::int32_t>(s), sheets[s].surface(), obstacles);
  if (!params.burning) return;
  const double hottest = params.burning->flame_temperature - ambient;
  ledgers["heat"].book_flow("walled_in", -spread_excess_heat(*raster, hottest, *params.smoke, gas->temperature));
}

/// Moves what swept cells hold to where it belongs, and notes where the gas has seen everything.
void World::Impl::hand_over() {
  Sweep sweep{.obstacles = &obstacles};
  for (std::size_t n = 0; n < seen_obstacles.size(); ++n)
    sweep.moves.push_back(between(seen_obstacles[n], obstacles[n].pose));
  for (const Sheet& sheet : sheets)
    if (!sheet.seen_x.empty() && (sheet.free() || sheet.driven()))
      sweep.by_sheet.push_back(swept_cells(raster->grid(), sheet.mesh, sheet.seen_x, sheet.state.x));
  const SweptLoss lost = hand_over_swept(*raster, sweep, *params.smoke, *gas);
  for (const auto& [term, smoke, heat] :
       {std::tuple("walled_in", lost.smoke, lost.heat), std::tuple("outflow", lost.smoke_out, lost.heat_out),
        std::tuple("rounding", lost.rounded_smoke, lost.rounded_heat)}) {
    ledgers["smoke"].book_flow(term, -smoke);
    ledgers["heat"].book_flow(term, -heat);
  }
  seen_obstacles.clear();
  for (const Obstacle& obstacle : obstacles) seen_obstacles.push_back(obstacle.pose);
  for (Sheet& sheet : sheets) sheet.seen_x = sheet.state.x;
}

/// Steps the gas with the sheets as walls; leaves the force of the gas on every vertex in `push`.
void World::Impl::move_gas(double dt, FrameReport& report) {
  push.assign(sheets.size(), {});
  if (!gas) return;
  const fluid::SmokeSources sources = gas_sources(params, raster->grid(), raster->walls(), time, dt);
  for (const double kg : sources.smoke) ledgers["smoke"].book_flow("sources", kg);
  for (const double joule : sources.heat) ledgers["heat"].book_flow("sources", joule);

  const bool any_sheet = !raster->hits().empty();
  const bool together = any_sheet && params.coupling.scheme == CouplingScheme::simultaneous;
  std::vector<Vec3> impulse;
  std::optional<fluid::MovableWalls> movable;
  if (together) movable = movable_walls(*raster, surfaces(), inverse_masses(sheets, time + dt));
  const fluid::SmokeStepReport step = gas_solver->step(
      *gas, sources, raster->walls(), dt, together ? &*movable : nullptr, together ? &impulse : nullptr);
  if (any_sheet && !together) impulse = pressure_impulse(*raster, surfaces(), gas->pressure, dt);

  std::size_t dof = 0;
  for (std::size_t s = 0; s < sheets.size() && any_sheet; ++s) {
    push[s].resize(sheets[s].mesh.vertex_count());
    for (Vec3& force : push[s]) force = impulse[dof++] / dt;
  }
  if (params.coupling.scheme == CouplingScheme::partitioned) relax_push();
  ledgers["smoke"].book_flow("outflow", -step.smoke_out);
  ledgers["smoke"].book_flow("advection", step.smoke_advection);
  ledgers["heat"].book_flow("outflow", -step.heat_out);
  ledgers["heat"].book_flow("advection", step.heat_advection);
  note_solve(report, "pressure", step.pressure);
  // rhs_sum is the volume that closed walls push in [m³/s]; below a thousandth of what could leave through one side
  // it is rounding.
  const fluid::Grid& grid = raster->grid();
  const double side = grid.h * grid.h * std::cbrt(std::pow(static_cast<double>(grid.cells()), 2));
  if (step.pressure.rhs_sum > 1e-3 * step.max_speed * side) ++report.squeezed_steps;
  if (params.smoke->viscosity > 0.0 || params.smoke->diffusivity > 0.0)
    note_solve(report, "gas_diffusion", step.diffusion);
  for (const auto& [stage, seconds] : step.seconds) report.seconds["smoke_" + stage] += seconds;
}

/// Gives the sheets of the partitioned scheme a running mean of the gas's force instead of the newest one.
/// The gas answers a change of a sheet's velocity with the added mass μ m, after the fact. Undamped, the change of
/// velocity from step to step is multiplied by -μ, at any step length [Causin 2005]; with the mean
///   F <- F + ω (F_new - F)
/// by 1 - ω (1 + μ), which decays for ω < 2/(1 + μ) and leaves steady motion what it is. A plate of half size l
/// carries about ρ l of gas an area: ω = m/(m + ρ l).
void World::Impl::relax_push() {
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    Sheet& sheet = sheets[s];
    push[s].resize(sheet.mesh.vertex_count(), Vec3::Zero());
    Eigen::AlignedBox3d box;
    for (const Vec3& x : sheet.state.x) box.extend(x);
    const double gas_mass = params.smoke->air_density * 0.5 * box.diagonal().norm();
    for (std::size_t i = 0; i < push[s].size(); ++i) {
      const double mass = sheet.inputs.mass[i];
      const double share = params.coupling.relaxation > 0.0 ? params.coupling.relaxation
                           : mass > 0.0                     ? mass / (mass + gas_mass * sheet.mesh.vertex_area[i])
                                                            : 0.0;
      sheet.gas_force[i] += share * (push[s][i] - sheet.gas_force[i]);
    }
    push[s] = sheet.gas_force;
  }
}

/// Heat crosses between sheets and gas: u_ext of the paper, taken from the cells that each face sees.
void World::Impl::exchange(double dt) {
  heat_in.assign(sheets.size(), {});
  hotter_side.assign(sheets.size(), {});
  if (!params.diffusion) return;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    heat_in[s].assign(sheets[s].mesh.vertex_count(), 0.0);
    hotter_side[s].assign(sheets[s].mesh.vertex_count(), 0.0);
    if (gas)
      exchange_heat(stencils[s], sheets[s].mesh.vertex_area, sheets[s].theta, sheets[s].heat_capacity,
                    {ambient, kelvin}, params.heat.convection, dt, *params.smoke, *gas, heat_in[s], hotter_side[s]);
  }
}

/// The paper's Eqs (8a)-(8g) on every sheet.
void World::Impl::diffuse(double dt, FrameReport& report) {
  if (!params.diffusion) return;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    Sheet& sheet = sheets[s];
    const SheetSupply supply = sheet_supply(params, sheet, ambient, kelvin, time, dt);
    diffusion::DiffusionInput input{.mesh = &sheet.mesh, .x = &sheet.state.x};
    input.rest_scale = &sheet.rest_scale();
    input.mass = &sheet.heat_capacity;
    input.loss = &supply.loss;
    input.supply_rate = supply.any ? &supply.rate : nullptr;
    input.supply_value = supply.any ? &supply.value : nullptr;
    input.amount = &heat_in[s];
    input.capacity = params.diffusion->capacity;
    input.gravity = params.gravity;
    if (params.burning) input.fraction_left = &sheet.burning.fraction_left;
    const diffusion::DiffusionReport step = sheet.diffusion->step(sheet.theta, input, dt);
    Ledger& heat = ledgers["heat"];
    double from_gas = 0.0;
    for (const double joule : heat_in[s]) from_gas += joule;
    heat.book_flow("heat_sources", step.supplied - from_gas);
    heat.book_flow("loss", -step.lost);
    heat.book_flow("sigma", step.sigma_source);
    heat.book_flow("excess", -step.excess);
    note_solve(report, "diffusion", step.solve);
    sheet.report.diffusion = step;
    // Kept for the frame's mesh: triangles that fall away next end the solver.
    sheet.strain_added = sheet.diffusion->strain_vertex();
  }
}

/// Hot places lose mass, which heats the sheet and becomes smoke and heat in the gas.
void World::Impl::react(double dt) {
  if (!params.burning) return;
  const BurningParams& burning = *params.burning;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    Sheet& sheet = sheets[s];
    const std::vector<double> lost =
        lose_mass(sheet.burning, burning, sheet.theta, hotter_side[s], ambient, ambient + kelvin, dt);
    const std::size_t count = lost.size();
    std::vector<double> smoke(count), heat(count), flame(count);
    double burnt = 0.0, kept_heat = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double kg = lost[i] * sheet.areal_mass * sheet.mesh.vertex_area[i];
      burnt += kg;
      kept_heat += burning.sheet_heat * lost[i] * sheet.heat_capacity[i];
      sheet.theta[i] += burning.sheet_heat * lost[i];
      smoke[i] = burning.smoke_yield * kg;
      heat[i] = burning.gas_heat * lost[i] * sheet.heat_capacity[i];
      flame[i] = std::min(1.0, lost[i] / (dt * burning.flame_rate));
    }
    ledgers["solid"].book_flow("smoke", -burning.smoke_yield * burnt);
    ledgers["solid"].book_flow("gas", -(1.0 - burning.smoke_yield) * burnt);
    ledgers["heat"].book_flow("combustion", kept_heat);
    if (!gas) continue;
    const Deposited deposited =
        deposit(stencils[s], smoke, heat, flame, burning.flame_temperature - ambient, *params.smoke, *gas);
    ledgers["smoke"].book_flow("burning", deposited.smoke + deposited.escaped_smoke);
    ledgers["smoke"].book_flow("escaped", -deposited.escaped_smoke);
    ledgers["heat"].book_flow("combustion", deposited.heat + deposited.escaped_heat);
    ledgers["heat"].book_flow("escaped", -deposited.escaped_heat);
  }
}

/// Ash leaves the sheets, and takes its mass and heat along.
void World::Impl::shed_ash() {
  if (!params.burning) return;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    const Ablated gone = ablate(sheets[s], params, push[s]);
    ledgers["solid"].book_flow("ash", -gone.mass);
    ledgers["heat"].book_flow("ash", -gone.heat);
    const std::size_t shed = shed_embers(sheets[s], params, push[s], embers);
    if (gone.any || shed > 0) contact.reset();
  }
}

void World::Impl::move_embers(double dt) {
  if (!params.burning || embers.size() == 0) return;
  const std::vector<Vec3> air =
      gas ? gas_velocity_at(*gas, raster->grid(), embers.x) : wind_at(params, embers.x, time);
  const EmberLoss lost = step_embers(embers, params, air, obstacles, gas ? &raster->grid() : nullptr, dt);
  ledgers["solid"].book_flow("ash", -lost.mass);
  ledgers["heat"].book_flow("ash", -lost.heat);
  ledgers["heat"].book_flow("loss", -lost.radiated);
}

/// Rest shape, weight and stiffness follow the burning; then XPBD small steps under gravity and the gas's push, in
/// parts between which overstrained sheets tear.
void World::Impl::move_sheets(double dt, FrameReport& report) {
  const int parts = tearing_checks(sheets, dt);
  for (int n = 1; n <= parts; ++n) {
    const double end = time + dt * n / parts;
    aim_obstacles(end - dt / parts, dt / parts);
    if (params.contact)
      move_sheets_together(end, dt / parts, report);
    else
      for (std::size_t s = 0; s < sheets.size(); ++s) move_sheet(s, end, dt / parts);
    for (Obstacle& obstacle : obstacles) obstacle.advance(dt / parts);
    for (std::size_t s = 0; s < sheets.size(); ++s)
      if (tear_sheet(sheets[s], params, push[s]) > 0) contact.reset();
  }
}

void World::Impl::aim_obstacles(double t, double dt) {
  for (std::size_t n = 0; n < obstacles.size(); ++n) aim(obstacles[n], params.obstacles[n], t, dt);
}

void World::Impl::move_sheet(std::size_t s, double end, double dt) {
  Sheet& sheet = sheets[s];
  if (sheet.driven()) follow_motion(sheet, end, dt);
  refresh_inputs(sheet, params);
  if (!sheet.shell) return;
  const std::vector<Vec3> air = gas ? std::vector<Vec3>{} : wind_at(params, sheet.state.x, end - dt);
  const solid::Pins pins = pins_at(sheet, end);
  sheet.report.shell =
      sheet.shell->step(sheet.state, sheet.mesh, {sheet.inputs, pins, obstacles, push[s], air, params.gravity}, dt);
}

/// States what every part holds now.
void World::Impl::audit() {
  double mass = 0.0, heat = 0.0;
  for (const Sheet& sheet : sheets) {
    for (std::size_t i = 0; i < sheet.theta.size(); ++i) heat += sheet.heat_capacity[i] * sheet.theta[i];
    for (std::size_t i = 0; i < sheet.burning.fraction_left.size(); ++i)
      mass += sheet.areal_mass * sheet.mesh.vertex_area[i] * sheet.burning.fraction_left[i];
  }
  if (params.diffusion) ledgers["heat"].set_stock("sheet", heat);
  if (params.burning) {
    ledgers["solid"].set_stock("sheet", mass);
    ledgers["solid"].set_stock("embers", embers.total_mass());
    ledgers["heat"].set_stock("embers", embers.total_heat());
  }
  if (!gas) return;
  ledgers["smoke"].set_stock("grid", fluid::total_smoke(*gas, *params.smoke));
  ledgers["heat"].set_stock("gas", fluid::total_heat(*gas, *params.smoke));
}

FrameReport World::step(double dt, FunctionRef<bool()> stop) {
  require(dt > 0.0 && std::isfinite(dt), "/fps", "gives a frame without a length");
  Impl& world = *impl_;
  const bool resumed = world.frame_end.has_value();
  FrameReport report = resumed ? std::exchange(world.unfinished, {}) : FrameReport{};
  const double end = resumed ? *world.frame_end : world.time + dt;
  world.frame_end.reset();
  for (double left = resumed ? end - world.time : dt; left > 0.0; left = end - world.time) {
    double step = world.longest_step(left);
    if (report.substeps == 0) report.steps_foreseen = left / step;
    require_no_runaway({world.params, world.sheets, world.gas ? &*world.gas : nullptr, world.frame + 1, world.time,
                        step, report.substeps + left / step, report.steps_foreseen, report.lengthened_steps});
    // Past the cap the rest of the frame is one equal share of what is left: counted, not hidden.
    const int remaining = world.params.coupling.max_substeps - report.substeps;
    if (left / step > std::max(remaining, 1)) {
      step = left / std::max(remaining, 1);
      ++report.lengthened_steps;
    }
    const bool last = step >= left * (1.0 - 1e-12);
    world.substep(step, report);
    if (last) world.time = end;
    if (world.time < end && stop()) {
      world.frame_end = end;
      world.unfinished = report;
      report.complete = false;
      break;
    }
  }
  {
    const StageTimer timer(report.seconds, "audit");
    world.audit();
  }
  if (report.complete) ++world.frame;
  report.frame = world.frame;
  report.time = world.time;
  return report;
}

}  // namespace wick::coupling
