#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/ledger.h"
#include "core/noise.h"
#include "core/obstacle.h"
#include "core/parallel.h"
#include "core/state.h"

namespace wick {
namespace {

double harmonic_sum(int threads) {
  const ThreadLimit limit(threads);
  return parallel_sum(1000003, 1000, [](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += 1.0 / (1.0 + static_cast<double>(i));
    return sum;
  });
}

TEST(Parallel, SumHasTheSameBitsAtAnyThreadCount) {
  EXPECT_EQ(harmonic_sum(1), harmonic_sum(2));
  EXPECT_EQ(harmonic_sum(1), harmonic_sum(5));
}

TEST(Parallel, EmptyRangesAreFine) {
  const auto unreachable = [](std::size_t, std::size_t) -> double { return NAN; };
  EXPECT_EQ(parallel_sum(0, 10, unreachable), 0.0);
  EXPECT_EQ(parallel_max(0, 10, -1.0, unreachable), -1.0);
}

TEST(Noise, CoversTheIntervalEvenly) {
  int below = 0;
  for (std::uint64_t i = 0; i < 10000; ++i) below += hash_unit(3, i) < 0.25 ? 1 : 0;
  EXPECT_NEAR(below, 2500, 5 * std::sqrt(10000 * 0.25 * 0.75));
}

TEST(Ledger, ClosesWhenAStockMovesAndShowsWhatIsMissing) {
  Ledger ledger;
  ledger.set_stock("sheet", 2.0);
  ledger.set_stock("smoke", 0.0);
  ledger.open();
  ledger.set_stock("sheet", 1.5);
  ledger.set_stock("smoke", 0.4);
  ledger.book_flow("outflow", -0.1);
  EXPECT_NEAR(ledger.relative_error(), 0.0, 1e-15);
  ledger.set_stock("smoke", 0.3);
  EXPECT_NEAR(ledger.relative_error(), 0.05, 1e-12);
}

std::uint64_t hash_of(std::vector<double> values) {
  StateHash hash;
  hash.group("g", [&] { hash.array("v", values); });
  return hash.digest();
}

TEST(StateHash, SeesEveryBitTheShapeAndSignedZero) {
  std::set<std::uint64_t> seen;
  seen.insert(hash_of({}));
  seen.insert(hash_of({0.0}));
  seen.insert(hash_of({-0.0}));
  seen.insert(hash_of({0.0, 0.0}));
  seen.insert(hash_of({1.0}));
  seen.insert(hash_of({std::nextafter(1.0, 2.0)}));
  EXPECT_EQ(seen.size(), 6U);
  EXPECT_EQ(hash_of({1.0, 2.0, 3.0}), hash_of({1.0, 2.0, 3.0}));
}

TEST(Obstacle, GradientsMatchFiniteDifferencesOutsideAndInside) {
  Obstacle sphere{.name = "s", .shape = SphereShape{Vec3(0.1, 0.2, 0.3), 0.5}};
  Obstacle box{.name = "b", .shape = BoxShape{Vec3(-1, -2, -3), Vec3(1, 1, 1)}};
  for (const Obstacle& obstacle : {sphere, box})
    for (std::uint64_t n = 0; n < 200; ++n) {
      const Vec3 x(2 * hash_signed(1, 3 * n), 2 * hash_signed(1, 3 * n + 1), 2 * hash_signed(1, 3 * n + 2));
      const DistanceSample s = sample_distance(obstacle, x);
      for (int a = 0; a < 3; ++a) {
        const Vec3 step = 1e-6 * Vec3::Unit(a);
        const double slope =
            (sample_distance(obstacle, x + step).distance - sample_distance(obstacle, x - step).distance) / 2e-6;
        EXPECT_NEAR(slope, s.gradient[a], 1e-4);
      }
    }
}

/// Distance samples of a ball of radius 0.4 about (0.1, 0, -0.1), with two spacings to spare.
SampledShape sampled_ball() {
  SampledShape shape{.origin = Vec3(-0.4, -0.5, -0.6), .spacing = 0.05, .nodes = {21, 21, 21}, .distance = {}};
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 21; ++j)
      for (int i = 0; i < 21; ++i) {
        const Vec3 node = shape.origin + shape.spacing * Vec3(i, j, k);
        shape.distance.push_back(static_cast<float>((node - Vec3(0.1, 0, -0.1)).norm() - 0.4));
      }
  return shape;
}

TEST(Obstacle, SegmentsMeetWhatTheirPointsAreIn) {
  const Vec3 shift(0.02, -0.01, 0.03);
  const std::vector<Obstacle> obstacles = {
      {.name = "s", .shape = SphereShape{Vec3(0.1, 0.2, 0.3), 0.5}, .pose = {.shift = shift}},
      {.name = "plate", .shape = BoxShape{Vec3(-0.6, -0.7, 0.1), Vec3(0.5, 0.4, 0.102)}, .pose = {.shift = shift}},
      {.name = "p", .shape = PlaneShape{Vec3::Zero(), Vec3(0.6, 0.0, 0.8)}, .pose = {.shift = shift}},
      {.name = "m", .shape = sampled_ball(), .pose = {.shift = shift}}};
  for (const Obstacle& obstacle : obstacles) {
    int met = 0;
    for (std::uint64_t n = 0; n < 400; ++n) {
      const auto random = [n](std::uint64_t k) { return hash_signed(k, n); };
      const Vec3 a(random(1), random(2), random(3)), b(random(4), random(5), random(6));
      double nearest = 1.0, deepest = -1.0;  // of the points, and of their distance to the edge
      for (int k = 0; k <= 4000; ++k) {
        const double distance = sample_distance(obstacle, a + k / 4000.0 * (b - a)).distance;
        nearest = std::min(nearest, distance);
        deepest = std::max(deepest, -distance);
      }
      const bool meets = segment_meets(obstacle, a, b);
      met += meets ? 1 : 0;
      // Points 1e-3 apart do not tell where a segment only grazes; of samples a chord of a quarter may be missed.
      const bool sampled = std::holds_alternative<SampledShape>(obstacle.shape);
      EXPECT_TRUE(meets || deepest <= (sampled ? 2e-3 : 0.0)) << obstacle.name << n;
      EXPECT_TRUE(!meets || nearest <= 1e-3) << obstacle.name << n;
      EXPECT_TRUE(meets == segment_meets(obstacle, b, a) || (sampled && deepest < 2e-3)) << obstacle.name << n;
    }
    EXPECT_GT(met, 50) << obstacle.name;
    EXPECT_LT(met, 350) << obstacle.name;
  }
}

TEST(Obstacle, MovesWithItsDisplacement) {
  Obstacle plane{.name = "p", .shape = PlaneShape{}, .pose = {.shift = Vec3(0, 0, 0.25)}};
  EXPECT_DOUBLE_EQ(sample_distance(plane, Vec3(3, 4, 1)).distance, 0.75);
}

}  // namespace
}  // namespace wick
