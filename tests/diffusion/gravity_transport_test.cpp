/// Transfers along edges: what gravity does and does not do, rates, convergence in the step.
#include "diffusion/gravity_transport.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

const Vec3 down(0.0, 0.0, -9.81);

DiffusionParams dripping() {
  DiffusionParams p = testing::plain_diffusion(0.0);
  p.model = Model::diffuse_gravity;
  return p;
}

Values drop(const Sheet& sheet) {
  return sheet.field([](const Vec3& x) { return std::exp(-100.0 * (x - Vec3(0.5, 0.5, 0.0)).squaredNorm()); });
}

void upright(Sheet& sheet) {
  for (std::size_t i = 0; i < sheet.x.size(); ++i) {
    const Vec3& r = sheet.mesh.rest[i];
    sheet.x[i] = Vec3(r.x(), 0.0, r.y());
  }
}

Values run(const Sheet& sheet, const DiffusionParams& p, Values u, double dt, int steps,
           const Vec3& gravity = down) {
  DiffusionSolver solver(p);
  DiffusionInput in = sheet.input();
  in.gravity = gravity;
  in.capacity = 1.0;
  for (int n = 0; n < steps; ++n) {
    const DiffusionReport r = solver.step(u, in, dt);
    EXPECT_LT(testing::budget_error(r), 1e-12);
    EXPECT_TRUE(r.solve.converged);
  }
  return u;
}

double mean_height(const Sheet& sheet, const Values& u) {
  double sum = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) sum += sheet.mass[i] * u[i] * sheet.x[i].z();
  return sum / sheet.total(u);
}

TEST(GravityTransport, GravityDoesNothingOnAHorizontalSheet) {
  const Sheet sheet(testing::jittered(31, 36, 0.2));
  DiffusionParams p = dripping(), without = p;
  without.gravity_transport.gravity_rate = 0.0;
  const Values a = run(sheet, p, drop(sheet), 1.0, 50);
  EXPECT_EQ(a, run(sheet, p, drop(sheet), 1.0, 50, Vec3::Zero()));
  // Substeps follow the sum of both rates: equal where a step is one substep.
  EXPECT_EQ(a, run(sheet, without, drop(sheet), 1.0, 50));
  EXPECT_GT(testing::rms(a, drop(sheet)), 1e-4);
  p.gravity_transport.angle_only = true;
  EXPECT_EQ(run(sheet, p, drop(sheet), 1.0, 50), drop(sheet));
}

TEST(GravityTransport, DropFallsOnAVerticalSheet) {
  Sheet sheet(testing::sheet(31, 36));
  upright(sheet);
  for (const bool angle_only : {false, true}) {
    DiffusionParams p = dripping();
    p.gravity_transport.angle_only = angle_only;
    const Values before = drop(sheet), after = run(sheet, p, before, 10.0, 50);
    std::printf("  mean height %.4f -> %.4f\n", mean_height(sheet, before), mean_height(sheet, after));
    EXPECT_LT(mean_height(sheet, after), mean_height(sheet, before) - 1e-3);
    // Left and right are alike: the pull is down and nowhere else.
    double aside = 0.0;
    for (std::size_t i = 0; i < after.size(); ++i) aside += sheet.mass[i] * after[i] * (sheet.x[i].x() - 0.5);
    EXPECT_LT(std::abs(aside) / sheet.total(after), 1e-3);
    EXPECT_LT(mean_height(sheet, after), mean_height(sheet, run(sheet, p, before, 10.0, 50, -down)) - 1e-3);
  }
}

