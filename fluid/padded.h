#pragma once
/// Copies of fields with a layer of ghost values around them, so that kernels need no case for the sides.
#include <array>
#include <cstddef>
#include <vector>

#include "fluid/grid.h"

namespace wick::fluid {

/// What a ghost value is made of, side by side.
enum class Ghost {
  copy,    ///< the nearest value inside: zero gradient
  zero,    ///< ambient air
  wrap,    ///< the value on the opposite side
  mirror,  ///< 2 w - inside: linear to the value w on the side itself, half a spacing out
};
struct GhostRule {
  Ghost kind = Ghost::copy;
  float wall = 0.0F;  ///< w of `mirror`
};
using GhostRules = std::array<GhostRule, 6>;

/// A box of count[0] x count[1] x count[2] values within pad[a] ghosts on both ends of axis a.
struct Padded {
  Int3 count = {0, 0, 0};
  Int3 pad = {1, 1, 1};
  std::vector<float> data;

  /// Sets the shape, not the values; leaves room behind the end for loads of eight that begin on the last one.
  void reshape(const Int3& counts, const Int3& pads);
  [[nodiscard]] int extent(int axis) const { return count[axis] + 2 * pad[axis]; }
  [[nodiscard]] std::ptrdiff_t stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? extent(0) : std::ptrdiff_t(extent(0)) * extent(1);
  }
  /// Index of the value (i,j,k), each from -pad to count + pad - 1.
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return std::size_t(i + pad[0]) +
           std::size_t(extent(0)) * (std::size_t(j + pad[1]) + std::size_t(extent(1)) * std::size_t(k + pad[2]));
  }
  [[nodiscard]] float at(int i, int j, int k) const { return data[index(i, j, k)]; }
  /// Copies count values of `source` (dense, x fastest), each multiplied by `factor`.
  void assign(const std::vector<float>& source, float factor);
  void fill_ghosts(const GhostRules& rules);
};

/// Ghosts of a scalar: ambient air (0) outside open sides, zero gradient outside closed ones.
GhostRules scalar_ghosts(const Sides& sides);

/// Number of values of the lattice that holds component `axis` of velocity (3: cell centres).
inline Int3 lattice_size(const Grid& grid, int axis) {
  return {grid.nx + (axis == 0), grid.ny + (axis == 1), grid.nz + (axis == 2)};
}

}  // namespace wick::fluid
