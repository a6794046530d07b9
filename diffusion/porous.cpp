#include "diffusion/porous.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace wick::diffusion {

namespace {

using Values = std::vector<double>;

/// Pores that have all but closed keep this share of their volume, so that s stays finite.
constexpr double least_pores = 0.05;

}  // namespace

Retention::Retention(const PorousParams& p)
    : suction_(p.capillary), exponent_(p.exponent), epsilon_(p.regularisation) {
  dry_ = std::pow(1.0 + epsilon_, exponent_);
  full_ = std::pow(epsilon_, exponent_);
  dry_slope_ = suction_ * exponent_ * std::pow(1.0 + epsilon_, exponent_ - 1.0);
  full_slope_ = suction_ * exponent_ * std::pow(epsilon_, exponent_ - 1.0);
}

double Retention::potential(double s, double stiffness, double lift) const {
  if (s >= 1.0) return lift + stiffness * s - suction_ * full_ + full_slope_ * (s - 1.0);
  if (s <= 0.0) return lift + stiffness * s - suction_ * dry_ + dry_slope_ * s;
  return lift + stiffness * s - suction_ * std::pow(1.0 - s + epsilon_, exponent_);
}

double Retention::storage(double s, double stiffness) const {
  if (s >= 1.0) return 1.0 / (stiffness + full_slope_);
  if (s <= 0.0) return 1.0 / (stiffness + dry_slope_);
  return 1.0 / (stiffness + suction_ * exponent_ * std::pow(1.0 - s + epsilon_, exponent_ - 1.0));
}

double Retention::saturation(double psi, double stiffness, double lift) const {
  const double y = psi - lift, at_full = stiffness - suction_ * full_, at_dry = -suction_ * dry_;
  if (y >= at_full) return 1.0 + (y - at_full) / (stiffness + full_slope_);
  if (y <= at_dry) return (y - at_dry) / (stiffness + dry_slope_);
  if (stiffness == 0.0) return 1.0 + epsilon_ - std::pow(-y / suction_, 1.0 / exponent_);

  // Newton within a bracket; steps that leave it become bisections.
  double low = 0.0, high = 1.0, s = (y - at_dry) / (at_full - at_dry);
  for (int k = 0; k < 80; ++k) {
    const double error = potential(s, stiffness, 0.0) - y;
    (error > 0.0 ? high : low) = s;
    double next = s - error * storage(s, stiffness);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - s) <= 1e-15) return next;
    s = next;
  }
  return s;
}

Values vertex_dilation(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, const Values* rest_scale) {
  Values triangle(mesh.triangle_count()), vertex(mesh.vertex_count());
  parallel_for(triangle.size(), chunk, [&](std::size_t t) {
    const Int3& v = mesh.triangles[t];
    Mat32 edges;
    edges << x[v[1]] - x[v[0]], x[v[2]] - x[v[0]];
    const Mat32 gradient = edges * mesh.inverse_rest_edges[t];
    const double scale = rest_scale == nullptr ? 1.0 : (*rest_scale)[t];
    triangle[t] = gradient.col(0).cross(gradient.col(1)).norm() / (scale * scale);
  });
  parallel_for(vertex.size(), chunk, [&](std::size_t i) {
    double sum = 0.0, area = 0.0;
    for (std::int32_t k = mesh.incident_offset[i]; k < mesh.incident_offset[i + 1]; ++k) {
      sum += mesh.rest_area[mesh.incident[k]] * triangle[mesh.incident[k]];
      area += mesh.rest_area[mesh.incident[k]];
    }
    vertex[i] = area > 0.0 ? sum / area : 1.0;
  });
  return vertex;
}

namespace {

/// What squeezing makes of the pores of one vertex.
struct Pores {
  double full;       ///< u at which they are full
  double stiffness;  ///< k_p max(0, J^-β - 1) [Pa]
};
Pores pores_at(const PorousParams& p, double dilation) {
  const double j = std::max(dilation, 1.0 - (1.0 - least_pores) * p.porosity);
  // At a million times k_p the vertex empties in any step; more would only cost digits.
  return {p.full * (j - 1.0 + p.porosity) / p.porosity,
          p.pressure * std::clamp(std::pow(j, -p.tait) - 1.0, 0.0, 1e6)};
}

/// One step in the making.
class PorousStep {
 public:
  PorousStep(const PorousParams& params, const TransferInput& input, const SheetOperator& edges, double tolerance,
             LinearSolver& solver, TransferResult& result)
      : params_(params),
        in_(input),
        retention_(params),
        edges_(edges),
        tolerance_(std::max(100.0 * tolerance, 1e-12)),
        solver_(solver),
        result_(result) {
    prepare_vertices();
    bound_rates();
  }

