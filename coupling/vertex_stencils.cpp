/// Which cells each face of a vertex sees: one-sided sampling and depositing at a sheet.
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "coupling/exchange.h"

namespace wick::coupling {

namespace {

constexpr std::size_t kGrain = 1024;
/// A closed segment tells sides only where the sheet there lies about parallel to the sheet at the vertex:
/// cosine of the largest angle between the normals.
constexpr double kSameLayer = 0.2;

/// The cube of eight cell centres around a point; corner n has offsets (n & 1, n >> 1 & 1, n >> 2).
struct Cube {
  Int3 base;
  std::array<double, 3> fraction;
  std::array<std::int64_t, 8> cell;  ///< -1 outside the box, in an obstacle or behind one
};

/// The place itself, or one just outside the obstacles that it touches: what rests on one is not inside it.
Vec3 outside_of(const std::vector<Obstacle>& obstacles, const Vec3& x, double margin) {
  Vec3 out = x;
  for (const Obstacle& obstacle : obstacles) {
    const DistanceSample at = sample_distance(obstacle, out);
    if (at.distance < margin && at.distance > -100.0 * margin) out += (margin - at.distance) * at.gradient;
  }
  return out;
}

Cube cube_around(const Raster& raster, const std::vector<Obstacle>& obstacles, const Vec3& x) {
  const fluid::Grid& grid = raster.grid();
  const Vec3 q = (x - grid.origin) / grid.h - Vec3::Constant(0.5);
  const Vec3 eye = outside_of(obstacles, x, 1e-3 * grid.h);
  Cube cube{};
  for (int a = 0; a < 3; ++a) {
    // Points far outside would overflow an int; anything below -2 or above n + 1 has no cells anyway.
    const double clamped = std::clamp(q[a], -3.0, grid.size(a) + 2.0);
    cube.base[a] = static_cast<int>(std::floor(clamped));
    cube.fraction[a] = std::clamp(clamped - cube.base[a], 0.0, 1.0);
  }
  for (int n = 0; n < 8; ++n) {
    const int i = cube.base[0] + (n & 1), j = cube.base[1] + (n >> 1 & 1), k = cube.base[2] + (n >> 2);
    const bool inside = i >= 0 && j >= 0 && k >= 0 && i < grid.nx && j < grid.ny && k < grid.nz;
    cube.cell[n] = inside ? static_cast<std::int64_t>(grid.cell(i, j, k)) : -1;
    if (!inside) continue;
    const Vec3 center = probe(grid, {i, j, k});
    const auto hides = [&](const Obstacle& obstacle) { return segment_meets(obstacle, eye, center); };
    if (raster.walls().solid[cube.cell[n]] || std::any_of(obstacles.begin(), obstacles.end(), hides))
      cube.cell[n] = -1;
  }
  return cube;
}

/// Face between corner n and its upper neighbour along `axis`.
std::size_t face_above(const Raster& raster, const Cube& cube, int n, int axis) {
  Int3 at = {cube.base[0] + (n & 1), cube.base[1] + (n >> 1 & 1), cube.base[2] + (n >> 2)};
  ++at[axis];
  return raster.grid().face(axis, at[0], at[1], at[2]);
}

/// Bit 1: on the - side of the sheet at the vertex, bit 2: on the + side, for each corner.
std::array<std::uint8_t, 8> label_corners(const Raster& raster, std::int32_t sheet, const SheetSurface& surface,
                                          const Cube& cube, const Vec3& normal, bool& crossed) {
  std::array<std::uint8_t, 8> label{};
  bool open[8][3] = {};
  for (int n = 0; n < 8; ++n)
    for (int axis = 0; axis < 3; ++axis) {
      const int up = n | 1 << axis;
      if (up == n || cube.cell[n] < 0 || cube.cell[up] < 0) continue;
      const std::size_t face = face_above(raster, cube, n, axis);
      open[n][axis] = raster.walls().closed[axis][face] == 0;
      if (open[n][axis]) continue;
      const std::int32_t index = raster.hit_at(axis, face);
      crossed = crossed || index >= 0;
      if (index < 0 || raster.hits()[index].sheet != sheet) continue;
      const WallHit& hit = raster.hits()[index];
      const Int3& t = surface.mesh->triangles[hit.triangle];
      const std::vector<Vec3>& x = *surface.x;
      const Vec3 n_hit = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
      if (n_hit.dot(normal) < kSameLayer) continue;
      label[n] |= hit.facing > 0 ? 1 : 2;
      label[up] |= hit.facing > 0 ? 2 : 1;
    }
  // Spread along open segments; a corner is at most seven segments from any other.
  for (int pass = 0; pass < 7; ++pass)
    for (int n = 0; n < 8; ++n)
      for (int axis = 0; axis < 3; ++axis)
        if (open[n][axis]) {
          const int up = n | 1 << axis;
          if (label[n] == 0) label[n] = label[up];
          if (label[up] == 0) label[up] = label[n];
        }
  return label;
}

VertexStencil stencil_at(const Raster& raster, std::int32_t sheet, const SheetSurface& surface,
                         const std::vector<Obstacle>& obstacles, const Vec3& x, const Vec3& normal) {
  VertexStencil stencil;
  if (!x.allFinite()) return stencil;
  const Cube cube = cube_around(raster, obstacles, x);
  bool crossed = false;
  auto label = label_corners(raster, sheet, surface, cube, normal, crossed);
  // At a rim, or on a sheet smaller than a cell, no segment is closed: both faces see all around.
  if (!crossed) label.fill(3);
  for (int side = 0; side < 2; ++side) {
    VertexStencil::Face& face = stencil.face[side];
    double sum = 0.0;
    for (int n = 0; n < 8; ++n) {
      const bool conflict = label[n] == 3 && crossed;
      if (cube.cell[n] < 0 || (label[n] & (side == 0 ? 1 : 2)) == 0 || conflict) continue;
      double weight = 1e-3;  // a visible corner counts a little even where the vertex sits on the opposite one
      double trilinear = 1.0;
      for (int a = 0; a < 3; ++a) trilinear *= (n >> a & 1) ? cube.fraction[a] : 1.0 - cube.fraction[a];
      weight += trilinear;
      face.cell[face.count] = cube.cell[n];
      face.weight[face.count++] = static_cast<float>(weight);
      sum += weight;
    }
    for (int n = 0; n < face.count; ++n) face.weight[n] = static_cast<float>(face.weight[n] / sum);
  }
  return stencil;
}

}  // namespace

std::vector<VertexStencil> vertex_stencils(const Raster& raster, std::int32_t sheet, const SheetSurface& surface,
                                           const std::vector<Obstacle>& obstacles) {
  const std::vector<Vec3> normals = solid::vertex_normals(*surface.mesh, *surface.x);
  std::vector<VertexStencil> stencils(normals.size());
  parallel_for(normals.size(), kGrain, [&](std::size_t i) {
    const bool orphan = surface.mesh->component[i] < 0;
    if (!orphan) stencils[i] = stencil_at(raster, sheet, surface, obstacles, (*surface.x)[i], normals[i]);
  });
  return stencils;
}

}  // namespace wick::coupling
