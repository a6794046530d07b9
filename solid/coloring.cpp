#include "solid/coloring.h"

#include <algorithm>
#include <bit>

namespace wick::solid {

Coloring color_constraints(std::span<const std::int32_t> vertices, int arity, std::size_t vertex_count) {
  const std::size_t count = vertices.size() / static_cast<std::size_t>(arity);
  Coloring result;
  result.color.resize(count);
  // One bit a colour that a constraint of the vertex has taken.
  std::vector<std::uint64_t> taken(vertex_count, 0);
  for (std::size_t c = 0; c < count; ++c) {
    const auto mine = vertices.subspan(c * arity, arity);
    std::uint64_t used = 0;
    for (const std::int32_t v : mine) used |= taken[v];
    const int color = std::countr_one(used);
    result.color[c] = color;
    if (color == kLeftOver) continue;
    result.count = std::max(result.count, color + 1);
    for (const std::int32_t v : mine) taken[v] |= std::uint64_t{1} << color;
  }
  return result;
}

}  // namespace wick::solid
