#include "fluid/multigrid.h"

#include <cmath>

#include "core/parallel.h"
#include "fluid/multigrid_wavefront.h"

namespace wick::fluid {

namespace {

/// Sums in a fixed order: eight lanes within a row, rows in order within a plane, planes in order.
class Lanes {
 public:
  template <class A, class B>
  void add_product(const A* __restrict a, const B* __restrict b, int count) {
    int m = 0;
    for (; m + 8 <= count; m += 8)
      for (int l = 0; l < 8; ++l) lane_[l] += double(a[m + l]) * double(b[m + l]);
    for (; m < count; ++m) lane_[m & 7] += double(a[m]) * double(b[m]);
  }
  [[nodiscard]] double sum() const {
    return ((lane_[0] + lane_[1]) + (lane_[2] + lane_[3])) + ((lane_[4] + lane_[5]) + (lane_[6] + lane_[7]));
  }

 private:
  double lane_[8] = {};
};

/// Calls body(colour, j, offset, row) for both colours of the rows of plane k.
template <class Body>
void for_rows(const Layout& layout, int k, Body&& body) {
  for (int j = 0; j < layout.ny; ++j)
    for (int c = 0; c < 2; ++c) body(c, j, Layout::offset(c, j, k), layout.row(j, k));
}

std::size_t plane_grain(const Layout& layout) {
  return layout.cells() > 20000 ? 2 : static_cast<std::size_t>(layout.nz);
}

template <class Body>
double sum_planes(const Layout& layout, Body&& body) {
  return parallel_sum(layout.nz, 1, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t k = begin; k < end; ++k) sum += body(static_cast<int>(k));
    return sum;
  });
}

double* row_work(int count) {
  thread_local std::vector<double> work;
  if (work.size() < std::size_t(count)) work.resize(count);
  return work.data();
}

}  // namespace

Multigrid::Multigrid(const Grid& grid, const Sides& sides) {
  graphs_.push_back(finest_graph(grid, sides));
  while (!graphs_.back().single_box()) graphs_.push_back(coarser_graph(graphs_.back()));
  for (std::size_t l = 0; l < graphs_.size(); ++l) {
    levels_.emplace_back(graphs_[l]);
    if (l == 0) continue;
    // The coefficient of a coarsened axis grows by 2 for every other axis that is coarsened with it, and halves.
    const auto& halves = graphs_[l - 1].halves;
    levels_[l].restriction = std::ldexp(1.0F, 2 - halves[0] - halves[1] - halves[2]);
  }
  installed_.resize(graphs_.size());
  const Layout& layout = levels_[0].layout;
  x_ = make_coloured(layout, 0.0);
  r_ = make_coloured(layout, 0.0);
  direction_ = make_coloured(layout, 0.0F);
}

void Multigrid::set_walls(const Walls& walls, const std::vector<Graph::WeakFace>& weak) {
  const Layout& layout = levels_[0].layout;
  Grid grid{.nx = layout.nx, .ny = layout.ny, .nz = layout.nz};
  build_finest(grid, walls, weak, graphs_[0]);
  for (std::size_t l = 0; l + 1 < graphs_.size(); ++l) build_coarser(graphs_[l], graphs_[l + 1]);
  // Levels do not touch one another, nor do their transfer lists; the first and finest ones take longest.
  parallel_for(graphs_.size() + 1, 1, [&](std::size_t l) {
    if (l < graphs_.size()) return install_level(graphs_[l], levels_[l], installed_[l]);
    part_ = closed_parts(graphs_, weak, parts_);
  });
  parallel_for(graphs_.size() - 1, 1, [&](std::size_t l) {
    install_transfer(graphs_[l], installed_[l], levels_[l], graphs_[l + 1], installed_[l + 1], levels_[l + 1]);
  });
}

void Multigrid::subtract_part_means(std::vector<double>& field, double* removed) const {
  if (part_.empty()) return;
  std::vector<double> sum(parts_, 0.0), count(parts_, 0.0);
  const std::size_t plane = std::size_t(levels_[0].layout.nx) * levels_[0].layout.ny;
  // One running sum a part, in cell order: rounding of 2 Mi cells stays below 1e-12 of the largest value.
  for (std::size_t c = 0; c < field.size(); ++c)
    if (part_[c] >= 0) {
      sum[part_[c]] += field[c];
      count[part_[c]] += 1.0;
    }
  for (int n = 0; n < parts_; ++n) {
    if (removed != nullptr) *removed += std::abs(sum[n]);
    sum[n] /= count[n];
  }
  parallel_for(field.size(), plane, [&](std::size_t c) {
    if (part_[c] >= 0) field[c] -= sum[part_[c]];
  });
}