  /// Advances u by `share` of the step. Returns false, leaving u, where Picard does not converge; `last` takes
  /// what it has.
  bool advance(double share, bool last, Values& u) {
    start(share, u);
    constexpr int most_iterations = 24;
    double error = find_error(share, u);
    result_.solve.residual_before = error;
    for (int k = 0; k < most_iterations && error > tolerance_; ++k) {
      correct(share);
      error = find_error(share, u);
    }
    result_.solve.residual_after = error;
    const bool converged = error <= tolerance_;
    if (!converged && !last) return false;
    result_.solve.converged = result_.solve.converged && converged;
    exchange(share, u);
    ++result_.substeps;
    return true;
  }

  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  const PorousParams& params_;
  const TransferInput& in_;
  const Retention retention_;
  const SheetOperator& edges_;
  const double tolerance_;
  LinearSolver& solver_;
  TransferResult& result_;
  Values stiffness_, lift_, pores_;  ///< k_p (J^-β - 1), -ρ g·x, u of full pores
  Values loss_, supply_;
  Values s_, psi_, storage_, kr_, rhs_, extra_, delta_, transfer_, content_, room_;
  SheetOperator op_;
  SheetMatrix matrix_;
  int iterations_ = 0;

  [[nodiscard]] bool holds(std::size_t i) const { return (*in_.mass)[i] > 0.0; }
  [[nodiscard]] double source(std::size_t i) const { return supply_[i] > 0.0 ? (*in_.supply_value)[i] : 0.0; }
  /// dt K full/(φ0 μ): amount that crosses an edge of weight 1 per pressure.
  [[nodiscard]] double conductance(double share) const {
    return share * in_.dt * params_.permeability * params_.full / (params_.porosity * params_.viscosity);
  }

  void prepare_vertices() {
    const Values dilation = vertex_dilation(*in_.mesh, *in_.x, in_.rest_scale);
    const std::size_t n = dilation.size();
    for (Values* field : {&stiffness_, &lift_, &pores_}) field->resize(n);
    parallel_for(n, chunk, [&](std::size_t i) {
      const Pores pores = pores_at(params_, dilation[i]);
      pores_[i] = pores.full;
      stiffness_[i] = pores.stiffness;
      lift_[i] = -params_.density * in_.gravity.dot((*in_.x)[i]);
    });
  }

  /// Rates so stiff that they fix the value to ten digits are as good as infinite; more would only cost digits.
  void bound_rates() {
    constexpr double stiffest = 1e10;
    loss_ = *in_.loss;
    supply_ = *in_.supply;
    const SheetGraph& graph = *in_.graph;
    parallel_for(loss_.size(), chunk, [&](std::size_t i) {
      if (!holds(i)) loss_[i] = supply_[i] = 0.0;
      if (loss_[i] == 0.0 && supply_[i] == 0.0) return;
      double row = 0.0;
      for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) row += edges_.edge[graph.entry_edge[k]];
      const double slope =
          1.0 / std::min(retention_.storage(0.0, stiffness_[i]), retention_.storage(1.0, stiffness_[i]));
      const double most = stiffest * ((*in_.mass)[i] + conductance(1.0) * row * slope / pores_[i]);
      loss_[i] = std::min(loss_[i], most);
      supply_[i] = std::min(supply_[i], most);
    });
  }

  /// Guess: what supply and loss make of each vertex alone.
  void start(double share, const Values& u) {
    const std::size_t n = u.size();
    for (Values* field : {&s_, &psi_, &storage_, &rhs_, &extra_, &op_.storage}) field->resize(n);
    for (Values* field : {&kr_, &transfer_}) field->resize(edges_.edge.size());
    op_.edge = edges_.edge;
    parallel_for(n, chunk, [&](std::size_t i) {
      const double mass = (*in_.mass)[i], supply = share * supply_[i], loss = share * loss_[i];
      const double alone = holds(i) ? (mass * u[i] + supply * source(i)) / (mass + supply + loss) : u[i];
      s_[i] = alone / pores_[i];
      psi_[i] = retention_.potential(s_[i], stiffness_[i], lift_[i]);
    });
  }

  [[nodiscard]] double relative_permeability(double s) const {
    const double bounded = std::clamp(s, 0.0, 1.0);
    return params_.relative == 1.0 ? bounded : std::pow(bounded, params_.relative);
  }

