#include "diffusion/rank_statistics.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "diffusion/strain_diffusion.h"

namespace wick::diffusion {

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first + 1;
    while (last < order.size() && values[order[last]] == values[order[first]]) ++last;
    for (std::size_t k = first; k < last; ++k) rank[order[k]] = 0.5 * static_cast<double>(first + 1 + last);
    first = last;
  }
  return rank;
}

double pearson(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  // Below this spread the values are equal up to rounding.
  const double least = 1e-20 * n;
  return aa > least * mean_a * mean_a && bb > least * mean_b * mean_b && aa > 0.0 && bb > 0.0
             ? ab / std::sqrt(aa * bb)
             : 0.0;
}

double spearman(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() < 3 ? 0.0 : pearson(ranks(a), ranks(b));
}

double partial_spearman(const std::vector<double>& a, const std::vector<double>& b,
                        std::span<const std::vector<double>> controls) {
  const auto n = static_cast<Eigen::Index>(a.size());
  if (n < static_cast<Eigen::Index>(controls.size()) + 4) return 0.0;
  Eigen::MatrixXd known(n, static_cast<Eigen::Index>(controls.size()) + 1);
  known.col(0).setOnes();
  for (std::size_t k = 0; k < controls.size(); ++k) {
    const std::vector<double> r = ranks(controls[k]);
    known.col(static_cast<Eigen::Index>(k) + 1) = Eigen::Map<const Eigen::VectorXd>(r.data(), n);
  }
  const auto solver = known.colPivHouseholderQr();
  const auto remainder = [&](const std::vector<double>& values) {
    const std::vector<double> r = ranks(values);
    const Eigen::Map<const Eigen::VectorXd> y(r.data(), n);
    const Eigen::VectorXd rest = y - known * solver.solve(y);
    // What the controls explain wholly leaves rounding behind, which correlates with nothing.
    if (rest.norm() < 1e-9 * y.norm()) return std::vector<double>(values.size(), 0.0);
    return std::vector<double>(rest.data(), rest.data() + n);
  };
  return pearson(remainder(a), remainder(b));
}

LineFit fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xy = 0.0, xx = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    yy += (y[i] - mean_y) * (y[i] - mean_y);
  }
  if (xx <= 0.0) return {0.0, mean_y, 0.0};
  const double slope = xy / xx;
  return {slope, mean_y - slope * mean_x, yy > 0.0 ? xy * xy / (xx * yy) : 1.0};
}

Spread spread(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto n = static_cast<double>(values.size());
  Spread s;
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  for (const double value : values) s.deviation += (value - s.mean) * (value - s.mean);
  s.deviation = n > 1.0 ? std::sqrt(s.deviation / (n - 1.0)) : 0.0;
  return s;
}

std::vector<double> smoothed(const solid::ShellMesh& mesh, const std::vector<double>& field, double width) {
  // Heat flow for a time t spreads with the variance 2 α t in each direction.
  constexpr int steps = 4;
  DiffusionParams params;
  params.model = Model::isotropic;
  params.alpha = 1.0;
  params.tolerance = 1e-10;
  DiffusionSolver solver(params);
  const double lowest = *std::min_element(field.begin(), field.end());
  std::vector<double> result = field;
  for (double& value : result) value -= lowest;  // the solver's quantities are not negative
  const DiffusionInput input{.mesh = &mesh, .x = &mesh.rest, .mass = &mesh.vertex_area};
  for (int k = 0; k < steps; ++k) solver.step(result, input, 0.5 * width * width / steps);
  for (double& value : result) value += lowest;
  return result;
}

double displacement_correlation(const std::vector<double>& u, const std::vector<double>& isotropic,
                                const std::vector<double>& strain) {
  // Mean of u at equal isotropic u: piecewise linear between the means of fourteen bins.
  constexpr double lower = 0.15, upper = 0.85;
  constexpr std::size_t bins = 14;
  std::vector<double> sum_u(bins, 0.0), sum_iso(bins, 0.0), count(bins, 0.0);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < u.size(); ++i) {
    if (!(isotropic[i] > lower && isotropic[i] < upper)) continue;
    const auto bin =
        std::min(bins - 1, static_cast<std::size_t>((isotropic[i] - lower) / (upper - lower) * double(bins)));
    chosen.push_back(i);
    sum_u[bin] += u[i];
    sum_iso[bin] += isotropic[i];
    count[bin] += 1.0;
  }
  std::vector<double> at, mean;
  for (std::size_t b = 0; b < bins; ++b)
    if (count[b] > 0.0) at.push_back(sum_iso[b] / count[b]), mean.push_back(sum_u[b] / count[b]);
  const auto expected = [&](double iso) {
    if (at.size() < 2) return mean.empty() ? 0.0 : mean[0];
    std::size_t k = 1;
    while (k + 1 < at.size() && at[k] < iso) ++k;
    return mean[k - 1] + (mean[k] - mean[k - 1]) * (iso - at[k - 1]) / (at[k] - at[k - 1]);
  };
  std::vector<double> deviation, c;
  for (const std::size_t i : chosen) {
    deviation.push_back(u[i] - expected(isotropic[i]));
    c.push_back(strain[i]);
  }
  return spearman(deviation, c);
}

}  // namespace wick::diffusion
