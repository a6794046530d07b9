/// Cutting sheets along an isocontour (methods 9.6).
#include "solid/mesh_cut.h"

#include <gtest/gtest.h>

#include <set>

#include "core/noise.h"
#include "solid/primitives.h"

namespace wick::solid {
namespace {

/// A mesh to be cut, and what is left of it.
struct Workpiece {
  explicit Workpiece(TriangleSoup soup, double snap = 0.3) : mesh(build_mesh(std::move(soup))) {
    surface = {mesh.rest, mesh.triangles, edge_spacing(mesh.rest, mesh.edges)};
    for (double& distance : surface.snapping) distance *= snap;
  }
  template <class Level>
  [[nodiscard]] std::vector<double> levels(Level&& level) const {
    std::vector<double> values;
    for (const Vec3& x : surface.rest) values.push_back(level(x));
    return values;
  }
  /// Every edge in at most two triangles, one fan at every vertex, all turned alike: build_mesh refuses the rest.
  [[nodiscard]] ShellMesh left() const { return build_mesh(surface.rest, {}, surface.triangles); }

  ShellMesh mesh;
  CutSurface surface;
};

double area_of(const ShellMesh& mesh) {
  double sum = 0.0;
  for (const double a : mesh.rest_area) sum += a;
  return sum;
}

double rim_length(const ShellMesh& mesh) {
  std::set<std::pair<int, int>> inner;
  for (const Hinge& hinge : mesh.hinges) inner.insert({hinge.vertex[0], hinge.vertex[1]});
  double sum = 0.0;
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    if (!inner.contains({mesh.edges[e][0], mesh.edges[e][1]})) sum += mesh.rest_length[e];
  return sum;
}

long euler_characteristic(const ShellMesh& mesh) {
  long vertices = 0;
  for (const std::int32_t part : mesh.component) vertices += part >= 0 ? 1 : 0;
  return vertices - static_cast<long>(mesh.edges.size()) + static_cast<long>(mesh.triangle_count());
}

/// That of the part above the level: it shrinks onto the vertices, edges and triangles that lie in it whole.
long euler_characteristic_above(const ShellMesh& mesh, const std::vector<double>& level) {
  long sum = 0;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) sum += level[i] > 0.0 ? 1 : 0;
  for (const auto& [a, b] : mesh.edges) sum -= level[a] > 0.0 && level[b] > 0.0 ? 1 : 0;
  for (const Int3& v : mesh.triangles) sum += level[v[0]] > 0.0 && level[v[1]] > 0.0 && level[v[2]] > 0.0 ? 1 : 0;
  return sum;
}

/// Integral of the linear q over the part of one triangle where the linear level is positive, by clipping.
double integral_above(const std::array<Vec3, 3>& x, const std::array<double, 3>& level,
                      const std::array<double, 3>& q) {
  struct Corner {
    Vec3 x;
    double q;
  };
  std::vector<Corner> part;
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    if (level[k] > 0.0) part.push_back({x[k], q[k]});
    if ((level[k] > 0.0) == (level[n] > 0.0)) continue;
    const double s = level[k] / (level[k] - level[n]);
    part.push_back({x[k] + s * (x[n] - x[k]), q[k] + s * (q[n] - q[k])});
  }
  double sum = 0.0;
  for (std::size_t k = 1; k + 1 < part.size(); ++k)
    sum += 0.5 * (part[k].x - part[0].x).cross(part[k + 1].x - part[0].x).norm() *
           (part[0].q + part[k].q + part[k + 1].q) / 3.0;
  return sum;
}

double integral(const ShellMesh& mesh, const std::vector<double>& q) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (const int i : mesh.triangles[t]) sum += mesh.rest_area[t] / 3.0 * q[i];
  return sum;
}

