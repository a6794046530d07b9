#include "core/parameters.h"
#include "diffusion/strain_diffusion.h"

namespace wick::diffusion {

namespace {

constexpr const char* preset_names[] = {"burning", "wetting", "literal"};
constexpr const char* model_names[] = {
    "isotropic", "strain_constrained", "strain_unconstrained", "porous", "diffuse_gravity", "noise", "strain_noise",
    "tensor"};
constexpr const char* operator_names[] = {"cotan", "umbrella", "graph"};
constexpr const char* metric_names[] = {"rest", "current"};
constexpr const char* measure_names[] = {"invariant", "orthotropic"};
constexpr const char* reference_names[] = {"original", "current"};
constexpr const char* gain_names[] = {"density", "literal"};
constexpr const char* order_names[] = {"inside", "after"};
constexpr const char* sigma_names[] = {"rate", "per_step", "influx"};
constexpr const char* total_names[] = {"area", "plain"};
constexpr const char* scope_names[] = {"global", "component", "front", "local", "local_front"};

void describe_diffusion(ParameterVisitor& v, DiffusionParams& p) {
  v.choice(
      {"operator",
       "",
       {},
       "Laplacian of the sheet: cotan converges on any mesh; umbrella is Eq 3 of Kim 2017; graph ignores lengths"},
      p.discretisation, operator_names);
  v.only(p.discretisation == Operator::umbrella, "operator is not umbrella", [&] {
    v.number({"umbrella_factor", "1", above_up_to(0.0, 10.0),
              "multiplies the umbrella: 2 gives alpha its nominal value on a surface, 1 is Eq 3 as printed (half "
              "of it)"},
             p.umbrella_factor);
  });
  v.flag({"clamp_weights",
          "",
          {},
          "set negative cotan weights to 0, so that nothing leaves the range of its neighbours on obtuse meshes; "
          "off: plain finite elements"},
         p.clamp_weights);
  v.choice({"metric",
            "",
            {},
            "shape in which lengths are measured: rest, or current (stretch q then slows diffusion by q squared)"},
           p.metric, metric_names);
  v.number({"alpha", "m2/s", at_least(0.0),
            "diffusivity; a spot spreads over sqrt(4 alpha t); too large: no front is left", OnResume::may_change},
           p.alpha);
  v.integer(
      {"sharpness", "1", between(0, 8),
       "m of the porous-medium flux div((m+1) u^m grad u): 0 linear with a long tail, 2 a sharp edge (wetting)"},
      p.sharpness);
  v.only(p.sharpness > 0, "sharpness is 0", [&] {
    v.integer({"picard", "1", between(1, 50),
               "sweeps per step when sharpness > 0; below 3 the front lags by about a cell a step"},
              p.picard);
  });
  v.number({"tolerance", "1", between(1e-14, 1e-2),
            "relative residual of the linear solves; conservation does not depend on it", OnResume::may_change},
           p.tolerance);
}

void describe_strain(ParameterVisitor& v, DiffusionParams& p) {
  v.choice({"measure",
            "",
            {},
            "strain measure S: orthotropic is Eq 5 of Kim 2017 in the frame of the material, invariant its mean "
            "over all frames"},
           p.measure, measure_names);
  v.choice({"reference",
            "",
            {},
            "strain against the original rest shape, or the current one (a freely shrunk sheet then has none)"},
           p.reference, reference_names);
  v.flag({"tension_only", "", {}, "count stretching only: principal strains below 0 become 0"}, p.tension_only);
  v.number({"delta", "1", at_least(0.0), "weakening: S is multiplied by 1/(1 + delta) [Kim 2017, Eq 5]"}, p.delta);
  v.choice({"gain_form",
            "",
            {},
            "density: C = gain c dt, independent of mesh and step; literal: a third of A S/2 per triangle and step "
            "[Kim 2017, Eq 4]"},
           p.gain_form, gain_names);
  v.number({"gain", "1/s (density), 1/m2 (literal)", at_least(0.0),
            "kappa: 0.4 Pi/(c_mean t), t half the run, Pi 1-3 visible, 10-30 strong; too large: fronts break into "
            "islands",
            OnResume::may_change},
           p.gain);
  v.number({"bending_gain", "m2", at_least(0.0),
            "adds bending_gain (kappa_1 + kappa_2 - rest)^2 to S, so that pure wrinkles count too; 0: off"},
           p.bending_gain);
}

void describe_front(ParameterVisitor& v, DiffusionParams& p) {
  v.number(
      {"u_min", "1", above(0.0), "lower end of the front; 0 would wet or ignite strained places never reached"},
      p.u_min);
  v.number({"u_max", "1", above(0.0), "upper end of the front"}, p.u_max);
  v.number({"front_ramp", "1", between(0.0, 10.0),
            "range of u over which the front sets in above u_min and fades below u_max; 0 is a hard front, whose "
            "vertices switch between two steps"},
           p.front_ramp);
  v.number({"virgin", "1", between(0.0, 1.0),
            "the front takes only vertices with more than this fraction of their mass left; 0: all; burnt cells "
            "that cool down would take heat from the flame"},
           p.virgin);
  v.choice(
      {"order",
       "",
       {},
       "inside: strain and what pays for it are rates, solved for together with the diffusion (converges); after: "
       "added and rescaled when it is done [Kim 2017, Eqs 8c-8g] (ragged, depends on the step)"},
      p.order, order_names);
  v.choice(
      {"scope",
       "",
       {},
       "what pays for the strain added: global is Kim 2017, Eq 8g; front and local_front act near the front only"},
      p.scope, scope_names);
  v.only(p.scope == Scope::local || p.scope == Scope::local_front, "scope is not local or local_front", [&] {
    v.number({"scope_radius", "m", above(0.0),
              "reach of local and local_front; much more than the front's width: detached pieces"},
             p.scope_radius);
  });
  v.number({"sigma", "1", between(0.0, 1e6),
            "scales the total [Kim 2017, Eq 8d]; 1 conserves, more creates, less removes", OnResume::may_change},
           p.sigma);
  v.choice({"sigma_mode",
            "",
            {},
            "rate: sigma per sigma_tau; per_step: sigma every step (literal, depends on the step); influx: scales "
            "what is taken up"},
           p.sigma_mode, sigma_names);
  v.only(p.sigma_mode == SigmaMode::rate, "sigma_mode is not rate", [&] {
    v.number({"sigma_tau", "s", above(0.0), "time over which sigma acts once in mode rate"}, p.sigma_tau);
  });
  v.choice(
      {"total", "", {}, "total that is kept: weighted by what a vertex holds, or the plain sum of Kim 2017, Eq 8b"},
      p.total, total_names);
  v.number({"capacity", "1", at_least(0.0), "u above this is refused and booked as excess; 0: no limit"},
           p.capacity);
}

}  // namespace

DiffusionParams make_preset(Preset preset) {
  DiffusionParams p;
  p.preset = preset;
  switch (preset) {
    case Preset::burning:
      break;
    case Preset::wetting:
      p.alpha = 0.1;
      p.gain = 4.0 / 0.003;
      p.u_min = 0.1;
      p.u_max = 0.8;
      p.virgin = 0.0;
      p.scope = Scope::local_front;
      p.sigma_mode = SigmaMode::influx;
      break;
    case Preset::literal:
      p.discretisation = Operator::umbrella;
      p.umbrella_factor = 1.0;
      p.metric = Metric::current;
      p.alpha = 5e-3;  // twice that of burning: Eq 3 halves it
      p.measure = Measure::orthotropic;
      p.gain_form = Gain::literal;
      p.gain = 8e4;  // that of burning at 1/60 s and 1e-4 m² per vertex
      p.u_min = 0.1;
      p.u_max = 0.9;
      p.virgin = 0.0;
      p.order = Order::after;
      p.scope = Scope::global;
      p.sigma_mode = SigmaMode::per_step;
      p.total = Total::plain;
      break;
  }
  return p;
}

void describe(ParameterVisitor& v, DiffusionParams& p) {
  const Preset before = p.preset;
  v.choice({"preset",
            "",
            {},
            "forms and defaults of all fields below: burning, wetting, or literal (Kim 2017 as printed: depends on "
            "step and mesh)"},
           p.preset, preset_names);
  if (p.preset != before) p = make_preset(p.preset);
  v.choice(
      {"model",
       "",
       {},
       "how u moves: strain_constrained is Eq 8 of Kim 2017; isotropic has no strain; strain_unconstrained is Eq "
       "7, "
       "strain everywhere and no rescale; porous [Lenaerts 2008]; diffuse_gravity [Patkar 2013]; noise in place of "
       "strain; strain_noise: strain times noise; tensor follows the principal stretches"},
      p.model, model_names);
  describe_diffusion(v, p);
  describe_strain(v, p);
  describe_front(v, p);
  v.only(p.model == Model::noise || p.model == Model::strain_noise, "model is not noise or strain_noise",
         [&] { v.nested("noise", "gradient noise of the models noise and strain_noise", p.noise); });
  v.only(p.model == Model::porous, "model is not porous", [&] {
    v.nested("porous", "capillary flow of the model porous; lengths follow metric, weights are always cotan",
             p.porous);
  });
  v.only(p.model == Model::diffuse_gravity, "model is not diffuse_gravity", [&] {
    v.nested("gravity_transport", "transfers along edges of the model diffuse_gravity", p.gravity_transport);
  });
  v.only(p.model == Model::tensor, "model is not tensor", [&] {
    v.number(
        {"tensor_gain", "1", between(0.0, 1e3),
         "k_t of the model tensor: D = alpha (I + k_t (U - I)) with U the stretch; above 8 obtuse meshes limit it"},
        p.tensor_gain);
  });
}

}  // namespace wick::diffusion
