#include "diffusion/strain_diffusion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/require.h"
#include "diffusion/input_check.h"
#include "diffusion/linear_solver.h"
#include "diffusion/operators.h"
#include "diffusion/redistribution.h"
#include "diffusion/strain.h"

namespace wick::diffusion {

namespace {

using Values = std::vector<double>;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Value of an optional span.
double at(const Values* values, std::size_t i, double otherwise = 0.0) {
  return values == nullptr ? otherwise : (*values)[i];
}

/// Whether a model adds C; the others only report it.
bool adds_strain(Model model) {
  return model == Model::strain_constrained || model == Model::strain_unconstrained || model == Model::noise ||
         model == Model::strain_noise;
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

struct DiffusionSolver::Impl {
  DiffusionParams params;
  // One topology: its triangles and rest shape tell whether it is still the same.
  std::vector<Int3> triangles;
  std::vector<Vec3> rest;
  SheetGraph graph;
  Values rest_corner;
  SheetOperator reference, kernel_reference;
  LinearSolver solver, kernel_solver;
  // Scratch of one step.
  Values corner, extra, edge_factor, rhs, unit_weight;
  SheetOperator op, kernel_op;
  SheetMatrix matrix, kernel_matrix;
  Values loss, supply, amount, given;  ///< dt K_loss, dt K_supply, f [M units], and what each vertex got
  Values c, c_front, strain;

  explicit Impl(const DiffusionParams& p) : params(p) {}

  OperatorChoice choice(bool clamp) const { return {params.discretisation, params.umbrella_factor, clamp}; }

  void follow_topology(const solid::ShellMesh& mesh);
  void build_matrix(const DiffusionInput& in, double dt);
  void book_external(const Values& u, const DiffusionInput& in, double dt, DiffusionReport& report);
  void diffuse(const Values& u, const DiffusionInput& in, double dt, Values& u_star, DiffusionReport& report);
  void sharpen(const Values& u);
  void close_budget(const Values& u, const DiffusionInput& in, Values& u_star, DiffusionReport& report);
  void close_supplied(std::span<const std::int32_t> members, const Values& u, const Values& mass,
                      const Values& u_star);
  void add_strain(const DiffusionInput& in, double dt, const Values& u_star, DiffusionReport& report);
  void redistribute(const DiffusionInput& in, double dt, const Values& u_star, Values& u, DiffusionReport& report);
  void add_everywhere(const DiffusionInput& in, const Values& u_star, Values& u, DiffusionReport& report);
  Kernel make_kernel(const DiffusionInput& in, DiffusionReport& report);

  /// C is a small part of u, and the totals are made exact afterwards: two digits less are enough.
  double increment_tolerance() const { return 100.0 * params.tolerance; }

  /// Storage per unit of M: 1 for cotan, whose storage is M itself.
  double unit(const Values& mass, std::size_t i) const { return mass[i] > 0.0 ? matrix.storage[i] / mass[i] : 0.0; }

  /// Adds up the work of all solves; residuals are those of Eq (8a).
  static void note(DiffusionReport& report, const SolveReport& solve, bool increment) {
    report.solve.iterations += solve.iterations;
    report.solve.converged = report.solve.converged && solve.converged;
    report.solve.seconds += solve.seconds;
    if (increment) return;
    report.solve.residual_before = solve.residual_before;
    report.solve.residual_after = solve.residual_after;
    report.solve.rhs_sum = solve.rhs_sum;
  }
};

/// Rebuilds what depends on the triangles or on the rest shape, only when they have changed.
void DiffusionSolver::Impl::follow_topology(const solid::ShellMesh& mesh) {
  if (same_bytes(triangles, mesh.triangles) && same_bytes(rest, mesh.rest) && !graph.offset.empty()) return;
  triangles = mesh.triangles;
  rest = mesh.rest;
  graph = build_graph(mesh);
  rest_corner = corner_cotangents(mesh, mesh.rest);
  build_operator(mesh, graph, choice(true), mesh.rest, rest_corner, mesh.vertex_area, reference);
  build_operator(mesh, graph, {}, mesh.rest, rest_corner, mesh.vertex_area, kernel_reference);
  solver.reset();
  kernel_solver.reset();
}

/// Limits what is given and taken from outside to what is meaningful, and keeps it per vertex.
void DiffusionSolver::Impl::book_external(const Values& u, const DiffusionInput& in, double dt,
                                          DiffusionReport& report) {
  const Values& mass = *in.mass;
  const std::size_t n = u.size();
  for (Values* field : {&loss, &supply, &amount, &given}) field->assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const double f = at(in.amount, i);
    if (mass[i] <= 0.0) {
      // A vertex that holds nothing refuses what it is given.
      given[i] = std::max(f, 0.0);
      report.excess += std::max(f, 0.0);
      continue;
    }
    amount[i] = std::max(f, -mass[i] * u[i]);  // no more can be taken than there is
    loss[i] = dt * at(in.loss, i);
    supply[i] = dt * at(in.supply_rate, i);
  }
}

/// A = S + dt α L + S/M dt (K_loss + K_supply), in place.
void DiffusionSolver::Impl::build_matrix(const DiffusionInput& in, double dt) {
  const solid::ShellMesh& mesh = *in.mesh;
  const Values& mass = *in.mass;
  const bool current = params.metric == Metric::current;
  if (params.model == Model::tensor) {
    corner = tensor_corners(mesh, *in.x, params.tensor_gain);
    build_operator(mesh, graph, {Operator::cotan, 1.0, params.clamp_weights}, mesh.rest, corner, mass, op);
  } else {
    if (current && params.discretisation == Operator::cotan) corner = corner_cotangents(mesh, *in.x);
    build_operator(mesh, graph, choice(params.clamp_weights), current ? *in.x : mesh.rest,
                   current ? corner : rest_corner, mass, op);
  }
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (op.storage[i] == 0.0) op.storage[i] = mass[i];

  // Rates so stiff that they fix the value to ten digits are as good as infinite; more would only cost digits.
  constexpr double stiffest = 1e10;
  extra.assign(mass.size(), 0.0);
  parallel_for(mass.size(), chunk, [&](std::size_t i) {
    if (mass[i] <= 0.0 || (loss[i] == 0.0 && supply[i] == 0.0)) return;
    const double q = op.storage[i] / mass[i];
    double row = op.storage[i];
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k)
      row += dt * params.alpha * std::abs(op.edge[graph.entry_edge[k]]);
    loss[i] = std::min(loss[i], stiffest * row / q);
    supply[i] = std::min(supply[i], stiffest * row / q);
    extra[i] = q * (loss[i] + supply[i]);
  });
}

/// Flux div((m+1) u^m grad u) = Laplacian of u^(m+1): on an edge its coefficient is the exact difference quotient.
void DiffusionSolver::Impl::sharpen(const Values& u) {
  edge_factor.resize(graph.corner.size());
  parallel_for(u.size(), chunk, [&](std::size_t i) {
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(graph.column[k]);
      if (j < i) continue;
      const double a = std::max(u[i], 0.0), b = std::max(u[j], 0.0);
      double quotient = 0.0, power = 1.0;
      for (int p = 0; p <= params.sharpness; ++p, power *= b) quotient = quotient * a + power;
      edge_factor[graph.entry_edge[k]] = quotient;
    }
  });
}

