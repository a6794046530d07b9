#include "fluid/fast_poisson.h"

#include <fftw3.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "core/parallel.h"

namespace wick::fluid {

namespace {

/// Columns handled together: a cache line's worth of doubles, twice.
constexpr int batch = 16;

struct AlignedBuffer {
  explicit AlignedBuffer(std::size_t count) : data(fftw_alloc_real(count)) {}
  ~AlignedBuffer() { fftw_free(data); }
  AlignedBuffer(const AlignedBuffer&) = delete;
  AlignedBuffer& operator=(const AlignedBuffer&) = delete;
  double* data;
};

/// FFTW's planner is not thread-safe; its executors are.
std::mutex& planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

struct Kinds {
  fftw_r2r_kind forward, backward;
};

/// The transform whose basis vectors satisfy the conditions of the two sides [Strang 1999, The DCT].
Kinds transform_kinds(Side low, Side high) {
  if (low == Side::periodic) return {FFTW_R2HC, FFTW_HC2R};
  if (low == Side::closed && high == Side::closed) return {FFTW_REDFT10, FFTW_REDFT01};
  if (low == Side::open && high == Side::open) return {FFTW_RODFT10, FFTW_RODFT01};
  if (low == Side::closed) return {FFTW_REDFT11, FFTW_REDFT11};
  return {FFTW_RODFT11, FFTW_RODFT11};
}

/// Eigenvalues of 2 p_i - p_(i-1) - p_(i+1) in the order of the transform:
/// 4 sin²(π κ / 2N), κ = k, k + 1, k + ½; periodic 4 sin²(π k / N).
std::vector<double> eigenvalues(int n, Side low, Side high) {
  std::vector<double> values(n);
  for (int k = 0; k < n; ++k) {
    double angle = 0.0;
    if (low == Side::periodic)
      angle = std::numbers::pi * std::min(k, n - k) / n;
    else if (low != high)
      angle = std::numbers::pi * (k + 0.5) / (2.0 * n);
    else
      angle = std::numbers::pi * (low == Side::open ? k + 1 : k) / (2.0 * n);
    const double s = std::sin(angle);
    values[k] = 4.0 * s * s;
  }
  return values;
}

/// Transforms along one axis, forth and back, `batch` interleaved lines at a time in a buffer of its own.
///
/// Plans are made with FFTW_ESTIMATE: it chooses by operation counts alone, so the same box always gets the
/// same plan and a run repeats bit for bit. FFTW_MEASURE is faster but chooses by the clock, and two plans
/// round differently.
class LineTransform {
 public:
  LineTransform(int n, Side low, Side high)
      : n_(n), scale_(1.0 / ((low == Side::periodic ? 1.0 : 2.0) * n)), eigenvalues_(eigenvalues(n, low, high)) {
    const Kinds kinds = transform_kinds(low, high);
    AlignedBuffer buffer(std::size_t(n) * batch);
    const std::lock_guard lock(planner_mutex());
    for (const bool back : {false, true}) {
      const fftw_r2r_kind kind = back ? kinds.backward : kinds.forward;
      // Lines one after the other for x (already contiguous), interleaved for y and z.
      rows_[back] = fftw_plan_many_r2r(1, &n_, 1, buffer.data, nullptr, 1, n, buffer.data, nullptr, 1, n, &kind,
                                       FFTW_ESTIMATE | FFTW_UNALIGNED);
      columns_[back] = fftw_plan_many_r2r(1, &n_, batch, buffer.data, nullptr, batch, 1, buffer.data, nullptr,
                                          batch, 1, &kind, FFTW_ESTIMATE);
    }
  }
  ~LineTransform() {
    const std::lock_guard lock(planner_mutex());
    for (const bool back : {false, true}) {
      fftw_destroy_plan(rows_[back]);
      fftw_destroy_plan(columns_[back]);
    }
  }
  LineTransform(const LineTransform&) = delete;
  LineTransform& operator=(const LineTransform&) = delete;

  [[nodiscard]] double eigenvalue(int k) const { return eigenvalues_[k]; }
  /// What a transform forth and back multiplies by, inverted.
  [[nodiscard]] double scale() const { return scale_; }

  void row(bool back, double* line) const { fftw_execute_r2r(rows_[back], line, line); }

  /// Transforms `count` <= batch neighbouring columns whose elements lie `stride` apart.
  void columns(bool back, double* first, std::size_t stride, int count, double* buffer) const {
    for (int i = 0; i < n_; ++i) std::copy_n(first + i * stride, count, buffer + std::size_t(i) * batch);
    if (count < batch)
      for (int i = 0; i < n_; ++i) std::fill_n(buffer + std::size_t(i) * batch + count, batch - count, 0.0);
    fftw_execute_r2r(columns_[back], buffer, buffer);
    for (int i = 0; i < n_; ++i) std::copy_n(buffer + std::size_t(i) * batch, count, first + i * stride);
  }

 private:
  int n_;
  double scale_;
  std::vector<double> eigenvalues_;
  fftw_plan rows_[2], columns_[2];
};

}  // namespace

struct FastPoisson::Impl {
  Impl(const Int3& cells, const Sides& box_sides)
      : n(cells),
        sides(box_sides),
        x(n[0], sides[0], sides[1]),
        y(n[1], sides[2], sides[3]),
        z(n[2], sides[4], sides[5]) {
    singular = std::none_of(sides.begin(), sides.end(), [](Side side) { return side == Side::open; });
  }

