#pragma once
/// Transfers between neighbours by saturation differences and gravity, out of vertices above a threshold
/// [Patkar 2013]:
///
///   dm_i→j = dt [k_d max(0, u_i - u_j) + k'_d u_i max(0, c_ij)] M_i/n_i    where u_i > t_diff
///   c_ij   = cosine between x_j - x_i and gravity, n_i = neighbours of i
///
/// A vertex passes on only what it holds above t_diff. A supply gives the share α of what it would give by itself,
/// while it is more than t_absorb above u and the vertex is below the capacity; drying is not slowed. What is
/// given explicitly is taken whole. No length enters: the result depends on the mesh, as the source's does.
#include "diffusion/edge_transfers.h"

namespace wick::diffusion {

/// Advances u by input.dt, in substeps that move at most a tenth of what a vertex holds. Steps that would need
/// more than 20,000 of them transport less than asked and report so (solve.converged).
TransferResult transport_by_gravity(const GravityTransportParams& params, const TransferInput& input,
                                    std::vector<double>& u);

}  // namespace wick::diffusion
