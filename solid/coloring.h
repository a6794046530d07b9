#pragma once
/// Greedy graph colouring of constraints: two constraints of one colour share no vertex, so all of them can be
/// projected at the same time, and in any order with the same result.
#include <cstdint>
#include <span>
#include <vector>

namespace wick::solid {

struct Coloring {
  std::vector<std::int32_t> color;  ///< per constraint; kLeftOver where no colour was free
  int count = 0;                    ///< number of colours
};

/// More colours are not given out: what remains around a vertex of huge valence is done one by one.
inline constexpr int kMostColors = 64;
inline constexpr std::int32_t kLeftOver = kMostColors;

/// `vertices` holds `arity` vertex numbers a constraint. Constraints take the first free colour in their order.
Coloring color_constraints(std::span<const std::int32_t> vertices, int arity, std::size_t vertex_count);

}  // namespace wick::solid
