#include "diffusion/linear_solver.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <chrono>
#include <cmath>

namespace wick::diffusion {

namespace {

using Values = std::vector<double>;
using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>;

/// Two sums made in one pass, chunk by chunk.
struct Pair {
  double first = 0.0, second = 0.0;
};

template <class Body>
Pair pair_sum(std::size_t count, std::vector<Pair>& partial, Body&& body) {
  partial.assign((count + chunk - 1) / chunk, {});
  parallel_chunks(count, chunk,
                  [&](std::size_t begin, std::size_t end) { partial[begin / chunk] = body(begin, end); });
  Pair total;
  for (const Pair& p : partial) total = {total.first + p.first, total.second + p.second};
  return total;
}

double row_product(const SheetMatrix& a, const Values& x, std::size_t i) {
  double sum = a.diagonal[i] * x[i];
  for (std::int32_t k = a.graph->offset[i]; k < a.graph->offset[i + 1]; ++k)
    sum += a.entry[k] * x[a.graph->column[k]];
  return sum;
}

/// Mean of each component that the row sums fix: 1ᵀA (m 1) = 1ᵀb.
void split_mean(const SheetMatrix& a, const Values& rhs, Values& mean) {
  mean.assign(rhs.size(), 0.0);
  const VertexGroups& groups = a.graph->components;
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const double amount = sum_over(groups[g], [&](std::size_t i) { return rhs[i]; });
    const double capacity = sum_over(groups[g], [&](std::size_t i) { return a.row_sum[i]; });
    for (const std::int32_t i : groups[g]) mean[i] = amount / capacity;
  }
}

/// What identifies a reference matrix: equal keys, equal factors.
struct FactorKey {
  double diffusion = -1.0;          ///< rounded dt α (per unit density)
  std::vector<std::int8_t> supply;  ///< rounded log16 of row sum over storage
  bool operator==(const FactorKey&) const = default;
};

/// Steps of 2^(1/4) keep the reference within 10 % of the matrix, and one factor serves time steps that nearly
/// agree.
FactorKey make_key(const SheetMatrix& a) {
  FactorKey key;
  key.diffusion = std::exp2(std::round(4.0 * std::log2(a.diffusion)) / 4.0);
  key.supply.resize(a.storage.size());
  for (std::size_t i = 0; i < key.supply.size(); ++i)
    key.supply[i] =
        static_cast<std::int8_t>(std::min(std::round(std::log2(a.row_sum[i] / a.storage[i]) / 4.0), 100.0));
  return key;
}

}  // namespace

double estimated_iterations(const SheetMatrix& a, double tolerance) {
  const std::size_t n = a.diagonal.size();
  if (n == 0) return 0.0;
  const double root =
      sum_of(n, [&](std::size_t i) { return std::sqrt(a.diagonal[i] / a.row_sum[i]); }) / static_cast<double>(n);
  return 0.5 * std::sqrt(0.5) * root * std::log(2.0 / tolerance);
}

struct LinearSolver::Impl {
  Values residual, direction, preconditioned, product, inverse_diagonal, row_weight, shifted, mean, deviation;
  std::vector<Pair> partial;
  Eigen::SparseMatrix<double> lower;
  Factor factor;
  bool analysed = false, usable = false;
  FactorKey key;

  /// Fills `lower` with diag + off-diagonal values.
  template <class Diagonal, class Entry>
  bool factorise(const SheetGraph& graph, Diagonal&& diagonal, Entry&& entry) {
    const int n = static_cast<int>(graph.offset.size()) - 1;
    if (!analysed) {
      lower.resize(n, n);
      lower.reserve(n + static_cast<int>(graph.column.size()) / 2);
      for (int j = 0; j < n; ++j) {
        lower.startVec(j);
        lower.insertBack(j, j) = 1.0;
        for (std::int32_t k = graph.offset[j]; k < graph.offset[j + 1]; ++k)
          if (graph.column[k] > j) lower.insertBack(graph.column[k], j) = 0.0;
      }
      lower.finalize();
      factor.analyzePattern(lower);
      analysed = true;
    }
    double* value = lower.valuePtr();
    for (int j = 0; j < n; ++j) {
      *value++ = diagonal(static_cast<std::size_t>(j));
      for (std::int32_t k = graph.offset[j]; k < graph.offset[j + 1]; ++k)
        if (graph.column[k] > j) *value++ = entry(static_cast<std::size_t>(k));
    }
    factor.factorize(lower);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXd pivots = factor.vectorD();
    return std::all_of(pivots.begin(), pivots.end(), [](double pivot) { return pivot > 0.0; });
  }

