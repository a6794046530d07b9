#include "diffusion/overflow.h"

#include <algorithm>
#include <queue>
#include <tuple>

#include "diffusion/sums.h"

namespace wick::diffusion {

namespace {

/// A way to a vertex, nearest first; `from` is where it began.
struct Way {
  double length;
  std::int32_t from, vertex;
  friend bool operator<(const Way& a, const Way& b) {  // the priority queue has the largest on top
    return std::tie(a.length, a.from, a.vertex) > std::tie(b.length, b.from, b.vertex);
  }
};
using Ways = std::priority_queue<Way>;

class Overflow {
 public:
  Overflow(const OverflowMap& map, const std::vector<double>& mass, double capacity, std::vector<double>& u)
      : map_(map), mass_(mass), capacity_(capacity), u_(u), seen_(u.size(), -1) {}

  /// For every full vertex the nearest one with room; -1 where its piece has none.
  [[nodiscard]] std::vector<std::int32_t> nearest_room() const {
    std::vector<std::int32_t> nearest(u_.size(), -1);
    Ways ways;
    for (std::int32_t i = 0; i < count(); ++i) {
      if (room(i) <= 0.0) continue;
      nearest[i] = i;
      push_neighbours({0.0, i, i}, ways, [&](std::int32_t j) { return room(j) <= 0.0; });
    }
    while (!ways.empty()) {
      const Way way = ways.top();
      ways.pop();
      if (nearest[way.vertex] >= 0) continue;
      nearest[way.vertex] = way.from;
      push_neighbours(way, ways, [&](std::int32_t j) { return nearest[j] < 0; });
    }
    return nearest;
  }

  /// Fills vertices from `start` outward; returns what is left.
  double fill_from(std::int32_t start, double amount) {
    Ways ways;
    ways.push({0.0, start, start});
    while (!ways.empty() && amount > 0.0) {
      const Way way = ways.top();
      ways.pop();
      if (seen_[way.vertex] == start) continue;
      seen_[way.vertex] = start;
      const double taken = std::min(room(way.vertex), amount);
      if (taken > 0.0) {
        double& value = u_[way.vertex];
        value = taken < amount ? capacity_ : std::min(capacity_, value + taken / mass_[way.vertex]);
        amount -= taken;
      }
      push_neighbours(way, ways, [&](std::int32_t j) { return seen_[j] != start; });
    }
    return amount;
  }

 private:
  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(u_.size()); }
  [[nodiscard]] double room(std::int32_t i) const {
    return mass_[i] > 0.0 && u_[i] < capacity_ ? mass_[i] * (capacity_ - u_[i]) : 0.0;
  }
  template <class Wanted>
  void push_neighbours(const Way& way, Ways& ways, const Wanted& wanted) const {
    const SheetGraph& graph = *map_.graph;
    for (std::int32_t k = graph.offset[way.vertex]; k < graph.offset[way.vertex + 1]; ++k) {
      const std::int32_t j = graph.column[k];
      if (wanted(j)) ways.push({way.length + (*map_.edge_length)[graph.entry_edge[k]], way.from, j});
    }
  }

  const OverflowMap& map_;
  const std::vector<double>& mass_;
  double capacity_;
  std::vector<double>& u_;
  std::vector<std::int32_t> seen_;  ///< the last start that came by
};

}  // namespace

void pour_over(const OverflowMap& map, const std::vector<double>& mass, double capacity, std::vector<double>& u) {
  const auto above = [&](std::size_t i) { return mass[i] > 0.0 ? mass[i] * std::max(0.0, u[i] - capacity) : 0.0; };
  const double over = sum_of(u.size(), above);
  // Less is rounding of vertices that are held at their capacity.
  if (!(over > 1e-14 * sum_of(u.size(), [&](std::size_t i) { return mass[i] * u[i]; }))) return;
  Overflow overflow(map, mass, capacity, u);
  const std::vector<std::int32_t> nearest = overflow.nearest_room();
  std::vector<double> arriving(u.size(), 0.0);
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double amount = above(i);
    if (amount == 0.0 || nearest[i] < 0) continue;
    arriving[nearest[i]] += amount;
    u[i] = capacity;
  }
  for (std::size_t i = 0; i < u.size(); ++i) {
    if (arriving[i] == 0.0) continue;
    const double left = overflow.fill_from(static_cast<std::int32_t>(i), arriving[i]);
    if (left > 0.0) u[i] += left / mass[i];
  }
}

}  // namespace wick::diffusion
