#include "diffusion/gravity_transport.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace wick::diffusion {

namespace {

using Values = std::vector<double>;

/// One step in the making.
struct Transport {
  const GravityTransportParams& params;
  const TransferInput& in;
  Values slope, content, room, transfer;  ///< c per edge, from its vertex of lower number to the other

  Transport(const GravityTransportParams& p, const TransferInput& input) : params(p), in(input) {
    slope.resize(in.graph->corner.size());
    transfer.resize(slope.size());
    const double weight = in.gravity.norm();
    for_each_edge(*in.graph, [&](std::size_t i, std::size_t j, std::size_t e) {
      const Vec3 along = (*in.x)[j] - (*in.x)[i];
      const double length = along.norm() * weight;
      slope[e] = length > 0.0 ? along.dot(in.gravity) / length : 0.0;
    });
  }

  [[nodiscard]] double neighbours(std::size_t i) const {
    return static_cast<double>(in.graph->offset[i + 1] - in.graph->offset[i]);
  }

  /// Largest rate at which differences or contents vanish [1/s]: what a vertex gives, or, next to heavier ones,
  /// what it is given.
  [[nodiscard]] double fastest() const {
    const Values& mass = *in.mass;
    const double crowd = parallel_max(mass.size(), chunk, 1.0, [&](std::size_t begin, std::size_t end) {
      double most = 1.0;
      for (std::size_t i = begin; i < end; ++i) {
        double received = 0.0;
        for (std::int32_t k = in.graph->offset[i]; k < in.graph->offset[i + 1]; ++k) {
          const auto j = static_cast<std::size_t>(in.graph->column[k]);
          received += mass[j] / neighbours(j);
        }
        if (mass[i] > 0.0) most = std::max(most, received / mass[i]);
      }
      return most;
    });
    return params.diffusion_rate * crowd + params.gravity_rate;
  }

  /// What i passes to j in the time h.
  [[nodiscard]] double donation(const Values& u, std::size_t i, std::size_t j, double cosine, double h) const {
    if (u[i] <= params.transport_threshold) return 0.0;
    const double down = std::max(0.0, cosine);
    const double spread = params.diffusion_rate * std::max(0.0, u[i] - u[j]) * (params.angle_only ? down : 1.0);
    return h * (spread + params.gravity_rate * u[i] * down) * (*in.mass)[i] / neighbours(i);
  }

  void move(double h, Values& u) {
    // Gather what neighbours want to exchange.
    const Values& mass = *in.mass;
    for_each_edge(*in.graph, [&](std::size_t i, std::size_t j, std::size_t e) {
      transfer[e] =
          mass[i] > 0.0 && mass[j] > 0.0 ? donation(u, i, j, slope[e], h) - donation(u, j, i, -slope[e], h) : 0.0;
    });

    // Limit it to what there is above the threshold and to what fits.
    content.resize(u.size());
    room.resize(in.capacity > 0.0 ? u.size() : 0);
    parallel_for(u.size(), chunk, [&](std::size_t i) {
      content[i] = mass[i] * std::max(0.0, u[i] - params.transport_threshold);
      if (!room.empty()) room[i] = mass[i] * std::max(0.0, in.capacity - u[i]);
    });
    limit_transfers(*in.graph, content, room, transfer);
    parallel_for(u.size(), chunk, [&](std::size_t i) {
      if (mass[i] > 0.0) u[i] = std::max(0.0, u[i] - net_outflow(*in.graph, transfer, i) / mass[i]);
    });
  }

  /// Supply and loss of each vertex alone, implicit; `share` is the substep's part of the step.
  double exchange(double share, Values& u, Values& given) const {
    const Values& mass = *in.mass;
    return sum_of(u.size(), [&](std::size_t i) {
      const double loss = share * (*in.loss)[i], supply = share * (*in.supply)[i];
      if (mass[i] <= 0.0 || (loss == 0.0 && supply == 0.0)) return 0.0;
      const double before = u[i], source = supply > 0.0 ? (*in.supply_value)[i] : 0.0;
      const double alone = mass[i] * before / (mass[i] + loss);
      double after = alone;
      if (source > before) {
        // Absorption: up to t_absorb below the source, and up to the capacity.
        double stop = source - params.absorb_threshold;
        if (in.capacity > 0.0) stop = std::min(stop, in.capacity);
        const double rate = params.absorption * supply;
        const double wetted = (mass[i] * before + rate * source) / (mass[i] + loss + rate);
        after = std::max(alone, std::min(wetted, stop));
      } else {
        after = (mass[i] * before + supply * source) / (mass[i] + loss + supply);
      }
      u[i] = after;
      const double lost = loss * after;
      if (supply > 0.0) given[i] += mass[i] * (after - before) + lost;
      return lost;
    });
  }
};

}  // namespace

TransferResult transport_by_gravity(const GravityTransportParams& params, const TransferInput& input, Values& u) {
  // A tenth per substep: first order, and no difference changes its sign.
  constexpr double share_per_substep = 0.1, stable_share = 0.5;
  constexpr double most_substeps = 20000.0;
  Transport transport(params, input);
  const double rate = transport.fastest(), wanted = std::ceil(input.dt * rate / share_per_substep);
  TransferResult result;
  result.given.assign(u.size(), 0.0);
  result.substeps = static_cast<int>(std::clamp(wanted, 1.0, most_substeps));
  const double h = input.dt / result.substeps;
  for (int n = 0; n < result.substeps; ++n) {
    result.lost += transport.exchange(1.0 / result.substeps, u, result.given);
    transport.move(rate > 0.0 ? std::min(h, stable_share / rate) : h, u);
  }
  result.solve.iterations = result.substeps;
  result.solve.converged = h * rate <= stable_share;
  return result;
}

}  // namespace wick::diffusion
