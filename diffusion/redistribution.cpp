#include "diffusion/redistribution.h"

#include <algorithm>
#include <cmath>

namespace wick::diffusion {

namespace {

/// 0 below 0, 1 above 1, 3t² - 2t³ in between.
double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

std::vector<double> front_band(const DiffusionParams& params, const std::vector<double>& u_star,
                               const std::vector<double>* fraction_left) {
  // Two ramps that met would leave no front.
  const double ramp = std::min(params.front_ramp, 0.5 * (params.u_max - params.u_min));
  std::vector<double> front(u_star.size());
  parallel_for(front.size(), chunk, [&](std::size_t i) {
    const bool virgin = params.virgin <= 0.0 || fraction_left == nullptr || (*fraction_left)[i] > params.virgin;
    const double inside = std::min(u_star[i] - params.u_min, params.u_max - u_star[i]);
    if (!virgin || !(inside >= 0.0)) return;
    front[i] = ramp > 0.0 ? smooth_step(inside / ramp) : 1.0;
  });
  return front;
}

Projection project_total(std::span<const std::int32_t> members, const std::vector<double>& weight, double target,
                         double cap, std::vector<double>& v) {
  // Below this a sum is rounding of nothing, and a quotient by it could overflow.
  constexpr double least_sum = 1e-280;
  const double total = sum_over(members, [&](std::size_t i) { return weight[i] * v[i]; });
  if (total <= least_sum) return {1.0, 0.0};
  double r = std::max(target, 0.0) / total;

  // Saturated vertices hold the cap; the rest share what remains in proportion to v.
  while (cap > 0.0) {
    const double full = sum_over(members, [&](std::size_t i) { return r * v[i] >= cap ? weight[i] : 0.0; });
    if (full == 0.0) break;
    const double open = sum_over(members, [&](std::size_t i) { return r * v[i] < cap ? weight[i] * v[i] : 0.0; });
    const double next = open > least_sum ? (target - cap * full) / open : r;
    if (!(next > r * (1.0 + 1e-15))) break;
    r = next;
  }
  parallel_for(members.size(), chunk, [&](std::size_t k) {
    double& value = v[members[k]];
    value = cap > 0.0 ? std::min(cap, r * value) : r * value;
  });
  if (cap <= 0.0) return {r, 0.0};
  const double held = sum_over(members, [&](std::size_t i) { return weight[i] * v[i]; });
  const double rest = target - held;
  return {r, rest > 1e-14 * target ? rest : 0.0};
}

double redistribute_locally(const std::vector<double>& mass, const std::vector<double>& c,
                            const std::vector<double>& taken, const Kernel& kernel, std::vector<double>& v) {
  constexpr int most_passes = 8;
  const std::size_t n = v.size();
  const auto weight = [&](std::size_t i) { return taken.empty() ? 1.0 : taken[i]; };
  std::vector<double> rhs(n), due = c;
  double smallest = 1.0;
  for (int pass = 0; pass < most_passes; ++pass) {
    parallel_for(n, chunk, [&](std::size_t i) { rhs[i] = mass[i] * v[i] * weight(i); });
    const std::vector<double> nearby = kernel(rhs);

    // C lies where v > 0, so D is positive there; where it is not, nothing can pay for C and it is dropped.
    parallel_for(n, chunk, [&](std::size_t i) {
      const bool payable = nearby[i] > 0.0 && due[i] > 0.0;
      if (!payable && pass == 0) v[i] -= c[i];
      rhs[i] = payable ? mass[i] * (due[i] / nearby[i]) : 0.0;
    });
    const std::vector<double> bracket = kernel(rhs);
    smallest = std::min(smallest, 1.0 - parallel_max(n, chunk, 0.0, [&](std::size_t begin, std::size_t end) {
                                    double most = 0.0;
                                    for (std::size_t i = begin; i < end; ++i)
                                      most = std::max(most, weight(i) * bracket[i]);
                                    return most;
                                  }));
    // What a vertex cannot pay is due in its surroundings again.
    parallel_for(n, chunk, [&](std::size_t i) {
      const double factor = 1.0 - weight(i) * bracket[i];
      due[i] = v[i] * std::max(0.0, -factor);
      v[i] *= std::max(0.0, factor);
    });
    const double rest = sum_of(n, [&](std::size_t i) { return mass[i] * due[i]; });
    if (!(rest > 1e-14 * sum_of(n, [&](std::size_t i) { return mass[i] * v[i]; }))) break;
  }
  return std::max(0.0, smallest);
}

double step_sigma(const DiffusionParams& params, double dt) {
  if (params.sigma_mode == SigmaMode::per_step) return params.sigma;
  if (params.sigma_mode == SigmaMode::rate && params.sigma != 1.0)
    return std::min(std::pow(params.sigma, dt / params.sigma_tau), 1e100);  // the bound keeps one step finite
  return 1.0;
}

namespace {

/// Target total of one group: σ U*, or U* + (σ - 1) times what it was given.
double target_total(const DiffusionParams& params, const RescaleInput& in, std::span<const std::int32_t> members,
                    double star) {
  if (params.sigma_mode != SigmaMode::influx) return step_sigma(params, in.dt) * star;
  if (params.sigma == 1.0) return star;
  const double given = sum_over(members, [&](std::size_t i) { return (*in.supply)[i]; });
  return std::max(0.0, star + (params.sigma - 1.0) * std::max(given, 0.0));
}

/// Influx in local scopes: what sigma makes of the supply, g = (σ - 1) supply, goes to what is held near it:
/// v_i += v_i K(g / K(W v)). Clamps at 0.
void scale_supply(const DiffusionParams& params, const RescaleInput& in, const VertexGroups& groups,
                  const Kernel& kernel, std::vector<double>& v) {
  if (params.sigma_mode != SigmaMode::influx || params.sigma == 1.0) return;
  const std::vector<double>&w = *in.weight, &supply = *in.supply;
  const std::size_t n = v.size();
  std::vector<double> rhs(n), made(n, 0.0);
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const double net = sum_over(groups[g], [&](std::size_t i) { return supply[i]; });
    const double given = sum_over(groups[g], [&](std::size_t i) { return std::max(0.0, supply[i]); });
    if (!(net > 0.0)) continue;
    const double share = std::abs(params.sigma - 1.0) * net / given;
    for (const std::int32_t i : groups[g]) made[i] = share * std::max(0.0, supply[i]);
  }
  parallel_for(n, chunk, [&](std::size_t i) { rhs[i] = w[i] * v[i]; });
  const std::vector<double> nearby = kernel(rhs);
  parallel_for(n, chunk, [&](std::size_t i) { rhs[i] = nearby[i] > 0.0 ? made[i] / nearby[i] : 0.0; });
  const std::vector<double> change = kernel(rhs);
  const double sign = params.sigma > 1.0 ? 1.0 : -1.0;
  parallel_for(n, chunk, [&](std::size_t i) { v[i] *= std::max(0.0, 1.0 + sign * change[i]); });
}

/// Rescales only the front of one component, each vertex as far as it belongs to it. Returns false, leaving v, when
/// it cannot meet the target alone.
bool rescale_front(const RescaleInput& in, std::span<const std::int32_t> members, double created,
                   std::vector<double>& v, Projection& done) {
  const std::vector<double>&w = *in.weight, &front = *in.front;
  std::vector<std::int32_t> inside;
  for (const std::int32_t i : members)
    if (front[i] > 0.0 && w[i] > 0.0) inside.push_back(i);
  // σ U* minus everything that is not rescaled, written as a difference that does not cancel when σ = 1:
  // u = v + f (r v - v), so Σ f W r v = Σ W u* + created - Σ (1 - f) W v.
  // Outside the front u* and v differ where u* is a budget: what each vertex got, not what it holds.
  const double wanted = created + sum_over(members, [&](std::size_t i) {
                          return w[i] * ((*in.u_star)[i] - (front[i] > 0.0 ? 1.0 - front[i] : 1.0) * v[i]);
                        });
  if (inside.empty() || wanted < 0.0) return false;
  std::vector<double> share(w.size());
  for (const std::int32_t i : inside) share[i] = front[i] * w[i];
  std::vector<double> rescaled = v;
  done = project_total(inside, share, wanted, 0.0, rescaled);
  for (const std::int32_t i : inside) v[i] = front[i] < 1.0 ? v[i] + front[i] * (rescaled[i] - v[i]) : rescaled[i];
  return true;
}

}  // namespace

RescaleResult rescale(const DiffusionParams& params, const RescaleInput& in, const Kernel& kernel,
                      std::vector<double>& u) {
  RescaleResult result;
  std::vector<double> before;
  const bool local = is_local(params.scope), near = local || params.scope == Scope::front;
  if (local && std::any_of(in.c->begin(), in.c->end(), [](double c) { return c > 0.0; })) {
    static const std::vector<double> everywhere;
    before = u;
    result.rescale =
        redistribute_locally(*in.mass, *in.c, params.scope == Scope::local ? everywhere : *in.front, kernel, u);
  }
  const VertexGroups& groups = params.scope == Scope::global ? *in.whole : *in.components;
  if (local) scale_supply(params, in, groups, kernel, u);
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const auto members = groups[g];
    const double star = sum_over(members, [&](std::size_t i) { return (*in.weight)[i] * (*in.u_star)[i]; });
    const double target = target_total(params, in, members, star);
    // The local form keeps Σ M u up to what the clamp adds. Where C is so large that this drowns in rounding, share
    // by v = u* + C over the component instead.
    if (!before.empty()) {
      const double kept = sum_over(members, [&](std::size_t i) { return (*in.mass)[i] * u[i]; });
      const double held = sum_over(members, [&](std::size_t i) { return (*in.mass)[i] * (*in.u_star)[i]; });
      if (!(kept >= 0.5 * held && kept <= 100.0 * held))
        for (const std::int32_t i : members) u[i] = before[i];
    }
    Projection done;
    if (params.scope != Scope::front || !rescale_front(in, members, target - star, u, done))
      done = project_total(members, *in.weight, target, near ? 0.0 : in.capacity, u);
    result.rescale = std::min(result.rescale, done.factor);
    result.created += target - star;
    result.excess += done.excess;
  }
  if (!near || in.capacity <= 0.0) return result;
  pour_over(in.overflow, *in.weight, in.capacity, u);
  // What has found no room has filled its piece.
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const double held = sum_over(groups[g], [&](std::size_t i) { return (*in.weight)[i] * u[i]; });
    result.excess += project_total(groups[g], *in.weight, held, in.capacity, u).excess;
  }
  return result;
}

}  // namespace wick::diffusion