/// Eq (8a): the implicit step with supply and loss; u_star enters as the guess.
void DiffusionSolver::Impl::diffuse(const Values& u, const DiffusionInput& in, double dt, Values& u_star,
                                    DiffusionReport& report) {
  const Values& mass = *in.mass;
  const bool sharp = params.sharpness > 0;
  build_matrix(in, dt);

  // Guess: where supply is stiff, what it imposes on the vertex alone.
  parallel_for(u.size(), chunk, [&](std::size_t i) {
    if (mass[i] > 0.0)
      u_star[i] = (mass[i] * u[i] + amount[i] + supply[i] * at(in.supply_value, i)) / (mass[i] + supply[i]);
  });
  rhs.resize(u.size());
  matrix.reference = sharp ? nullptr : &reference;
  for (int sweep = 0; sweep < (sharp ? params.picard : 1); ++sweep) {
    if (sharp) sharpen(u_star);
    assemble(graph, op, dt * params.alpha, extra, edge_factor, matrix);
    parallel_for(u.size(), chunk, [&](std::size_t i) {
      rhs[i] = matrix.storage[i] * u[i] + unit(mass, i) * (amount[i] + supply[i] * at(in.supply_value, i));
    });
    note(report, solver.solve(matrix, rhs, params.tolerance, u_star), false);
  }
  close_budget(u, in, u_star, report);
}

