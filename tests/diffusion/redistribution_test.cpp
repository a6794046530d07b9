#include "diffusion/redistribution.h"

#include <gtest/gtest.h>

#include <numeric>

#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

VertexGroups one_group(std::size_t n) {
  VertexGroups g;
  g.vertex.resize(n);
  std::iota(g.vertex.begin(), g.vertex.end(), 0);
  g.offset = {0, static_cast<std::int32_t>(n)};
  return g;
}

/// Eqs (8e)-(8g) as printed: scale by the maximum, normalise, multiply.
Values rescale_as_printed(const Values& v, double target) {
  const double most = testing::largest(v);
  Values scale;
  double sum = 0.0;
  for (const double value : v) scale.push_back(value / most), sum += value / most;
  for (double& value : scale) value = value / sum * target;
  return scale;
}

TEST(Rescale, WorkedExampleOfTheArticle) {
  Values v = {5.7, 12.0, 2.0, 4.5, 9.3, 6.7, 4.1, 1.5};
  const Values table = {0.535153, 1.126638, 0.187773, 0.422489, 0.873144, 0.629039, 0.384934, 0.140830};
  const Values printed = rescale_as_printed(v, 4.3);
  const VertexGroups group = one_group(v.size());
  const Projection done = project_total(group[0], Values(v.size(), 1.0), 4.3, 0.0, v);
  EXPECT_NEAR(done.factor, 0.093886463, 1e-9);
  for (std::size_t i = 0; i < v.size(); ++i) {
    EXPECT_NEAR(v[i], table[i], 5e-7);
    EXPECT_NEAR(v[i], printed[i], 1e-13);
  }
  EXPECT_NEAR(std::accumulate(v.begin(), v.end(), 0.0), 4.3, 1e-14);
}

/// Vertices in a row.
SheetGraph path_of(std::size_t n) {
  SheetGraph g;
  g.offset.push_back(0);
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(n); ++i) {
    if (i > 0) g.column.push_back(i - 1), g.entry_edge.push_back(i - 1);
    if (i + 1 < static_cast<std::int32_t>(n)) g.column.push_back(i + 1), g.entry_edge.push_back(i);
    g.offset.push_back(static_cast<std::int32_t>(g.column.size()));
  }
  return g;
}

/// Runs Eqs (8c)-(8g) on given u* and C with weight 1.
Values run_rescale(DiffusionParams p, const Values& star, const Values& c, double cap = 0.0,
                   RescaleResult* out = nullptr, const Kernel& kernel = {}) {
  const VertexGroups group = one_group(star.size());
  const Values one(star.size(), 1.0), none(star.size(), 0.0);
  const auto front = front_band(p, star, nullptr);
  Values masked = c, u = star;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += masked[i] *= front[i];
  SheetGraph edges = path_of(star.size());
  const std::vector<double> lengths(star.size(), 1.0);
  const RescaleInput in{.components = &group,
                        .whole = &group,
                        .mass = &one,
                        .weight = &one,
                        .u_star = &star,
                        .c = &masked,
                        .front = &front,
                        .supply = &none,
                        .overflow = {&edges, &lengths},
                        .capacity = cap,
                        .dt = 0.1};
  const RescaleResult result = rescale(p, in, kernel, u);
  if (out != nullptr) *out = result;
  return u;
}

DiffusionParams global_band(double low, double high) {
  DiffusionParams p;
  p.scope = Scope::global;
  p.u_min = low;
  p.u_max = high;
  return p;
}

TEST(Rescale, FrontBandExample) {
  RescaleResult result;
  const Values u = run_rescale(global_band(0.1, 0.9), {0.0, 0.2, 0.5, 1.0}, Values(4, 0.1), 0.0, &result);
  EXPECT_NEAR(result.rescale, 0.894736842, 1e-9);
  const Values expected = {0.0, 0.268421, 0.536842, 0.894737};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(u[i], expected[i], 5e-7);
}

