#include "coupling/rasterize.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace wick::coupling {

namespace {

constexpr std::size_t kTriangleGrain = 512;
/// A crossing nearer than this to a cell centre [cells] closes the faces on both sides of it: which side the
/// centre is on is then a matter of rounding, and the axes might disagree.
constexpr double kCenterMargin = 1e-9;
/// Cells within which the segment to a neighbouring centre may meet an obstacle: one, and room for the slope of
/// sampled distances, which may exceed 1.
constexpr double kCloseCells = 2.0;

/// Twice the signed area of (a, b, p). Evaluated for a < b in a fixed order, so that the two triangles at
/// an edge get the same bits with opposite sign.
double edge_function(const double* a, const double* b, double px, double py) {
  const bool swap = a[0] > b[0] || (a[0] == b[0] && a[1] > b[1]);
  if (swap) std::swap(a, b);
  const double value = (b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0]);
  return swap ? -value : value;
}

/// Crossings of one triangle with the grid lines along `axis`.
class LineCrossings {
 public:
  LineCrossings(const fluid::Grid& grid, const SheetSurface& sheet, std::int32_t sheet_number)
      : grid_(grid), sheet_(sheet), number_(sheet_number) {}

  void add(std::int32_t triangle, std::vector<WallHit>& hits) const {
    const Int3& t = sheet_.mesh->triangles[triangle];
    // Cell centres have whole coordinates here.
    std::array<Vec3, 3> q;
    for (int k = 0; k < 3; ++k)
      q[k] = ((*sheet_.x)[t[k]] - grid_.origin) / grid_.h - Vec3::Constant(0.5) + grid_line_offset();
    if (!(q[0].allFinite() && q[1].allFinite() && q[2].allFinite())) return;
    for (int axis = 0; axis < 3; ++axis) add_axis(triangle, axis, q, hits);
  }

 private:
  void add_axis(std::int32_t triangle, int axis, const std::array<Vec3, 3>& q, std::vector<WallHit>& hits) const {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    double corner[3][2];
    for (int k = 0; k < 3; ++k) corner[k][0] = q[k][b], corner[k][1] = q[k][c];
    const int lines[2] = {grid_.size(b), grid_.size(c)};
    int first[2], last[2];
    for (int d = 0; d < 2; ++d) {
      const double low = std::min({corner[0][d], corner[1][d], corner[2][d]});
      const double high = std::max({corner[0][d], corner[1][d], corner[2][d]});
      first[d] = static_cast<int>(std::ceil(std::clamp(low, 0.0, double(lines[d]))));
      last[d] = static_cast<int>(std::floor(std::clamp(high, -1.0, double(lines[d] - 1))));
    }
    for (int n = first[1]; n <= last[1]; ++n)
      for (int m = first[0]; m <= last[0]; ++m) {
        const double e0 = edge_function(corner[1], corner[2], m, n);
        const double e1 = edge_function(corner[2], corner[0], m, n);
        const double e2 = edge_function(corner[0], corner[1], m, n);
        const bool front = e0 >= 0 && e1 >= 0 && e2 >= 0, back = e0 <= 0 && e1 <= 0 && e2 <= 0;
        const double area = e0 + e1 + e2;
        // A triangle seen edge-on has no crossing of its own: its neighbours have it.
        if ((!front && !back) || area == 0.0) continue;
        const std::array<double, 3> weight = {e0 / area, e1 / area, e2 / area};
        const double depth = weight[0] * q[0][axis] + weight[1] * q[1][axis] + weight[2] * q[2][axis];
        add_crossing(triangle, axis, depth, m, n, weight, area > 0 ? 1 : -1, hits);
      }
  }

  void add_crossing(std::int32_t triangle, int axis, double depth, int m, int n,
                    const std::array<double, 3>& weight, int facing, std::vector<WallHit>& hits) const {
    if (depth < -1.0 || depth > grid_.size(axis)) return;
    const int low = static_cast<int>(std::floor(depth - kCenterMargin));
    const int high = static_cast<int>(std::floor(depth + kCenterMargin));
    for (int below = low; below <= high; ++below) {
      if (below < -1 || below >= grid_.size(axis)) continue;
      Int3 cell;
      cell[axis] = below + 1;
      cell[(axis + 1) % 3] = m;
      cell[(axis + 2) % 3] = n;
      const auto face = static_cast<std::int64_t>(grid_.face(axis, cell[0], cell[1], cell[2]));
      hits.push_back({number_,
                      triangle,
                      weight,
                      static_cast<std::int8_t>(axis),
                      static_cast<std::int8_t>(facing),
                      face,
                      {cell[0], cell[1], cell[2]},
                      below == static_cast<int>(std::floor(depth)) ? 1 : 0});
    }
  }

