#pragma once
/// Contact of a point of a sheet with a rigid obstacle: a unilateral position constraint with Coulomb friction.
#include "core/obstacle.h"

namespace wick::solid {

/// Pushes x out to the distance `offset` from the obstacle, then takes back sliding relative to it up to
/// friction times the normal correction [Müller 2007, Macklin 2014]. `previous` is the position at the start of the
/// substep of length h; overlap that was there already is taken out of it too, so that it is undone without gaining
/// speed. A way that is longer than the offset is followed from `previous` on, so that it cannot lead through a
/// thin obstacle. Returns the distance of x to the obstacle afterwards, minus the offset; <= 0 (up to rounding): in
/// contact. The obstacle is given where it was `start` before the substep and moves with its velocity and spin.
double resolve_contact(const Obstacle& obstacle, double start, double h, double offset, Vec3& x, Vec3& previous);

/// A distance shrinks by at most this times the way gone; sampled distances are steeper than true ones.
double steepest_slope(const Obstacle& obstacle);

}  // namespace wick::solid
