#pragma once
/// Discrete Laplacians of a triangle sheet as symmetric edge weights, and the matrix of one implicit step.
///
///   s_i u*_i + dt α Σ_j w_ij (u*_i - u*_j) + dt k_i u*_i = s_i u_i + ...
///
///   cotan     w_ij = ρ (cot a_ij + cot b_ij)/2,  s_i = M_i              conserves Σ M u, O(h²)
///   umbrella  w_ij = 2 f/|d_ij|,                 s_i = E_i = Σ_j |d_ij|  [Kim 2017, Eq 3] times E_i: conserves Σ E
///   u graph       w_ij = 4/h²,                       s_i = valence           conserves Σ n u
#include <array>
#include <cstdint>
#include <vector>

#include "diffusion/strain_diffusion.h"
#include "diffusion/sums.h"
#include "solid/shell_mesh.h"

namespace wick::diffusion {

/// Adjacency of one topology in compressed rows, without the diagonal.
struct SheetGraph {
  std::vector<std::int32_t> offset;      ///< V+1
  std::vector<std::int32_t> column;      ///< neighbour, ascending within a row
  std::vector<std::int32_t> entry_edge;  ///< edge of each entry: where its value comes from
  std::vector<std::array<std::int32_t, 2>>
      corner;               ///< per edge: 3 triangle + corner opposite to it; -1 on the border
  VertexGroups components;  ///< vertices of triangles
  VertexGroups whole;       ///< the same, as one group
};
SheetGraph build_graph(const solid::ShellMesh& mesh);

/// Half cotangent of each triangle corner (3 per triangle) in the shape `x`, times rest area over current
/// area: a stretched sheet holds the same amount on a longer way, so stretch q divides the rate by q².
std::vector<double> corner_cotangents(const solid::ShellMesh& mesh, const std::vector<Vec3>& x);

/// The same for the tensor D = I + gain (U - I), U = √(FᵀF) the right stretch of the triangle in shape x: entry k
/// is -A g_i·D g_j with g the gradients of the hat functions at the two other corners [m²/m²]. For gain 0 or a
/// rigid shape these are the half cotangents. D is cut to principal values in [1e-3, 1e3].
std::vector<double> tensor_corners(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, double gain);

/// Symmetric weights w per edge and storage s per vertex of one operator.
struct SheetOperator {
  std::vector<double> edge;
  std::vector<double> storage;
  std::vector<double> scratch;  ///< kept between fillings
};

/// What an operator is made from besides the graph.
struct OperatorChoice {
  Operator kind = Operator::cotan;
  double umbrella_factor = 2.0;
  bool clamp = true;  ///< cotan weights below 0 become 0
};

/// Fills `result` for the shape x. Cotan takes `corner` (of the same shape) and the amount M per vertex:
/// a triangle conducts with the harmonic mean of M_i/A_i of its corners, nothing where one is 0.
void build_operator(const solid::ShellMesh& mesh, const SheetGraph& graph, const OperatorChoice& choice,
                    const std::vector<Vec3>& x, const std::vector<double>& corner, const std::vector<double>& mass,
                    SheetOperator& result);

/// A = diag(row_sum) + diffusion * Laplacian. Rows without storage stand alone.
struct SheetMatrix {
  const SheetGraph* graph = nullptr;
  const SheetOperator* reference = nullptr;  ///< unit-density operator of the rest shape, for the frozen factor
  double diffusion = 0.0;                    ///< dt α
  std::vector<double> storage;               ///< s_i, next to nothing where the vertex holds nothing
  std::vector<double> row_sum;               ///< s_i + dt k_i
  std::vector<double> diagonal;              ///< V
  std::vector<double> entry;                 ///< off-diagonal values in the order of graph.column
};

/// Writes the values in place; `extra` is dt k_i per vertex in the units of the storage (empty: 0), `factor` an
/// optional multiplier per edge (empty: 1).
void assemble(const SheetGraph& graph, const SheetOperator& op, double diffusion, const std::vector<double>& extra,
              const std::vector<double>& factor, SheetMatrix& matrix);

/// Σ_j w_ij (u_i - u_j) of row i, times the matrix's diffusion: its difference form, exact for constants.
double diffusive_outflow(const SheetMatrix& matrix, const std::vector<double>& u, std::size_t i);

}  // namespace wick::diffusion