TEST(Rescale, FrontScopeLeavesTheRestAlone) {
  DiffusionParams p = global_band(0.1, 0.9);
  p.scope = Scope::front;
  const Values u = run_rescale(p, {0.0, 0.2, 0.5, 1.0}, Values(4, 0.1));
  EXPECT_EQ(u[0], 0.0);
  EXPECT_EQ(u[3], 1.0);
  EXPECT_NEAR(u[1], 0.3 * 0.7 / 0.9, 1e-15);
  EXPECT_NEAR(u[2], 0.6 * 0.7 / 0.9, 1e-15);
}

TEST(Rescale, AFrontWithoutHardEndsKeepsTheTotalInEveryScope) {
  const Values star = {0.0, 0.12, 0.2, 0.5, 0.83, 1.0, 0.3}, c = {0.1, 0.3, 0.02, 0.2, 0.1, 0.1, 0.0};
  const double total = std::accumulate(star.begin(), star.end(), 0.0);
  const Kernel ones = [](const Values& rhs) {
    return Values(rhs.size(), std::accumulate(rhs.begin(), rhs.end(), 0.0));
  };
  for (const Scope scope : {Scope::global, Scope::component, Scope::front, Scope::local, Scope::local_front})
    for (const double ramp : {0.0, 0.1, 0.3, 10.0})
      for (const double cap : {0.0, 1.0}) {
        DiffusionParams p = global_band(0.1, 0.9);
        p.scope = scope;
        p.front_ramp = ramp;
        const Values u = run_rescale(p, star, c, cap, nullptr, ones);
        EXPECT_NEAR(std::accumulate(u.begin(), u.end(), 0.0), total, 1e-14);
        for (const double value : u) EXPECT_GE(value, 0.0);
      }
}

TEST(Front, SetsInAndFadesOverTheRamp) {
  DiffusionParams p = global_band(0.1, 0.9);
  p.front_ramp = 0.2;
  const Values front = front_band(p, {0.0999, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.9001}, nullptr);
  const Values expected = {0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.5, 0.0, 0.0};
  for (std::size_t i = 0; i < front.size(); ++i) EXPECT_NEAR(front[i], expected[i], 1e-12) << i;
  // Ramps that would overlap meet in the middle.
  p.front_ramp = 10.0;
  EXPECT_NEAR(front_band(p, {0.5}, nullptr)[0], 1.0, 1e-12);
}

TEST(Rescale, LocalScopeWithAKernelOfOnesIsTheLiteralRescaling) {
  const Values star = {0.0, 0.2, 0.5, 1.0}, c(4, 0.1);
  const Kernel ones = [](const Values& rhs) {
    return Values(rhs.size(), std::accumulate(rhs.begin(), rhs.end(), 0.0));
  };
  DiffusionParams p = global_band(0.1, 0.9);
  const Values literal = run_rescale(p, star, c);
  p.scope = Scope::local;
  const Values local = run_rescale(p, star, c, 0.0, nullptr, ones);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(local[i], literal[i], 1e-15);
  p.scope = Scope::front;
  const Values front = run_rescale(p, star, c);
  p.scope = Scope::local_front;
  const Values local_front = run_rescale(p, star, c, 0.0, nullptr, ones);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(local_front[i], front[i], 1e-15);
}

TEST(Rescale, ScalesWithItsInput) {
  DiffusionParams p = global_band(0.05, 0.9), p7 = global_band(0.35, 6.3);
  const Values star = {0.0, 0.2, 0.5, 1.0, 0.07}, c = {0.1, 0.02, 0.3, 0.1, 0.2};
  Values star7 = star, c7 = c;
  for (double& v : star7) v *= 7.0;
  for (double& v : c7) v *= 7.0;
  const Values u = run_rescale(p, star, c), u7 = run_rescale(p7, star7, c7);
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u7[i], 7.0 * u[i], 1e-14);
}

TEST(Rescale, FactorIsAtMostSigma) {
  for (const double sigma : {0.2, 1.0, 3.0}) {
    DiffusionParams p = global_band(0.05, 0.9);
    p.sigma = sigma;
    p.sigma_mode = SigmaMode::per_step;
    RescaleResult result;
    run_rescale(p, {0.1, 0.2, 0.3}, {0.0, 1e3, 0.1}, 0.0, &result);
    EXPECT_LE(result.rescale, sigma);
    EXPECT_GT(result.rescale, 0.0);
  }
}

