#pragma once
/// What one solver keeps between and within steps; its members are the lines of the paper's list
/// [Kim & Lee 2017, Eqs (8a)-(8g)].
#include "diffusion/edge_transfers.h"
#include "diffusion/linear_solver.h"
#include "diffusion/neighbourhood.h"
#include "diffusion/operators.h"
#include "diffusion/redistribution.h"
#include "diffusion/strain_diffusion.h"

namespace wick::diffusion {

using Values = std::vector<double>;

/// Value of an optional span.
inline double at(const Values* values, std::size_t i, double otherwise = 0.0) {
  return values == nullptr ? otherwise : (*values)[i];
}

struct DiffusionSolver::Impl {
  DiffusionParams params;
  // One topology: its triangles and rest shape tell whether it is still the same.
  std::vector<Int3> triangles;
  std::vector<Vec3> rest;
  SheetGraph graph;
  Values rest_corner;
  SheetOperator reference;
  std::unique_ptr<Neighbourhood> neighbourhood;  ///< made when a local scope first asks for it
  LinearSolver solver;
  // Scratch of one step.
  Values spread_u, corner, extra, edge_factor, rhs, unit_weight;
  SheetOperator op;
  SheetMatrix matrix;
  Values loss, supply, amount, given;   ///< dt K_loss, dt K_supply, f [M units], and what each vertex got
  Values c, c_front, strain;            ///< C, its part on the front, S per triangle
  Values front;                         ///< how far each vertex belongs to it
  Values toll;                          ///< share of u paid for C within the solve; empty: nothing is
  std::vector<std::uint8_t> misjudged;  ///< where this step is too long for the exchange; empty: nowhere
  bool strained = false;                ///< there is C to add
  bool exchanging = false;              ///< C and toll go through the solve of this step

  explicit Impl(const DiffusionParams& p) : params(p) {}

  OperatorChoice choice(bool clamp) const { return {params.discretisation, params.umbrella_factor, clamp}; }

  void follow_topology(const solid::ShellMesh& mesh);
  void build_edges(const DiffusionInput& in, const OperatorChoice& wanted);
  void build_matrix(const DiffusionInput& in, double dt);
  void book_external(const Values& u, const DiffusionInput& in, double dt, DiffusionReport& report);
  void spread(const Values& u, const DiffusionInput& in, double dt, Values& u_star, DiffusionReport& report);
  void diffuse(const Values& u, const DiffusionInput& in, double dt, Values& u_star, DiffusionReport& report);
  void transfer(const DiffusionInput& in, double dt, Values& u_star, DiffusionReport& report);
  void sharpen(const Values& u);
  void close_budget(const Values& u, const DiffusionInput& in, Values& u_star, DiffusionReport& report);
  void close_supplied(std::span<const std::int32_t> members, const Values& u, const Values& mass,
                      const Values& u_star);
  bool find_strain(const DiffusionInput& in, double dt);
  void mask_strain(const DiffusionInput& in, const Values& u);
  Kernel make_kernel(const DiffusionInput& in);
  Values toll_for(const DiffusionInput& in, const Values& u, const Values& added, const Kernel& kernel) const;
  void pay(const DiffusionInput& in, Values& open, const Kernel& kernel, Values& held) const;
  bool plan_exchange(const DiffusionInput& in, const Values& u);
  Values without_exchange(const DiffusionInput& in, const Values& u, const Values& v) const;
  bool find_misjudged(const Values& mass, const Values& budget, const Values& u);
  void take_as_printed(const DiffusionInput& in, const Values& v, Values& u);
  bool settle_exchange(const DiffusionInput& in, double dt, Values& v, Values& u, DiffusionReport& report);
  void redistribute(const DiffusionInput& in, double dt, const Values& u_star, Values& u, DiffusionReport& report);
  void settle_total(const DiffusionInput& in, double dt, const Values& u_star, Values& u, DiffusionReport& report);
  std::size_t count_front(const DiffusionInput& in) const;

  /// Storage per unit of M: 1 for cotan, whose storage is M itself.
  double unit(const Values& mass, std::size_t i) const { return mass[i] > 0.0 ? matrix.storage[i] / mass[i] : 0.0; }

  /// Adds up the work of all sweeps; residuals are those of the last.
  static void note(DiffusionReport& report, const SolveReport& solve) {
    report.solve.iterations += solve.iterations;
    report.solve.converged = report.solve.converged && solve.converged;
    report.solve.seconds += solve.seconds;
    report.solve.residual_before = solve.residual_before;
    report.solve.residual_after = solve.residual_after;
    report.solve.rhs_sum = solve.rhs_sum;
  }
};

}  // namespace wick::diffusion
