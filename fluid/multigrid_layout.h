#pragma once
/// Storage of one multigrid level: cells are split by colour, red (i + j + k even) and black, so that a
/// relaxation of one colour reads and writes runs of neighbouring numbers.
///
/// In row (j, k) the cell (i, j, k) of colour c is number m = (i - o)/2 of its colour, o = (j + k + c) mod 2.
/// Its neighbours are all of the other colour: at m - 1 + o and m + o in the same row, at m in the four rows
/// beside it. A rim of one row on every side, and of at least one number at both ends of a row, stays 0
/// (closed and open sides) or holds the cells of the opposite end (periodic sides).
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/types.h"

namespace wick::fluid {

struct Layout {
  int nx = 1, ny = 1, nz = 1;
  std::ptrdiff_t row_stride = 0, plane_stride = 0;

  Layout() = default;
  explicit Layout(const Int3& n) : nx(n[0]), ny(n[1]), nz(n[2]) {
    row_stride = (half() + 7) / 8 * 8 + 8;
    plane_stride = row_stride * (ny + 2);
  }

  /// Most cells of one colour in a row.
  [[nodiscard]] int half() const { return (nx + 1) / 2; }
  /// Cells of one colour in a row whose first such cell is i = o.
  [[nodiscard]] int count(int o) const { return (nx - o + 1) / 2; }
  [[nodiscard]] static int offset(int colour, int j, int k) { return (j + k + colour) & 1; }
  [[nodiscard]] static int colour(int i, int j, int k) { return (i + j + k) & 1; }
  [[nodiscard]] std::ptrdiff_t row(int j, int k) const { return (k + 1) * plane_stride + (j + 1) * row_stride + 8; }
  /// Place of a cell within the array of its colour; rim cells (-1 and n) have places too.
  [[nodiscard]] std::ptrdiff_t place(int i, int j, int k) const { return row(j, k) + (i >> 1); }
  [[nodiscard]] std::size_t size() const { return (nz + 2) * plane_stride + 8; }
  [[nodiscard]] std::size_t rows() const { return std::size_t(ny) * nz; }
  [[nodiscard]] std::size_t cells() const { return rows() * nx; }
  [[nodiscard]] std::size_t row_index(int j, int k) const { return j + std::size_t(ny) * k; }
  [[nodiscard]] int size(int axis) const { return axis == 0 ? nx : axis == 1 ? ny : nz; }
};

/// One number a cell, by colour; numbers past Layout::size() belong to nodes beside the grid.
template <class T>
using Coloured = std::array<std::vector<T>, 2>;

template <class T>
Coloured<T> make_coloured(const Layout& layout, T value) {
  return {std::vector<T>(layout.size(), value), std::vector<T>(layout.size(), value)};
}

}  // namespace wick::fluid
