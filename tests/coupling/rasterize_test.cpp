#include "coupling/rasterize.h"

#include <gtest/gtest.h>

#include <cmath>
#include <queue>

#include "core/noise.h"
#include "core/parallel.h"
#include "coupling/exchange.h"
#include "solid/primitives.h"

namespace wick::coupling {
namespace {

const fluid::Sides kClosed = {};

fluid::Grid unit_grid(int n) {
  return {n, n, n, 1.0 / n, Vec3::Zero()};
}

solid::ShellMesh sphere_mesh(int level, double radius, const Vec3& center) {
  solid::TriangleSoup soup = solid::icosphere(level, radius);
  for (Vec3& x : soup.positions) x += center;
  return solid::build_mesh(soup.positions, soup.material, soup.triangles);
}

/// Bends a closed sphere into an odd, still closed, shape.
std::vector<Vec3> deformed(const solid::ShellMesh& mesh, double amount, std::uint64_t seed) {
  std::vector<Vec3> x = mesh.rest;
  for (Vec3& p : x) {
    Vec3 shift = Vec3::Zero();
    for (std::uint64_t n = 0; n < 4; ++n) {
      const Vec3 k(8 * hash_signed(seed, 7 * n), 8 * hash_signed(seed, 7 * n + 1),
                   8 * hash_signed(seed, 7 * n + 2));
      const Vec3 d(hash_signed(seed, 7 * n + 3), hash_signed(seed, 7 * n + 4), hash_signed(seed, 7 * n + 5));
      shift += std::sin(k.dot(p) + 6.0 * hash_unit(seed, 7 * n + 6)) * d;
    }
    p += amount * shift;
  }
  return x;
}

/// Cells that open faces join to the corner cell (0,0,0).
std::vector<std::uint8_t> outside_cells(const Raster& raster) {
  const fluid::Grid& g = raster.grid();
  std::vector<std::uint8_t> seen(g.cells(), 0);
  std::queue<Int3> todo;
  todo.push({0, 0, 0});
  seen[0] = 1;
  while (!todo.empty()) {
    const Int3 at = todo.front();
    todo.pop();
    for (int axis = 0; axis < 3; ++axis)
      for (int step : {-1, 1}) {
        Int3 q = at, face = at;
        q[axis] += step;
        if (step > 0) ++face[axis];
        if (q[axis] < 0 || q[axis] >= g.size(axis)) continue;
        if (raster.walls().closed[axis][g.face(axis, face[0], face[1], face[2])]) continue;
        std::uint8_t& mark = seen[g.cell(q[0], q[1], q[2])];
        if (mark) continue;
        mark = 1;
        todo.push(q);
      }
  }
  return seen;
}

TEST(Rasterize, ClosedSurfacesAreAirtight) {
  // Flood from a corner of the box: the number of cells that are not reached must be that of the enclosed volume.
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const solid::ShellMesh mesh = sphere_mesh(3, 0.3, Vec3(0.5, 0.5, 0.5));
    const std::vector<Vec3> x = deformed(mesh, 0.02, seed), v(x.size(), Vec3::Zero());
    Raster raster(unit_grid(40), kClosed);
    raster.see({{&mesh, &x, &v}}, {});
    const std::vector<std::uint8_t> outside = outside_cells(raster);
    double enclosed = 0.0, volume = 0.0;
    for (const std::uint8_t mark : outside) enclosed += mark ? 0.0 : std::pow(1.0 / 40, 3);
    for (const Int3& t : mesh.triangles) volume += x[t[0]].dot(x[t[1]].cross(x[t[2]])) / 6.0;
    EXPECT_NEAR(enclosed, volume, 0.01 * volume) << "seed " << seed;
  }
}

TEST(Rasterize, SheetsThatLieExactlyOnCellCentresSeparate) {
  // z = 0.5 is a plane of cell centres for odd n, and a plane of faces for even n.
  for (const int n : {15, 16}) {
    const auto soup = solid::rectangle(9, 9, Vec2(1.2, 1.2), solid::Lattice::grid);
    std::vector<Vec3> x = soup.positions;
    for (Vec3& p : x) p += Vec3(-0.1, -0.1, 0.5);
    const solid::ShellMesh mesh = solid::build_mesh(x, soup.material, soup.triangles);
    const std::vector<Vec3> v(x.size(), Vec3::Zero());
    Raster raster(unit_grid(n), kClosed);
    raster.see({{&mesh, &x, &v}}, {});
    const std::vector<std::uint8_t> below = outside_cells(raster);
    EXPECT_EQ(below[raster.grid().cell(n - 1, n - 1, n - 1)], 0) << n;
    EXPECT_EQ(raster.hits().size(), static_cast<std::size_t>(n * n)) << n;
  }
}

TEST(Rasterize, HitAreasAddUpToTheSurface) {
  // Each hit stands for h2 |n_axis| of surface.
  const solid::ShellMesh mesh = sphere_mesh(4, 0.31, Vec3(0.5, 0.49, 0.52));
  const std::vector<Vec3> v(mesh.vertex_count(), Vec3::Zero());
  Raster raster(unit_grid(64), kClosed);
  raster.see({{&mesh, &mesh.rest, &v}}, {});
  double area = 0.0, exact = 0.0;
  for (const WallHit& hit : raster.hits()) {
    const Int3& t = mesh.triangles[hit.triangle];
    const Vec3 n = (mesh.rest[t[1]] - mesh.rest[t[0]]).cross(mesh.rest[t[2]] - mesh.rest[t[0]]).normalized();
    area += std::abs(n[hit.axis]) / (64.0 * 64.0);
    EXPECT_EQ(hit.facing > 0, n[hit.axis] > 0);
  }
  for (const double a : mesh.rest_area) exact += a;
  EXPECT_NEAR(area, exact, 0.01 * exact);
}

TEST(Rasterize, WallFacesMoveWithTheSheet) {
  const solid::ShellMesh mesh = sphere_mesh(3, 0.3, Vec3(0.5, 0.5, 0.5));
  std::vector<Vec3> v;
  for (const Vec3& x : mesh.rest) v.push_back(Vec3(1, 2, 3) + Vec3(x.y(), -x.x(), 0.5 * x.z()));
  Raster raster(unit_grid(24), kClosed);
  raster.see({{&mesh, &mesh.rest, &v}}, {});
  ASSERT_FALSE(raster.hits().empty());
  for (const WallHit& hit : raster.hits()) {
    const Int3& t = mesh.triangles[hit.triangle];
    Vec3 x = Vec3::Zero();
    for (int k = 0; k < 3; ++k) x += hit.weight[k] * mesh.rest[t[k]];
    const Vec3 exact = Vec3(1, 2, 3) + Vec3(x.y(), -x.x(), 0.5 * x.z());
    EXPECT_NEAR(raster.walls().velocity[hit.axis][hit.face], exact[hit.axis], 1e-5);
  }
}

TEST(Rasterize, ForgetsTheOldPlace) {
  const solid::ShellMesh mesh = sphere_mesh(2, 0.2, Vec3(0.3, 0.3, 0.3));
  std::vector<Vec3> x = mesh.rest, v(x.size(), Vec3::Zero());
  Raster moved(unit_grid(20), kClosed), fresh(unit_grid(20), kClosed);
  moved.see({{&mesh, &x, &v}}, {});
  for (Vec3& p : x) p += Vec3(0.31, 0.27, 0.4);
  moved.see({{&mesh, &x, &v}}, {});
  fresh.see({{&mesh, &x, &v}}, {});
  EXPECT_EQ(moved.walls().closed, fresh.walls().closed);
  EXPECT_EQ(moved.walls().near, fresh.walls().near);
}

TEST(Rasterize, IsTheSameAtOneAndTwoThreads) {
  const solid::ShellMesh mesh = sphere_mesh(4, 0.3, Vec3(0.5, 0.5, 0.5));
  const std::vector<Vec3> v(mesh.vertex_count(), Vec3(1, 0, 0));
  const auto closed = [&](int threads) {
    const ThreadLimit limit(threads);
    Raster raster(unit_grid(48), kClosed);
    raster.see({{&mesh, &mesh.rest, &v}}, {});
    return std::make_pair(raster.walls().closed, raster.walls().velocity);
  };
  EXPECT_EQ(closed(1), closed(2));
}

TEST(Rasterize, ObstaclesBecomeSolidCellsWithTheirVelocity) {
  const Obstacle ball{.name = "b", .shape = SphereShape{Vec3(0.5, 0.5, 0.5), 0.25}, .velocity = Vec3(0, 0, 2)};
  Raster raster(unit_grid(32), kClosed);
  raster.see({}, {ball});
  double volume = 0.0;
  for (const std::uint8_t s : raster.walls().solid) volume += s * std::pow(1.0 / 32, 3);
  EXPECT_NEAR(volume, 4.0 / 3.0 * M_PI * std::pow(0.25, 3), 0.002);
  const fluid::Grid& g = raster.grid();
  EXPECT_EQ(raster.walls().closed[2][g.face(2, 16, 16, 24)], 1);
  EXPECT_EQ(raster.walls().velocity[2][g.face(2, 16, 16, 24)], 2.0F);
}

TEST(Rasterize, ObstaclesThinnerThanACellPartTheGas) {
  // A plate of a thousandth of a cell across the box, and a box of six such plates, wherever they lie in the cells.
  for (std::uint64_t n = 0; n < 20; ++n) {
    const double z = 0.5 + 0.1 * hash_signed(1, n);
    Raster raster(unit_grid(16), kClosed);
    raster.see({}, {{.name = "plate", .shape = BoxShape{Vec3(-1, -1, z), Vec3(2, 2, z + 6e-5)}}});
    const auto below = outside_cells(raster);
    const auto count = std::count(below.begin(), below.end(), std::uint8_t{1});
    EXPECT_NEAR(static_cast<double>(count) / 256.0, z * 16.0, 0.51);

    std::vector<Obstacle> walls;
    const double low = 0.25 + (n == 0 ? 0.0 : 0.03 * hash_unit(2, n)), high = low + 0.5;
    for (int axis = 0; axis < 3; ++axis)
      for (const double at : {low, high}) {
        Vec3 lower = Vec3::Constant(low), upper = Vec3::Constant(high);
        lower[axis] = at;
        upper[axis] = at + 6e-5;
        walls.push_back({.name = "wall", .shape = BoxShape{lower, upper}});
      }
    raster.see({}, walls);
    const auto outside = outside_cells(raster);
    EXPECT_EQ(outside[raster.grid().cell(8, 8, 8)], 0) << "walls from " << low;
    EXPECT_NEAR(static_cast<double>(std::count(outside.begin(), outside.end(), std::uint8_t{0})), 512.0, 220.0);
    EXPECT_EQ(outside[raster.grid().cell(15, 15, 15)], 1);
  }
}

TEST(SweptCells, AreThoseThatChangeSides) {
  // Independent count: inside before and after by flooding, against the cells that the moving surface passes.
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const solid::ShellMesh mesh = sphere_mesh(3, 0.28, Vec3(0.5, 0.5, 0.5));
    const std::vector<Vec3> before = deformed(mesh, 0.01, seed), v(before.size(), Vec3::Zero());
    std::vector<Vec3> after = deformed(mesh, 0.02, seed + 100);
    for (Vec3& p : after) p += 0.03 * Vec3(hash_signed(seed, 900), hash_signed(seed, 901), hash_signed(seed, 902));
    Raster one(unit_grid(32), kClosed), two(unit_grid(32), kClosed);
    one.see({{&mesh, &before, &v}}, {});
    two.see({{&mesh, &after, &v}}, {});
    const auto a = outside_cells(one), b = outside_cells(two);
    std::vector<std::int64_t> changed;
    for (std::size_t c = 0; c < a.size(); ++c)
      if (a[c] != b[c]) changed.push_back(static_cast<std::int64_t>(c));
    EXPECT_GT(changed.size(), 50U);
    EXPECT_EQ(swept_cells(one.grid(), mesh, before, after), changed) << "seed " << seed;
  }
}

