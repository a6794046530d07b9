#include "solid/primitives.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "core/require.h"

namespace wick::solid {

namespace {

/// Largest number of vertices that a primitive makes.
constexpr std::int64_t kMostVertices = 100'000'000;

void check_counts(std::int64_t a, std::int64_t b, int least_a, int least_b) {
  require(a >= least_a && b >= least_b, "",
          "a sheet of " + std::to_string(a) + " x " + std::to_string(b) + " vertices (too few) give at least " +
              std::to_string(least_a) + " x " + std::to_string(least_b));
  require(
      a * b <= kMostVertices, "",
      "a sheet of " + std::to_string(a) + " x " + std::to_string(b) + " vertices (more than 1e8) make it coarser",
      ExitCode::refused);
}

/// One square of the lattice with corners a b (below) and c d (above), left to right. The diagonal runs a-d or b-c.
void add_square(std::vector<Int3>& triangles, int a, int b, int c, int d, bool diagonal_ad) {
  if (diagonal_ad) {
    triangles.push_back({a, b, d});
    triangles.push_back({a, d, c});
  } else {
    triangles.push_back({a, b, c});
    triangles.push_back({b, d, c});
  }
}

}  // namespace

TriangleSoup rectangle(int nx, int ny, const Vec2& size, Lattice lattice) {
  check_counts(nx, ny, 2, 2);
  require(size.allFinite() && size.minCoeff() > 0.0, "", "a sheet needs a positive size");
  TriangleSoup soup;
  soup.positions.reserve(std::size_t(nx) * ny);
  soup.triangles.reserve(std::size_t(2) * (nx - 1) * (ny - 1));
  // Odd rows are half a spacing to the right; their first and last vertices are put on the ends of the sheet.
  const bool staggered = lattice == Lattice::staggered;
  const double spacing = size.x() / (nx - 1);
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      double x = spacing * (staggered && j % 2 == 1 ? i + 0.5 : i);
      if (i == 0) x = 0.0;
      if (i == nx - 1) x = size.x();
      const Vec2 u(x, size.y() * j / (ny - 1));
      soup.material.push_back(u);
      soup.positions.emplace_back(u.x(), u.y(), 0.0);
    }
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i) {
      const int a = j * nx + i, c = a + nx;
      const bool diagonal_ad = lattice == Lattice::grid || (staggered ? j % 2 == 1 : (i + j) % 2 == 0);
      add_square(soup.triangles, a, a + 1, c, c + 1, diagonal_ad);
    }
  return soup;
}

TriangleSoup icosphere(int level, double radius) {
  require(level >= 0 && level <= 11, "", "icosphere level " + std::to_string(level) + " (0 to 11)");
  require(radius > 0.0 && std::isfinite(radius), "", "a sphere needs a positive radius");
  TriangleSoup soup;
  const double g = std::numbers::phi;
  soup.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  soup.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  const auto to_sphere = [&] {
    for (Vec3& p : soup.positions) p *= radius / p.norm();
  };
  to_sphere();
  for (int k = 0; k < level; ++k) {
    soup = subdivide(soup);
    to_sphere();
  }
  return soup;
}

TriangleSoup cylinder(double radius, double height, int n_around, int n_up) {
  check_counts(n_around, n_up, 3, 2);
  require(radius > 0.0 && height > 0.0 && std::isfinite(radius + height), "", "a tube needs a positive size");
  TriangleSoup soup;
  for (int j = 0; j < n_up; ++j)
    for (int i = 0; i < n_around; ++i) {
      const double angle = 2.0 * std::numbers::pi * (i + 0.5 * (j % 2)) / n_around;
      soup.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height * j / (n_up - 1));
    }
  for (int j = 0; j + 1 < n_up; ++j)
    for (int i = 0; i < n_around; ++i) {
      const int next = (i + 1) % n_around, a = j * n_around, c = a + n_around;
      add_square(soup.triangles, a + i, a + next, c + i, c + next, j % 2 == 1);
    }
  return soup;
}

TriangleSoup subdivide(const TriangleSoup& soup) {
  TriangleSoup fine{soup.positions, soup.material, {}};
  fine.triangles.reserve(4 * soup.triangles.size());
  std::unordered_map<std::uint64_t, int> midpoint;
  midpoint.reserve(2 * soup.triangles.size());
  const auto middle = [&](int a, int b) {
    const auto low = static_cast<std::uint64_t>(std::min(a, b)), high = static_cast<std::uint64_t>(std::max(a, b));
    const auto [it, fresh] = midpoint.try_emplace(low << 32 | high, static_cast<int>(fine.positions.size()));
    if (fresh) {
      fine.positions.push_back(0.5 * (soup.positions[a] + soup.positions[b]));
      if (!soup.material.empty()) fine.material.push_back(0.5 * (soup.material[a] + soup.material[b]));
    }
    return it->second;
  };
  for (const Int3& v : soup.triangles) {
    const int a = middle(v[0], v[1]), b = middle(v[1], v[2]), c = middle(v[2], v[0]);
    fine.triangles.push_back({v[0], a, c});
    fine.triangles.push_back({a, v[1], b});
    fine.triangles.push_back({c, b, v[2]});
    fine.triangles.push_back({a, b, c});
  }
  return fine;
}

}  // namespace wick::solid
