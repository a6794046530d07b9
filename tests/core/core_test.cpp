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

TEST(Obstacle, MovesWithItsDisplacement) {
  Obstacle plane{.name = "p", .shape = PlaneShape{}, .displacement = Vec3(0, 0, 0.25)};
  EXPECT_DOUBLE_EQ(sample_distance(plane, Vec3(3, 4, 1)).distance, 0.75);
}

}  // namespace
}  // namespace wick
