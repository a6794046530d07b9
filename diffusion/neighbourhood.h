#pragma once
/// Averages over the neighbourhood of every vertex of a sheet, cheaply: what the local scopes of the rescaling ask
/// for.
///
///   K ≈ (A + R² L)^-1,   A areas and L the cotan Laplacian of the rest shape
///
/// is smooth over R, so it is solved for on patches half of R apart: K = P (Pᵀ (A + R² L) P)^-1 Pᵀ, with P the
/// patches' hats, which sum to 1 at each vertex [Shepard 1968]. They are laid out by place, not by vertex, so that
/// K converges as the mesh is refined. K is symmetric and keeps constants, K A 1 = 1, whatever the patches: amounts
/// that are moved with it are kept exactly. The factor lasts as long as the topology.
#include <memory>
#include <vector>

#include "diffusion/operators.h"

namespace wick::diffusion {

class Neighbourhood {
 public:
  /// `op` is the operator of the rest shape with unit density. Vertices without area belong to no patch.
  Neighbourhood(const solid::ShellMesh& mesh, const SheetGraph& graph, const SheetOperator& op, double radius);
  ~Neighbourhood();
  Neighbourhood(const Neighbourhood&) = delete;
  Neighbourhood& operator=(const Neighbourhood&) = delete;

  /// K rhs (V); 0 at vertices of no patch.
  [[nodiscard]] std::vector<double> average(const std::vector<double>& rhs) const;
  [[nodiscard]] std::size_t patches() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::diffusion
