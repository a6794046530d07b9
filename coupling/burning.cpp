#include "coupling/burning.h"

#include <algorithm>
#include <cmath>

#include "core/noise.h"
#include "core/parallel.h"
#include "core/parameters.h"
#include "core/state.h"

namespace wick::coupling {

namespace {

constexpr std::size_t kGrain = 2048;
constexpr const char* kLawNames[] = {"threshold", "arrhenius"};
constexpr const char* kRimNames[] = {"cut", "whole"};

/// Exact solution over dt of the mass-loss law at frozen theta; never below the ash fraction.
double fraction_after(double mu, double theta, const BurningParams& p, double ambient, double reference,
                      double dt) {
  if (mu <= p.ash) return mu;
  if (p.law == MassLoss::threshold) {
    const double drive = std::clamp((theta - p.ignition) / (1.0 - p.ignition), 0.0, 1.0);
    return std::max(p.ash, mu - p.rate * drive * dt);
  }
  const double kelvin = ambient + std::max(theta, 0.0) * (reference - ambient);
  const double rate = p.pre_exponential * std::exp(-p.activation_temperature / kelvin);
  return p.ash + (mu - p.ash) * std::exp(-rate * dt);
}

}  // namespace

double burnt(double mu, const BurningParams& p) {
  return std::clamp((1.0 - mu) / (1.0 - p.ash), 0.0, 1.0);
}

void describe(ParameterVisitor& v, SheetHeatParams& p) {
  v.number({"ambient_temperature", "K", between(1, 5000), "T_amb of a scene without gas; with gas its own is used"},
           p.ambient_temperature);
  v.number({"reference_temperature", "K", between(2, 20000), "T_ref, where theta = 1; must exceed the ambient"},
           p.reference_temperature);
  v.number({"heat_capacity", "J/(kg K)", between(1e-2, 1e7), "c of the sheet; paper 1400, cotton 1300"},
           p.heat_capacity);
  v.number({"loss", "1/s", between(0, 1e6),
            "radiation and unresolved air: decay rate of theta; too large puts the fire out", OnResume::may_change},
           p.loss);
  v.number({"convection", "W/(m2 K)", between(0, 1e6), "h_conv between sheet and gas, per side; still air about 10",
            OnResume::may_change},
           p.convection);
}

void describe(ParameterVisitor& v, BurningParams& p) {
  v.choice({"law", "", any_value(), "threshold: rate grows from theta_ign on; arrhenius: A exp(-T_act/T)"}, p.law,
           kLawNames);
  v.only(p.law == MassLoss::threshold, "law is not threshold", [&] {
    v.number({"ignition", "1", between(0, 0.999), "theta_ign: below it nothing burns (threshold law)"}, p.ignition);
    v.number({"rate", "1/s", between(0, 1e6), "k_b: fraction of the mass lost a second at theta = 1",
              OnResume::may_change},
             p.rate);
  });
  v.only(p.law == MassLoss::arrhenius, "law is not arrhenius", [&] {
    v.number({"pre_exponential", "1/s", between(0, 1e20), "A of the arrhenius law"}, p.pre_exponential);
    v.number({"activation_temperature", "K", between(0, 1e6), "T_act of the arrhenius law"},
             p.activation_temperature);
  });
  v.number({"ash", "1", between(1e-4, 0.999), "mu_ash: fraction of the mass that does not burn"}, p.ash);
  v.number({"removal", "1", between(0, 0.999), "what has less of its mass left falls away as ash; 0: never"},
           p.removal);
  v.only(p.removal > 0.0, "removal is 0", [&] {
    v.choice({"rim", "", any_value(),
              "cut: the mesh is cut along the contour of removal; whole: triangles fall away whole when "
              "their last corner is below it (always so where motion moves the sheet)"},
             p.rim, kRimNames);
    v.only(p.rim == BurntRim::cut, "rim is not cut", [&] {
      v.number(
          {"rim_snap", "1", between(0.05, 0.45),
           "vertices nearer to the contour than this share of the sheet's edges are moved onto it (those of the "
           "rim once they are half as far from it) instead of cutting edges; small values make small triangles"},
          p.rim_snap);
    });
  });
  v.number({"ember_size", "m", between(0, 1e3),
            "pieces that hang on nothing and measure less than its square become embers; 0: never",
            OnResume::may_change},
           p.ember_size);
  v.only(p.ember_size > 0.0, "ember_size is 0", [&] {
    v.number({"ember_life", "s", between(0, 1e6),
              "after this an ember goes out and is booked as ash; so it does where it meets an obstacle or leaves "
              "the gas",
              OnResume::may_change},
             p.ember_life);
  });
  v.number({"sheet_heat", "1", between(0, 1e3),
            "eta_f: heat kept by the sheet per burnt mass in units of c (T_ref - T_amb); spreads the fire",
            OnResume::may_change},
           p.sheet_heat);
  v.number({"gas_heat", "1", between(0, 1e3), "heat given to the gas per burnt mass, same unit; lifts the smoke",
            OnResume::may_change},
           p.gas_heat);
  v.number(
      {"flame_temperature", "K", between(300, 1e5),
       "adiabatic flame temperature of the fuel in air: burning heats gas no further, the rest passes unburnt"},
      p.flame_temperature);
  v.number({"smoke_yield", "1", between(0, 1), "y_s: smoke per burnt mass [Kim 2017]; the rest is unseen gas",
            OnResume::may_change},
           p.smoke_yield);
  v.number(
      {"flame_rate", "1/s", between(1e-6, 1e6),
       "fraction of the mass lost a second that shows as a full flame; too low: embers show as flames, too high: "
       "the flame field stays dark",
       OnResume::may_change},
      p.flame_rate);
  v.number({"shrink", "1", between(0.05, 1), "s_min: rest length of ash relative to virgin; small values crumple"},
           p.shrink);
  v.number({"weaken", "1", between(1e-6, 1), "e_min: stiffness of ash relative to virgin"}, p.weaken);
  v.number({"curl", "1", between(0, 100), "rest curvature of a fully burnt place times curl_radius"}, p.curl);
  v.only(p.curl > 0.0, "curl is 0", [&] {
    v.number({"curl_radius", "m", between(1e-6, 1e6), "radius to which a fully burnt place curls at curl = 1"},
             p.curl_radius);
    v.number({"curl_noise", "1", between(0, 1),
              "share of the curl's direction that is seeded noise instead of the hotter side"},
             p.curl_noise);
    v.integer({"seed", "", between(0, 2147483647), "of the curl noise"}, p.seed);
  });
}

void visit(StateVisitor& visitor, BurningState& state) {
  visitor.array("fraction_left", state.fraction_left);
  visitor.array("curl", state.curl);
}

BurningState make_burning_state(std::size_t vertices) {
  return {std::vector<double>(vertices, 1.0), std::vector<double>(vertices, 0.0)};
}

std::vector<double> lose_mass(BurningState& state, const BurningParams& p, const std::vector<double>& theta,
                              const std::vector<double>& hotter_side, double ambient, double reference, double dt) {
  std::vector<double> lost(theta.size(), 0.0);
  parallel_for(theta.size(), kGrain, [&](std::size_t i) {
    double& mu = state.fraction_left[i];
    const double after = fraction_after(mu, theta[i], p, ambient, reference, dt);
    lost[i] = mu - after;
    mu = after;
    const double noise = hash_signed(static_cast<std::uint64_t>(p.seed), i);
    const double side = (1.0 - p.curl_noise) * hotter_side[i] + p.curl_noise * noise;
    state.curl[i] = std::clamp(state.curl[i] + side * lost[i] / (1.0 - p.ash), -1.0, 1.0);
  });
  return lost;
}

void reshape(solid::ShellInputs& inputs, const solid::ShellInputs& base, const solid::ShellMesh& mesh,
             const BurningState& state, const BurningParams& p, double areal_mass) {
  parallel_for(mesh.vertex_count(), kGrain,
               [&](std::size_t i) { inputs.mass[i] = areal_mass * mesh.vertex_area[i] * state.fraction_left[i]; });

  // s(mu) = s_min + (1 - s_min)(mu - mu_ash)/(1 - mu_ash), and stiffness likewise with the square of what is left.
  parallel_for(mesh.triangle_count(), kGrain, [&](std::size_t t) {
    double gone = 0.0;
    for (const int vertex : mesh.triangles[t]) gone += burnt(state.fraction_left[vertex], p) / 3.0;
    const double left = 1.0 - gone;
    inputs.rest_scale[t] = base.rest_scale[t] * (p.shrink + (1.0 - p.shrink) * left);
    inputs.stiffness_scale[t] = base.stiffness_scale[t] * (p.weaken + (1.0 - p.weaken) * left * left);
  });

  // A sheet of curvature k bends by k times the width that belongs to the edge, 2 (A0 + A1)/(3 |e|).
  parallel_for(mesh.hinges.size(), kGrain, [&](std::size_t h) {
    const solid::Hinge& hinge = mesh.hinges[h];
    double side = 0.0;
    for (const int vertex : hinge.vertex) side += state.curl[vertex] / 4.0;
    const double area = mesh.rest_area[hinge.triangle[0]] + mesh.rest_area[hinge.triangle[1]];
    const double edge = (mesh.rest[hinge.vertex[1]] - mesh.rest[hinge.vertex[0]]).norm();
    const double angle = p.curl * side / p.curl_radius * 2.0 * area / (3.0 * edge);
    // Sharper than a quarter turn at one edge is a fold that the mesh cannot follow.
    inputs.rest_angle[h] = base.rest_angle[h] + std::clamp(angle, -M_PI_2, M_PI_2);
  });
}

std::vector<std::uint8_t> unburnt_triangles(const solid::ShellMesh& mesh, const BurningState& state,
                                            const BurningParams& p) {
  std::vector<std::uint8_t> keep(mesh.triangle_count(), 1);
  parallel_for(mesh.triangle_count(), kGrain, [&](std::size_t t) {
    const Int3& v = mesh.triangles[t];
    const double most = std::max({state.fraction_left[v[0]], state.fraction_left[v[1]], state.fraction_left[v[2]]});
    keep[t] = most < p.removal ? 0 : 1;
  });
  return keep;
}

}  // namespace wick::coupling
