#include "diffusion/comparison_params.h"

#include "core/parameters.h"

namespace wick::diffusion {

void describe(ParameterVisitor& v, NoiseParams& p) {
  v.number({"amplitude", "1", between(0.0, 1e3), "a: size of the noise; above 1 it switches strain off in places"},
           p.amplitude);
  v.number({"frequency", "1/m", between(0.0, 1e4),
            "f: cycles per metre of the sheet; above 1/(2 edge length) it is only mesh noise"},
           p.frequency);
  v.number({"level", "1", at_least(0.0), "value of c that noise of size 1 stands for in the model noise"}, p.level);
  v.integer({"seed", "", between(0, 2147483647), "of the noise"}, p.seed);
}

void describe(ParameterVisitor& v, PorousParams& p) {
  v.number(
      {"capillary", "Pa", above_up_to(0.0, 1e9),
       "k_c of the capillary potential -k_c (1 - s + eps)^a [Lenaerts 2008]; too large: everything wets at once"},
      p.capillary);
  v.number(
      {"exponent", "1", between(0.01, 4.0),
       "a of the capillary potential [Lenaerts 2008]; small: suction ends only next to full, fronts are sharp"},
      p.exponent);
  v.number({"regularisation", "1", between(1e-12, 0.1),
            "eps of the capillary potential; below 1e-6 the flow near full pores is stiff and steps are cut"},
           p.regularisation);
  v.number(
      {"pressure", "Pa", between(0.0, 1e9),
       "k_p of the pore pressure k_p s (J^-beta - 1) of squeezed places [Lenaerts 2008]; too large: they empty "
       "at once"},
      p.pressure);
  v.number({"tait", "1", between(0.0, 20.0),
            "beta of the pore pressure [Lenaerts 2008]; large: only strong squeezing counts, but then much"},
           p.tait);
  v.number({"permeability", "m2", between(0.0, 1e-3),
            "K of Darcy's law; cloth 1e-12 to 1e-10, a front then moves millimetres to centimetres in a second"},
           p.permeability);
  v.number({"viscosity", "Pa s", between(1e-6, 1e6), "mu of the liquid; water 1e-3; too large: nothing moves"},
           p.viscosity);
  v.number({"porosity", "1", between(0.01, 0.99),
            "phi_0, share of pores in the rest shape; small: slight squeezing closes them"},
           p.porosity);
  v.number({"density", "kg/m3", between(0.0, 1e5),
            "rho of the liquid: weighs against capillarity; 0 switches gravity off"},
           p.density);
  v.number({"relative_exponent", "1", above_up_to(0.0, 10.0),
            "n of the relative permeability s^n, 2 to 3 in real cloth; large: half-wet places hardly conduct"},
           p.relative);
  v.number({"full", "1", above_up_to(0.0, 1e6),
            "value of u at which the pores are full; heat needs the largest u of the run, since beyond it u flows "
            "on like a liquid under pressure"},
           p.full);
  v.number(
      {"effective_stress", "1", between(0.0, 1.0),
       "eta of the effective stress, tension - eta phi_0 P t with P the pore pressure: wet places swell where they "
       "are squeezed [Lenaerts 2008: 1]; thin cloth hardly feels it; 0: off"},
      p.effective_stress);
}

void describe(ParameterVisitor& v, GravityTransportParams& p) {
  v.number({"absorption", "1", between(0.0, 1.0),
            "alpha: share of what a supply offers that is taken up [Patkar 2013, meaning inferred]; 0: none"},
           p.absorption);
  v.number({"absorb_threshold", "1", at_least(0.0),
            "t_absorb: a supply nearer than this to u is not taken up [Patkar 2013, meaning inferred]"},
           p.absorb_threshold);
  v.number({"diffusion_rate", "1/s", between(0.0, 1e3),
            "k_d of transfers by differences of u [Patkar 2013, unit inferred]; depends on the mesh: spreads as "
            "k_d h^2/4 on edges of length h"},
           p.diffusion_rate);
  v.number({"gravity_rate", "1/s", between(0.0, 1e3),
            "k'_d of transfers down along edges [Patkar 2013, unit inferred]; water falls k'_d edges in a second"},
           p.gravity_rate);
  v.number({"transport_threshold", "1", at_least(0.0),
            "t_diff: vertices pass on only what they hold above this [Patkar 2013, meaning inferred]; above the "
            "supply: nothing spreads"},
           p.transport_threshold);
  v.flag({"angle_only",
          "",
          {},
          "the cosine to gravity multiplies transfers by differences too: flat places do not spread at all"},
         p.angle_only);
}

}  // namespace wick::diffusion