  const fluid::Grid& grid_;
  const SheetSurface& sheet_;
  std::int32_t number_;
};

/// All crossings of one sheet, in the order of its triangles at any thread count.
void collect_hits(const fluid::Grid& grid, const SheetSurface& sheet, std::int32_t number,
                  std::vector<WallHit>& hits) {
  const std::size_t triangles = sheet.mesh->triangle_count();
  std::vector<std::vector<WallHit>> found((triangles + kTriangleGrain - 1) / kTriangleGrain);
  const LineCrossings crossings(grid, sheet, number);
  parallel_chunks(triangles, kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<WallHit>& mine = found[begin / kTriangleGrain];
    for (std::size_t t = begin; t < end; ++t) crossings.add(static_cast<std::int32_t>(t), mine);
  });
  for (const auto& part : found) hits.insert(hits.end(), part.begin(), part.end());
}

Vec3 hit_point(const SheetSurface& sheet, const WallHit& hit, const std::vector<Vec3>& values) {
  const Int3& t = sheet.mesh->triangles[hit.triangle];
  return hit.weight[0] * values[t[0]] + hit.weight[1] * values[t[1]] + hit.weight[2] * values[t[2]];
}

Vec3 face_place(const fluid::Grid& grid, int axis, std::size_t face) {
  const std::size_t nx = grid.nx + (axis == 0 ? 1 : 0), ny = grid.ny + (axis == 1 ? 1 : 0);
  const std::size_t row = face / nx;
  return grid.face_center(axis, static_cast<int>(face % nx), static_cast<int>(row % ny),
                          static_cast<int>(row / ny));
}

}  // namespace

Vec3 grid_line_offset() {
  return {3.1e-6, 5.3e-6, 7.7e-6};
}

Vec3 probe(const fluid::Grid& grid, const Int3& cell) {
  return grid.cell_center(cell[0], cell[1], cell[2]) - grid.h * grid_line_offset();
}

Raster::Raster(const fluid::Grid& grid, const fluid::Sides& sides) : grid_(grid), sides_(sides) {
  walls_.solid.assign(grid.cells(), 0);
  walls_.near.assign(grid.cells(), 0);
  walls_.velocity = fluid::make_face_field(grid);
  for (int a = 0; a < 3; ++a) {
    walls_.closed[a].assign(grid.faces(a), 0);
    hit_at_[a].assign(grid.faces(a), -1);
    obstacle_face_[a].assign(grid.faces(a), 0);
  }
  obstacle_mark_.assign(grid.cells(), 0);
}

void Raster::see(const std::vector<SheetSurface>& sheets, const std::vector<Obstacle>& obstacles) {
  clear_sheets();
  close_obstacle_faces(obstacles);
  close_sheet_faces(sheets);
  walls_.any = !hits_.empty() || !obstacles.empty();
  if (walls_.any) fluid::mark_near_walls(grid_, sides_, walls_);
}

void Raster::clear_sheets() {
  for (const WallHit& hit : hits_) {
    walls_.closed[hit.axis][hit.face] = 0;
    walls_.velocity[hit.axis][hit.face] = 0.0F;
    hit_at_[hit.axis][hit.face] = -1;
  }
  hits_.clear();
}

