#include "fluid/smoke.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/require.h"
#include "fluid/advection.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;
const Walls no_walls;

std::uint64_t hash(SmokeState& s) {
  StateHash h;
  visit(h, s);
  return h.digest();
}

bool finite(const SmokeState& s) {
  const auto all = [](const auto& values) {
    for (const auto v : values) {
      if (!std::isfinite(v)) return false;
    }
    return true;
  };
  return all(s.velocity[0]) && all(s.velocity[1]) && all(s.velocity[2]) && all(s.pressure) && all(s.density) &&
         all(s.temperature) && all(s.flame);
}

/// A round hot patch on the floor that gives off smoke, heat and flame.
SmokeSources burner(const Grid& g, double power, double smoke) {
  SmokeSources s;
  for_each({g.nx, g.ny, std::min(g.nz, 2)}, [&](int i, int j, int k) {
    const Vec3 x = g.cell_center(i, j, k) - g.origin;
    if (std::hypot(x.x() - 0.5 * g.nx * g.h, x.y() - 0.5 * g.ny * g.h) > 0.12 * g.nx * g.h) return;
    s.cell.push_back(std::int64_t(g.cell(i, j, k)));
  });
  s.smoke.assign(s.cell.size(), smoke / double(s.cell.size()));
  s.heat.assign(s.cell.size(), power / double(s.cell.size()));
  s.flame.assign(s.cell.size(), 1.0);
  return s;
}

class SmokeBooks : public ::testing::TestWithParam<Advection> {};

// What is in the box now = what came in - what went out + what the scheme itself made, to the rounding of the
// float sums; and in flux form the scheme makes nothing.
TEST_P(SmokeBooks, CloseEveryStep) {
  SmokeParams p;
  p.resolution = {20, 18, 24};
  p.sides = {Side::closed, Side::open, Side::closed, Side::closed, Side::closed, Side::open};
  p.scalar_advection = GetParam();
  p.dissipation = 0.3, p.cooling = 0.2, p.diffusivity = 1e-3, p.viscosity = 1e-3;
  SmokeState s = make_smoke_state(p);
  SmokeSolver solver(p);
  double heat_in = 0.0, smoke_out = 0.0;
  for (int step = 0; step < 60; ++step) {
    const double smoke = total_smoke(s, p), heat = total_heat(s, p);
    const SmokeSources sources = burner(smoke_grid(p), 100.0, 1e-4);
    const auto r = solver.step(s, sources, no_walls, std::min(0.05, stable_dt(s, p, sources.gravity)));
    heat_in += 100.0, smoke_out += r.smoke_out;
    ASSERT_NEAR(total_smoke(s, p), smoke + 1e-4 - r.smoke_out + r.smoke_advection, 1e-6 * (smoke + 1e-4));
    ASSERT_NEAR(total_heat(s, p), heat + 100.0 - r.heat_out + r.heat_advection, 1e-6 * (heat_in));
    ASSERT_TRUE(r.pressure.converged);
    if (GetParam() != Advection::conservative) continue;
    ASSERT_NEAR(r.smoke_advection, 0.0, 1e-6 * (smoke + 1e-4));
    ASSERT_NEAR(r.heat_advection, 0.0, 1e-6 * heat_in);
  }
  EXPECT_GT(smoke_out, 0.0);
  EXPECT_TRUE(finite(s));
}
INSTANTIATE_TEST_SUITE_P(Schemes, SmokeBooks,
                         ::testing::Values(Advection::semi_lagrangian, Advection::maccormack,
                                           Advection::conservative));

TEST(Smoke, SameBitsAtOneAndTwoThreads) {
  std::uint64_t digest[2];
  for (int threads = 1; threads <= 2; ++threads) {
    ThreadLimit limit(threads);
    SmokeParams p;
    p.resolution = {24, 20, 28};
    p.viscosity = 1e-3;
    SmokeState s = make_smoke_state(p);
    SmokeSolver solver(p);
    const Walls walls = bag(smoke_grid(p), [](const Vec3& x) { return (x - Vec3(0.5, 0.4, 0.7)).norm() < 0.2; });
    for (int step = 0; step < 8; ++step) solver.step(s, burner(smoke_grid(p), 400.0, 1e-4), walls, 0.04);
    digest[threads - 1] = hash(s);
  }
  EXPECT_EQ(digest[0], digest[1]);
}

