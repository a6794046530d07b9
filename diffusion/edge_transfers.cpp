#include "diffusion/edge_transfers.h"

#include <algorithm>

namespace wick::diffusion {

namespace {

/// Transfer k of row i, positive outwards.
double outward(const SheetGraph& graph, const std::vector<double>& transfer, std::size_t i, std::int32_t k) {
  const double amount = transfer[graph.entry_edge[k]];
  return static_cast<std::size_t>(graph.column[k]) > i ? amount : -amount;
}

constexpr double rounding = 1e-14;

/// Shares of its outflow and inflow that a vertex may keep; returns by how much the strictest falls short of 1.
/// What passes through a vertex counts unless it is strict; `mark` makes those strict that still need a cut.
double find_shares(const SheetGraph& graph, const std::vector<double>& content, const std::vector<double>& room,
                   const std::vector<double>& transfer, bool mark, std::vector<std::uint8_t>& strict,
                   std::vector<double>& keep_out, std::vector<double>& keep_in) {
  return parallel_max(content.size(), chunk, 0.0, [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      double out = 0.0, in = 0.0;
      for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
        const double amount = outward(graph, transfer, i, k);
        (amount > 0.0 ? out : in) += std::abs(amount);
      }
      const double giving = content[i] + (strict[i] == 0 ? in : 0.0);
      keep_out[i] = out > giving ? giving / out : 1.0;
      const double taking = room.empty() ? in : room[i] + (strict[i] == 0 ? out : 0.0);
      keep_in[i] = in > taking ? taking / in : 1.0;
      const double missing = 1.0 - std::min(keep_out[i], keep_in[i]);
      if (mark && missing > rounding) strict[i] = 1;
      worst = std::max(worst, missing);
    }
    return worst;
  });
}

}  // namespace

double net_outflow(const SheetGraph& graph, const std::vector<double>& transfer, std::size_t i) {
  double sum = 0.0;
  for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) sum += outward(graph, transfer, i, k);
  return sum;
}

void limit_transfers(const SheetGraph& graph, const std::vector<double>& content, const std::vector<double>& room,
                     std::vector<double>& transfer) {
  // Most steps need none or one. Long chains of full or empty vertices settle slowly: from some pass on, vertices
  // that still need a cut are limited by content and room alone; in the last, all are, which always suffices.
  constexpr int passes = 60, marking = 12;
  std::vector<double> keep_out(content.size()), keep_in(content.size());
  std::vector<std::uint8_t> strict(content.size(), 0);
  for (int pass = 0; pass <= passes; ++pass) {
    if (pass == passes) std::fill(strict.begin(), strict.end(), 1);
    if (find_shares(graph, content, room, transfer, pass >= marking, strict, keep_out, keep_in) <= rounding) return;
    for_each_edge(graph, [&](std::size_t i, std::size_t j, std::size_t e) {
      const bool up = transfer[e] > 0.0;
      transfer[e] *= std::min(keep_out[up ? i : j], keep_in[up ? j : i]);
    });
  }
}

}  // namespace wick::diffusion
