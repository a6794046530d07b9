#include "fluid/fast_poisson.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "wall_shapes.h"

namespace wick::fluid {
namespace {

/// 2 p_i - p_(i-1) - p_(i+1) of one axis with its sides, written out cell by cell.
double second_difference(const std::vector<double>& p, const Int3& n, Int3 at, int axis, Side low, Side high) {
  const auto value = [&](Int3 c) { return p[c[0] + std::size_t(n[0]) * (c[1] + std::size_t(n[1]) * c[2])]; };
  const double own = value(at);
  double sum = 0.0;
  for (const int step : {-1, 1}) {
    Int3 other = at;
    other[axis] += step;
    const Side side = step < 0 ? low : high;
    if (other[axis] < 0 || other[axis] >= n[axis]) {
      if (side == C) continue;
      if (side == O) {
        sum += 2.0 * own;
        continue;
      }
      other[axis] = (other[axis] + n[axis]) % n[axis];
    }
    sum += own - value(other);
  }
  return sum;
}

double largest_residual(const std::vector<double>& p, const std::vector<double>& f, const Int3& n,
                        const Sides& sides) {
  double worst = 0.0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        double product = 0.0;
        for (int a = 0; a < 3; ++a)
          product += second_difference(p, n, {i, j, k}, a, sides[2 * a], sides[2 * a + 1]);
        worst = std::max(worst, std::abs(product - f[i + std::size_t(n[0]) * (j + std::size_t(n[1]) * k)]));
      }
  return worst;
}

std::vector<double> balanced_noise(std::size_t count) {
  std::vector<double> f(count);
  double sum = 0.0;
  for (std::size_t c = 0; c < count; ++c) sum += f[c] = hash_signed(5, c);
  for (double& value : f) value -= sum / static_cast<double>(count);
  return f;
}

const std::array<std::array<Side, 2>, 5> pairs = {{{C, C}, {O, O}, {C, O}, {O, C}, {P, P}}};

TEST(FastPoisson, SolvesEveryMixOfSides) {
  const Int3 n = {9, 6, 7};
  for (const auto& x : pairs)
    for (const auto& y : pairs)
      for (const auto& z : pairs) {
        const Sides sides = {x[0], x[1], y[0], y[1], z[0], z[1]};
        const std::vector<double> f = balanced_noise(std::size_t(n[0]) * n[1] * n[2]);
        std::vector<double> p = f;
        FastPoisson(n, sides).solve(p);
        // Values of order 10 and a few dozen operations each: 1e-12 is a hundred roundings.
        EXPECT_LT(largest_residual(p, f, n, sides), 1e-12);
      }
}

TEST(FastPoisson, ReturnsDiscreteEigenmodes) {
  // cos(π(i+½)/n) belongs to 4 sin²(π/2n) between closed sides, sin(π(i+½)/n) to the same between open ones.
  const int n = 16;
  for (const Side side : {C, O}) {
    std::vector<double> mode(n), p;
    for (int i = 0; i < n; ++i) {
      const double angle = std::numbers::pi * (i + 0.5) / n;
      mode[i] = side == C ? std::cos(angle) : std::sin(angle);
    }
    p = mode;
    FastPoisson({n, 1, 1}, {side, side, C, C, C, C}).solve(p);
    const double s = std::sin(std::numbers::pi / (2 * n));
    for (int i = 0; i < n; ++i) EXPECT_NEAR(p[i], mode[i] / (4 * s * s), 1e-12);
  }
}

TEST(FastPoisson, TakesThinAndLongBoxes) {
  for (const Int3 n :
       {Int3{1, 1, 1}, Int3{1, 40, 3}, Int3{64, 1, 1}, Int3{1, 1, 64}, Int3{4, 256, 4}, Int3{17, 31, 2}})
    for (const Sides& sides : {open_top, all_closed, Sides{P, P, P, P, P, P}, Sides{P, P, C, C, O, O}}) {
      const std::vector<double> f = balanced_noise(std::size_t(n[0]) * n[1] * n[2]);
      std::vector<double> p = f;
      FastPoisson(n, sides).solve(p);
      // Long boxes have solutions of order n² = 1e4 and more: relative to those, 1e-13.
      EXPECT_LT(largest_residual(p, f, n, sides), 1e-9);
    }
}

TEST(FastPoisson, HasTheSameBitsAtAnyThreadCountAndInANewSolver) {
  const Int3 n = {33, 20, 18};
  const std::vector<double> f = balanced_noise(std::size_t(n[0]) * n[1] * n[2]);
  std::vector<std::vector<double>> results;
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    results.push_back(f);
    FastPoisson(n, open_top).solve(results.back());
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

/// -lap p = f with p = cos(πx) cos(2πy) cos(πz/2): closed sides, open top.
double manufactured_error(int n) {
  const double h = 1.0 / n, pi = std::numbers::pi;
  std::vector<double> p(std::size_t(n) * n * n), exact(p.size());
  std::size_t c = 0;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i, ++c) {
        exact[c] =
            std::cos(pi * (i + 0.5) * h) * std::cos(2 * pi * (j + 0.5) * h) * std::cos(0.5 * pi * (k + 0.5) * h);
        p[c] = h * h * 5.25 * pi * pi * exact[c];
      }
  FastPoisson({n, n, n}, open_top).solve(p);
  double error = 0.0;
  for (c = 0; c < p.size(); ++c) error = std::max(error, std::abs(p[c] - exact[c]));
  return error;
}

TEST(FastPoisson, ConvergesWithSecondOrder) {
  const double coarse = manufactured_error(16), fine = manufactured_error(32);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.05);
}

}  // namespace
}  // namespace wick::fluid
