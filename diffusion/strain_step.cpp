/// Eqs (8b)-(8g) [Kim & Lee 2017]: strain on the front, and the total rescaled to its target.
#include <algorithm>
#include <cmath>

#include "diffusion/strain.h"
#include "diffusion/strain_diffusion_impl.h"

namespace wick::diffusion {

namespace {

/// C of one step is at most this many times the largest u: beyond, u takes the shape of C all the same.
constexpr double most_strain = 1e8;
/// Less than this of the largest u is rounding: rigid motion leaves the isotropic result bit for bit.
constexpr double least_strain = 1e-16;
/// The toll is at most this: it is dear where C lies in surroundings that hold next to nothing.
constexpr double highest_toll = 1e100;

/// 0 where all are negative.
double largest(const Values& values) {
  return parallel_max(values.size(), chunk, 0.0, [&](std::size_t begin, std::size_t end) {
    double most = 0.0;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, values[i]);
    return most;
  });
}

/// 1 - x for what is still open, and always positive: where nearly all has gone in one step, something stays that
/// the total can be made of.
double share_kept(double open) {
  return open < 0.5 ? 1.0 - open : 0.25 / open;
}

/// Whether a model adds C; the others only report it.
bool adds_strain(Model model) {
  return model == Model::strain_constrained || model == Model::strain_unconstrained || model == Model::noise ||
         model == Model::strain_noise;
}

}  // namespace

/// C of each vertex; false where there is none to add.
bool DiffusionSolver::Impl::find_strain(const DiffusionInput& in, double dt) {
  triangle_strain(params, *in.mesh, *in.x, in.rest_scale, strain);
  vertex_strain(params, *in.mesh, strain, dt, c);
  apply_noise(params, *in.mesh, dt, c);
  c_front.assign(c.size(), 0.0);
  front.assign(c.size(), 0.0);
  toll.clear();
  return adds_strain(params.model) && largest(c) > 0.0;
}

/// The front of the values u, and C on it. Without a front, Eq (7), C is added wherever there is sheet, without
/// limit.
void DiffusionSolver::Impl::mask_strain(const DiffusionInput& in, const Values& u) {
  const bool everywhere = params.model == Model::strain_unconstrained;
  const double most = everywhere ? INFINITY : most_strain * largest(u);
  if (!everywhere) front = front_band(params, u, in.fraction_left);
  parallel_for(c.size(), chunk, [&](std::size_t i) {
    const bool held = (*in.mass)[i] > 0.0 && u[i] >= 0.0;
    c_front[i] = held ? std::clamp(c[i], 0.0, most) * (everywhere ? 1.0 : front[i]) : 0.0;
  });
}

std::size_t DiffusionSolver::Impl::count_front(const DiffusionInput& in) const {
  return static_cast<std::size_t>(parallel_sum(front.size(), chunk, [&](std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += front[i] > 0.0 && (*in.mass)[i] > 0.0 ? 1 : 0;
    return static_cast<double>(count);
  }));
}

/// What a vertex pays for C in its surroundings, as a share of what it holds: w K(M C / D) with D = K(M u w), so
/// that Σ M C = Σ M toll u over every scope. w is the front, or 1 where the scope takes from all.
Values DiffusionSolver::Impl::toll_for(const DiffusionInput& in, const Values& u, const Values& added,
                                       const Kernel& kernel) const {
  const Values& mass = *in.mass;
  const bool front_pays = params.scope == Scope::front || params.scope == Scope::local_front;
  Values right(u.size());
  parallel_for(u.size(), chunk, [&](std::size_t i) { right[i] = mass[i] * u[i] * (front_pays ? front[i] : 1.0); });
  const Values nearby = kernel(right);
  parallel_for(u.size(), chunk, [&](std::size_t i) {
    right[i] = nearby[i] > 0.0 ? mass[i] * std::min(added[i] / nearby[i], highest_toll) : 0.0;
  });
  Values result = kernel(right);
  parallel_for(u.size(), chunk, [&](std::size_t i) { result[i] *= front_pays ? front[i] : 1.0; });
  return result;
}