/// r of Σ W min(cap, r v) = target by bisection.
double brute_force_factor(const Values& v, const Values& w, double target, double cap) {
  double low = 0.0, high = 1e12;
  for (int k = 0; k < 300; ++k) {
    const double middle = 0.5 * (low + high);
    double sum = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) sum += w[i] * std::min(cap, middle * v[i]);
    (sum < target ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

TEST(Capacity, ProjectionMatchesABruteForceSearch) {
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    Values v, w;
    double most = 0.0;
    for (std::uint64_t i = 0; i < 50; ++i) {
      v.push_back(std::pow(10.0, 3.0 * hash_signed(trial, 2 * i)));
      w.push_back(0.1 + hash_unit(trial, 2 * i + 1));
      most += w.back();
    }
    const double target = most * (0.01 + 0.98 * hash_unit(trial, 1000));
    const double r = brute_force_factor(v, w, target, 1.0);
    Values u = v;
    const VertexGroups group = one_group(v.size());
    const Projection done = project_total(group[0], w, target, 1.0, u);
    double sum = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      sum += w[i] * u[i];
      EXPECT_NEAR(u[i], std::min(1.0, r * v[i]), 1e-10);
      EXPECT_LE(u[i], 1.0);
    }
    EXPECT_NEAR(sum / target, 1.0, 1e-13);
    EXPECT_EQ(done.excess, 0.0);
  }
}

TEST(Capacity, ReturnsWhatTheSheetCannotHold) {
  Values u = {0.5, 2.0, 1.0};
  const VertexGroups group = one_group(3);
  const Projection done = project_total(group[0], {1.0, 2.0, 3.0}, 10.0, 1.0, u);
  EXPECT_EQ(u, Values(3, 1.0));
  EXPECT_NEAR(done.excess, 4.0, 1e-14);
}

TEST(Rescale, NothingStaysNothing) {
  const Values u = run_rescale(global_band(0.1, 0.9), Values(5, 0.0), Values(5, 1.0));
  EXPECT_EQ(u, Values(5, 0.0));
}

/// Largest relative change by C beyond x = 3 m of a strip of 4 m, nearly full at one end and nearly dry at the
/// other, crumpled below x = 2 m. `full` is set where it met the capacity.
double change_far_away(Scope scope, Order order, double bumps, double capacity, bool& full) {
  Sheet s(testing::sheet(401, 24, Vec2(4.0, 0.2)));
  for (Vec3& p : s.x)
    if (p.x() < 2.0) p.z() += bumps * std::sin(40.0 * p.x()) * std::sin(30.0 * p.y());
  Values ours = s.field([](const Vec3& p) { return 0.05 + 0.949 / (1.0 + std::exp((p.x() - 1.0) / 0.03)); });
  Values plain = ours;
  DiffusionParams p;
  p.scope = scope;
  p.order = order;
  p.u_max = 0.999;
  DiffusionSolver strained(p), isotropic(testing::plain_diffusion(p.alpha));
  DiffusionInput in = s.input();
  in.capacity = capacity;
  for (int step = 0; step < 20; ++step) {
    const DiffusionReport r = strained.step(ours, in, 1.0 / 30.0);
    isotropic.step(plain, in, 1.0 / 30.0);
    EXPECT_LT(testing::budget_error(r), 1e-12);
    EXPECT_EQ(r.excess, 0.0);
    EXPECT_TRUE(capacity == 0.0 || testing::largest(ours) <= capacity);
  }
  full = testing::largest(ours) >= 1.0;
  double far = 0.0;
  for (std::size_t i = 0; i < ours.size(); ++i)
    if (s.mesh.rest[i].x() > 3.0) far = std::max(far, std::abs(ours[i] / plain[i] - 1.0));
  return far;
}

