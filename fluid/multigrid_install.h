#pragma once
/// Turns graphs of walls into the arrays that the passes of a level read.
#include "fluid/multigrid_graph.h"
#include "fluid/multigrid_level.h"

namespace wick::fluid {

/// Keeps what must be undone when the walls have moved.
struct Installed {
  std::vector<std::int32_t> boxes;    ///< whose weights were changed
  std::vector<std::uint32_t> places;  ///< of the graph's nodes, in the array of their colour
};

/// Weights, diagonals, spans and link lists of one level.
void install_level(const Graph& graph, Level& level, Installed& installed);
/// Transfer lists between two levels.
void install_transfer(const Graph& fine_graph, const Installed& fine_installed, Level& fine,
                      const Graph& coarse_graph, const Installed& coarse_installed, Level& coarse);

}  // namespace wick::fluid
