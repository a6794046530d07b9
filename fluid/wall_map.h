#pragma once
/// Which faces of each cell one may pass, a byte a cell, so that whatever moves near walls asks one table.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "fluid/walls.h"

namespace wick::fluid {

/// Covers the cells of the box and two layers around it. Outside an open side there is one layer of ghost cells,
/// which are cells like all others; nothing goes into the second. A periodic side continues with the cells of
/// the other end, however far.
class WallMap {
 public:
  WallMap(const Grid& grid, const Sides& sides);

  /// Takes other walls. For paths of up to `reach` - 2 cells, clearance() tells where they are far.
  void set(const Walls& walls, int reach);

  /// Bit 2 a + u set: one may go across the lower (u = 0) or upper (1) face of axis a.
  [[nodiscard]] unsigned doors(const Int3& cell) const { return open_[index(cell)]; }
  /// Doors of the 2x2x2 cells from `cell` (within the box or its ghosts) toward `toward`, x fastest.
  [[nodiscard]] std::array<std::uint8_t, 8> block_doors(const Int3& cell, const Int3& toward) const {
    const std::size_t scale[3] = {1, stride_y_, stride_z_};
    std::size_t at[3][2];
    for (int a = 0; a < 3; ++a) {
      at[a][0] = std::size_t(place(cell[a], a) + pad) * scale[a];
      at[a][1] = std::size_t(place(cell[a] + toward[a], a) + pad) * scale[a];
    }
    std::array<std::uint8_t, 8> doors;
    for (int corner = 0; corner < 8; ++corner)
      doors[corner] = open_[at[0][corner & 1] + at[1][corner >> 1 & 1] + at[2][corner >> 2]];
    return doors;
  }
  [[nodiscard]] bool passable(const Int3& cell, int axis, int upper) const {
    return doors(cell) >> (2 * axis + upper) & 1U;
  }
  /// True where the face is closed for good: an inner wall, or a closed side of the box.
  [[nodiscard]] bool closed_face(int axis, const Int3& face) const;
  /// True if all faces between the cells from `low` to `high` can be passed. What lies beyond the layer of ghosts
  /// does not count; false for boxes of more than eight cells along x and across periodic sides, where
  /// this was not looked for.
  [[nodiscard]] bool all_open(const Int3& low, const Int3& high) const;

  /// For each cell how many cells away, counted along the axis where it is farthest (Chebyshev), the nearest cell
  /// with a closed face is that is no side of the box; reach + 1 where there is none within `reach`. Eight
  /// bytes may be read before and after. Null before the first walls.
  [[nodiscard]] const std::uint8_t* clearance() const { return clear_.empty() ? nullptr : clear_.data() + slack; }
  /// What clearance() holds where there is no such cell.
  [[nodiscard]] std::uint8_t far() const { return far_; }

 private:
  static constexpr int pad = 2;
  static constexpr std::size_t slack = 8;

  [[nodiscard]] int place(int at, int axis) const {
    const int n = size_[axis];
    return periodic_[axis] && (at < 0 || at >= n) ? (at % n + n) % n : at;
  }
  [[nodiscard]] std::size_t index(const Int3& c) const {
    return std::size_t(place(c[0], 0) + pad) + stride_y_ * std::size_t(place(c[1], 1) + pad) +
           stride_z_ * std::size_t(place(c[2], 2) + pad);
  }
  [[nodiscard]] bool passable_in_box(const Int3& cell, int axis, int upper) const;
  void close_row(const Walls& walls, int j, int k, std::uint8_t far);
  void close_ghost_doors(const Walls& walls);
  void spread(int axis, int reach);

  Grid grid_;
  Sides sides_;
  Int3 size_, ghost_low_, ghost_high_;  ///< lowest and highest cells that exist, ghosts included
  std::array<bool, 3> periodic_{};
  std::size_t stride_y_ = 0, stride_z_ = 0;
  std::uint8_t far_ = 0;
  std::vector<std::uint8_t> box_, open_;  ///< doors without and with the walls
  std::vector<std::uint8_t> clear_, other_;
  std::vector<std::uint8_t> near_row_, other_row_;  ///< rows of `clear_` that hold a value other than reach + 1
};

inline bool WallMap::all_open(const Int3& low, const Int3& high) const {
  Int3 from, to;
  for (int a = 0; a < 3; ++a) {
    if (periodic_[a] && (low[a] < 0 || high[a] >= size_[a])) return false;
    from[a] = std::max(low[a], ghost_low_[a]);
    to[a] = std::min(high[a], ghost_high_[a]);
  }
  const int width = to[0] - from[0] + 1;
  if (width > 8) return false;
  if (width < 1) return true;

  // Look at up to eight cells at once: of those doors that lead to another cell of the box, none may be shut.
  const std::uint64_t cells = 0x0101010101010101U & (~std::uint64_t{0} >> (8 * (8 - width)));
  const std::uint64_t along_x = cells >> 8 << 1, along_y = cells << 3, along_z = cells << 5;
  std::uint64_t shut = 0;
  for (int k = from[2]; k <= to[2]; ++k) {
    const std::uint64_t need = along_x | (k < to[2] ? along_z : 0);
    const std::uint8_t* row = open_.data() + std::size_t(from[0] + pad) + stride_y_ * std::size_t(from[1] + pad) +
                              stride_z_ * std::size_t(k + pad);
    for (int j = from[1]; j <= to[1]; ++j, row += stride_y_) {
      std::uint64_t open;
      std::memcpy(&open, row, sizeof open);
      shut |= (need | (j < to[1] ? along_y : 0)) & ~open;
    }
  }
  return shut == 0;
}

}  // namespace wick::fluid
