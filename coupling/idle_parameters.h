#pragma once
/// Parameters of one section that have no effect beside those of another, where the list of neither can tell.
#include <string>
#include <vector>

#include "coupling/world_params.h"

namespace wick::coupling {

/// A warning for each parameter that differs from its default and has no effect, with its pointer in front.
std::vector<std::string> idle_parameters(const WorldParams& params);

}  // namespace wick::coupling
