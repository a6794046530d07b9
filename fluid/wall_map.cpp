#include "fluid/wall_map.h"

#include <algorithm>

#include "core/parallel.h"

namespace wick::fluid {

namespace {

constexpr std::uint8_t all_doors = 0x3F;
constexpr std::size_t row_grain = 64;

}  // namespace

WallMap::WallMap(const Grid& grid, const Sides& sides)
    : grid_(grid), sides_(sides), size_{grid.nx, grid.ny, grid.nz} {
  for (int a = 0; a < 3; ++a) {
    periodic_[a] = sides[2 * a] == Side::periodic;
    ghost_low_[a] = sides[2 * a] == Side::open ? -1 : 0;
    ghost_high_[a] = size_[a] - (sides[2 * a + 1] == Side::open ? 0 : 1);
  }
  stride_y_ = std::size_t(grid.nx) + 2 * pad;
  stride_z_ = stride_y_ * (std::size_t(grid.ny) + 2 * pad);
}

bool WallMap::passable_in_box(const Int3& cell, int axis, int upper) const {
  // Nothing goes out of the layer of ghosts, whose outer sides are at infinity for what is near a wall, and
  // behind closed sides there is nothing.
  for (int b = 0; b < 3; ++b) {
    if (periodic_[b]) continue;
    if (cell[b] < (b == axis ? -1 : ghost_low_[b]) || cell[b] > (b == axis ? size_[b] : ghost_high_[b]))
      return false;
  }
  if (periodic_[axis]) return true;
  const int face = cell[axis] + upper, n = size_[axis];
  if (face < 0 || face > n) return false;
  // Between ghosts of an open side there is only air.
  for (int b = 0; b < 3; ++b) {
    if (b != axis && !periodic_[b] && (cell[b] < 0 || cell[b] >= size_[b])) return true;
  }
  return !(face == 0 && sides_[2 * axis] == Side::closed) && !(face == n && sides_[2 * axis + 1] == Side::closed);
}

bool WallMap::closed_face(int axis, const Int3& face) const {
  if (face[axis] < size_[axis]) return !passable(face, axis, 0);
  Int3 cell = face;
  --cell[axis];
  return !passable(cell, axis, 1);
}

/// Doors and first marks of clearance of one row of cells.
void WallMap::close_row(const Walls& walls, int j, int k, std::uint8_t far) {
  const int nx = grid_.nx;
  // Of the two copies of a periodic face the lower counts.
  const int up_j = periodic_[1] && j + 1 == grid_.ny ? 0 : j + 1,
            up_k = periodic_[2] && k + 1 == grid_.nz ? 0 : k + 1;
  const std::uint8_t* const x = walls.closed[0].data() + grid_.face(0, 0, j, k);
  const std::uint8_t* const y0 = walls.closed[1].data() + grid_.face(1, 0, j, k);
  const std::uint8_t* const y1 = walls.closed[1].data() + grid_.face(1, 0, up_j, k);
  const std::uint8_t* const z0 = walls.closed[2].data() + grid_.face(2, 0, j, k);
  const std::uint8_t* const z1 = walls.closed[2].data() + grid_.face(2, 0, j, up_k);
  const std::size_t first = index({0, j, k});
  const std::uint8_t* const box = box_.data() + first;
  std::uint8_t* __restrict open = open_.data() + first;
  std::uint8_t* __restrict clear = clear_.data() + slack + grid_.cell(0, j, k);
  const auto bit = [](std::uint8_t closed, int at) { return static_cast<std::uint8_t>(closed != 0 ? 1 << at : 0); };
  std::uint8_t any = 0;
  for (int i = 0; i < nx; ++i) {
    const std::uint8_t shut =
        bit(x[i], 0) | bit(x[i + 1], 1) | bit(y0[i], 2) | bit(y1[i], 3) | bit(z0[i], 4) | bit(z1[i], 5);
    open[i] = static_cast<std::uint8_t>(box[i] & ~shut);
    const auto lost = static_cast<std::uint8_t>(box[i] & shut);
    clear[i] = lost != 0 ? std::uint8_t{0} : far;
    any |= lost;
  }
  if (periodic_[0]) {
    // The last cell's upper face is the first one's lower.
    const std::uint8_t shut = (x[0] != 0 ? 2U : 0U);
    open[nx - 1] = static_cast<std::uint8_t>((open[nx - 1] | 2U) & ~unsigned(shut));
    if (shut != 0) clear[nx - 1] = 0, any = 1;
  }
  near_row_[std::size_t(j) + std::size_t(grid_.ny) * k] = any != 0;
}

/// Ghosts of open sides do not see into the box through faces that are closed.
void WallMap::close_ghost_doors(const Walls& walls) {
  for (int s = 0; s < 6; ++s) {
    if (sides_[s] != Side::open) continue;
    const int a = s / 2, b = (a + 1) % 3, c = (a + 2) % 3, upper = s % 2;
    for (int q = 0; q < size_[c]; ++q) {
      for (int p = 0; p < size_[b]; ++p) {
        Int3 ghost{}, face{};
        ghost[b] = face[b] = p, ghost[c] = face[c] = q;
        ghost[a] = upper ? size_[a] : -1, face[a] = upper ? size_[a] : 0;
        const std::uint8_t door = static_cast<std::uint8_t>(1U << (2 * a + 1 - upper));
        const std::size_t at = index(ghost);
        const bool shut = walls.closed[a][grid_.face(a, face[0], face[1], face[2])] != 0;
        open_[at] = static_cast<std::uint8_t>(shut ? box_[at] & ~door : box_[at]);
      }
    }
  }
}

/// out = min over |o| <= reach of max(|o|, value o cells along the axis), rows of bytes at a time.
void WallMap::spread(int axis, int reach) {
  const int nx = grid_.nx, ny = grid_.ny, n = size_[axis];
  const bool periodic = periodic_[axis];
  const auto far = static_cast<std::uint8_t>(reach + 1);
  parallel_chunks(std::size_t(ny) * grid_.nz, row_grain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint8_t> padded(std::size_t(nx) + 2 * reach);
    for (std::size_t row = begin; row < end; ++row) {
      const int j = int(row % ny), k = int(row / ny);
      std::uint8_t* __restrict to = other_.data() + slack + row * nx;
      std::fill_n(to, nx, far);
      other_row_[row] = 0;
      const auto lower = [&](const std::uint8_t* from, int distance) {
        const auto d = static_cast<std::uint8_t>(distance);
        const int count = nx;
        for (int i = 0; i < count; ++i) {
          const std::uint8_t v = from[i] > d ? from[i] : d;
          to[i] = v < to[i] ? v : to[i];
        }
        other_row_[row] = 1;
      };
      if (axis == 0) {
        if (!near_row_[row]) continue;
        const std::uint8_t* self = clear_.data() + slack + row * nx;
        for (int i = -reach; i < nx + reach; ++i) {
          const bool outside = i < 0 || i >= nx;
          padded[i + reach] = !outside ? self[i] : periodic ? self[(i % nx + nx) % nx] : far;
        }
        for (int o = -reach; o <= reach; ++o) lower(padded.data() + reach + o, std::abs(o));
        continue;
      }
      for (int o = -reach; o <= reach; ++o) {
        int at = (axis == 1 ? j : k) + o;
        if (periodic) at = (at % n + n) % n;
        if (at < 0 || at >= n) continue;
        const std::size_t source = axis == 1 ? std::size_t(at) + std::size_t(ny) * k : j + std::size_t(ny) * at;
        if (near_row_[source]) lower(clear_.data() + slack + source * nx, std::abs(o));
      }
    }
  });
  std::swap(clear_, other_);
  std::swap(near_row_, other_row_);
}

