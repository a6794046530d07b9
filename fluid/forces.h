#pragma once
/// What changes smoke, heat, flame and velocity where they are: sources, fading, buoyancy, confinement.
#include "fluid/padded.h"
#include "fluid/smoke.h"

namespace wick::fluid {

/// What has left the gas on the spot.
struct Faded {
  double smoke = 0.0;  ///< [kg]
  double heat = 0.0;   ///< [J]
};

/// Lets smoke, heat and flame fade for dt. Each obeys dq/dt = -r q, whose exact solution is q e^{-r dt}.
Faded fade(SmokeState& state, const SmokeParams& params, double dt);

/// Puts the amounts of `sources` into their cells.
void add_sources(SmokeState& state, const SmokeSources& sources, const SmokeParams& params);

/// Upward pull of each cell's gas in units of gravity [Fedkiw 2001, Eq. 8, with the lift of a light gas]:
///   l = b (T - T_amb)/T - a ρ_s/ρ
void lift(const SmokeState& state, const SmokeParams& params, Padded& result);

/// u += dt (-g l + a_body) on open faces.
void add_buoyancy(FaceField& velocity, const Padded& lift, const SmokeSources& sources, const Grid& grid,
                  const Walls& walls, double dt);

/// u -= dt/(2ρ) grad p, from a pressure with one value a cell. `work` is a padded copy of it.
///
/// A parcel feels the pressure all along its path: half of it where it sets out, at t, and half where it
/// arrives, at t + dt. With all of it applied on arrival, as in [Stam 1999], a steady vortex loses energy at a
/// rate of order dt; with the half on departure that error is of order dt² [cf. Zehnder 2018].
void add_half_pressure(FaceField& velocity, const std::vector<double>& pressure, Padded& work, const Grid& grid,
                       const Sides& sides, double density, double dt);

/// Vorticity confinement [Fedkiw 2001, Eqs. 9-11] from the flow at the start of the step:
///   ω = curl u,  N = grad|ω| / |grad|ω||,  u += dt ε h (N × ω)
/// Cells near a wall take no part: their curl would be that of the jump across the wall.
class Confinement {
 public:
  explicit Confinement(const Grid& grid, const Sides& sides);
  /// `flow` in cells a step of dt, with ghosts.
  void add(FaceField& velocity, const std::array<Padded, 3>& flow, const Walls& walls, double epsilon, double dt);

 private:
  Grid grid_;
  Sides sides_;
  std::array<Padded, 3> curl_, push_;
  Padded strength_;
};

}  // namespace wick::fluid
