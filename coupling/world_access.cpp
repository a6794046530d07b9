/// Looking at the world from outside, and saving and restoring it.
#include <algorithm>

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

std::vector<std::string> World::models() const {
  std::vector<std::string> names;
  const WorldParams& p = impl_->params;
  const auto moving = [](const Sheet& sheet) { return sheet.shell != nullptr; };
  if (std::any_of(impl_->sheets.begin(), impl_->sheets.end(), moving)) names.emplace_back("shell");
  if (p.diffusion) names.emplace_back("diffusion");
  if (p.smoke) names.emplace_back("smoke");
  if (p.burning) names.emplace_back("burning");
  return names;
}

std::vector<ShellView> World::shells() const {
  std::vector<ShellView> views;
  for (const Sheet& sheet : impl_->sheets) {
    ShellView view{sheet.name, &sheet.mesh, &sheet.state.x, &sheet.state.v, {}};
    add_shown_values(view, sheet, impl_->ambient, impl_->kelvin);
    views.push_back(std::move(view));
  }
  return views;
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
    visitor.group("obstacle_" + std::to_string(n),
                  [&] { visitor.value("displacement", world.obstacles[n].displacement); });
  if (world.gas) visitor.group("smoke", [&] { fluid::visit(visitor, *world.gas); });
  for (auto& [quantity, ledger] : world.ledgers)
    visitor.group("ledger_" + quantity, [&] { ledger.visit(visitor); });
}

void World::restored() {
  for (Sheet& sheet : impl_->sheets) {
    rebuild_topology(sheet, impl_->params);
    sheet.seen_x.clear();  // the gas of the state already agrees with the sheet's place
  }
  impl_->see_sheets();
}

std::uint64_t World::state_hash() {
  StateHash hash;
  visit(hash);
  return hash.digest();
}

std::uint64_t World::estimate_bytes(const WorldParams& params) {
  return estimate_world_bytes(params);
}

}  // namespace wick::coupling