/// C and its toll as rates of the step that begins with u. False where there is nothing on the front.
bool DiffusionSolver::Impl::plan_exchange(const DiffusionInput& in, const Values& u) {
  mask_strain(in, u);
  if (params.model == Model::strain_unconstrained) return true;
  if (!misjudged.empty())
    for (std::size_t i = 0; i < u.size(); ++i)
      if (misjudged[i] != 0) c_front[i] = 0.0;
  if (misjudged.empty() && !(largest(c_front) > least_strain * largest(u))) return strained = false;
  toll = toll_for(in, u, c_front, make_kernel(in));
  return true;
}

/// u of each vertex without the exchange, as Eq (8d) counts it: its budget. Operators that do not keep Σ M u, and
/// sums that do not count M, need v without what the solve has added to it and taken from it.
Values DiffusionSolver::Impl::without_exchange(const DiffusionInput& in, const Values& u, const Values& v) const {
  const Values& mass = *in.mass;
  const bool kept = params.discretisation == Operator::cotan && params.total != Total::plain;
  Values result(v.size());
  parallel_for(v.size(), chunk, [&](std::size_t i) {
    if (kept)
      result[i] = mass[i] > 0.0 ? u[i] + (given[i] - loss[i] * v[i]) / mass[i] : u[i];
    else
      result[i] = v[i] - c_front[i] + (toll.empty() ? 0.0 : toll[i] * v[i]);
  });
  return result;
}

/// Marks the vertices of all groups of which the exchange leaves less than half or more than twice their budget:
/// the step is too long for it there. True where there are any.
bool DiffusionSolver::Impl::find_misjudged(const Values& mass, const Values& budget, const Values& u) {
  const VertexGroups& groups = params.scope == Scope::global ? graph.whole : graph.components;
  misjudged.assign(u.size(), 0);
  bool any = false;
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const double wanted = sum_over(groups[g], [&](std::size_t i) { return mass[i] * budget[i]; });
    const double held = sum_over(groups[g], [&](std::size_t i) { return mass[i] * u[i]; });
    if (wanted >= 0.5 * held && wanted <= 2.0 * held) continue;
    for (const std::int32_t i : groups[g]) misjudged[i] = 1;
    any = true;
  }
  if (!any) misjudged.clear();
  return any;
}

/// Takes the share `open` of what the vertices hold from them. What one cannot pay is due in its surroundings
/// again; after a few passes it is left to the total.
void DiffusionSolver::Impl::pay(const DiffusionInput& in, Values& open, const Kernel& kernel, Values& held) const {
  constexpr int most_passes = 8;
  const Values& mass = *in.mass;
  Values unpaid(held.size());
  for (int pass = 0;; ++pass) {
    parallel_for(held.size(), chunk, [&](std::size_t i) {
      const double left = held[i] * share_kept(open[i]);
      unpaid[i] = std::max(0.0, left - held[i] * (1.0 - open[i]));
      held[i] = left;
    });
    const double due = sum_of(held.size(), [&](std::size_t i) { return mass[i] * unpaid[i]; });
    const double all = sum_of(held.size(), [&](std::size_t i) { return mass[i] * held[i]; });
    if (pass == most_passes || !(due > 1e-14 * all)) return;
    open = toll_for(in, held, unpaid, kernel);
  }
}

