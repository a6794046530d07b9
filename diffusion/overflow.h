#pragma once
/// Where what a sheet cannot hold goes: the nearest places with room.
#include <vector>

#include "diffusion/operators.h"

namespace wick::diffusion {

/// A sheet as it is walked: its edges and their lengths.
struct OverflowMap {
  const SheetGraph* graph = nullptr;
  const std::vector<double>* edge_length = nullptr;  ///< [m], by SheetGraph::entry_edge
};

/// Moves the amounts M (u - capacity) of vertices above the capacity to the vertices nearest along the sheet's
/// edges that have room, and from there outward, each filled before the next: nothing beyond what gets full is
/// touched. Σ M u is kept; what finds no room in its piece stays. Deterministic: among equally near vertices the
/// one with the lower number comes first.
void pour_over(const OverflowMap& map, const std::vector<double>& mass, double capacity, std::vector<double>& u);

}  // namespace wick::diffusion
