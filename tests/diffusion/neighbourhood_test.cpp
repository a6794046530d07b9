/// Averages over neighbourhoods: symmetric, exact for constants, and near the exact kernel (A + R² L)^-1.
#include "diffusion/neighbourhood.h"

#include <gtest/gtest.h>

#include <map>

#include "diffusion/linear_solver.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

struct Geometry {
  Sheet s;
  SheetGraph graph;
  SheetOperator op;
  explicit Geometry(solid::ShellMesh mesh) : s(std::move(mesh)), graph(build_graph(s.mesh)) {
    build_operator(s.mesh, graph, {}, s.mesh.rest, corner_cotangents(s.mesh, s.mesh.rest), s.mesh.vertex_area, op);
  }
  [[nodiscard]] Values exact(const Values& rhs, double radius) const {
    SheetMatrix matrix;
    assemble(graph, op, radius * radius, {}, {}, matrix);
    Values x(rhs.size(), 0.0);
    LinearSolver().solve(matrix, rhs, 1e-12, x);
    return x;
  }
  [[nodiscard]] Values random_amounts(std::uint64_t seed) const {
    Values v;
    for (std::size_t i = 0; i < s.mass.size(); ++i) v.push_back(s.mass[i] * hash_unit(seed, i));
    return v;
  }
};

double dot(const Values& a, const Values& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

TEST(Neighbourhood, IsSymmetricAndKeepsConstantsForAnyRadius) {
  const Geometry g(testing::jittered(41, 47, 0.25));
  for (const double radius : {1e-12, 1e-3, 0.05, 0.3, 10.0, 1e6, 1e300}) {
    const Neighbourhood k(g.s.mesh, g.graph, g.op, radius);
    for (const double one : k.average(g.s.mass)) EXPECT_NEAR(one, 1.0, 1e-9) << radius;
    const Values a = g.random_amounts(1), b = g.random_amounts(2);
    const double ab = dot(a, k.average(b)), ba = dot(b, k.average(a));
    EXPECT_NEAR(ab / ba, 1.0, 1e-9) << radius;
  }
}

TEST(Neighbourhood, IsNearTheExactKernel) {
  const Geometry g(testing::sheet(93, 107));
  for (const double radius : {0.03, 0.05, 0.2}) {
    const Neighbourhood k(g.s.mesh, g.graph, g.op, radius);
    // A front as wide as the radius, and one vertex, whose neighbourhood has a cusp that patches cannot show.
    Values front(g.s.mass.size(), 0.0), point = front;
    for (std::size_t i = 0; i < front.size(); ++i)
      front[i] = g.s.mass[i] * std::exp(-0.5 * std::pow((g.s.mesh.rest[i].y() - 0.5) / radius, 2));
    point[50 * 93 + 46] = 1.0;
    const Values exact = g.exact(front, radius), approximate = k.average(front);
    EXPECT_LT(testing::rms(approximate, exact), 0.02 * testing::largest(exact)) << radius;
    const Values cusp = g.exact(point, radius), blunt = k.average(point);
    EXPECT_LT(testing::rms(blunt, cusp), 0.05 * testing::largest(cusp)) << radius;
    EXPECT_GT(testing::smallest(blunt), -0.01 * testing::largest(blunt)) << radius;
    std::printf("  R = %.2f: %zu patches, rms error %.1e of a front, %.1e of a point\n", radius, k.patches(),
                testing::rms(approximate, exact) / testing::largest(exact),
                testing::rms(blunt, cusp) / testing::largest(cusp));
  }
}

/// The average of a front, at the vertices that all meshes of the test share.
std::map<std::pair<long, long>, double> average_of_front(int columns, int rows) {
  const Geometry g(testing::sheet(columns, rows));
  const Neighbourhood k(g.s.mesh, g.graph, g.op, 0.05);
  Values front(g.s.mass.size());
  for (std::size_t i = 0; i < front.size(); ++i) {
    const Vec3& x = g.s.mesh.rest[i];
    front[i] = g.s.mass[i] * std::exp(-0.5 * std::pow((x.y() - 0.4 - 0.1 * std::sin(9.0 * x.x())) / 0.03, 2));
  }
  const Values average = k.average(front);
  std::map<std::pair<long, long>, double> at;
  for (std::size_t i = 0; i < front.size(); ++i)
    at[{std::lround(1e7 * g.s.mesh.rest[i].x()), std::lround(1e7 * g.s.mesh.rest[i].y())}] = average[i];
  return at;
}

TEST(Neighbourhood, ConvergesAsTheMeshIsRefined) {
  const auto coarse = average_of_front(47, 54), middle = average_of_front(93, 107),
             fine = average_of_front(185, 213);
  const auto change = [](const auto& a, const auto& b) {
    double sum = 0.0, count = 0.0;
    for (const auto& [place, value] : a)
      if (const auto found = b.find(place); found != b.end())
        sum += (value - found->second) * (value - found->second), count += 1.0;
    return std::sqrt(sum / count);
  };
  EXPECT_LT(change(middle, fine), 0.6 * change(coarse, middle));
}

TEST(Neighbourhood, DoesNotReachAcrossGapsAndLeavesOrphansAlone) {
  const Geometry g(solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1.01, 0, 0), Vec3(2, 0, 0),
                                      Vec3(1.01, 1, 0), Vec3(5, 5, 5)},
                                     {}, {{0, 1, 2}, {3, 4, 5}}));
  const Neighbourhood k(g.s.mesh, g.graph, g.op, 3.0);
  const Values result = k.average({1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0});
  for (const int i : {0, 1, 2}) EXPECT_GT(result[i], 0.0);
  for (const int i : {3, 4, 5, 6}) EXPECT_EQ(result[i], 0.0);
}

}  // namespace
}  // namespace wick::diffusion
