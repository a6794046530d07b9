#pragma once
/// Capillary flow through the pores of a sheet: the porous bodies of [Lenaerts 2008] on a surface, vertices as
/// control volumes.
///
///   Ψ_i  = k_p s_i max(0, J_i^-β - 1) - k_c (1 - s_i + ε)^a - ρ g·x_i
///   J_ij = K/(φ0 μ) kr(s_up) w_ij (Ψ_i - Ψ_j),   kr = s^n at the vertex with the larger Ψ
///   M_i du_i/dt = -Σ_j J_ij + supply - loss
///
/// w_ij are clamped cotan weights times what an area holds (M_i over area), so thickness is in them. J is the
/// dilation in the plane; pores of the rest volume φ0 change with it to φ J, φ = 1 - (1-φ0)/J, so s = u/(φ J/φ0)
/// and squeezing raises s. Beyond s = 1 the potential goes on along its tangent: what is too much flows on.
#include "diffusion/edge_transfers.h"
#include "diffusion/linear_solver.h"

namespace wick::diffusion {

/// Ψ of one vertex as a function of its saturation, convex and increasing for a <= 1.
class Retention {
 public:
  explicit Retention(const PorousParams& params);
  /// `stiffness` = k_p max(0, J^-β - 1), `lift` = -ρ g·x.
  [[nodiscard]] double potential(double s, double stiffness, double lift) const;
  /// ds/dΨ.
  [[nodiscard]] double storage(double s, double stiffness) const;
  /// Saturation at potential `psi`, below 0 and above 1 along the tangents.
  [[nodiscard]] double saturation(double psi, double stiffness, double lift) const;

 private:
  double suction_, exponent_, epsilon_;
  double dry_, full_, dry_slope_, full_slope_;  ///< (1+ε)^a, ε^a and the slopes of k_c (1-s+ε)^a there
};

/// J per vertex, area-weighted over its triangles; 1 for vertices of none.
std::vector<double> vertex_dilation(const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                                    const std::vector<double>* rest_scale);

/// Pore pressure k_p s max(0, J^-β - 1) of every vertex [Pa].
std::vector<double> pore_pressure(const PorousParams& params, const solid::ShellMesh& mesh,
                                  const std::vector<Vec3>& x, const std::vector<double>* rest_scale,
                                  const std::vector<double>& u);

/// Advances u by input.dt: implicit, modified Picard in mixed form [Celia 1990], whose matrix is symmetric in Ψ;
/// amounts then cross the edges as the last iteration says, limited by contents and capacity. Where Picard does
/// not converge the step is halved, down to dt/256; such steps are taken as they are, limited, and reported
/// (solve.converged). `edges` holds the weights w, `tolerance` that of linear diffusion: the imbalance
/// that Picard may leave is 100 times that, as u; the residuals reported are those of the last substep.
TransferResult flow_through_pores(const PorousParams& params, const TransferInput& input,
                                  const SheetOperator& edges, double tolerance, LinearSolver& solver,
                                  std::vector<double>& u);

}  // namespace wick::diffusion
