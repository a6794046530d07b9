#pragma once
/// Paths and samples near walls, where every step goes from cell to cell through open faces only, so that
/// nothing is ever seen or carried through a closed face [Guendelman 2005].
///
/// Positions are in cells: cell (i,j,k) spans [i, i+1) x ..., face i of axis a lies at coordinate i. Outside
/// an open side there is one layer of ghost cells, which are cells like all others; a periodic side continues
/// with the cells of the other end.
#include <array>

#include "fluid/padded.h"
#include "fluid/wall_map.h"

namespace wick::fluid {

/// A point and the cell that it counts as lying in (a point on a face could be in either).
struct WallPoint {
  std::array<float, 3> x{};
  Int3 cell{};
  bool clipped = false;  ///< the path here was cut by a closed face or by a closed side
};

/// An interpolated value with the range of what it was made of.
struct WallSample {
  float value = 0.0F, low = 0.0F, high = 0.0F;
  bool thinned = false;  ///< a sample with weight could not be reached
};

class WallPaths {
 public:
  /// `map` must outlive the use.
  WallPaths(const Grid& grid, const Sides& sides, const WallMap& map);

  /// Goes from `start` along `displacement` until the end or the first closed face.
  [[nodiscard]] WallPoint walk(const WallPoint& start, const std::array<float, 3>& displacement) const;
  /// Interpolates values at cell centres from those of the eight cells around the point that can be reached.
  [[nodiscard]] WallSample sample_scalar(const Padded& field, const WallPoint& at) const;
  /// Interpolates component `axis` of velocity. An open face belongs to the cells on both its sides; a closed
  /// face shows the velocity stored there, the wall's, to both.
  [[nodiscard]] WallSample sample_velocity(const Padded& component, int axis, const WallPoint& at) const;
  [[nodiscard]] std::array<float, 3> velocity(const std::array<Padded, 3>& field, const WallPoint& at) const;
  /// Second-order path against (sign -1) or along (+1) the flow [cells a step].
  [[nodiscard]] WallPoint trace(const std::array<Padded, 3>& flow, const WallPoint& start, float sign) const;

 private:
  struct Block;
  [[nodiscard]] Block block_around(const WallPoint& at) const;
  template <int A>
  [[nodiscard]] WallSample sample_component(const Padded& component, const WallPoint& at, const Block& block) const;
  void wrap_cell(Int3& cell) const;
  /// Which of the cells of the block are joined to the point's own by open faces within the block.
  [[nodiscard]] unsigned reach(const Block& block) const;

  Int3 size_;
  std::array<bool, 3> periodic_{};
  std::array<float, 3> low_{}, high_{};  ///< limits of positions: half a cell beyond open sides
  const WallMap& map_;
};

}  // namespace wick::fluid