/// Ends a step whose exchange went through the solve: v is its result. The toll was taken with the holdings of the
/// beginning; what this leaves open is made good where it arose, then the totals are made exact. False, with u as
/// it was and the places marked, where these are too far away.
bool DiffusionSolver::Impl::settle_exchange(const DiffusionInput& in, double dt, Values& v, Values& u,
                                            DiffusionReport& report) {
  const Values& mass = *in.mass;
  const auto amount_of = [&](const Values& w) {
    return sum_of(w.size(), [&](std::size_t i) { return mass[i] * w[i]; });
  };
  Values budget = without_exchange(in, u, v);
  if (params.discretisation != Operator::cotan || params.total == Total::plain)
    report.drift = amount_of(budget) - (report.before + report.supplied - report.excess - report.lost);
  report.strain_added = amount_of(c_front);
  if (toll.empty()) {
    report.sigma_source = report.drift + report.strain_added;
    u = v;
    return true;
  }
  const Kernel kernel = make_kernel(in);
  const Values due = toll_for(in, v, c_front, kernel);
  Values open(v.size());
  parallel_for(v.size(), chunk, [&](std::size_t i) { open[i] = due[i] - toll[i]; });
  Values& settled = extra;
  settled = v;
  pay(in, open, kernel, settled);
  if (misjudged.empty() && find_misjudged(mass, budget, settled)) return false;
  report.sigma_source = report.drift;
  u = settled;
  take_as_printed(in, v, u);
  settle_total(in, dt, budget, u, report);
  report.rescale = std::min(report.rescale, 1.0 / (1.0 + largest(due)));
  return true;
}

/// What is misjudged went through the solve without exchange; there C is added to v now, Eq (8c).
void DiffusionSolver::Impl::take_as_printed(const DiffusionInput& in, const Values& v, Values& u) {
  c_front.assign(v.size(), 0.0);
  if (misjudged.empty()) return;
  const Values before = front;
  mask_strain(in, v);
  parallel_for(v.size(), chunk, [&](std::size_t i) {
    if (misjudged[i] != 0)
      u[i] = v[i] + c_front[i];
    else
      front[i] = before[i], c_front[i] = 0.0;
  });
}

/// K of the scope: the mean over each vertex's surroundings, or the sum over its component or the whole sheet.
Kernel DiffusionSolver::Impl::make_kernel(const DiffusionInput& in) {
  if (!is_local(params.scope)) {
    const VertexGroups& groups = params.scope == Scope::global ? graph.whole : graph.components;
    return [&groups](const Values& right) {
      Values result(right.size(), 0.0);
      for (std::size_t g = 0; g < groups.count(); ++g) {
        const double sum = sum_over(groups[g], [&](std::size_t i) { return right[i]; });
        for (const std::int32_t i : groups[g]) result[i] = sum;
      }
      return result;
    };
  }
  if (!neighbourhood) {
    SheetOperator geometry;
    build_operator(*in.mesh, graph, {}, in.mesh->rest, rest_corner, in.mesh->vertex_area, geometry);
    neighbourhood = std::make_unique<Neighbourhood>(*in.mesh, graph, geometry, params.scope_radius);
  }
  return [this](const Values& right) {
    Values result = neighbourhood->average(right);
    for (double& value : result) value = std::max(value, 0.0);
    return result;
  };
}

/// Eqs (8b)-(8g) after the diffusion; Eq (7) where there is no front.
void DiffusionSolver::Impl::redistribute(const DiffusionInput& in, double dt, const Values& u_star, Values& u,
                                         DiffusionReport& report) {
  const Values& mass = *in.mass;
  mask_strain(in, u_star);
  if (!strained) c_front.assign(u.size(), 0.0);
  parallel_for(u.size(), chunk, [&](std::size_t i) { u[i] = u_star[i] + c_front[i]; });
  report.strain_added = sum_of(u.size(), [&](std::size_t i) { return mass[i] * c_front[i]; });
  if (params.model == Model::strain_unconstrained)
    report.sigma_source += report.strain_added;
  else
    settle_total(in, dt, u_star, u, report);
}

/// Brings the total of u to its target, Eqs (8d)-(8g); that of u* is what the target counts from.
void DiffusionSolver::Impl::settle_total(const DiffusionInput& in, double dt, const Values& u_star, Values& u,
                                         DiffusionReport& report) {
  const Values& mass = *in.mass;
  const std::size_t n = u.size();
  const bool plain = params.total == Total::plain;
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
                           .overflow = {&graph, &in.mesh->rest_length},
                           .capacity = in.capacity,
                           .dt = dt};
  const RescaleResult result = rescale(params, input, is_local(params.scope) ? make_kernel(in) : Kernel(), u);
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
