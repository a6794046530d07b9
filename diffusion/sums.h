#pragma once
/// Compensated sums whose bits do not depend on the number of threads.
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace wick::diffusion {

/// Items a chunk: long enough to hide the cost of a task, short enough that 20,000 vertices still make ten.
inline constexpr std::size_t chunk = 2048;

/// Neumaier's sum: the error does not grow with the number of terms [Neumaier 1974].
class CompensatedSum {
 public:
  void add(double value) {
    const double total = sum_ + value;
    lost_ += std::abs(sum_) >= std::abs(value) ? (sum_ - total) + value : (value - total) + sum_;
    sum_ = total;
  }
  [[nodiscard]] double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0, lost_ = 0.0;
};

/// Sum of term(i) for i in [0, count), compensated within chunks that are added in order.
template <class Term>
double sum_of(std::size_t count, Term&& term) {
  return parallel_sum(count, chunk, [&](std::size_t begin, std::size_t end) {
    CompensatedSum sum;
    for (std::size_t i = begin; i < end; ++i) sum.add(term(i));
    return sum.value();
  });
}

/// Vertices in lists: each connected component, or the whole sheet.
struct VertexGroups {
  std::vector<std::int32_t> vertex;        ///< grouped, ascending within a group
  std::vector<std::int32_t> offset = {0};  ///< groups + 1
  [[nodiscard]] std::size_t count() const { return offset.size() - 1; }
  [[nodiscard]] std::span<const std::int32_t> operator[](std::size_t group) const {
    return std::span(vertex).subspan(offset[group], offset[group + 1] - offset[group]);
  }
};

template <class Term>
double sum_over(std::span<const std::int32_t> vertices, Term&& term) {
  return sum_of(vertices.size(), [&](std::size_t k) { return term(static_cast<std::size_t>(vertices[k])); });
}

}  // namespace wick::diffusion
