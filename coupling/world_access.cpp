/// Looking at the world from outside, and saving and restoring it.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "coupling/obstacles.h"
#include "coupling/world_impl.h"

namespace wick::coupling {

World::World(const WorldParams& params) : impl_(std::make_unique<Impl>(params)) {}

World::~World() = default;

int World::frame() const {
  return impl_->frame;
}

double World::time() const {
  return impl_->time;
}

const fluid::SmokeState* World::smoke() const {
  return impl_->gas ? &*impl_->gas : nullptr;
}

const std::map<std::string, Ledger>& World::ledgers() const {
  return impl_->ledgers;
}

const std::vector<std::string>& World::warnings() const {
  return impl_->warnings;
}

std::vector<std::string> World::models() const {
  std::vector<std::string> names;
  const WorldParams& p = impl_->params;
  const auto moving = [](const Sheet& sheet) { return sheet.shell != nullptr; };
  if (std::any_of(impl_->sheets.begin(), impl_->sheets.end(), moving)) names.emplace_back("shell");
  if (p.contact) names.emplace_back("contact");
  if (p.diffusion) names.emplace_back("diffusion");
  if (p.smoke) names.emplace_back("smoke");
  if (p.burning) names.emplace_back("burning");
  return names;
}

std::vector<ShellView> World::shells() const {
  std::vector<ShellView> views;
  for (const Sheet& sheet : impl_->sheets) {
    ShellView view{sheet.name, &sheet.mesh, &sheet.state.x, &sheet.state.v, {}, &sheet.original};
    add_shown_values(view, sheet, impl_->ambient, impl_->kelvin);
    views.push_back(std::move(view));
  }
  return views;
}

EmberView World::embers() const {
  const EmberState& state = impl_->embers;
  EmberView view{&state.x, &state.v, &state.id, {}, {}};
  for (const double theta : state.theta)
    view.temperature.push_back(static_cast<float>(impl_->ambient + impl_->kelvin * theta));
  for (const double area : state.area) view.radius.push_back(static_cast<float>(std::sqrt(area / M_PI)));
  return view;
}

const std::vector<Obstacle>& World::obstacles() const {
  return impl_->obstacles;
}

std::map<std::string, std::map<std::string, double>> World::shell_metrics() const {
  std::map<std::string, std::map<std::string, double>> metrics;
  for (const Sheet& sheet : impl_->sheets) metrics[sheet.name] = sheet_metrics(sheet);
  return metrics;
}

void World::visit(StateVisitor& visitor) {
  Impl& world = *impl_;
  std::int32_t frame = world.frame;
  visitor.value("frame", frame);
  world.frame = frame;
  visitor.value("time", world.time);
  for (std::size_t s = 0; s < world.sheets.size(); ++s)
    visitor.group("sheet_" + std::to_string(s), [&] { coupling::visit(visitor, world.sheets[s]); });
  for (std::size_t n = 0; n < world.obstacles.size(); ++n)
    visitor.group("obstacle_" + std::to_string(n), [&] { coupling::visit(visitor, world.obstacles[n]); });
  if (world.params.burning) visitor.group("embers", [&] { coupling::visit(visitor, world.embers); });
  if (world.gas) visitor.group("smoke", [&] { fluid::visit(visitor, *world.gas); });
  for (auto& [quantity, ledger] : world.ledgers)
    visitor.group("ledger_" + quantity, [&visitor, &ledger = ledger] { ledger.visit(visitor); });
  visitor.group("unfinished_frame", [&] { world.visit_unfinished(visitor); });
}

/// The end of an unfinished frame and its report; nothing between frames, so that no clock enters their hash.
void World::Impl::visit_unfinished(StateVisitor& visitor) {
  std::vector<double> end, seconds, solve_values;
  std::vector<std::string> stages, solvers;
  std::vector<std::int32_t> counts;
  if (frame_end) {
    end = {*frame_end, unfinished.steps_foreseen};
    counts = {unfinished.substeps, unfinished.unconverged_solves, unfinished.lengthened_steps,
              unfinished.squeezed_steps, unfinished.forced_contacts};
  }
  for (const auto& [stage, spent] : unfinished.seconds) {
    stages.push_back(stage);
    seconds.push_back(spent);
  }
  for (const auto& [solver, s] : unfinished.solves) {
    solvers.push_back(solver);
    solve_values.insert(solve_values.end(), {double(s.iterations), s.residual_before, s.residual_after, s.rhs_sum,
                                             s.converged ? 1.0 : 0.0, s.seconds});
  }
  visitor.array("end", end);
  visitor.array("counts", counts);
  visitor.array("stages", stages);
  visitor.array("seconds", seconds);
  visitor.array("solvers", solvers);
  visitor.array("solve_values", solve_values);
  const bool any = !end.empty();
  const bool fits = (!any || end.size() == 2) && counts.size() == (any ? 5 : 0) &&
                    seconds.size() == stages.size() && solve_values.size() == 6 * solvers.size();
  if (!fits) throw std::runtime_error("the unfinished frame of a checkpoint does not fit together");
  frame_end.reset();
  unfinished = {};
  if (!any) return;
  frame_end = end[0];
  unfinished.steps_foreseen = end[1];
  unfinished.substeps = counts[0];
  unfinished.unconverged_solves = counts[1];
  unfinished.lengthened_steps = counts[2];
  unfinished.squeezed_steps = counts[3];
  unfinished.forced_contacts = counts[4];
  for (std::size_t i = 0; i < stages.size(); ++i) unfinished.seconds[stages[i]] = seconds[i];
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    const double* v = &solve_values[6 * i];
    unfinished.solves[solvers[i]] = {static_cast<int>(v[0]), v[1], v[2], v[3], v[4] != 0.0, v[5]};
  }
}

void World::restored() {
  impl_->seen_obstacles.clear();
  impl_->contact.reset();
  for (Sheet& sheet : impl_->sheets) {
    rebuild_topology(sheet, impl_->params);
    sheet.seen_x.clear();  // the gas of the state already agrees with the sheet's place
  }
  impl_->aim_obstacles(impl_->time, impl_->params.coupling.max_step);
  impl_->see_sheets();
}

std::uint64_t World::state_hash() {
  StateHash hash;
  visit(hash);
  return hash.digest();
}

std::vector<MemoryShare> World::estimate_memory(const WorldParams& params) {
  return world_memory(params);
}

}  // namespace wick::coupling
