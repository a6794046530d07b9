#include "scenes/rare_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace wick::scenes {

namespace {

/// Strain of unburnt cloth or paper that no load of theirs explains.
constexpr double kOddStretch = 0.25;
/// Part of a quantity that may be lost on a way that no scene asks for without a word.
constexpr double kMuchLost = 0.01;

void add_stretched_shells(const Metrics& metrics, std::vector<std::string>& found) {
  const std::string head = "/shell/", tail = "/max_stretch_unburnt";
  for (const auto& [path, column] : metrics.columns()) {
    if (!path.starts_with(head) || !path.ends_with(tail)) continue;
    // A frame in which the shell had no such number holds NaN.
    const auto most = std::max_element(column.begin(), column.end(),
                                       [](double a, double b) { return std::isnan(a) ? !std::isnan(b) : a < b; });
    if (most == column.end() || !(*most > kOddStretch)) continue;
    const std::vector<double>* frames = metrics.column("/frame");
    found.push_back(
        fmt::format("shell \"{}\" stretched by {:.0f} % where it does not burn (frame {:.0f}): raise its substeps "
                    "or stiffness, or "
                    "see whether obstacles and pins pull it apart",
                    path.substr(head.size(), path.size() - head.size() - tail.size()), 100.0 * *most,
                    (*frames)[static_cast<std::size_t>(most - column.begin())]));
  }
}

void add_cold_shells(const Metrics& metrics, std::vector<std::string>& found) {
  const std::string head = "/shell/", tail = "/theta_max";
  for (const auto& [path, column] : metrics.columns()) {
    if (!path.starts_with(head) || !path.ends_with(tail) || column.size() < 2) continue;
    if (std::any_of(column.begin(), column.end(), [](double theta) { return theta > 0.0; })) continue;
    found.push_back(fmt::format("shell \"{}\" was heated in no frame: none of /heat_sources held a vertex of it",
                                path.substr(head.size(), path.size() - head.size() - tail.size())));
  }
}

void add_losses(const std::map<std::string, Ledger>& ledgers, std::vector<std::string>& found) {
  struct Loss {
    const char *flow, *text;
  };
  constexpr Loss kLosses[] = {
      {"walled_in",
       "was taken out of pockets that walls shut on all sides (walled_in in the ledger): finer cells "
       "resolve them"},
      {"escaped",
       "was given off by sheets outside the box of the gas and is lost (escaped in the ledger): let the box "
       "hold them"}};
  for (const auto& [quantity, ledger] : ledgers)
    for (const Loss& loss : kLosses) {
      const auto flow = ledger.flows().find(loss.flow);
      if (flow == ledger.flows().end()) continue;
      const double share = std::abs(flow->second) / ledger.largest_amount();
      if (share > kMuchLost)
        found.push_back(fmt::format("{:.0f} % of the {} {}", 100.0 * share, quantity, loss.text));
    }
}

}  // namespace

long long total_count(const Metrics& metrics, const std::string& path) {
  long long total = 0;
  if (const auto* column = metrics.column(path))
    for (const double count : *column) total += std::isnan(count) ? 0 : static_cast<long long>(count);
  return total;
}

std::vector<std::string> rare_events(const Metrics& metrics, const std::map<std::string, Ledger>& ledgers) {
  std::vector<std::string> found;
  if (const long long solves = total_count(metrics, "/unconverged_solves"); solves > 0)
    found.push_back(fmt::format(
        "{} solves stopped at their iteration limit, above their tolerance (see /solve in metrics.h5)", solves));
  if (const long long steps = total_count(metrics, "/squeezed_steps"); steps > 0)
    found.push_back(fmt::format(
        "in {} steps closed walls pushed more gas in than out, which cannot flow anywhere: open a side of "
        "/smoke/sides, or keep what moves from entering or squeezing a closed box",
        steps));
  if (const long long pairs = total_count(metrics, "/forced_contacts"); pairs > 0)
    found.push_back(
        fmt::format("contact could not keep sheets apart ({} times): what is held, driven or pinned forced them "
                    "through each other",
                    pairs));
  if (const long long steps = total_count(metrics, "/lengthened_steps"); steps > 0)
    found.push_back(fmt::format(
        "{} steps were longer than asked (/coupling/max_substeps cut them off): raise it, or shorten the frame",
        steps));
  add_stretched_shells(metrics, found);
  add_cold_shells(metrics, found);
  add_losses(ledgers, found);
  return found;
}

}  // namespace wick::scenes
