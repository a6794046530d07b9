#include "fluid/walls.h"

#include <algorithm>
#include <cstring>

#include "core/parallel.h"

namespace wick::fluid {

namespace {

/// Marks cells that have a closed face.
void mark_touching(const Grid& grid, Walls& walls) {
  walls.near.assign(grid.cells(), 0);
  parallel_for(grid.nz, 4, [&](std::size_t plane) {
    const int k = static_cast<int>(plane);
    for (int j = 0; j < grid.ny; ++j)
      for (int a = 0; a < 3; ++a) {
        std::uint8_t* near = walls.near.data() + grid.cell(0, j, k);
        const std::uint8_t* low = walls.closed[a].data() + grid.face(a, 0, j, k);
        const std::uint8_t* high = walls.closed[a].data() + grid.face(a, a == 0, j + (a == 1), k + (a == 2));
        for (int i = 0; i < grid.nx; ++i) near[i] |= low[i] | high[i];
      }
  });
}

/// Spreads marks by `reach` cells along one axis, around the box where it is periodic: rows along x, or whole
/// rows that lie behind one another along y or z.
void spread(const Grid& grid, int axis, bool periodic, int reach, std::vector<std::uint8_t>& marks) {
  const int n = grid.size(axis), nx = grid.nx;
  const std::size_t stride = axis == 1 ? 1 : grid.ny;  // in rows
  const std::vector<std::uint8_t> before = marks;
  parallel_for(std::size_t(grid.ny) * grid.nz, 64, [&](std::size_t row) {
    std::uint8_t* __restrict to = marks.data() + row * nx;
    const std::uint8_t* self = before.data() + row * nx;
    const int at = axis == 0 ? 0 : static_cast<int>(axis == 1 ? row % grid.ny : row / grid.ny);
    for (int shift = -reach; shift <= reach; ++shift) {
      if (axis == 0) {
        const int low = std::max(0, -shift), high = std::min(nx, nx - shift);
        for (int i = low; i < high; ++i) to[i] |= self[i + shift];
        for (int i = 0; periodic && i < nx; ++i) {
          if (i < low || i >= high) to[i] |= self[((i + shift) % n + n) % n];
        }
        continue;
      }
      int from = at + shift;
      if (periodic) from = ((from % n) + n) % n;
      if (from < 0 || from >= n) continue;
      const std::uint8_t* source = self + (from - at) * std::ptrdiff_t(stride) * nx;
      for (int i = 0; i < nx; ++i) to[i] |= source[i];
    }
  });
}

}  // namespace

void move_with_walls(const Walls& walls, int axis, std::vector<float>& velocity) {
  if (!walls.any) return;
  const std::uint8_t* closed = walls.closed[axis].data();
  const float* wall = walls.velocity[axis].data();
  float* u = velocity.data();
  parallel_chunks(velocity.size(), 1 << 15, [=](std::size_t begin, std::size_t end) {
    // Nearly all faces are open: look at eight at once.
    for (std::size_t f = begin; f < end; f += 8) {
      const std::size_t count = std::min<std::size_t>(8, end - f);
      std::uint64_t marks = 0;
      std::memcpy(&marks, closed + f, count);
      if (marks == 0) continue;
      for (std::size_t i = f; i < f + count; ++i) u[i] = closed[i] ? wall[i] : u[i];
    }
  });
}

void mark_near_walls(const Grid& grid, const Sides& sides, Walls& walls) {
  mark_touching(grid, walls);
  for (int a = 0; a < 3; ++a) spread(grid, a, sides[2 * a] == Side::periodic, 2, walls.near);
}

}  // namespace wick::fluid
