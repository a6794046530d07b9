/// Closest points against a search over the features, and the tree of boxes against all pairs.
#include "solid/proximity.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "solid/box_tree.h"

namespace wick::solid {
namespace {

std::array<Vec3, 4> random_points(std::mt19937_64& random, int degenerate) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::array<Vec3, 4> x;
  for (Vec3& p : x) p = Vec3(uniform(random), uniform(random), uniform(random));
  if (degenerate == 1) x[3] = x[2];
  if (degenerate == 2) x[3] = x[2] + (x[1] - x[0]);  // parallel edges
  if (degenerate == 3) x[3] = x[1] + 0.5 * (x[2] - x[1]);
  return x;
}

/// Least distance between points of the features on a lattice of weights.
double searched(FeaturePair kind, const std::array<Vec3, 4>& x, int steps) {
  double least = INFINITY;
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; j <= steps; ++j) {
      const double s = double(i) / steps, t = double(j) / steps;
      if (kind == FeaturePair::edge_edge)
        least = std::min(least, (x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])).norm());
      else if (s + t <= 1.0)
        least = std::min(least, (x[0] - x[1] - s * (x[2] - x[1]) - t * (x[3] - x[1])).norm());
    }
  return least;
}

TEST(Proximity, ClosestPointsAreThoseOfASearch) {
  constexpr int kSteps = 100;
  std::mt19937_64 random(11);
  for (int n = 0; n < 400; ++n)
    for (const FeaturePair kind : {FeaturePair::vertex_triangle, FeaturePair::edge_edge}) {
      const std::array<Vec3, 4> x = random_points(random, n % 4);
      const Separation s = closest(kind, x);
      const double found = searched(kind, x, kSteps);
      EXPECT_LE(s.distance, found + 1e-12);
      EXPECT_NEAR(s.distance, found, 4.0 / kSteps);
      Vec3 way = Vec3::Zero();
      double first = 0.0, second = 0.0;
      for (int k = 0; k < 4; ++k) {
        way += s.weight[k] * x[k];
        (k < first_count(kind) ? first : second) += s.weight[k];
      }
      EXPECT_NEAR(first, 1.0, 1e-12);
      EXPECT_NEAR(second, -1.0, 1e-12);
      EXPECT_NEAR((way - s.distance * s.direction).norm(), 0.0, 1e-12);
      // The plane across the shortest way separates the features.
      EXPECT_NEAR(gap_along(kind, x, s.direction), s.distance, 1e-9);
    }
}

TEST(Proximity, NearlyParallelEdgesKeepTheirDistance) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int n = 0; n < 2000; ++n) {
    const double tilt = std::pow(10.0, -16.0 + 8.0 * n / 2000.0), shift = uniform(random);
    const std::array<Vec3, 4> x = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(shift, 0.1, tilt * uniform(random)),
                                   Vec3(shift + 1.0, 0.1 + tilt, 0.0)};
    EXPECT_NEAR(closest(FeaturePair::edge_edge, x).distance, 0.1, 1e-7);
  }
}

/// A vertex shot at a triangle, and edges at edges: what the advancement calls apart is apart at 1000 times
/// between.
TEST(Proximity, WhatStaysApartDoes) {
  std::mt19937_64 random(3);
  int apart = 0, near = 0;
  for (int n = 0; n < 4000; ++n)
    for (const FeaturePair kind : {FeaturePair::vertex_triangle, FeaturePair::edge_edge}) {
      const std::array<Vec3, 4> from = random_points(random, 0), to = random_points(random, 0);
      const double least = 0.02;
      double nearest = INFINITY;
      for (int k = 0; k <= 100; ++k) {
        std::array<Vec3, 4> x;
        for (int c = 0; c < 4; ++c) x[c] = from[c] + k / 100.0 * (to[c] - from[c]);
        nearest = std::min(nearest, closest(kind, x).distance);
      }
      const bool said = stay_apart(kind, from, to, least);
      EXPECT_FALSE(said && nearest < least);
      EXPECT_TRUE(said || nearest < 0.1);
      ++(said ? apart : near);
    }
  EXPECT_GT(apart, 4000);
  EXPECT_GT(near, 300);
}

bool overlap(const Box& a, const Box& b, double margin) {
  return (a.low.array() <= b.high.array() + margin).all() && (b.low.array() <= a.high.array() + margin).all();
}

/// Overlaps are found up to the rounding of boxes to floats, each once; clusters share the boxes out.
TEST(BoxTree, FindsTheOverlapsThatAllPairsHave) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const int count : {0, 1, 3, 5, 64, 777}) {
    std::vector<Box> boxes(count);
    for (Box& box : boxes) {
      const Vec3 low(uniform(random), uniform(random), uniform(random));
      box.add(low);
      box.add(low + 0.15 * Vec3(uniform(random), uniform(random), uniform(random)));
    }
    const BoxTree tree(boxes);
    for (int a = 0; a < count; ++a) {
      std::set<int> found;
      tree.for_overlaps(boxes[a], [&](std::int32_t b) { EXPECT_TRUE(found.insert(b).second); });
      for (int b = 0; b < count; ++b) {
        const bool in_tree = found.count(b) != 0;
        EXPECT_TRUE(in_tree || !overlap(boxes[a], boxes[b], 0.0));
        EXPECT_TRUE(!in_tree || overlap(boxes[a], boxes[b], 1e-6));
      }
    }
    std::size_t next = 0;
    tree.for_clusters(16, [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin, next);
      EXPECT_LE(end - begin, 16u);
      next = end;
    });
    EXPECT_EQ(next, static_cast<std::size_t>(count));
  }
}

}  // namespace
}  // namespace wick::solid