double smallest_angle(const ShellMesh& mesh) {
  double least = M_PI;
  for (const Int3& v : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.rest[v[(k + 1) % 3]] - mesh.rest[v[k]], b = mesh.rest[v[(k + 2) % 3]] - mesh.rest[v[k]];
      least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  return least;
}

/// Sum of six waves of random direction, length and phase, moved up or down: up to some dozen islands and holes.
auto random_level(const Vec3& extent, std::uint64_t seed) {
  return [=](const Vec3& x) {
    double sum = 0.8 * hash_signed(seed, 0);
    for (std::uint64_t n = 1; n <= 6; ++n) {
      const Vec3 direction(hash_signed(seed, 5 * n), hash_signed(seed, 5 * n + 1), hash_signed(seed, 5 * n + 2));
      const double waves = 6.0 + 12.0 * hash_unit(seed, 5 * n + 3);
      sum += std::sin(waves * direction.dot(x) / extent.maxCoeff() + 6.3 * hash_unit(seed, 5 * n + 4));
    }
    return sum;
  };
}

/// Methods 9.6: a circular hole, and a disc.
TEST(MeshCut, AreaAndRimOfCirclesConverge) {
  for (const double side : {1.0, -1.0}) {
    std::vector<double> area_error, rim_error;
    for (const int n : {20, 40, 80, 160}) {
      // Over many places of the circle, as the error of one is a matter of chance.
      double area = 0.0, rim = 0.0;
      for (std::uint64_t place = 0; place < 8; ++place) {
        Workpiece piece(rectangle(n, n, {1.0, 1.0}, Lattice::staggered));
        const Vec3 low = piece.mesh.rest.front(), high = piece.mesh.rest.back();
        const Vec3 middle = 0.5 * (low + high) + 0.05 * Vec3(hash_signed(1, place), hash_signed(2, place), 0.0);
        const auto level = piece.levels([&](const Vec3& x) { return side * ((x - middle).norm() - 0.3); });
        cut_below(piece.surface, level);
        const ShellMesh left = piece.left();
        const double disc = M_PI * 0.09, whole = area_of(piece.mesh);
        area += std::abs(area_of(left) - (side > 0 ? whole - disc : disc)) / 8.0;
        rim += std::abs(rim_length(left) - (side > 0 ? rim_length(piece.mesh) : 0.0) - 0.6 * M_PI) / 8.0;
        EXPECT_EQ(euler_characteristic(left), side > 0 ? 0 : 1) << "of a disc with a hole, of a disc";
        EXPECT_GT(smallest_angle(left), 0.05);
      }
      area_error.push_back(area);
      rim_error.push_back(rim);
    }
    EXPECT_GT(std::log2(area_error.front() / area_error.back()) / 3.0, 1.8)
        << area_error[0] << " " << area_error[3];
    EXPECT_GT(std::log2(rim_error.front() / rim_error.back()) / 3.0, 0.9) << rim_error[0] << " " << rim_error[3];
  }
}

/// 1,000 contours on three meshes: what is left is a manifold, has the area, mass and heat of the part above the
/// level and as many parts and holes, and is not cut twice.
TEST(MeshCut, RandomContoursKeepEverythingExact) {
  const std::array<TriangleSoup, 3> soups = {rectangle(23, 21, {1.0, 0.8}, Lattice::staggered), icosphere(3, 0.4),
                                             cylinder(0.2, 0.9, 24, 19)};
  std::size_t cuts = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    // Without snapping the cut is the exact clip of a level that is linear on triangles.
    Workpiece piece(soups[seed % 3], 1e-9);
    const auto level = piece.levels(random_level({1.0, 1.0, 1.0}, seed));
    auto mass = piece.levels([](const Vec3& x) { return 1.0 + 0.5 * std::sin(9.0 * x.x()) + x.y() * x.y(); });
    double above = 0.0, area_above = 0.0;
    for (const Int3& v : piece.mesh.triangles) {
      const std::array<Vec3, 3> x = {piece.mesh.rest[v[0]], piece.mesh.rest[v[1]], piece.mesh.rest[v[2]]};
      const std::array<double, 3> l = {level[v[0]], level[v[1]], level[v[2]]};
      above += integral_above(x, l, {mass[v[0]], mass[v[1]], mass[v[2]]});
      area_above += integral_above(x, l, {1.0, 1.0, 1.0});
    }
    auto later = level;
    const MeshCut cut = cut_below(piece.surface, level);
    cuts += cut.any() ? 1 : 0;
    apply(cut.blends, mass);
    apply(cut.blends, later);
    const ShellMesh left = piece.left();
    ASSERT_NEAR(area_of(left), area_above, 1e-10 * area_of(piece.mesh)) << "seed " << seed;
    ASSERT_NEAR(integral(left, mass), above,
                1e-10 * integral(piece.mesh, piece.levels([](const Vec3&) { return 1.0; })))
        << "seed " << seed;
    ASSERT_EQ(euler_characteristic(left), euler_characteristic_above(piece.mesh, level)) << "seed " << seed;
    const MeshCut again = cut_below(piece.surface, later);
    ASSERT_FALSE(again.any()) << "seed " << seed << ": " << again.moved << " moved, " << again.born << " born, "
                              << again.removed << " removed";
  }
  EXPECT_GT(cuts, 900u);
}