TEST(GravityTransport, OneTriangleFollowsItsOdes) {
  // A vertical triangle: vertex 2 above the edge 0-1 of equal height. Without k'_d and above t_diff, u_2 - u_0
  // decays: each pair exchanges k_d M_2/2 (u_2 - u_0), so d(u_2 - u_0)/dt = -(k_d/2)(2 + 1)(u_2 - u_0).
  Sheet sheet(solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0, 1)}, {}, {{0, 1, 2}}));
  DiffusionParams p = dripping();
  p.gravity_transport.gravity_rate = 0.0;
  const Values spread = run(sheet, p, {0.5, 0.5, 0.9}, 0.1, 1000);
  // First order in a step of 0.1 x 0.0075: 4e-4 of the exponent.
  EXPECT_NEAR((spread[2] - spread[0]) / 0.4, std::exp(-0.0075 * 100.0), 5e-4);

  // With k'_d alone vertex 2 gives k'_d u_2 c/2 to each lower vertex, c the cosine of its edges, until t_diff.
  p = dripping();
  p.gravity_transport.diffusion_rate = 0.0;
  const double c = 1.0 / std::sqrt(1.25);
  const Values fallen = run(sheet, p, {0.1, 0.1, 0.9}, 0.1, 1000);
  EXPECT_NEAR(fallen[2] / 0.9, std::exp(-0.001 * c * 100.0), 1e-5);
  EXPECT_NEAR(fallen[0], fallen[1], 1e-15);
  const Values rest = run(sheet, p, {0.1, 0.1, 0.9}, 100.0, 200);
  EXPECT_NEAR(rest[2], p.gravity_transport.transport_threshold, 1e-12);
}

TEST(GravityTransport, NothingMovesBelowTheThreshold) {
  Sheet sheet(testing::sheet(15, 17));
  upright(sheet);
  Values u = drop(sheet);
  for (double& v : u) v *= 0.42;
  EXPECT_EQ(run(sheet, dripping(), u, 100.0, 10), u);
}

TEST(GravityTransport, AbsorptionTakesItsShareAndStopsNearTheSource) {
  Sheet sheet(testing::sheet(8, 9));
  const Values rate(sheet.mass), value(sheet.mass.size(), 0.3);
  DiffusionParams p = dripping();
  DiffusionSolver solver(p);
  DiffusionInput in = sheet.input();
  in.supply_rate = &rate;
  in.supply_value = &value;
  Values u(sheet.mass.size(), 0.0);
  double supplied = 0.0;
  for (int n = 0; n < 1000; ++n) supplied += solver.step(u, in, 0.001).supplied;
  // k = M: u = 0.3 (1 - exp(-α t)).
  EXPECT_NEAR(u[5], 0.3 * (1.0 - std::exp(-0.1)), 1e-5);
  EXPECT_NEAR(supplied, sheet.total(u), 1e-14);
  for (int n = 0; n < 100; ++n) solver.step(u, in, 10.0);
  EXPECT_NEAR(u[5], 0.3 - p.gravity_transport.absorb_threshold, 1e-12);
}

TEST(GravityTransport, HalvingTheStepHalvesTheChange) {
  Sheet sheet(testing::jittered(21, 24, 0.2));
  upright(sheet);
  DiffusionParams p = dripping();
  p.gravity_transport.diffusion_rate = 0.5;
  p.gravity_transport.gravity_rate = 0.1;
  const auto at = [&](double dt) { return run(sheet, p, drop(sheet), dt, static_cast<int>(std::round(8.0 / dt))); };
  const Values a = at(0.04), b = at(0.02), c = at(0.01), d = at(0.005), e = at(0.0025);
  std::printf("  rms change of u under dt/2: %.2e %.2e %.2e %.2e\n", testing::rms(a, b), testing::rms(b, c),
              testing::rms(c, d), testing::rms(d, e));
  // A vertex passes the threshold within a step, here or there: halves on the average of three halvings.
  EXPECT_LT(testing::rms(d, e), 0.6 * 0.6 * 0.6 * testing::rms(a, b));
  // Long steps are cut: not far from the short ones.
  EXPECT_LT(testing::rms(at(8.0), e), 0.05 * testing::rms(drop(sheet), e));
}

}  // namespace
}  // namespace wick::diffusion
