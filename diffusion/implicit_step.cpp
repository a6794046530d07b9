/// Eq (8a) [Kim & Lee 2017]: supply, loss and diffusion in one implicit step, with a closed budget.
#include <algorithm>
#include <cmath>

#include "diffusion/strain_diffusion_impl.h"

namespace wick::diffusion {

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

/// Edge weights and storage of the sheet in the metric that is asked for.
void DiffusionSolver::Impl::build_edges(const DiffusionInput& in, const OperatorChoice& wanted) {
  const solid::ShellMesh& mesh = *in.mesh;
  const bool current = params.metric == Metric::current;
  if (current && wanted.kind == Operator::cotan) corner = corner_cotangents(mesh, *in.x);
  build_operator(mesh, graph, wanted, current ? *in.x : mesh.rest, current ? corner : rest_corner, *in.mass, op);
}

/// A = S + dt α L + S/M dt (K_loss + K_supply) + S toll, in place.
void DiffusionSolver::Impl::build_matrix(const DiffusionInput& in, double dt) {
  const Values& mass = *in.mass;
  if (params.model == Model::tensor) {
    corner = tensor_corners(*in.mesh, *in.x, params.tensor_gain);
    build_operator(*in.mesh, graph, {Operator::cotan, 1.0, params.clamp_weights}, in.mesh->rest, corner, mass, op);
  } else {
    build_edges(in, choice(params.clamp_weights));
  }
  for (std::size_t i = 0; i < mass.size(); ++i)
    if (op.storage[i] == 0.0) op.storage[i] = mass[i];

  // Rates so stiff that they fix the value to ten digits are as good as infinite; more would only cost digits.
  constexpr double stiffest = 1e10;
  extra.assign(mass.size(), 0.0);
  parallel_for(mass.size(), chunk, [&](std::size_t i) {
    if (mass[i] <= 0.0) return;
    if (exchanging && !toll.empty()) extra[i] = op.storage[i] * toll[i];
    if (loss[i] == 0.0 && supply[i] == 0.0) return;
    const double q = op.storage[i] / mass[i];
    double row = op.storage[i];
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k)
      row += dt * params.alpha * std::abs(op.edge[graph.entry_edge[k]]);
    loss[i] = std::min(loss[i], stiffest * row / q);
    supply[i] = std::min(supply[i], stiffest * row / q);
    extra[i] += q * (loss[i] + supply[i]);
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

/// Eq (8a), the implicit step with supply and loss, and C with its toll where they go through it; u_star enters as
/// the guess.
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
      const double gain = exchanging ? c_front[i] : 0.0;
      rhs[i] = matrix.storage[i] * (u[i] + gain) + unit(mass, i) * (amount[i] + supply[i] * at(in.supply_value, i));
    });
    note(report, solver.solve(matrix, rhs, params.tolerance, u_star));
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
    const double gain = exchanging ? c_front[i] - (toll.empty() ? 0.0 : toll[i] * u_star[i]) : 0.0;
    const double balance = matrix.storage[i] * (u_star[i] - u[i] - gain) + q * (loss[i] * u_star[i] - amount[i]);
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
}  // namespace wick::diffusion
