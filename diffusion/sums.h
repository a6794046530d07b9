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

/// One running sum with its rounding error kept apart [Knuth 1997, two-sum; Ogita 2005]: the error does not grow
/// with the number of terms.
struct CompensatedSum {
  double sum = 0.0, lost = 0.0;
  void add(double value) {
    const double total = sum + value, part = total - sum;
    lost += (sum - (total - part)) + (value - part);
    sum = total;
  }
  [[nodiscard]] double value() const { return sum + lost; }
};

/// Sum of term(i) for i in [0, count), compensated. Eight sums run side by side, since each waits for itself;
/// chunks and lanes are added in order.
template <class Term>
double sum_of(std::size_t count, Term&& term) {
  constexpr std::size_t lanes = 8;
  return parallel_sum(count, chunk, [&](std::size_t begin, std::size_t end) {
    double sum[lanes] = {}, lost[lanes] = {};
    std::size_t i = begin;
    for (; i + lanes <= end; i += lanes)
      for (std::size_t k = 0; k < lanes; ++k) {
        const double value = term(i + k), total = sum[k] + value, part = total - sum[k];
        lost[k] += (sum[k] - (total - part)) + (value - part);
        sum[k] = total;
      }
    CompensatedSum all;
    for (; i < end; ++i) all.add(term(i));
    for (std::size_t k = 0; k < lanes; ++k) {
      all.add(sum[k]);
      all.lost += lost[k];
    }
    return all.value();
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