  /// What crosses the edges at the present Ψ and s, and the imbalance that it leaves:
  ///   r = S (s⁰ - s) + supply - loss - h T Ψ,   S = M times pores
  /// Returns the largest, as u.
  double find_error(double share, const Values& u) {
    const SheetGraph& graph = *in_.graph;
    const double h = conductance(share);
    for_each_edge(graph, [&](std::size_t i, std::size_t j, std::size_t e) {
      kr_[e] = relative_permeability(s_[psi_[i] >= psi_[j] ? i : j]);
      transfer_[e] = h * edges_.edge[e] * kr_[e] * (psi_[i] - psi_[j]);
    });
    return parallel_max(u.size(), chunk, 0.0, [&](std::size_t begin, std::size_t end) {
      double most = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const double mass = (*in_.mass)[i], supply = share * supply_[i], loss = share * loss_[i];
        const double now = pores_[i] * s_[i];
        rhs_[i] = holds(i) ? mass * (u[i] - now) + supply * (source(i) - now) - loss * now -
                                 net_outflow(graph, transfer_, i)
                           : 0.0;
        if (!holds(i)) continue;
        const double error = std::abs(rhs_[i]) / (mass + supply + loss);
        most = std::max(most, error <= 1e300 ? error : 1e300);  // not a number counts as far away
      }
      return most;
    });
  }

  /// One modified Picard iteration:  (S C + rates C + h T) δ = r,   C = ds/dΨ,   Ψ += δ.
  void correct(double share) {
    parallel_for(s_.size(), chunk, [&](std::size_t i) {
      const double slope = pores_[i] * retention_.storage(s_[i], stiffness_[i]);
      op_.storage[i] = (*in_.mass)[i] * slope;
      extra_[i] = share * (supply_[i] + loss_[i]) * slope;
    });
    assemble(*in_.graph, op_, conductance(share), extra_, kr_, matrix_);
    delta_.assign(s_.size(), 0.0);
    // Four digits of each correction: the next one sees what is left.
    note(solver_.solve(matrix_, rhs_, 1e-4, delta_));
    parallel_for(s_.size(), chunk, [&](std::size_t i) {
      if (!holds(i)) return;
      psi_[i] += delta_[i];
      s_[i] = retention_.saturation(psi_[i], stiffness_[i], lift_[i]);
    });
  }

  void note(const SolveReport& solve) {
    ++iterations_;
    result_.solve.iterations += solve.iterations;
    result_.solve.seconds += solve.seconds;
  }

  /// Moves the amounts, exactly conserved, and books what supply and loss did.
  void exchange(double share, Values& u) {
    const SheetGraph& graph = *in_.graph;
    const std::size_t n = u.size();
    for (double& amount : transfer_)
      if (!std::isfinite(amount)) amount = 0.0;
    content_.resize(n);
    room_.resize(in_.capacity > 0.0 ? n : 0);
    parallel_for(n, chunk, [&](std::size_t i) {
      const double mass = (*in_.mass)[i], supply = share * supply_[i], loss = share * loss_[i];
      content_[i] = mass * u[i] + supply * source(i);
      // What Picard leaves of imbalance is no overflow: the projection on the capacity takes it.
      const double full = (in_.capacity + tolerance_) * (mass + supply + loss);
      if (!room_.empty()) room_[i] = std::max(0.0, full - content_[i]);
    });
    limit_transfers(graph, content_, room_, transfer_);
    result_.lost += sum_of(n, [&](std::size_t i) {
      if (!holds(i)) return 0.0;
      const double mass = (*in_.mass)[i], supply = share * supply_[i], loss = share * loss_[i];
      const double out = net_outflow(graph, transfer_, i);
      const double before = u[i];
      u[i] = std::max(0.0, (content_[i] - out) / (mass + supply + loss));
      const double lost = loss * u[i];
      if (supply > 0.0) result_.given[i] += mass * (u[i] - before) + lost + out;
      return lost;
    });
  }
};

}  // namespace

Values pore_pressure(const PorousParams& params, const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                     const Values* rest_scale, const Values& u) {
  Values pressure = vertex_dilation(mesh, x, rest_scale);
  parallel_for(pressure.size(), chunk, [&](std::size_t i) {
    const Pores pores = pores_at(params, pressure[i]);
    pressure[i] = pores.stiffness * std::clamp(u[i] / pores.full, 0.0, 1.0);
  });
  return pressure;
}

TransferResult flow_through_pores(const PorousParams& params, const TransferInput& input,
                                  const SheetOperator& edges, double tolerance, LinearSolver& solver, Values& u) {
  constexpr double least_share = 1.0 / 256.0;
  TransferResult result;
  result.given.assign(u.size(), 0.0);
  PorousStep step(params, input, edges, tolerance, solver, result);

  // Halve until Picard converges, grow again where it did so quickly.
  double done = 0.0, share = 1.0;
  while (done < 1.0) {
    share = std::min(share, 1.0 - done);
    const int before = step.iterations();
    if (!step.advance(share, share <= least_share, u)) {
      share *= 0.5;
      continue;
    }
    done += share;
    if (step.iterations() - before <= 10) share *= 2.0;
  }
  return result;
}

}  // namespace wick::diffusion
