#pragma once
/// One level of the pressure multigrid and the passes over it.
///
/// A level solves  diagonal_n p_n - sum over links of weight (p_other) = b_n.  Away from walls weight is 1 and
/// diagonal 6 (plus end_term at the sides of the box); there only p and b are read. Rows that walls
/// touch have spans in which stored weights are read instead. On coarse levels a box of 2×2×2 fine boxes that
/// walls cut into several parts holds one unknown (node) for each: the largest is the box's own cell, the
/// others are stored behind the grid, and all nodes that have links to such are relaxed from link lists.
/// Two nodes of one box are never linked, so red and black stay independent.
#include <cstdint>

#include "fluid/multigrid_graph.h"
#include "fluid/multigrid_layout.h"

namespace wick::fluid {

struct Level {
  struct Span {
    std::uint16_t begin, end;  ///< numbers m of either colour
  };
  struct Link {
    std::uint32_t at;  ///< in the array of the other colour
    float weight;
  };
  /// A node with a list of links; lists are sorted by plane and colour.
  struct Special {
    std::uint32_t at, link_begin, link_end;
    float diagonal;
  };
  /// A fine node whose residual goes into a coarse node.
  struct Child {
    std::uint32_t at;
    std::int32_t special;  ///< index among the fine level's specials, -1: none
    std::uint8_t colour, offset;
  };
  /// A coarse node whose right-hand side is gathered child by child.
  struct Gather {
    std::uint32_t at, child_begin, child_end;
    std::uint8_t colour;
  };
  /// A fine node that takes its coarse correction from another node than the box's own.
  struct Adoption {
    std::uint32_t at, parent, wrong_parent;  ///< wrong_parent: what the row pass added, or `none`
    std::uint8_t parent_colour;
  };
  static constexpr std::uint32_t none = 0xffffffffU;

  Layout layout;
  std::array<std::array<float, 2>, 3> end_term{};  ///< what the ends of an axis add to the diagonal beside them
  std::array<bool, 3> wraps{};                     ///< periodic axes
  bool periodic = false;                           ///< any of them
  float restriction = 0.5F;                        ///< of the next finer level's residuals
  std::array<Coloured<float>, 3> weight;           ///< of the lower face of each cell
  Coloured<float> diagonal;
  Coloured<float> p, b;
  std::vector<std::uint32_t> span_begin;  ///< per row, and one more
  std::vector<Span> spans;
  std::vector<Special> specials;
  std::vector<std::uint32_t> special_begin;  ///< per plane and colour, and one more
  std::vector<Link> links;
  /// Towards the next finer level: right-hand sides of this level's nodes.
  std::vector<Gather> gathers;
  std::vector<std::uint32_t> gather_begin;  ///< per plane, and one more
  std::vector<Child> children;
  /// Towards the next coarser level: corrections of this level's nodes.
  std::vector<Adoption> adoptions;
  std::vector<std::uint32_t> adoption_begin;  ///< per plane and colour, and one more

  explicit Level(const Graph& graph);

  /// Diagonal of a cell that no wall touches.
  [[nodiscard]] float regular_diagonal(int i, int j, int k) const;
  [[nodiscard]] bool large() const { return layout.cells() > 20000; }
};

/// Relaxes one colour in one plane: p = (b + sum weight p_other) / diagonal.
void relax_plane(Level& level, int colour, int k);
/// The same when p is 0 everywhere: p = b / diagonal.
void relax_plane_from_zero(Level& level, int colour, int k);
/// Right-hand side of coarse plane K: sum of the residuals of the fine nodes in each coarse node, times
/// coarse.restriction (½ where all axes are coarsened, which undoes the factor 2 of plain aggregation).
/// Black residuals are 0 after a black relaxation and need no pass then (both_colours = false).
void restrict_plane(const Level& fine, Level& coarse, int K, bool both_colours);
/// Adds the coarse correction to one colour of a fine plane (piecewise constant).
void prolong_plane(Level& fine, const Level& coarse, int k, int colour);
/// Copies the cells at one end of periodic axes into the rim at the other.
template <class T>
void fill_rim(const Level& level, Coloured<T>& field);

/// out[m] = (A p) in row (j, k) of one colour, for m < layout.count(offset).
template <class T>
void apply_row(const Level& level, const Coloured<T>& p, int colour, int j, int k, double* out);

/// One V-cycle of the levels: p of the first level from its b. V(2,2), red-black forth, black-red back, so
/// that it is symmetric.
void v_cycle(std::vector<Level>& levels);

}  // namespace wick::fluid
