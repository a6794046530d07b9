#include "scenes/rare_events.h"

#include <fmt/format.h>

#include <cmath>

namespace wick::scenes {

namespace {

constexpr double kOddStretch = 0.25;
constexpr double kMuchWalledIn = 0.01;

}  // namespace

void RareEvents::add(const coupling::FrameReport& report) {
  unconverged_solves_ += report.unconverged_solves;
  lengthened_steps_ += report.lengthened_steps;
  squeezed_steps_ += report.squeezed_steps;
}

void RareEvents::look_at(int frame, const std::map<std::string, std::map<std::string, double>>& shells,
                         const std::map<std::string, Ledger>& ledgers) {
  for (const auto& [name, metrics] : shells) {
    const auto found = metrics.find("max_stretch_unburnt");
    if (found == metrics.end() || !(found->second > kOddStretch)) continue;
    Stretch& most = stretched_[name];
    if (found->second > most.strain) most = {found->second, frame};
  }
  for (const auto& [quantity, ledger] : ledgers) {
    const auto flow = ledger.flows().find("walled_in");
    if (flow == ledger.flows().end()) continue;
    const double share = std::abs(flow->second) / ledger.largest_amount();
    if (share > kMuchWalledIn)
      walled_in_[quantity] = share;
    else
      walled_in_.erase(quantity);
  }
}

std::vector<std::string> RareEvents::warnings() const {
  std::vector<std::string> found;
  if (unconverged_solves_ > 0)
    found.push_back(
        fmt::format("{} solves stopped at their iteration limit, above their tolerance (see /solve in metrics.h5)",
                    unconverged_solves_));
  if (squeezed_steps_ > 0)
    found.push_back(fmt::format(
        "in {} steps closed walls pushed more gas in than out, which cannot flow anywhere: open a side of "
        "/smoke/sides, or keep what moves from entering or squeezing a closed box",
        squeezed_steps_));
  if (lengthened_steps_ > 0)
    found.push_back(fmt::format(
        "{} steps were longer than asked (/coupling/max_substeps cut them off): raise it, or shorten the frame",
        lengthened_steps_));
  for (const auto& [name, most] : stretched_)
    found.push_back(fmt::format(
        "shell \"{}\" stretched by {:.0f} % where it does not burn (frame {}): raise its substeps or stiffness, "
        "or see whether obstacles and pins pull it apart",
        name, 100.0 * most.strain, most.frame));
  for (const auto& [quantity, share] : walled_in_)
    found.push_back(
        fmt::format("{:.0f} % of the {} was taken out of pockets that walls shut on all sides (walled_in in the "
                    "ledger): finer cells "
                    "resolve them",
                    100.0 * share, quantity));
  return found;
}

}  // namespace wick::scenes
