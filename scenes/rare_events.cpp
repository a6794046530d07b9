#include "scenes/rare_events.h"

#include <fmt/format.h>

namespace wick::scenes {

void RareEvents::add(const coupling::FrameReport& report) {
  unconverged_solves_ += report.unconverged_solves;
  lengthened_steps_ += report.lengthened_steps;
  squeezed_steps_ += report.squeezed_steps;
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
        "/smoke/sides, or keep obstacles from entering a closed box",
        squeezed_steps_));
  if (lengthened_steps_ > 0)
    found.push_back(fmt::format(
        "{} steps were longer than asked (/coupling/max_substeps cut them off): raise it, or shorten the frame",
        lengthened_steps_));
  return found;
}

}  // namespace wick::scenes
