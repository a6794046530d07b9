/// Closest points against a search over the features, and the tree of boxes against all pairs.
#include "solid/proximity.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

#include "solid/box_tree.h"
#include "solid/contact_pairs.h"
#include "solid/primitives.h"

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

using PairKey = std::tuple<FeaturePair, std::int32_t, std::int32_t, std::int32_t, std::int32_t>;
PairKey key_of(FeaturePair kind, std::array<std::int32_t, 4> v) {
  if (kind == FeaturePair::vertex_triangle) {
    std::sort(v.begin() + 1, v.end());
  } else {
    if (v[0] > v[1]) std::swap(v[0], v[1]);
    if (v[2] > v[3]) std::swap(v[2], v[3]);
    if (v[0] > v[2]) v = {v[2], v[3], v[0], v[1]};
  }
  return {kind, v[0], v[1], v[2], v[3]};
}

/// Calls body(kind, vertices) for every pair of features without a common vertex.
template <class Body>
void for_all_pairs(const ContactMesh& mesh, Body&& body) {
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (const Int3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
  for (const Int3& t : mesh.triangles)
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(mesh.vertex_count()); ++v)
      if (v != t[0] && v != t[1] && v != t[2])
        body(FeaturePair::vertex_triangle, std::array<std::int32_t, 4>{v, t[0], t[1], t[2]});
  for (auto a = edges.begin(); a != edges.end(); ++a)
    for (auto b = std::next(a); b != edges.end(); ++b)
      if (a->first != b->first && a->first != b->second && a->second != b->first && a->second != b->second)
        body(FeaturePair::edge_edge, std::array<std::int32_t, 4>{a->first, a->second, b->first, b->second});
}

/// The search against all pairs: none that is near is missing, and each is there once; also when only some
/// triangles are searched anew after they have moved.
TEST(PairFinder, FindsWhatAllPairsHold) {
  constexpr double kReach = 0.004, kFar = 0.05, kHalf = 0.001;
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const ShellMesh sheets[2] = {build_mesh(rectangle(13, 12, {0.2, 0.2})), build_mesh(rectangle(9, 14, {0.2, 0.2}))};
  const ContactMesh mesh =
      join_sheets(std::vector<const ShellMesh*>{&sheets[0], &sheets[1]}, std::vector<double>{kHalf, kHalf});
  ASSERT_GT(mesh.cluster_count(), 4U);
  std::vector<Row> x;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Vec3 p = mesh.rest[i] + 0.01 * Vec3(uniform(random), uniform(random), uniform(random));
    x.push_back({p.x(), p.y(), p.z() + 0.01 * mesh.sheet[i], 1.0});
  }
  const std::size_t triangles = mesh.triangles.size(), count = mesh.cluster_count();
  ContactBase base;
  base.corner.resize(3 * triangles);
  base.reach.assign(triangles, kReach);
  base.travelled.assign(triangles, 0.0);
  base.drifted.assign(count, Vec3::Zero());
  base.drift.assign(count, Vec3::Zero());
  base.triangle_marked.assign(triangles, 1);
  base.cluster_marked.assign(count, 1);
  PairFinder finder(mesh);
  std::vector<ClusterPair> clusters;
  for (int again = 0; again < 3; ++again) {
    for (std::size_t t = 0; t < triangles; ++t)
      for (int k = 0; k < 3 && base.triangle_marked[t] != 0; ++k) base.corner[3 * t + k] = x[mesh.triangles[t][k]];
    finder.place_boxes(base);
    if (again == 0) {
      finder.pair_clusters(kFar, clusters);
      base.pair_marked.assign(clusters.size(), 2);
    }
    finder.search(base, clusters);
    std::set<PairKey> found;
    for (const ClusterPair& c : clusters)
      for (const ContactPair& pair : c.pairs) {
        EXPECT_TRUE(found.insert(key_of(pair.kind, pair.vertex)).second);
        const double distance = closest(pair.kind, points(x, pair.vertex)).distance;
        const double gone = base.travelled[pair.triangle[0]] + base.travelled[pair.triangle[1]];
        EXPECT_LE(pair.allowance - gone, distance - pair.keep + 1e-12) << "it must be looked at before it is near";
      }
    std::size_t near = 0;
    for_all_pairs(mesh, [&](FeaturePair kind, const std::array<std::int32_t, 4>& v) {
      // What moved by half its reach and was not searched anew may have come nearer by as much.
      if (closest(kind, points(x, v)).distance >= 2.0 * kHalf + (again == 0 ? 2.0 : 1.0) * kReach) return;
      ++near;
      EXPECT_TRUE(found.count(key_of(kind, v)) != 0);
    });
    EXPECT_GT(near, 500U);
    // Half of the vertices move by up to half the reach; triangles with one of them are searched anew, but for
    // some.
    for (std::size_t i = 0; i < x.size(); i += 2) {
      const Vec3 way = 0.5 * kReach / std::sqrt(3.0) * Vec3(uniform(random), uniform(random), uniform(random));
      x[i] = {x[i].x + way.x(), x[i].y + way.y(), x[i].z + way.z(), 1.0};
    }
    for (double& travelled : base.travelled) travelled += 0.5 * kReach;
    std::fill(base.cluster_marked.begin(), base.cluster_marked.end(), std::uint8_t{0});
    for (std::size_t t = 0; t < triangles; ++t) {
      // Once left out, twice moved: then it has to be searched.
      base.triangle_marked[t] = again == 1 || t % 3 != 0 ? 1 : 0;
      base.cluster_marked[mesh.cluster[t]] |= base.triangle_marked[t];
    }
    for (std::uint8_t& marked : base.pair_marked) marked = 1;
  }
}

}  // namespace
}  // namespace wick::solid
