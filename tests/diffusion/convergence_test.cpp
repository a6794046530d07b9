#include <gtest/gtest.h>

#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

/// Wetting from the left edge of a crumpled sheet up to `time`.
Values wet(const DiffusionParams& p, double dt, double time = 0.5) {
  Sheet s(testing::sheet(47, 54));
  s.x = testing::crumple(s.mesh, 0.025);
  Values rate(s.mass.size(), 0.0), value(s.mass.size(), 1.0), u(s.mass.size(), 0.0);
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (s.mesh.rest[i].x() == 0.0) rate[i] = 1e9 * s.mass[i];
  DiffusionInput in = s.input();
  in.supply_rate = &rate;
  in.supply_value = &value;
  in.capacity = 1.0;
  DiffusionSolver solver(p);
  for (int k = 0; k < static_cast<int>(std::round(time / dt)); ++k)
    EXPECT_TRUE(solver.step(u, in, dt).solve.converged);
  return u;
}

struct Changes {
  double first, second, against_isotropic;
};

Changes time_step_changes(const DiffusionParams& p) {
  const Values a = wet(p, 1.0 / 30.0), b = wet(p, 1.0 / 60.0), c = wet(p, 1.0 / 120.0);
  DiffusionParams iso = p;
  iso.model = Model::isotropic;
  return {testing::rms(a, b), testing::rms(b, c), testing::rms(c, wet(iso, 1.0 / 120.0))};
}

void report(const char* name, const Changes& c) {
  ::testing::Test::RecordProperty(
      name, std::to_string(c.first) + " " + std::to_string(c.second) + " " + std::to_string(c.against_isotropic));
  std::printf("  %-24s rms change of u under dt/2: %.4f %.4f   effect of strain: %.4f\n", name, c.first, c.second,
              c.against_isotropic);
}

TEST(Convergence, DefaultFormsHalveTheirChangeWithTheStep) {
  for (const Scope scope : {Scope::local_front, Scope::front, Scope::global}) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.scope = scope;
    const Changes c = time_step_changes(p);
    report(scope == Scope::local_front ? "local_front" : scope == Scope::front ? "front" : "global", c);
    // First order in dt; a tenth of slack for where a vertex enters the band.
    EXPECT_LT(c.second, 0.55 * c.first);
    EXPECT_LT(c.second, 0.5 * c.against_isotropic);
  }
}

TEST(Convergence, RestDoesNotDependOnTheStep) {
  // Where gain, toll and diffusion balance, the step has no say; added after the diffusion, C would still show as
  // it is added, diffused or not. The source is a line, the other end loses, so that the front comes to rest.
  Sheet s(testing::sheet(41, 41));
  s.x = testing::crumple(s.mesh, 0.02);
  Values rate(s.mass.size(), 0.0), value(s.mass.size(), 1.0), loss(s.mass.size(), 0.0);
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (s.mesh.rest[i].x() == 0.0) rate[i] = 1e9 * s.mass[i];
    loss[i] = 2.0 * s.mass[i];
  }
  DiffusionInput in = s.input();
  in.supply_rate = &rate;
  in.supply_value = &value;
  in.loss = &loss;
  for (const Scope scope : {Scope::local_front, Scope::front, Scope::global}) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.scope = scope;
    p.gain = 2000.0;
    p.u_min = 1e-6;  // no vertex near the ends of the front: the hard switch there has no rest
    p.u_max = 2.0;
    p.tolerance = 1e-11;
    const auto rest = [&](Model model, double dt) {
      p.model = model;
      Values u(s.mass.size(), 0.0);
      DiffusionSolver solver(p);
      for (int k = 0; k < static_cast<int>(std::round(12.0 / dt)); ++k) solver.step(u, in, dt);
      return u;
    };
    const Values coarse = rest(Model::strain_constrained, 0.1), fine = rest(Model::strain_constrained, 0.02);
    EXPECT_GT(testing::rms(fine, rest(Model::isotropic, 0.1)), 0.003) << static_cast<int>(scope);
    EXPECT_LT(testing::rms(coarse, fine), 1e-6) << static_cast<int>(scope);
  }
}

TEST(Convergence, SharpDiffusionWithPicardSweepsConverges) {
  DiffusionParams p = make_preset(Preset::wetting);
  p.sharpness = 2;
  p.alpha = 0.06;
  const Changes c = time_step_changes(p);
  report("sharp, 3 sweeps", c);
  EXPECT_LT(c.second, 0.6 * c.first);
}

TEST(Convergence, LiteralGainPerStepDoesNotConverge) {
  DiffusionParams p = make_preset(Preset::wetting);
  p.scope = Scope::global;
  p.order = Order::after;
  p.gain_form = Gain::literal;
  p.gain = 1333.0 / 60.0 / 4e-4;
  const Changes c = time_step_changes(p);
  report("literal", c);
  EXPECT_GT(c.second, c.first);
  EXPECT_GT(c.second, 0.3 * c.against_isotropic);
}

TEST(Sharp, FollowsTheBarenblattSolution) {
  // u_t = Δ(u^(m+1)), m = 2, in the plane: U = t^-1/3 (C - k r² t^-1/3)_+^(1/2), k = m/(4 (m+1)^2 ... ) from the
  // similarity ODE.
  const double exponent = 3.0, beta = 1.0 / (2.0 * (exponent - 1.0) + 2.0),
               scale = beta * (exponent - 1.0) / (2.0 * exponent);
  const double c = 0.05, alpha = 1.0;
  const auto exact = [&](double r, double t) {
    return std::pow(t, -2.0 * beta) * std::sqrt(std::max(0.0, c - scale * r * r * std::pow(t, -2.0 * beta)));
  };
  Sheet s(testing::sheet(93, 107, Vec2(4.0, 4.0)));
  const double t0 = 0.2, t1 = 1.0;
  const auto at = [&](double t) {
    return s.field([&](const Vec3& x) { return exact((x - Vec3(2, 2, 0)).norm(), t); });
  };
  DiffusionParams p = testing::plain_diffusion(alpha);
  p.sharpness = 2;
  p.tolerance = 1e-10;
  DiffusionSolver solver(p);
  Values u = at(t0);
  const int steps = 100;
  for (int k = 0; k < steps; ++k) solver.step(u, s.input(), (t1 - t0) / steps);
  // The edge is a square root: rms error of some per cent of the height at 20 vertices across.
  EXPECT_LT(testing::rms(u, at(t1)), 0.03 * exact(0.0, t1));
  // Nothing far outside: compact support, but for what one sweep leaks.
  double outside = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i)
    if ((s.mesh.rest[i] - Vec3(2, 2, 0)).norm() > std::sqrt(c / scale) * std::pow(t1, beta) + 0.2)
      outside = std::max(outside, u[i]);
  EXPECT_LT(outside, 1e-6);
}

}  // namespace
}  // namespace wick::diffusion
