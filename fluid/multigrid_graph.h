#pragma once
/// The walls as the multigrid sees them: for every level, the boxes that walls touch, the nodes they fall
/// into, and the links between nodes. Boxes that no wall touches are not stored.
///
/// A box of 2×2×2 finer boxes has one node for each group of finer nodes that are joined by open faces inside
/// the box. So no coarse node ever reaches through a wall, however the sheet is bent, and on the last level,
/// a single box, the nodes are the connected parts of the fluid.
///   link area     a = mean of the finer areas             (1 when nothing is in the way)
///   weak faces    a -> 2a/(1 + a) before the mean: a film whose resistance 1/a - 1, in boxes of gas, halves as
///                 boxes double; nodes on its two sides are one from a = ½ on
///   link weight   a / distance of the two centroids along the axis of the face
/// in units of the level's box. The weight is the finite-volume coefficient; plain sums over piecewise
/// constant aggregates would be too large by a factor of 2 a level [Braess 1995].
#include <cstdint>

#include "fluid/multigrid_layout.h"
#include "fluid/walls.h"

namespace wick::fluid {

struct Graph {
  static constexpr std::int32_t regular = -1, empty = -2;

  struct Link {
    std::int32_t box, local;  ///< node at the other end
    float area, weight;
    std::uint8_t side;  ///< -x, +x, -y, +y, -z, +z
    bool weak = false;  ///< leads through weak faces only
  };
  struct Node {
    float volume = 1.0F;
    std::array<float, 3> center{};   ///< centroid from the middle of the box
    std::array<float, 6> outside{};  ///< area towards open sides of the fluid's box
    std::uint32_t link_begin = 0, link_end = 0;
    std::int32_t parent = 0;  ///< local number in the coarser box
    bool special = false;     ///< not local 0, or linked to such a node
  };
  struct Record {
    std::int32_t box;
    std::uint32_t node_begin, node_count;
    std::array<std::int32_t, 8> child_local;  ///< node that a finer box without record belongs to
  };
  /// A face that is closed to the fluid but yields: its coefficient instead of 1.
  struct WeakFace {
    std::uint8_t axis;
    std::int64_t face;
    float weight;
  };

  Int3 n{};
  bool finest = true;
  std::array<bool, 6> open{};               ///< sides with p = 0
  std::array<bool, 3> wraps{};              ///< periodic axes with more than one box
  std::array<bool, 3> halves{};             ///< axes along which the next level is coarser
  std::array<float, 3> extent{};            ///< size of the fluid's box in boxes of this level
  std::array<float, 3> stiffness{1, 1, 1};  ///< coefficient of an axis that is no longer coarsened
  std::vector<std::int32_t> state;          ///< per box: regular, empty, or number of its record
  std::vector<Record> records;
  std::vector<std::int32_t> empties;
  std::vector<Node> nodes;
  std::vector<Link> links;

  [[nodiscard]] std::int32_t box(const Int3& at) const { return at[0] + n[0] * (at[1] + n[1] * at[2]); }
  [[nodiscard]] Int3 place(std::int32_t b) const { return {b % n[0], b / n[0] % n[1], b / (n[0] * n[1])}; }
  [[nodiscard]] bool single_box() const { return n == Int3{1, 1, 1}; }
  /// Box behind a side; -1 where there is none.
  [[nodiscard]] std::int32_t beside(Int3 at, int side) const;
  /// Area of the open side of the fluid's box in front of a regular box.
  [[nodiscard]] float regular_outside(const Int3& at, int side) const;
  /// Weight of the link from a node to p = 0 on the sides of the fluid's box.
  [[nodiscard]] float outside_weight(const Int3& at, const Node& node) const;
  /// Number of the node at the end of a link that starts in box `from`, or -1 where the box has no record.
  [[nodiscard]] std::int64_t node_of(std::int32_t b, std::int32_t local) const {
    return state[b] >= 0 ? std::int64_t(records[state[b]].node_begin) + local : -1;
  }
  /// Forgets all records.
  void clear();
};

Graph finest_graph(const Grid& grid, const Sides& sides);
Graph coarser_graph(const Graph& fine);

/// Fills the finest graph from closed faces and solid cells; `weak` faces are closed ones.
void build_finest(const Grid& grid, const Walls& walls, const std::vector<Graph::WeakFace>& weak, Graph& graph);
/// Fills a coarser graph and tells the finer nodes their parents.
void build_coarser(Graph& fine, Graph& coarse);

/// Number of the connected part that each cell lies in, counting only parts without an open side; -1: a part
/// with an open side, or solid. `parts` receives how many there are; empty when there is none. Parts with a weak
/// face between them are one.
std::vector<std::int32_t> closed_parts(const std::vector<Graph>& graphs, const std::vector<Graph::WeakFace>& weak,
                                       int& parts);

}  // namespace wick::fluid
