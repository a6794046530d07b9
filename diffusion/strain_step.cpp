/// Eqs (8b)-(8g) [Kim & Lee 2017]: strain on the front, and the total rescaled to its target.
#include <algorithm>
#include <cmath>

#include "diffusion/strain.h"
#include "diffusion/strain_diffusion_impl.h"

namespace wick::diffusion {

namespace {

/// Whether a model adds C; the others only report it.
bool adds_strain(Model model) {
  return model == Model::strain_constrained || model == Model::strain_unconstrained || model == Model::noise ||
         model == Model::strain_noise;
}

}  // namespace

/// C of each vertex, through the same solve when the order asks for it.
void DiffusionSolver::Impl::add_strain(const DiffusionInput& in, double dt, const Values& u_star,
                                       DiffusionReport& report) {
  triangle_strain(params, *in.mesh, *in.x, in.rest_scale, strain);
  vertex_strain(params, *in.mesh, strain, dt, c);
  apply_noise(params, *in.mesh, dt, c);
  c_front.assign(c.size(), 0.0);
  const auto largest = [&](std::size_t begin, std::size_t end) {
    return *std::max_element(c.begin() + static_cast<std::ptrdiff_t>(begin),
                             c.begin() + static_cast<std::ptrdiff_t>(end));
  };
  if (!adds_strain(params.model) || parallel_max(c.size(), chunk, 0.0, largest) <= 0.0) return;
  if (params.order == Order::inside) {
    parallel_for(c.size(), chunk, [&](std::size_t i) {
      rhs[i] = matrix.storage[i] * c[i];
      c_front[i] = c[i];
    });
    note(report, solver.solve(matrix, rhs, increment_tolerance(), c_front), true);
  }
  const Values& added = params.order == Order::inside ? c_front : c;
  parallel_for(c.size(), chunk, [&](std::size_t i) {
    c_front[i] = (*in.mass)[i] <= 0.0 || u_star[i] < 0.0 ? 0.0 : std::max(added[i], 0.0);
  });
}

/// K on the rest shape, the same until the topology changes.
Kernel DiffusionSolver::Impl::make_kernel(const solid::ShellMesh& mesh) {
  if (!neighbourhood) {
    SheetOperator geometry;
    build_operator(mesh, graph, {}, mesh.rest, rest_corner, mesh.vertex_area, geometry);
    neighbourhood = std::make_unique<Neighbourhood>(mesh, graph, geometry, params.scope_radius);
  }
  return [this](const Values& right) {
    Values result = neighbourhood->average(right);
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
  front = front_band(params, u_star, in.fraction_left);
  parallel_for(n, chunk, [&](std::size_t i) {
    c_front[i] *= front[i];
    u[i] = u_star[i] + c_front[i];
  });
  report.front_vertices = static_cast<std::size_t>(parallel_sum(n, chunk, [&](std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += front[i] > 0.0 && mass[i] > 0.0 ? 1 : 0;
    return static_cast<double>(count);
  }));
  report.strain_added = sum_of(n, [&](std::size_t i) { return mass[i] * c_front[i]; });
  Values supplied;
  if (plain) {
    supplied = given;
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
                           .supply = plain ? &supplied : &given,
                           .capacity = in.capacity,
                           .dt = dt};
  const bool local = params.scope == Scope::local || params.scope == Scope::local_front;
  const RescaleResult result = rescale(params, input, local ? make_kernel(*in.mesh) : Kernel(), u);
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
}  // namespace wick::diffusion