  Int3 n;
  Sides sides;
  LineTransform x, y, z;
  bool singular;

  [[nodiscard]] std::size_t plane() const { return std::size_t(n[0]) * n[1]; }

  /// Transforms one plane of constant z along x and y.
  void transform_plane(bool back, double* p, double* buffer) const {
    const auto along_y = [&] {
      for (int i = 0; i < n[0]; i += batch) y.columns(back, p + i, n[0], std::min(batch, n[0] - i), buffer);
    };
    if (back) along_y();
    for (int j = 0; j < n[1]; ++j) x.row(back, p + std::size_t(j) * n[0]);
    if (!back) along_y();
  }

  void transform_planes(bool back, std::vector<double>& f) const {
    parallel_chunks(n[2], 1, [&](std::size_t begin, std::size_t end) {
      const AlignedBuffer buffer(std::size_t(n[1]) * batch);
      for (std::size_t k = begin; k < end; ++k) transform_plane(back, f.data() + k * plane(), buffer.data);
    });
  }

  void fill_lambda(int i, int j, int count, double* lambda) const {
    for (int c = 0; c < count; ++c) lambda[c] = x.eigenvalue(i + c) + y.eigenvalue(j);
  }

  /// Divides by the eigenvalues between two transforms along z.
  void divide_columns(double* first, const double* lambda, int count, double* buffer) const {
    const double scale = x.scale() * y.scale() * z.scale();
    z.columns(false, first, plane(), count, buffer);
    for (int k = 0; k < n[2]; ++k)
      for (int c = 0; c < count; ++c) {
        const double eigenvalue = lambda[c] + z.eigenvalue(k);
        double& value = first[k * plane() + c];
        // Only the constant mode of a box without an open side has eigenvalue 0; its amplitude is free.
        value = eigenvalue > 0.0 ? value * scale / eigenvalue : 0.0;
      }
    z.columns(true, first, plane(), count, buffer);
  }

  /// Solves (λ + d_k) p_k - p_(k-1) - p_(k+1) = f_k by elimination, `count` modes side by side; d is 2, or
  /// 1 next to a closed and 3 next to an open end. `ratio` holds n_z × batch values.
  void eliminate_columns(double* first, const double* lambda, int count, double* ratio) const {
    const auto end_term = [](Side side) { return side == Side::closed ? -1.0 : 1.0; };
    const double scale = x.scale() * y.scale();
    double last_ratio[batch] = {}, last_value[batch] = {};
    for (int k = 0; k < n[2]; ++k) {
      double d = 2.0;
      if (k == 0) d += end_term(sides[4]);
      if (k == n[2] - 1) d += end_term(sides[5]);
      double* row = first + k * plane();
      for (int c = 0; c < count; ++c) {
        // The last pivot of the free constant mode is 0: its end value is set to 0, the mean is taken out later.
        const bool free = singular && k == n[2] - 1 && lambda[c] == 0.0;
        const double inverse = free ? 0.0 : 1.0 / (lambda[c] + d - last_ratio[c]);
        last_value[c] = (row[c] * scale + last_value[c]) * inverse;
        last_ratio[c] = inverse;
        row[c] = last_value[c];
        ratio[std::size_t(k) * batch + c] = inverse;
      }
    }
    for (int k = n[2] - 2; k >= 0; --k) {
      double* row = first + k * plane();
      for (int c = 0; c < count; ++c) row[c] += ratio[std::size_t(k) * batch + c] * row[plane() + c];
    }
  }

  void solve_modes(std::vector<double>& f) const {
    const std::size_t blocks = (n[0] + batch - 1) / batch;
    parallel_chunks(n[1] * blocks, 8, [&](std::size_t begin, std::size_t end) {
      const AlignedBuffer buffer(std::size_t(n[2]) * batch);
      double lambda[batch];
      for (std::size_t block = begin; block < end; ++block) {
        const int j = static_cast<int>(block / blocks), i = batch * static_cast<int>(block % blocks);
        const int count = std::min(batch, n[0] - i);
        fill_lambda(i, j, count, lambda);
        double* first = f.data() + std::size_t(j) * n[0] + i;
        if (sides[4] == Side::periodic)
          divide_columns(first, lambda, count, buffer.data);
        else
          eliminate_columns(first, lambda, count, buffer.data);
      }
    });
  }

  void remove_mean(std::vector<double>& p) const {
    const double sum = parallel_sum(p.size(), 1U << 16, [&](std::size_t begin, std::size_t end) {
      double part = 0.0;
      for (std::size_t i = begin; i < end; ++i) part += p[i];
      return part;
    });
    const double mean = sum / static_cast<double>(p.size());
    parallel_for(p.size(), 1U << 16, [&](std::size_t i) { p[i] -= mean; });
  }
};

FastPoisson::FastPoisson(const Int3& cells, const Sides& sides) : impl_(std::make_unique<Impl>(cells, sides)) {}
FastPoisson::~FastPoisson() = default;
FastPoisson::FastPoisson(FastPoisson&&) noexcept = default;
FastPoisson& FastPoisson::operator=(FastPoisson&&) noexcept = default;

bool FastPoisson::singular() const {
  return impl_->singular;
}

void FastPoisson::solve(std::vector<double>& f) {
  impl_->transform_planes(false, f);
  impl_->solve_modes(f);
  impl_->transform_planes(true, f);
  if (impl_->singular) impl_->remove_mean(f);
}

}  // namespace wick::fluid