  /// Factor of the reference matrix, in symmetric scaling with the matrix itself left to the caller.
  bool prepare_reference(const SheetMatrix& a) {
    FactorKey wanted = make_key(a);
    if (usable && wanted == key) return true;
    const SheetOperator& op = *a.reference;
    const SheetGraph& graph = *a.graph;
    Values sum(op.storage.size());
    for (std::size_t i = 0; i < sum.size(); ++i)
      for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) sum[i] += op.edge[graph.entry_edge[k]];
    // The mean is solved apart, so the reference may hold a little more than the matrix: keeps pivots positive.
    const auto diagonal = [&](std::size_t i) {
      const double storage = op.storage[i] > 0.0 ? op.storage[i] * std::exp2(4.0 * wanted.supply[i]) : 1.0;
      const double flux = wanted.diffusion * sum[i];
      return std::max(storage, 1e-9 * flux) + flux;
    };
    usable =
        factorise(graph, diagonal, [&](std::size_t k) { return -wanted.diffusion * op.edge[graph.entry_edge[k]]; });
    key = std::move(wanted);
    return usable;
  }

  bool prepare_exact(const SheetMatrix& a) {
    usable = false;
    return factorise(
        *a.graph, [&](std::size_t i) { return a.diagonal[i] * (1.0 + 1e-12); },
        [&](std::size_t k) { return a.entry[k]; });
  }

  /// Weighted norm of rhs - A v; fills residual.
  double true_residual(const SheetMatrix& a, const Values& rhs, const Values& v) {
    return std::sqrt(pair_sum(v.size(), partial, [&](std::size_t begin, std::size_t end) {
                       Pair p;
                       for (std::size_t i = begin; i < end; ++i) {
                         residual[i] = rhs[i] - row_product(a, v, i);
                         const double weighted = residual[i] * row_weight[i];
                         p.first += weighted * weighted;
                       }
                       return p;
                     }).first);
  }

  /// v += step * direction, r -= step * A direction and z = P⁻¹ r; returns (r.z, weighted r.r).
  Pair advance(bool factored, double step, Values& v) {
    const auto update = [&](std::size_t i) {
      v[i] += step * direction[i];
      residual[i] -= step * product[i];
    };
    if (factored) {
      parallel_for(v.size(), chunk, update);
      const Eigen::Map<const Eigen::VectorXd> r(residual.data(), static_cast<Eigen::Index>(residual.size()));
      Eigen::Map<Eigen::VectorXd>(preconditioned.data(), r.size()) = factor.solve(r);
    }
    return pair_sum(v.size(), partial, [&](std::size_t begin, std::size_t end) {
      Pair p;
      for (std::size_t i = begin; i < end; ++i) {
        if (!factored) {
          update(i);
          preconditioned[i] = residual[i] * inverse_diagonal[i];
        }
        const double weighted = residual[i] * row_weight[i];
        p.first += residual[i] * preconditioned[i];
        p.second += weighted * weighted;
      }
      return p;
    });
  }

  /// Preconditioned conjugate gradients from v, whose residual is in place; stops at `target` or after `limit`.
  int iterate(const SheetMatrix& a, bool factored, double target, int limit, Values& v) {
    const std::size_t n = v.size();
    direction.assign(n, 0.0);
    product.assign(n, 0.0);
    Pair rho = advance(factored, 0.0, v);
    direction = preconditioned;
    for (int iteration = 1; iteration <= limit; ++iteration) {
      const double curvature = pair_sum(n, partial, [&](std::size_t begin, std::size_t end) {
                                 Pair p;
                                 for (std::size_t i = begin; i < end; ++i) {
                                   product[i] = row_product(a, direction, i);
                                   p.first += product[i] * direction[i];
                                 }
                                 return p;
                               }).first;
      if (!(curvature > 0.0)) return iteration;
      const Pair next = advance(factored, rho.first / curvature, v);
      if (!(next.first > 0.0) || std::sqrt(next.second) <= target) return iteration;
      const double beta = next.first / rho.first;
      parallel_for(n, chunk, [&](std::size_t i) { direction[i] = preconditioned[i] + beta * direction[i]; });
      rho = next;
    }
    return limit;
  }

  /// Restarts CG from the true residual while the recursive one has drifted from it.
  double run(const SheetMatrix& a, bool factored, double target, int limit, Values& v, double norm,
             SolveReport& report) {
    for (int restart = 0; restart < 3 && norm > target && std::isfinite(norm); ++restart) {
      report.iterations += iterate(a, factored, 0.9 * target, limit, v);
      norm = true_residual(a, shifted, v);
    }
    return norm;
  }
};

