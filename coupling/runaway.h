#pragma once
/// Stops a run that only goes on by following its own error, and names what is most likely at fault.
#include <vector>

#include "coupling/sheet.h"
#include "fluid/smoke.h"

namespace wick::coupling {

/// The world between two substeps.
struct StepOutlook {
  const WorldParams& params;
  const std::vector<Sheet>& sheets;
  const fluid::SmokeState* gas;  ///< null without smoke
  int frame;                     ///< being computed
  double time;                   ///< [s]
  double step;                   ///< that the fastest part bears now [s]
  double wanted_steps;           ///< of this frame: done, and still to do at that length
  double first_wanted;           ///< when the frame began
  int lengthened_steps;          ///< of this frame so far
};

/// Throws Refusal (numerical_failure) where a partitioned run needs more steps than a frame may have, or where in
/// any run something is faster than no scene can make it. The pointer is that of the parameter to change.
void require_no_runaway(const StepOutlook& outlook);

}  // namespace wick::coupling