void WallMap::set(const Walls& walls, int reach) {
  if (box_.empty()) {
    // Only at the sides of the box do doors differ.
    const std::size_t cells = stride_z_ * (std::size_t(grid_.nz) + 2 * pad);
    box_.assign(cells + slack, 0);
    for (int k = -pad; k < grid_.nz + pad; ++k) {
      for (int j = -pad; j < grid_.ny + pad; ++j) {
        const bool inner = j > 0 && j + 1 < grid_.ny && k > 0 && k + 1 < grid_.nz;
        std::uint8_t* row = box_.data() + pad + stride_y_ * std::size_t(j + pad) + stride_z_ * std::size_t(k + pad);
        for (int i = -pad; i < grid_.nx + pad; ++i) {
          unsigned doors = inner && i > 0 && i + 1 < grid_.nx ? all_doors : 0;
          for (int d = 0; doors != all_doors && d < 6; ++d) {
            doors |= unsigned{passable_in_box({i, j, k}, d / 2, d % 2)} << d;
          }
          row[i] = static_cast<std::uint8_t>(doors);
        }
      }
    }
    open_ = box_;
    for (auto* marks : {&clear_, &other_}) marks->assign(grid_.cells() + 2 * slack, 0);
    for (auto* rows : {&near_row_, &other_row_}) rows->assign(std::size_t(grid_.ny) * grid_.nz, 0);
  }
  far_ = static_cast<std::uint8_t>(reach + 1);
  parallel_for(std::size_t(grid_.ny) * grid_.nz, row_grain,
               [&](std::size_t row) { close_row(walls, int(row % grid_.ny), int(row / grid_.ny), far_); });
  close_ghost_doors(walls);
  for (int a = 0; a < 3; ++a) spread(a, reach);
}

}  // namespace wick::fluid
