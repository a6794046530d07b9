#pragma once
/// Amounts that cross the edges of a sheet: what leaves one vertex enters another, so that sums are kept exactly,
/// and limits under which no vertex gives more than it holds or takes more than fits.
#include <vector>

#include "diffusion/operators.h"

namespace wick::diffusion {

/// What a model that moves amounts along edges is given; all amounts are those of the whole step [M units].
struct TransferInput {
  const solid::ShellMesh* mesh = nullptr;
  const SheetGraph* graph = nullptr;
  const std::vector<Vec3>* x = nullptr;
  const std::vector<double>* rest_scale = nullptr;    ///< per triangle; null: 1
  const std::vector<double>* mass = nullptr;          ///< M_i
  const std::vector<double>* loss = nullptr;          ///< dt K_i
  const std::vector<double>* supply = nullptr;        ///< dt k_i
  const std::vector<double>* supply_value = nullptr;  ///< u_src,i; null where there is no supply
  double capacity = 0.0;                              ///< 0: none
  Vec3 gravity = Vec3::Zero();
  double dt = 0.0;
};

struct TransferResult {
  std::vector<double> given;  ///< by the supply to each vertex
  double lost = 0.0;
  int substeps = 0;
  SolveReport solve;
};

/// Calls body(i, j, edge) once for each edge, i < j.
template <class Body>
void for_each_edge(const SheetGraph& graph, Body&& body) {
  parallel_for(graph.offset.size() - 1, chunk, [&](std::size_t i) {
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(graph.column[k]);
      if (j > i) body(i, j, static_cast<std::size_t>(graph.entry_edge[k]));
    }
  });
}

/// Transfers are net amounts per edge, positive from the vertex of lower number to the other. Sum of those that
/// leave vertex i, minus those that enter.
double net_outflow(const SheetGraph& graph, const std::vector<double>& transfer, std::size_t i);

/// Scales transfers down until each vertex gives at most content + what enters, and takes at most room + what
/// leaves (empty `room`: no limit). Like [Zalesak 1979], but what passes through counts, in repeated passes; where
/// these do not settle, content and room alone limit a vertex. content, room >= 0.
void limit_transfers(const SheetGraph& graph, const std::vector<double>& content, const std::vector<double>& room,
                     std::vector<double>& transfer);

}  // namespace wick::diffusion