LinearSolver::LinearSolver() : impl_(std::make_unique<Impl>()) {}
LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;
LinearSolver& LinearSolver::operator=(LinearSolver&&) noexcept = default;

void LinearSolver::reset() {
  impl_ = std::make_unique<Impl>();
}

SolveReport LinearSolver::solve(const SheetMatrix& a, const Values& rhs, double tolerance, Values& x) {
  const auto start = std::chrono::steady_clock::now();
  Impl& s = *impl_;
  const std::size_t n = rhs.size();
  for (Values* field :
       {&s.residual, &s.preconditioned, &s.inverse_diagonal, &s.row_weight, &s.shifted, &s.deviation})
    field->resize(n);

  // Take the mean out: A (m + v) = b becomes A v = b - (row sum) m.
  split_mean(a, rhs, s.mean);
  const Values& mean = s.mean;
  Values& v = s.deviation;
  parallel_for(n, chunk, [&](std::size_t i) { s.row_weight[i] = a.storage[i] / a.row_sum[i]; });
  const double scale = std::sqrt(sum_of(n, [&](std::size_t i) {
    const double weighted = rhs[i] * s.row_weight[i];
    return weighted * weighted;
  }));
  parallel_for(n, chunk, [&](std::size_t i) {
    s.shifted[i] = rhs[i] - a.row_sum[i] * mean[i];
    s.inverse_diagonal[i] = 1.0 / a.diagonal[i];
    v[i] = x[i] - mean[i];
  });
  SolveReport report;
  report.rhs_sum = sum_of(n, [&](std::size_t i) { return rhs[i]; });

  // Start from the guess or from the mean, whichever is nearer.
  double norm = s.true_residual(a, s.shifted, v);
  const double norm_of_mean = std::sqrt(sum_of(n, [&](std::size_t i) {
    const double weighted = s.shifted[i] * s.row_weight[i];
    return weighted * weighted;
  }));
  if (!(norm <= norm_of_mean)) {
    std::fill(v.begin(), v.end(), 0.0);
    s.residual = s.shifted;
    norm = norm_of_mean;
  }
  const double unit = scale > 0.0 ? 1.0 / scale : 1.0, target = tolerance * scale;
  report.residual_before = norm * unit;

  // Diagonal while few iterations are promised, then the reference factor, then the factor of A itself.
  constexpr int diagonal_limit = 600, factored_limit = 60;
  // An exact factor serves only once and costs several times as much as one of the reference that is kept.
  const bool kept = a.reference != nullptr;
  const bool promising = estimated_iterations(a, tolerance) <= (kept ? 1.0 : 4.0) * factor_threshold;
  if (promising) norm = s.run(a, false, target, diagonal_limit, v, norm, report);
  if (norm > target && !promising && kept && s.prepare_reference(a))
    norm = s.run(a, true, target, factored_limit, v, norm, report);
  if (norm > target && s.prepare_exact(a)) norm = s.run(a, true, target, factored_limit, v, norm, report);

  parallel_for(n, chunk, [&](std::size_t i) { x[i] = mean[i] + v[i]; });
  report.residual_after = norm * unit;
  report.converged = norm <= target;
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace wick::diffusion