/// The same for values in two colours. Rounding of A x leaves a constant in closed parts that A cannot make, and
/// that conjugate gradients would chase in vain.
void Multigrid::subtract_part_means(Coloured<double>& field) const {
  if (part_.empty()) return;
  const Layout& layout = levels_[0].layout;
  std::vector<double> mean(parts_, 0.0), count(parts_, 0.0);
  const auto for_parts = [&](const auto& body) {
    for (int k = 0; k < layout.nz; ++k)
      for_rows(layout, k, [&](int c, int j, int o, std::ptrdiff_t row) {
        const auto* part = part_.data() + std::size_t(layout.nx) * layout.row_index(j, k) + o;
        double* values = field[c].data() + row;
        for (int m = 0; m < layout.count(o); ++m)
          if (part[2 * m] >= 0) body(part[2 * m], values[m]);
      });
  };
  for_parts([&](int n, double& value) { mean[n] += value, count[n] += 1.0; });
  for (int n = 0; n < parts_; ++n) mean[n] /= count[n];
  for_parts([&](int n, double& value) { value -= mean[n]; });
}

void Multigrid::load(const std::vector<double>& field, double scale, Coloured<double>& out) const {
  const Layout& layout = levels_[0].layout;
  parallel_for(layout.nz, plane_grain(layout), [&](std::size_t k) {
    for_rows(layout, static_cast<int>(k), [&](int c, int j, int o, std::ptrdiff_t row) {
      const double* from = field.data() + std::size_t(layout.nx) * layout.row_index(j, static_cast<int>(k)) + o;
      double* to = out[c].data() + row;
      for (int m = 0; m < layout.count(o); ++m) to[m] = from[2 * m] * scale;
    });
  });
}

void Multigrid::store(const Coloured<double>& in, double scale, std::vector<double>& field) const {
  const Layout& layout = levels_[0].layout;
  parallel_for(layout.nz, plane_grain(layout), [&](std::size_t k) {
    for_rows(layout, static_cast<int>(k), [&](int c, int j, int o, std::ptrdiff_t row) {
      double* to = field.data() + std::size_t(layout.nx) * layout.row_index(j, static_cast<int>(k)) + o;
      const double* from = in[c].data() + row;
      for (int m = 0; m < layout.count(o); ++m) to[2 * m] = from[m] * scale;
    });
  });
}

/// r += factor E p, with p at the cells of the term.
void Multigrid::add_term(const MovableTerm& extra, double factor, const std::vector<double>& at_cells) {
  std::vector<double> product(at_cells.size(), 0.0);
  extra.add_product(at_cells, factor, product);
  for (std::size_t c = 0; c < product.size(); ++c)
    r_[extra.cells()[c].colour][extra.cells()[c].place] += product[c];
}

/// r = scale f - A x, b = r; returns |r|².
double Multigrid::update_residual(const std::vector<double>& f, double scale, const MovableTerm* extra) {
  Level& level = levels_[0];
  const Layout& layout = level.layout;
  if (level.periodic) fill_rim(level, x_);
  load(f, scale, r_);
  parallel_for(layout.nz, plane_grain(layout), [&](std::size_t plane) {
    const int k = static_cast<int>(plane);
    double* product = row_work(layout.half());
    for_rows(layout, k, [&](int c, int j, int o, std::ptrdiff_t row) {
      apply_row(level, x_, c, j, k, product);
      double* r = r_[c].data() + row;
      for (int m = 0; m < layout.count(o); ++m) r[m] -= product[m];
    });
  });
  if (extra != nullptr) add_term(*extra, -1.0, extra->gather(x_));
  subtract_part_means(r_);
  return sum_planes(layout, [&](int k) {
    Lanes lanes;
    for_rows(layout, k, [&](int c, int, int o, std::ptrdiff_t row) {
      const double* r = r_[c].data() + row;
      float* b = level.b[c].data() + row;
      for (int m = 0; m < layout.count(o); ++m) b[m] = static_cast<float>(r[m]);
      lanes.add_product(r, r, layout.count(o));
    });
    return lanes.sum();
  });
}

