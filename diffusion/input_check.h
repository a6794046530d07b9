#pragma once
#include <vector>

#include "diffusion/strain_diffusion.h"

namespace wick::diffusion {

/// Refuses fields of the wrong size, values that are not finite, negative masses and rates, and a negative time
/// step, before they reach a solver.
void require_input(const std::vector<double>& u, const DiffusionInput& in, double dt);

}  // namespace wick::diffusion