/// Makes the budget of each component exact: without supply by a factor that differs from 1 by the solver's
/// residual, with supply by what the supply has given.
void DiffusionSolver::Impl::close_budget(const Values& u, const DiffusionInput& in, Values& u_star,
                                         DiffusionReport& report) {
  const Values& mass = *in.mass;
  parallel_for(u_star.size(), chunk, [&](std::size_t i) { u_star[i] = std::max(u_star[i], 0.0); });
  for (std::size_t g = 0; g < graph.components.count(); ++g) {
    const auto members = graph.components[g];
    const double supplied =
        in.supply_rate == nullptr ? 0.0 : sum_over(members, [&](std::size_t i) { return supply[i]; });
    if (supplied > 0.0) {
      close_supplied(members, u, mass, u_star);
      continue;
    }
    const double wanted = sum_over(members, [&](std::size_t i) { return rhs[i]; });
    const double held = sum_over(members, [&](std::size_t i) { return matrix.row_sum[i] * u_star[i]; });
    const double factor = held > 1e-280 ? std::max(wanted, 0.0) / held : 1.0;
    parallel_for(members.size(), chunk, [&](std::size_t k) { u_star[members[k]] *= factor; });
  }

  // A vertex that holds nothing keeps its value.
  for (std::size_t i = 0; i < u.size(); ++i)
    if (op.storage[i] == 0.0) u_star[i] = u[i];

  // Vertices of no triangle stand alone: what their supply gave is plain.
  for (std::size_t i = 0; i < u.size(); ++i) {
    if (in.mesh->component[i] < 0 && mass[i] > 0.0)
      given[i] = mass[i] * u_star[i] + loss[i] * u_star[i] - mass[i] * u[i] - amount[i];
    if (mass[i] > 0.0) given[i] += amount[i];
  }
  report.lost = sum_of(u.size(), [&](std::size_t i) { return loss[i] * u_star[i]; });
  report.supplied = sum_of(u.size(), [&](std::size_t i) { return given[i]; });
}

/// What the supply gave each vertex: its balance of storage, loss and diffusion. The solver's residual elsewhere is
/// shared out in proportion to the supply rates, so that the sum is exact.
void DiffusionSolver::Impl::close_supplied(std::span<const std::int32_t> members, const Values& u,
                                           const Values& mass, const Values& u_star) {
  CompensatedSum gained, found, rates;
  for (const std::int32_t i : members) {
    const double q = unit(mass, i);
    const double balance = matrix.storage[i] * (u_star[i] - u[i]) + q * (loss[i] * u_star[i] - amount[i]);
    gained.add(balance);
    if (supply[i] == 0.0 || q == 0.0) continue;
    const double outflow = diffusive_outflow(matrix, u_star, static_cast<std::size_t>(i));
    given[i] = (balance + outflow) / q;
    found.add(balance + outflow);
    rates.add(q * supply[i]);
  }
  const double missing = gained.value() - found.value();
  for (const std::int32_t i : members) given[i] += missing * supply[i] / rates.value();
}

/// C of each vertex, through the same solve when the order asks for it.
void DiffusionSolver::Impl::add_strain(const DiffusionInput& in, double dt, const Values& u_star,
                                       DiffusionReport& report) {
  triangle_strain(params, *in.mesh, *in.x, in.rest_scale, strain);
  vertex_strain(params, *in.mesh, strain, dt, c);
  apply_noise(params, *in.mesh, dt, c);
  c_front.assign(c.size(), 0.0);
  const bool any = std::any_of(c.begin(), c.end(), [](double value) { return value > 0.0; });
  if (!adds_strain(params.model) || !any) return;
  c_front = c;
  if (params.order == Order::inside) {
    parallel_for(c.size(), chunk, [&](std::size_t i) { rhs[i] = matrix.storage[i] * c[i]; });
    note(report, solver.solve(matrix, rhs, increment_tolerance(), c_front), true);
    parallel_for(c.size(), chunk, [&](std::size_t i) { c_front[i] = std::max(c_front[i], 0.0); });
  }
  for (std::size_t i = 0; i < c.size(); ++i)
    if ((*in.mass)[i] <= 0.0 || u_star[i] < 0.0) c_front[i] = 0.0;
}

/// K = (M + R² L)^-1 on the rest shape.
Kernel DiffusionSolver::Impl::make_kernel(const DiffusionInput& in, DiffusionReport& report) {
  build_operator(*in.mesh, graph, {}, in.mesh->rest, rest_corner, *in.mass, kernel_op);
  assemble(graph, kernel_op, params.scope_radius * params.scope_radius, {}, {}, kernel_matrix);
  kernel_matrix.reference = &kernel_reference;
  kernel_matrix.constant = true;
  return [this, &report](const Values& right) {
    Values result(right.size(), 0.0);
    note(report, kernel_solver.solve(kernel_matrix, right, increment_tolerance(), result), true);
    for (double& value : result) value = std::max(value, 0.0);
    return result;
  };
}

/// Eq (7): C everywhere, no front, no rescaling.
void DiffusionSolver::Impl::add_everywhere(const DiffusionInput& in, const Values& u_star, Values& u,
                                           DiffusionReport& report) {
  const Values& mass = *in.mass;
  report.strain_added = sum_of(u.size(), [&](std::size_t i) { return mass[i] * c_front[i]; });
  report.sigma_source += report.strain_added;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = u_star[i] + c_front[i];
}

