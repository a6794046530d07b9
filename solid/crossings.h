#pragma once
/// Counts where sheets pass through themselves or each other. Exact, and independent of contact: it judges it.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "solid/shell_mesh.h"

namespace wick::solid {

struct PosedSheet {
  const ShellMesh* mesh;
  const std::vector<Vec3>* x;  ///< positions, V
};

/// An edge and a triangle without a common vertex that share a point.
struct Crossing {
  std::int32_t edge_sheet, edge;
  std::int32_t triangle_sheet, triangle;
};

/// All of them, ordered by triangle and edge; positions must be finite. n log n by a tree of boxes.
std::vector<Crossing> find_crossings(std::span<const PosedSheet> sheets);

}  // namespace wick::solid
