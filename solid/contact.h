#pragma once
/// Contact of vertices with rigid obstacles: unilateral position constraints with Coulomb friction.
#include "core/obstacle.h"
#include "solid/lanes.h"

namespace wick::solid {

/// Pushes x out to the distance `offset` from the obstacle, then takes back sliding relative to it up to
/// friction times the normal correction [Müller 2007, Macklin 2014]. `previous` is the position at the start of the
/// substep of length h; overlap that was there already is taken out of it too, so that it is undone without gaining
/// speed. Returns the distance of x to the obstacle afterwards, minus the offset; <= 0 (up to rounding): in
/// contact. The obstacle is given where it was `start` before the substep and moves with its velocity.
double resolve_contact(const Obstacle& obstacle, double start, double h, double offset, Vec3& x, Vec3& previous);

}  // namespace wick::solid