TEST(SweptCells, HandOverKeepsSumsAndSides) {
  fluid::SmokeParams params;
  params.resolution = {32, 32, 32};
  const solid::ShellMesh mesh = sphere_mesh(3, 0.28, Vec3(0.5, 0.5, 0.5));
  const std::vector<Vec3> before = deformed(mesh, 0.01, 1), after = deformed(mesh, 0.025, 2),
                          v(before.size(), Vec3::Zero());
  Raster raster(unit_grid(32), kClosed);
  raster.see({{&mesh, &before, &v}}, {});
  fluid::SmokeState gas = fluid::make_smoke_state(params);
  const auto outside = outside_cells(raster);
  for (std::size_t c = 0; c < outside.size(); ++c) gas.density[c] = outside[c] ? 0.0F : 1.0F;
  const double total = fluid::total_smoke(gas, params);

  raster.see({{&mesh, &after, &v}}, {});
  const SweptLoss lost =
      hand_over_swept(raster, {.by_sheet = {swept_cells(raster.grid(), mesh, before, after)}}, params, gas);
  EXPECT_NEAR(fluid::total_smoke(gas, params) + lost.smoke, total, 1e-6 * total);
  EXPECT_EQ(lost.smoke, 0.0);
  const auto now_outside = outside_cells(raster);
  for (std::size_t c = 0; c < now_outside.size(); ++c)
    if (now_outside[c]) {
      EXPECT_EQ(gas.density[c], 0.0F);
    }
}

}  // namespace
}  // namespace wick::coupling