/// Eqs (8b)-(8g).
void DiffusionSolver::Impl::redistribute(const DiffusionInput& in, double dt, const Values& u_star, Values& u,
                                         DiffusionReport& report) {
  const Values& mass = *in.mass;
  const std::size_t n = u.size();
  const bool plain = params.total == Total::plain;
  const std::vector<std::uint8_t> front = front_band(params, u_star, in.fraction_left);
  for (std::size_t i = 0; i < n; ++i) {
    if (front[i] == 0)
      c_front[i] = 0.0;
    else if (mass[i] > 0.0)
      ++report.front_vertices;
    u[i] = u_star[i] + c_front[i];
  }
  report.strain_added = sum_of(n, [&](std::size_t i) { return mass[i] * c_front[i]; });
  Values supplied = given;
  if (plain) {
    unit_weight.assign(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
      if (mass[i] > 0.0) unit_weight[i] = 1.0, supplied[i] /= mass[i];
  }
  const RescaleInput input{.components = &graph.components,
                           .whole = &graph.whole,
                           .mass = &mass,
                           .weight = plain ? &unit_weight : &mass,
                           .u_star = &u_star,
                           .c = &c_front,
                           .front = &front,
                           .supply = &supplied,
                           .capacity = in.capacity,
                           .dt = dt};
  const bool local = params.scope == Scope::local || params.scope == Scope::local_front;
  const RescaleResult result = rescale(params, input, local ? make_kernel(in, report) : Kernel(), u);
  report.rescale = result.rescale;
  if (!plain) {
    report.excess += result.excess;
    report.sigma_source += result.created;
    return;
  }

  // The plain sum says nothing about amounts: book what it has changed.
  const double held = sum_of(n, [&](std::size_t i) { return mass[i]; });
  const double count = sum_of(n, [&](std::size_t i) { return unit_weight[i]; });
  const double excess = count > 0.0 ? result.excess * held / count : 0.0;
  const double change = sum_of(n, [&](std::size_t i) { return mass[i] * (u[i] - u_star[i]); });
  report.excess += excess;
  report.sigma_source += change + excess;
  report.drift += change + excess;
}

DiffusionSolver::DiffusionSolver(const DiffusionParams& params) : impl_(std::make_unique<Impl>(params)) {
  require(params.u_min > 0.0 && params.u_min < params.u_max, "/diffusion/u_min",
          "u_min must lie between 0 and u_max (at 0 dry vertices would count as front) raise it or u_max");
}
DiffusionSolver::~DiffusionSolver() = default;
DiffusionSolver::DiffusionSolver(DiffusionSolver&&) noexcept = default;
DiffusionSolver& DiffusionSolver::operator=(DiffusionSolver&&) noexcept = default;

DiffusionReport DiffusionSolver::step(std::vector<double>& u, const DiffusionInput& input, double dt) {
  require_input(u, input, dt);
  Impl& s = *impl_;
  const Values& mass = *input.mass;
  const auto amount_of = [&](const Values& w) {
    return sum_of(w.size(), [&](std::size_t i) { return mass[i] * w[i]; });
  };
  DiffusionReport report;
  for (double& value : u) value = std::max(value, 0.0);
  report.before = amount_of(u);
  s.follow_topology(*input.mesh);

  // (8a) supply and diffusion.
  const auto start = Clock::now();
  s.book_external(u, input, dt, report);
  const double refused = report.excess;
  Values u_star = u;
  s.diffuse(u, input, dt, u_star, report);
  if (s.params.discretisation != Operator::cotan)
    report.drift = amount_of(u_star) - (report.before + report.supplied - refused - report.lost);
  report.sigma_source = report.drift;
  report.seconds_solve = seconds_since(start);

  // (8b)-(8g) strain on the front, rescaled to the total.
  const auto middle = Clock::now();
  s.add_strain(input, dt, u_star, report);
  if (s.params.model == Model::strain_unconstrained)
    s.add_everywhere(input, u_star, u, report);
  else
    s.redistribute(input, dt, u_star, u, report);

  // Cut what no projection has seen: Eq (7), and vertices of no triangle.
  if (input.capacity > 0.0)
    for (std::size_t i = 0; i < u.size(); ++i)
      if (u[i] > input.capacity) report.excess += mass[i] * (u[i] - input.capacity), u[i] = input.capacity;
  report.after = amount_of(u);
  report.seconds_strain = seconds_since(middle);
  if (!std::isfinite(report.after))
    throw Refusal(ExitCode::numerical_failure, "/diffusion/sigma",
                  "the total of u overflowed (sigma creates too much) reduce sigma or the run");
  return report;
}

const std::vector<double>& DiffusionSolver::strain_vertex() const {
  return impl_->c;
}
const std::vector<double>& DiffusionSolver::strain_triangle() const {
  return impl_->strain;
}
const std::vector<double>& DiffusionSolver::supplied_vertex() const {
  return impl_->given;
}

}  // namespace wick::diffusion