/// d = z + beta d; returns d·A d.
double Multigrid::turn_direction(double beta, const MovableTerm* extra) {
  const Level& level = levels_[0];
  const Layout& layout = level.layout;
  std::vector<double> partial(layout.nz);
  const auto turn = [&](int k) {
    for_rows(layout, k, [&](int c, int, int o, std::ptrdiff_t row) {
      float* __restrict d = direction_[c].data() + row;
      const float* __restrict z = level.p[c].data() + row;
      const auto factor = static_cast<float>(beta);
      for (int m = 0; m < layout.count(o); ++m) d[m] = z[m] + factor * d[m];
    });
  };
  const auto multiply = [&](int k) {
    double* product = row_work(layout.half());
    Lanes lanes;
    for_rows(layout, k, [&](int c, int j, int o, std::ptrdiff_t row) {
      apply_row(level, direction_, c, j, k, product);
      lanes.add_product(product, direction_[c].data() + row, layout.count(o));
    });
    partial[k] = lanes.sum();
  };
  if (level.periodic) {
    parallel_for(layout.nz, plane_grain(layout), [&](std::size_t k) { turn(static_cast<int>(k)); });
    fill_rim(level, direction_);
    parallel_for(layout.nz, plane_grain(layout), [&](std::size_t k) { multiply(static_cast<int>(k)); });
  } else {
    wavefront(layout.nz, 2, level.large(), [&](int stage, int k) { stage == 0 ? turn(k) : multiply(k); });
  }
  double sum = 0.0;
  for (const double part : partial) sum += part;
  if (layer_) layer_->turn(beta);
  return extra != nullptr ? sum + extra->quadratic(layer_ ? layer_->direction() : extra->gather(direction_)) : sum;
}

/// x += alpha d, r -= alpha A d, b = r; returns |r|². A d is formed again: cheaper than keeping it.
double Multigrid::advance(double alpha, const MovableTerm* extra) {
  Level& level = levels_[0];
  const Layout& layout = level.layout;
  if (extra != nullptr) add_term(*extra, -alpha, layer_ ? layer_->direction() : extra->gather(direction_));
  if (layer_) layer_->advance(alpha, direction_, x_, r_);
  std::vector<double> partial(layout.nz);
  parallel_for(layout.nz, plane_grain(layout), [&](std::size_t plane) {
    const int k = static_cast<int>(plane);
    double* __restrict product = row_work(layout.half());
    Lanes lanes;
    for_rows(layout, k, [&](int c, int j, int o, std::ptrdiff_t row) {
      apply_row(level, direction_, c, j, k, product);
      const float* __restrict d = direction_[c].data() + row;
      double* __restrict x = x_[c].data() + row, * __restrict r = r_[c].data() + row;
      float* __restrict b = level.b[c].data() + row;
      for (int m = 0; m < layout.count(o); ++m) {
        x[m] += alpha * double(d[m]);
        r[m] -= alpha * product[m];
        b[m] = static_cast<float>(r[m]);
      }
      lanes.add_product(r, r, layout.count(o));
    });
    partial[k] = lanes.sum();
  });
  double sum = 0.0;
  for (const double part : partial) sum += part;
  return sum;
}

/// z of the residual: one cycle, then the cells beside light masses exactly.
void Multigrid::precondition() {
  v_cycle(levels_);
  if (!layer_) return;
  layer_->correct(r_, levels_[0].p);
}

/// r·z with the float r that the preconditioner has seen.
double Multigrid::preconditioned_product() const {
  const Level& level = levels_[0];
  return sum_planes(level.layout, [&](int k) {
    Lanes lanes;
    for_rows(level.layout, k, [&](int c, int, int o, std::ptrdiff_t row) {
      lanes.add_product(level.b[c].data() + row, level.p[c].data() + row, level.layout.count(o));
    });
    return lanes.sum();
  });
}

