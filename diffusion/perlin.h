#pragma once
/// Gradient noise [Perlin 2002]: smooth, about zero, features one unit across.
#include <cstdint>

#include "core/types.h"

namespace wick::diffusion {

/// Noise at p, in [-1, 1], 0 at the points of the integer lattice, twice differentiable. Another seed gives another
/// pattern.
double perlin(const Vec3& p, std::uint64_t seed);

}  // namespace wick::diffusion