TEST(Smoke, ANewSolverGoesOnWithTheSameBits) {
  SmokeParams p;
  p.resolution = {16, 16, 20};
  SmokeState s = make_smoke_state(p);
  auto solver = std::make_unique<SmokeSolver>(p);
  const SmokeSources sources = burner(smoke_grid(p), 200.0, 1e-4);
  for (int step = 0; step < 5; ++step) solver->step(s, sources, no_walls, 0.04);
  SmokeState again = s;
  for (int step = 0; step < 5; ++step) solver->step(s, sources, no_walls, 0.04);
  solver = std::make_unique<SmokeSolver>(p);
  for (int step = 0; step < 5; ++step) solver->step(again, sources, no_walls, 0.04);
  EXPECT_EQ(hash(s), hash(again));
}

TEST(Smoke, ASealedBagOfHotSmokeLetsNothingOut) {
  SmokeParams p;
  p.resolution = {20, 20, 20};
  const auto inside = [](const Vec3& x) { return (x - Vec3(0.5, 0.5, 0.5)).norm() < 0.3; };
  const Grid g = smoke_grid(p);
  const Walls walls = bag(g, inside);
  SmokeState s = make_smoke_state(p);
  s.density = cell_field(g, [&](const Vec3& x) { return inside(x) ? 1.0 : 0.0; });
  s.temperature = cell_field(g, [&](const Vec3& x) { return inside(x) ? 300.0 * (x.x() > 0.5) : 0.0; });
  SmokeSolver solver(p);
  for (int step = 0; step < 60; ++step) {
    const auto r = solver.step(s, {}, walls, std::min(0.05, stable_dt(s, p, Vec3(0, 0, -9.81))));
    EXPECT_EQ(r.smoke_out, 0.0);
  }
  for_each({20, 20, 20}, [&](int i, int j, int k) {
    if (inside(g.cell_center(i, j, k))) return;
    ASSERT_EQ(s.density[g.cell(i, j, k)], 0.0F);
    ASSERT_EQ(s.temperature[g.cell(i, j, k)], 0.0F);
  });
}

TEST(Smoke, StableStepCountsFlowInAnyDirectionAndForcesToCome) {
  SmokeParams p;
  p.resolution = {10, 10, 10};
  p.vorticity = 0.0;
  SmokeState s = make_smoke_state(p);
  const Vec3 gravity(0, 0, -9.81);
  EXPECT_TRUE(std::isinf(stable_dt(s, p, gravity)));
  s.velocity[2][5] = -4.0F;  // falling: cfl h / |u|
  EXPECT_NEAR(stable_dt(s, p, gravity), 2.0 * 0.1 / 4.0, 1e-9);
  s.velocity[2][5] = 0.0F;
  s.temperature[3] = 293.15F;  // lift g/2: (g/2) dt² = cfl h
  EXPECT_NEAR(stable_dt(s, p, gravity), std::sqrt(0.2 / (0.5 * 9.81)), 1e-6);
  // A step of that size from rest indeed stays under the limit.
  SmokeSolver solver(p);
  const double dt = stable_dt(s, p, gravity);
  EXPECT_LE(solver.step(s, {}, no_walls, dt).max_speed * dt, p.cfl * 0.1);
}

TEST(Smoke, StaysFiniteAtExtremes) {
  struct Case {
    Int3 n;
    double width, dt, temperature, speed;
  };
  const Case cases[] = {{{1, 1, 1}, 1.0, 0.1, 1e3, 1.0},      {{1, 8, 5}, 1e-6, 1e-3, 1e4, 1e3},
                        {{64, 1, 1}, 1.0, 10.0, -500.0, 1e3}, {{2, 2, 128}, 1e4, 1e-9, 1e4, 1e3},
                        {{9, 7, 5}, 1e-3, 100.0, 1e4, 1e3},   {{8, 8, 8}, 1.0, 1e-12, 0.0, 0.0}};
  for (const Case& c : cases) {
    for (const Side side : {Side::closed, Side::open, Side::periodic}) {
      for (const auto scheme : {Advection::maccormack, Advection::conservative}) {
        SmokeParams p;
        p.resolution = c.n, p.width = c.width;
        p.sides = all_sides(side);
        p.scalar_advection = scheme;
        SmokeState s = make_smoke_state(p);
        s.velocity = stirring(smoke_grid(p), p.sides, {}, c.speed, 4);
        join_periodic_faces(smoke_grid(p), p.sides, s.velocity);
        for (float& t : s.temperature) t = static_cast<float>(c.temperature);
        SmokeSolver solver(p);
        for (int step = 0; step < 3; ++step) solver.step(s, {}, no_walls, c.dt);
        ASSERT_TRUE(finite(s)) << c.n[0] << " " << c.n[1] << " " << c.n[2] << " side " << int(side);
      }
    }
  }
}

TEST(Smoke, RefusesHalfAPeriodicAxis) {
  SmokeParams p;
  p.sides[0] = Side::periodic;
  EXPECT_THROW(SmokeSolver{p}, Refusal);
}

}  // namespace
}  // namespace wick::fluid