TEST(Overflow, FillsTheNearestRoomAndNothingElse) {
  const SheetGraph path = path_of(9);
  const std::vector<double> lengths(9, 1.0), mass = {1, 1, 1, 1, 0.5, 0, 2, 1, 1};
  Values u = {1.0, 3.0, 1.0, 0.9, 0.4, 7.0, 0.1, 0.2, 0.3};
  pour_over({&path, &lengths}, mass, 1.0, u);
  // 2 units over: 0.1 fills vertex 3, 0.3 vertex 4, the massless one is passed, the rest comes to vertex 6.
  const Values expected = {1.0, 1.0, 1.0, 1.0, 1.0, 7.0, 0.9, 0.2, 0.3};
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], expected[i], 1e-14) << i;

  Values full(9, 1.5);
  pour_over({&path, &lengths}, mass, 1.0, full);
  EXPECT_EQ(full, Values(9, 1.5)) << "what has no room stays";
}

TEST(Overflow, KeepsTheSumOnSheetsWithHoles) {
  Sheet s = testing::two_pieces(testing::jittered(61, 40, 0.2), 0.45, 0.5);
  Values u = s.field([](const Vec3& p) { return p.x() < 0.3 ? 1.2 : 0.1 + 0.5 * p.y(); });
  const double before = s.total(u);
  const Values start = u;
  const SheetGraph graph = build_graph(s.mesh);
  pour_over({&graph, &s.mesh.rest_length}, s.mass, 1.0, u);
  EXPECT_NEAR(s.total(u), before, 1e-13 * before);
  EXPECT_EQ(testing::largest(u), 1.0);
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_TRUE(s.mesh.rest[i].x() <= 0.55 || u[i] == start[i]);
}

/// A strip that is overfull at one end, with a damp spot at the other that has nothing to do with it.
TEST(Overflow, LeavesDistantSpotsAlone) {
  Sheet s(testing::sheet(401, 24, Vec2(4.0, 0.2)));
  Values rate(s.mass.size(), 0.0), value(s.mass.size(), 2.1);
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (s.mesh.rest[i].x() < 0.05) rate[i] = 20.0 * s.mass[i];
  const auto spot = [](const Vec3& p) { return p.x() > 3.5 ? 0.125 : 0.0; };
  for (const auto& [scope, sigma] :
       {std::pair(Scope::front, 1.0), std::pair(Scope::local, 1.0), std::pair(Scope::local_front, 1.0),
        std::pair(Scope::local_front, 1.5), std::pair(Scope::local, 0.5)}) {
    DiffusionParams p;
    p.scope = scope;
    p.sigma_mode = SigmaMode::influx;
    p.sigma = sigma;
    p.model = Model::isotropic;
    p.alpha = 1e-4;
    DiffusionSolver with(p), without(p);
    Values wet = s.field(spot), dry = wet;
    DiffusionInput in = s.input();
    in.capacity = 1.0;
    for (int step = 0; step < 60; ++step) {
      without.step(dry, in, 1.0 / 30.0);
      DiffusionInput supplied = in;
      supplied.supply_rate = &rate;
      supplied.supply_value = &value;
      ASSERT_LT(testing::budget_error(with.step(wet, supplied, 1.0 / 30.0)), 1e-12);
      ASSERT_LE(testing::largest(wet), 1.0);
    }
    double reached = 0.0, change = 0.0;
    for (std::size_t i = 0; i < wet.size(); ++i) {
      if (s.mesh.rest[i].x() < 3.4 && wet[i] > 0.5) reached = std::max(reached, s.mesh.rest[i].x());
      if (s.mesh.rest[i].x() > 3.7) change = std::max(change, std::abs(wet[i] / dry[i] - 1.0));
    }
    EXPECT_GT(reached, sigma < 1.0 ? 0.5 : 1.0) << static_cast<int>(scope);
    EXPECT_LT(change, sigma == 1.0 ? 1e-12 : 1e-9) << static_cast<int>(scope) << " " << sigma;
  }
}

TEST(LocalScopes, DoNotActFarAway) {
  // Bumps of 5 mm and of 20 mm, which stretch the sheet by a per cent and by a third.
  for (const double bumps : {0.005, 0.02})
    for (const Scope scope : {Scope::local, Scope::local_front})
      for (const Order order : {Order::inside, Order::after})
        for (const double capacity : {0.0, 1.0}) {
          bool full = false;
          const double far = change_far_away(scope, order, bumps, capacity, full);
          EXPECT_LT(far, 1e-6);
        }
}

}  // namespace
}  // namespace wick::diffusion