/// The same with vertices moved onto the contour, as burning does it.
TEST(MeshCut, RandomContoursWithSnappingStaySound) {
  const std::array<TriangleSoup, 3> soups = {rectangle(45, 41, {1.0, 0.8}, Lattice::staggered), icosphere(4, 0.4),
                                             cylinder(0.2, 0.9, 48, 37)};
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Workpiece piece(soups[seed % 3], 0.3);
    auto level = piece.levels(random_level({1.0, 1.0, 1.0}, seed));
    double area_above = 0.0;
    for (const Int3& v : piece.mesh.triangles)
      area_above += integral_above({piece.mesh.rest[v[0]], piece.mesh.rest[v[1]], piece.mesh.rest[v[2]]},
                                   {level[v[0]], level[v[1]], level[v[2]]}, {1.0, 1.0, 1.0});
    const MeshCut cut = cut_below(piece.surface, level);
    apply(cut.blends, level);
    const ShellMesh left = piece.left();
    ASSERT_NEAR(area_of(left), area_above, 0.02 * area_of(piece.mesh)) << "seed " << seed;
    if (left.triangle_count() > 0) {
      ASSERT_GT(smallest_angle(left), 0.01) << "seed " << seed;
    }
    ASSERT_FALSE(cut_below(piece.surface, level).any()) << "seed " << seed;
  }
}

/// A hole that grows by a twentieth of an edge at a time: the rim stays on the contour, triangles stay sound, and
/// their number does not grow.
TEST(MeshCut, AFrontThatTravelsOnLeavesASoundMesh) {
  const int n = 60;
  Workpiece piece(rectangle(n, n, {1.0, 1.0}, Lattice::staggered));
  const Vec3 middle = 0.5 * (piece.mesh.rest.front() + piece.mesh.rest.back());
  const double h = 1.0 / (n - 1), whole = area_of(piece.mesh);
  const double shortest_at_first = *std::min_element(piece.mesh.rest_length.begin(), piece.mesh.rest_length.end());
  std::size_t born = 0;
  for (double radius = 0.05; radius < 0.45; radius += 0.05 * h) {
    born +=
        cut_below(piece.surface, piece.levels([&](const Vec3& x) { return (x - middle).norm() - radius; })).born;
    const ShellMesh left = piece.left();
    // Vertices of the rim wait for half the snapping distance, 0.15 of an edge.
    ASSERT_NEAR(area_of(left), whole - M_PI * radius * radius, 2.0 * M_PI * radius * 0.15 * h) << radius;
    ASSERT_GT(smallest_angle(left), 0.04) << radius;
    ASSERT_LE(left.triangle_count(), piece.mesh.triangle_count());
    ASSERT_GT(*std::min_element(left.rest_length.begin(), left.rest_length.end()), 0.1 * shortest_at_first);
  }
  EXPECT_LT(born, piece.mesh.vertex_count()) << "vertices that are made anew as the front passes";
}

/// Two parts that would meet in one vertex get one each; one that has burnt everywhere leaves nothing.
TEST(MeshCut, PartsShareNoLoneVertex) {
  // Four triangles around vertex 4, of which two opposite ones burn.
  CutSurface surface{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}, {0.5, -1, 0}, {0.5, 2, 0}},
                     {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 5, 1}, {2, 6, 3}},
                     std::vector<double>(7, 1e-6)};
  const MeshCut cut = cut_below(surface, {0, 0, 0, 0, 0, 1, 1});
  EXPECT_EQ(cut.removed, 4u);
  EXPECT_EQ(surface.triangles.size(), 2u);
  CutSurface bow{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}},
                 {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}},
                 std::vector<double>(5, 1e-6)};
  // Above the level at the corners 0, 1 and 2, 3, at it in the middle, below nowhere but on the two sides.
  bow.rest.insert(bow.rest.end(), {{1.5, 0.5, 0}, {-0.5, 0.5, 0}});
  bow.triangles = {{0, 1, 4}, {2, 3, 4}, {1, 5, 4}, {5, 2, 4}, {3, 6, 4}, {6, 0, 4}};
  bow.snapping.resize(7, 1e-6);
  cut_below(bow, {1, 1, 1, 1, 0, -1, -1});
  const ShellMesh left = build_mesh(bow.rest, {}, bow.triangles);
  EXPECT_EQ(*std::max_element(left.component.begin(), left.component.end()), 1);
  CutSurface gone = bow;
  const MeshCut all = cut_below(gone, std::vector<double>(gone.rest.size(), -1.0));
  EXPECT_TRUE(all.any());
  EXPECT_TRUE(gone.triangles.empty());
}

}  // namespace
}  // namespace wick::solid
