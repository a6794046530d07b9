#pragma once
/// Tree of boxes: finds the ones that overlap a box.
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/types.h"

namespace wick::solid {

struct Box {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);  ///< empty
  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  void grow(double by) {
    low.array() -= by;
    high.array() += by;
  }
};

class BoxTree {
 public:
  BoxTree() = default;
  /// Cuts at the median along the longest side; a node's first half follows it at once.
  explicit BoxTree(std::span<const Box> boxes);

  /// Calls body(index) for every box that overlaps `query`; boxes are rounded outwards to floats.
  template <class Body>
  void for_overlaps(const Box& query, Body&& body) const {
    visit(across(rounded(query)), body);
  }

  /// Calls body(begin, end) for ranges of at most `size` boxes of order() that are near each other.
  template <class Body>
  void for_clusters(std::size_t size, Body&& body) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const bool small = nodes_[n].end - nodes_[n].begin <= std::max(size, kLeaf);
      if (small) body(nodes_[n].begin, nodes_[n].end);
      n = small ? nodes_[n].after : n + 1;
    }
  }
  /// The boxes in the order of the leaves.
  [[nodiscard]] const std::vector<std::int32_t>& order() const { return order_; }

 private:
  static constexpr std::size_t kLeaf = 4;
  /// Low corner, and the high one with its sign turned: a box overlaps another if none of its numbers is above
  /// that of the other, seen across.
  struct Bounds {
    float v[6];
  };
  struct Node {
    Bounds bounds;
    std::uint32_t begin, end;  ///< places in order_
    std::uint32_t after;       ///< the node that follows its last descendant
  };
  static Bounds rounded(const Box& box);
  static Bounds across(const Bounds& b) { return {{-b.v[3], -b.v[4], -b.v[5], -b.v[0], -b.v[1], -b.v[2]}}; }
  static bool overlap(const Bounds& a, const Bounds& seen) {
    bool all = true;
    for (int k = 0; k < 6; ++k) all &= a.v[k] <= seen.v[k];
    return all;
  }
  static Bounds around(const Bounds& a, const Bounds& b);
  void build(std::span<const Box> boxes, std::uint32_t begin, std::uint32_t end);

  template <class Body>
  void visit(const Bounds& seen, Body& body) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const bool meets = overlap(node.bounds, seen);
      if (meets && node.end - node.begin <= kLeaf)
        for (std::size_t k = node.begin; k < node.end; ++k)
          if (overlap(leaves_[k], seen)) body(order_[k]);
      n = meets ? n + 1 : node.after;
    }
  }

  std::vector<std::int32_t> order_;
  std::vector<Bounds> leaves_;  ///< in that order
  std::vector<Node> nodes_;
};

}  // namespace wick::solid
