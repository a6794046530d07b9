#include "core/parameters.h"
#include "core/require.h"
#include "fluid/smoke.h"

namespace wick::fluid {

namespace {

constexpr const char* side_names[] = {"closed", "open", "periodic"};
constexpr const char* side_keys[] = {"-x", "+x", "-y", "+y", "-z", "+z"};
constexpr const char* velocity_schemes[] = {"semi_lagrangian", "maccormack"};
constexpr const char* scalar_schemes[] = {"semi_lagrangian", "maccormack", "conservative"};

void describe_sides(ParameterVisitor& v, Sides& sides) {
  for (int s = 0; s < 6; ++s) {
    v.choice({side_keys[s], "", any_value(),
              "what this side does to the air; both sides of an axis are periodic, or neither"},
             sides[s], side_names);
  }
}

void describe_side_velocity(ParameterVisitor& v, std::array<Vec3, 6>& velocity) {
  for (int s = 0; s < 6; ++s) {
    v.vector({side_keys[s], "m/s", any_value(), "velocity along this side; used when closed and no_slip"},
             velocity[s]);
  }
}

void describe_forces(ParameterVisitor& v, SmokeParams& p) {
  v.number({"buoyancy_heat", "1", between(-1e3, 1e3), "b, multiplies the lift g (T - T_amb)/T; 1 is physical",
            OnResume::may_change},
           p.buoyancy_heat);
  v.number({"buoyancy_smoke", "1", between(-1e3, 1e3),
            "a, multiplies the weight g rho_s/rho of the smoke; 1 is physical", OnResume::may_change},
           p.buoyancy_smoke);
  v.number({"vorticity", "1/s", between(0, 1e6),
            "confinement eps [Fedkiw 2001]; too large: boiling noise at the grid scale", OnResume::may_change},
           p.vorticity);
  v.number({"viscosity", "m2/s", at_least(0), "nu of the air; 1.5e-5 is physical and below what a grid can show",
            OnResume::may_change},
           p.viscosity);
  v.number(
      {"diffusivity", "m2/s", at_least(0), "k of smoke and heat; too large: smoke blurs", OnResume::may_change},
      p.diffusivity);
}

void describe_fading(ParameterVisitor& v, SmokeParams& p) {
  v.number({"dissipation", "1/s", at_least(0), "rate at which smoke fades, booked as gone", OnResume::may_change},
           p.dissipation);
  v.number({"cooling", "1/s", at_least(0),
            "rate at which the gas loses its excess heat, booked; too large: plumes stall", OnResume::may_change},
           p.cooling);
  v.number(
      {"flame_life", "s", between(1e-6, 1e6),
       "time in which the flame coordinate falls by e; too large: flames trail like smoke", OnResume::may_change},
      p.flame_life);
}

}  // namespace

void describe(ParameterVisitor& v, SmokeParams& p) {
  v.vector({"resolution", "1", between(1, 4096), "cells along x, y, z"}, p.resolution);
  v.vector({"lower", "m", between(-1e5, 1e5), "lower corner of the box"}, p.lower);
  v.number({"width", "m", between(1e-5, 1e6), "extent of the box along x; cells are cubes of width/nx"}, p.width);
  v.group("sides", "what each side of the box does", [&](ParameterVisitor& g) { describe_sides(g, p.sides); });
  v.number({"cfl", "1", above_up_to(0, 100),
            "cells that the fastest flow may cross in one step; too large: smeared detail", OnResume::may_change},
           p.cfl);
  v.choice({"velocity_advection", "", any_value(), "how velocity is carried; semi_lagrangian damps eddies",
            OnResume::may_change},
           p.velocity_advection, velocity_schemes);
  v.choice(
      {"scalar_advection", "", any_value(),
       "how smoke, heat and flame are carried; conservative keeps their sums to rounding, the others make or lose "
       "both, most of all beside sheets",
       OnResume::may_change},
      p.scalar_advection, scalar_schemes);
  v.number({"air_density", "kg/m3", between(1e-6, 1e6), "rho of the air"}, p.air_density);
  v.number({"air_heat_capacity", "J/(kg K)", between(1e-3, 1e9), "c_p of the air"}, p.air_heat_capacity);
  v.number({"ambient_temperature", "K", between(1, 5000), "T_amb, far from any fire"}, p.ambient_temperature);
  describe_forces(v, p);
  describe_fading(v, p);
  v.flag({"no_slip", "", any_value(), "closed sides hold the air beside them (needs viscosity to be seen)"},
         p.no_slip);
  v.only(p.no_slip, "no_slip is false", [&] {
    v.group("side_velocity", "velocity of the sides that hold the air beside them",
            [&](ParameterVisitor& g) { describe_side_velocity(g, p.side_velocity); });
  });
  v.flag({"active_window", "", any_value(),
          "step only the part of the box that smoke, heat and motion can reach; changes a flow as a tenth of a "
          "percent of lift does",
          OnResume::may_change},
         p.active_window);
  v.nested("pressure", "the pressure solve", p.pressure);
}

void check(const SmokeParams& p) {
  for (int a = 0; a < 3; ++a) {
    const bool low = p.sides[2 * a] == Side::periodic, high = p.sides[2 * a + 1] == Side::periodic;
    require(
        low == high, "/smoke/sides",
        std::string("one side of an axis is periodic and the other is not (they are joined to each other) make ") +
            side_keys[2 * a] + " and " + side_keys[2 * a + 1] + " both periodic or neither");
    require(p.resolution[a] >= 1, "/smoke/resolution",
            "a box needs at least one cell along each axis (got fewer) raise it");
  }
  require(p.width > 0.0, "/smoke/width", "the box has no width (cells are width/nx wide) give a positive width");
  require(p.velocity_advection != Advection::conservative, "/smoke/velocity_advection",
          "conservative transport is for smoke, heat and flame (velocity is a property of the air that is carried) "
          "choose maccormack or semi_lagrangian");
}

}  // namespace wick::fluid