/// Runs conjugate gradients until the true residual is below `target` (both squared norms).
int Multigrid::iterate(const std::vector<double>& f, double scale, const MovableTerm* extra, double target,
                       int max_iterations, double& residual) {
  int iterations = 0;
  double last_product = 0.0, last_exact = residual, least = residual;
  bool exact = true, kept = false;
  while (iterations < max_iterations && residual > target) {
    precondition();
    const double product = preconditioned_product();
    const double curvature = turn_direction(last_product > 0.0 ? product / last_product : 0.0, extra);
    // Rounding has used up the direction, or something is not finite: what was reached is what there is.
    if (!(curvature > 0.0) || !(product > 0.0) || !std::isfinite(product / curvature)) break;
    residual = advance(product / curvature, extra);
    last_product = product;
    ++iterations;
    // The recursive residual drifts from the true one by rounding: form the true one before believing it,
    // and start afresh from it if it is larger.
    exact = !(residual > target) || iterations == max_iterations;
    if (!exact) continue;
    residual = update_residual(f, scale, extra);
    last_product = 0.0;
    if (residual > target && residual < least) {
      // Keep it: where rounding is all that is left, going on can make it worse by any factor.
      least = residual;
      best_ = x_;
      kept = true;
    }
    // Half the residual is the least that a fresh start must bring; with less, rounding is all that is left.
    if (!(residual <= 0.25 * last_exact)) break;
    last_exact = residual;
  }
  if (!exact) residual = update_residual(f, scale, extra);
  if (kept && !(residual <= least)) {
    x_ = best_;
    residual = update_residual(f, scale, extra);
  }
  return iterations;
}

SolveReport Multigrid::solve(std::vector<double>& f, std::vector<double>& p, const MovableTerm* extra,
                             double tolerance, int max_iterations) {
  SolveReport report;
  subtract_part_means(f, &report.rhs_sum);
  const double largest = parallel_max(f.size(), 1U << 15, 0.0, [&](std::size_t begin, std::size_t end) {
    double value = 0.0;
    // A comparison alone would step over NaN.
    for (std::size_t c = begin; c < end; ++c) value = std::abs(f[c]) <= value ? value : std::abs(f[c]);
    return value;
  });
  // Zero times anything that is not finite is NaN.
  const double check = parallel_sum(f.size(), 1U << 15, [&](std::size_t begin, std::size_t end) {
    double zeros = 0.0;
    for (std::size_t c = begin; c < end; ++c) zeros += 0.0 * f[c];
    return zeros;
  });
  if (check != 0.0 || !std::isfinite(largest)) {
    report.converged = false;
    report.residual_before = report.residual_after = std::numeric_limits<double>::quiet_NaN();
    return report;
  }
  // Below this the squares of a scaled problem would leave the range of doubles: nothing to solve.
  if (largest < 1e-290) {
    std::fill(p.begin(), p.end(), 0.0);
    return report;
  }
  const double scale = 1.0 / largest;
  for (auto& x : x_) std::fill(x.begin(), x.end(), 0.0);
  const double norm = update_residual(f, scale, nullptr);
  load(p, scale, x_);
  double residual = update_residual(f, scale, extra);
  // A guess that is worse than none (or not finite) is dropped.
  if (!(residual <= norm)) {
    for (auto& x : x_) std::fill(x.begin(), x.end(), 0.0);
    residual = update_residual(f, scale, nullptr);
  }
  report.residual_before = std::sqrt(residual / norm);
  layer_.reset();
  if (extra != nullptr && extra->light()) {
    // Begin with no residual in the layer: only then is the preconditioner of pressure_layer.h symmetric.
    layer_.emplace(levels_[0], *extra);
    for (auto* field : {&levels_[0].p, &direction_})
      for (auto& values : *field) std::fill(values.begin(), values.end(), 0.0F);
    layer_->correct(r_, levels_[0].p);
    layer_->turn(0.0);
    layer_->advance(1.0, direction_, x_, r_);
    residual = update_residual(f, scale, extra);
  }
  report.iterations = iterate(f, scale, extra, tolerance * tolerance * norm, max_iterations, residual);
  report.residual_after = std::sqrt(residual / norm);
  report.converged = report.residual_after <= tolerance * (1.0 + 1e-12);
  store(x_, largest, p);
  subtract_part_means(p, nullptr);
  return report;
}

}  // namespace wick::fluid