void Raster::close_sheet_faces(const std::vector<SheetSurface>& sheets) {
  std::vector<WallHit> all;
  for (std::size_t s = 0; s < sheets.size(); ++s) collect_hits(grid_, sheets[s], static_cast<std::int32_t>(s), all);

  // Keep one hit a face: the one whose sheet point is nearest to the face; the earlier one on a tie.
  std::vector<double> distance;
  for (const WallHit& hit : all) {
    const Vec3 point = hit_point(sheets[hit.sheet], hit, *sheets[hit.sheet].x);
    const Vec3 center = grid_.face_center(hit.axis, hit.cell[0], hit.cell[1], hit.cell[2]);
    const double offset = std::abs(point[hit.axis] - center[hit.axis]);
    std::int32_t& slot = hit_at_[hit.axis][hit.face];
    if (slot < 0) {
      slot = static_cast<std::int32_t>(hits_.size());
      hits_.push_back(hit);
      distance.push_back(offset);
      continue;
    }
    const std::int32_t crossings = hits_[slot].crossings + hit.crossings;
    if (offset < distance[slot]) {
      hits_[slot] = hit;
      distance[slot] = offset;
    }
    hits_[slot].crossings = crossings;
  }
  for (const WallHit& hit : hits_) {
    walls_.closed[hit.axis][hit.face] = 1;
    walls_.velocity[hit.axis][hit.face] =
        static_cast<float>(hit_point(sheets[hit.sheet], hit, *sheets[hit.sheet].v)[hit.axis]);
  }
}

void Raster::close_obstacle_faces(const std::vector<Obstacle>& obstacles) {
  if (obstacles.empty()) return;
  bool same = obstacle_place_.size() == obstacles.size();
  for (std::size_t n = 0; same && n < obstacles.size(); ++n) same = obstacle_place_[n] == obstacles[n].pose;
  if (!same) {
    obstacle_place_.clear();
    for (const Obstacle& obstacle : obstacles) obstacle_place_.push_back(obstacle.pose);
    mark_obstacles(obstacles);
  }
  parallel_for(grid_.cells(), 1 << 16, [&](std::size_t c) { walls_.solid[c] = obstacle_mark_[c] != 0 ? 1 : 0; });
  for (int axis = 0; axis < 3; ++axis)
    parallel_for(grid_.faces(axis), 1 << 16, [&](std::size_t face) {
      const int mark = obstacle_face_[axis][face];
      walls_.closed[axis][face] = mark != 0 ? 1 : 0;
      walls_.velocity[axis][face] =
          mark != 0 ? static_cast<float>(obstacles[mark - 1].velocity_at(face_place(grid_, axis, face))[axis])
                    : 0.0F;
    });
}

void Raster::mark_obstacles(const std::vector<Obstacle>& obstacles) {
  const int nx = grid_.nx, ny = grid_.ny, nz = grid_.nz;
  // Only cells within one cell of an obstacle have a face whose segment may meet it.
  std::vector<std::uint8_t> close(grid_.cells());
  parallel_for(static_cast<std::size_t>(nz), 1, [&](std::size_t k) {
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const std::size_t c = grid_.cell(i, j, static_cast<int>(k));
        const Vec3 point = probe(grid_, {i, j, static_cast<int>(k)});
        obstacle_mark_[c] = 0;
        for (std::size_t n = 0; n < obstacles.size() && obstacle_mark_[c] == 0; ++n) {
          const double distance = sample_distance(obstacles[n], point).distance;
          if (distance < 0.0) obstacle_mark_[c] = static_cast<std::uint8_t>(n + 1);
          if (distance < kCloseCells * grid_.h) close[c] = 1;
        }
      }
  });
  for (int axis = 0; axis < 3; ++axis) {
    const int faces[3] = {nx + (axis == 0), ny + (axis == 1), nz + (axis == 2)};
    parallel_for(static_cast<std::size_t>(faces[2]), 1, [&](std::size_t k) {
      for (int j = 0; j < faces[1]; ++j)
        for (int i = 0; i < faces[0]; ++i) {
          const Int3 above = {i, j, static_cast<int>(k)};
          Int3 below = above;
          --below[axis];
          int mark = 0, near = 0;
          for (const Int3& at : {below, above}) {
            if (at[axis] < 0 || at[axis] >= grid_.size(axis)) continue;
            const std::size_t c = grid_.cell(at[0], at[1], at[2]);
            mark = std::max<int>(mark, obstacle_mark_[c]);
            near = std::max<int>(near, close[c]);
          }
          const Vec3 from = probe(grid_, below), to = probe(grid_, above);
          for (std::size_t n = 0; n < obstacles.size() && near != 0 && mark == 0; ++n)
            if (segment_meets(obstacles[n], from, to)) mark = static_cast<int>(n + 1);
          obstacle_face_[axis][grid_.face(axis, i, j, static_cast<int>(k))] = static_cast<std::uint8_t>(mark);
        }
    });
  }
}

}  // namespace wick::coupling
