#include "solid/box_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace wick::solid {

BoxTree::BoxTree(std::span<const Box> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  if (boxes.empty()) return;
  leaves_.resize(boxes.size());
  build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
}

BoxTree::Bounds BoxTree::rounded(const Box& box) {
  // More than the rounding to a float takes, of numbers and of denormal ones.
  constexpr double kRelative = 1.0 / (1 << 23), kAbsolute = std::numeric_limits<float>::min();
  Bounds b;
  for (int k = 0; k < 3; ++k) {
    b.v[k] = static_cast<float>(box.low[k] - std::abs(box.low[k]) * kRelative - kAbsolute);
    b.v[k + 3] = static_cast<float>(-box.high[k] - std::abs(box.high[k]) * kRelative - kAbsolute);
  }
  return b;
}

BoxTree::Bounds BoxTree::around(const Bounds& a, const Bounds& b) {
  Bounds both;
  for (int k = 0; k < 6; ++k) both.v[k] = std::min(a.v[k], b.v[k]);
  return both;
}

void BoxTree::build(std::span<const Box> boxes, std::uint32_t begin, std::uint32_t end) {
  const std::size_t node = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  if (end - begin <= kLeaf) {
    for (std::uint32_t k = begin; k < end; ++k) {
      leaves_[k] = rounded(boxes[order_[k]]);
      nodes_[node].bounds = k == begin ? leaves_[k] : around(nodes_[node].bounds, leaves_[k]);
    }
  } else {
    Box bounds;
    for (std::uint32_t k = begin; k < end; ++k) {
      bounds.add(boxes[order_[k]].low);
      bounds.add(boxes[order_[k]].high);
    }
    int axis = 0;
    (bounds.high - bounds.low).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto center = [&](std::int32_t i) { return boxes[i].low[axis] + boxes[i].high[axis]; };
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](std::int32_t a, std::int32_t b) { return std::pair(center(a), a) < std::pair(center(b), b); });
    build(boxes, begin, middle);
    const std::size_t second = nodes_.size();
    build(boxes, middle, end);
    nodes_[node].bounds = around(nodes_[node + 1].bounds, nodes_[second].bounds);
  }
  nodes_[node].after = static_cast<std::uint32_t>(nodes_.size());
}

}  // namespace wick::solid
