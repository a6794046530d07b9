#include "diffusion/rank_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/noise.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

Values random_values(std::uint64_t seed, std::size_t n) {
  Values v(n);
  for (std::size_t i = 0; i < n; ++i) v[i] = hash_signed(seed, i);
  return v;
}

TEST(Ranks, ShareTheirMeanWhenEqual) {
  EXPECT_EQ(ranks({3.0, 1.0, 3.0, 2.0}), (Values{3.5, 1.0, 3.5, 2.0}));
}

TEST(Spearman, SeesAnyMonotoneRelation) {
  const Values a = random_values(1, 500);
  Values b, c;
  for (const double value : a) b.push_back(std::exp(5.0 * value)), c.push_back(-value * value * value);
  EXPECT_NEAR(spearman(a, b), 1.0, 1e-12);
  EXPECT_NEAR(spearman(a, c), -1.0, 1e-12);
  EXPECT_LT(std::abs(spearman(a, random_values(2, 500))), 0.13);  // three standard deviations of chance
  EXPECT_EQ(spearman(a, Values(500, 1.0)), 0.0);
}

TEST(Spearman, OfATextbookTable) {
  // IQ against hours of television, the usual worked example: ρ = -29/165.
  const Values iq = {106, 100, 86, 101, 99, 103, 97, 113, 112, 110}, hours = {7, 27, 2, 50, 28, 29, 20, 12, 6, 17};
  EXPECT_NEAR(spearman(iq, hours), -29.0 / 165.0, 1e-12);
}

TEST(Spearman, PartialTakesACommonCauseAway) {
  const std::size_t n = 2000;
  const Values cause = random_values(3, n), e1 = random_values(4, n), e2 = random_values(5, n);
  Values a(n), b(n), own(n);
  for (std::size_t i = 0; i < n; ++i) {
    a[i] = cause[i] + 0.5 * e1[i];
    b[i] = cause[i] + 0.5 * e2[i];
    own[i] = cause[i] + 0.5 * e1[i] + 0.1 * e2[i];
  }
  const std::vector<Values> controls = {cause};
  EXPECT_GT(spearman(a, b), 0.6);
  EXPECT_LT(std::abs(partial_spearman(a, b, controls)), 0.07);
  EXPECT_GT(partial_spearman(a, own, controls), 0.8);
  EXPECT_EQ(partial_spearman(cause, b, controls), 0.0);
}

TEST(LineFit, RecoversALine) {
  const LineFit fit = fit_line({1, 2, 3, 4}, {5, 7, 9, 11});
  EXPECT_NEAR(fit.slope, 2.0, 1e-12);
  EXPECT_NEAR(fit.offset, 3.0, 1e-12);
  EXPECT_NEAR(fit.r_squared, 1.0, 1e-12);
  const Spread s = spread({1, 2, 3, 4});
  EXPECT_NEAR(s.mean, 2.5, 1e-15);
  EXPECT_NEAR(s.deviation, std::sqrt(5.0 / 3.0), 1e-15);
}

TEST(Smoothed, DampsWavesLikeFourStepsOfHeatFlow) {
  const Sheet sheet(testing::sheet(101, 117));
  const double width = 0.04, k = 2.0 * M_PI;  // a wave that natural borders keep
  const Values field = sheet.field([&](const Vec3& p) { return std::cos(k * p.x()); });
  const Values s = smoothed(sheet.mesh, field, width);
  const double factor = std::pow(1.0 + width * width / 8.0 * k * k, -4.0);
  double worst = 0.0;
  for (std::size_t i = 0; i < s.size(); ++i) worst = std::max(worst, std::abs(s[i] - factor * field[i]));
  EXPECT_LT(worst, 2e-3);
  EXPECT_NEAR(sheet.total(s), sheet.total(field), 1e-9);
}

TEST(DisplacementCorrelation, IsOneWhereStrainIsWhatIsAdded) {
  const Sheet sheet(testing::sheet(61, 71));
  const Values isotropic = sheet.field([](const Vec3& p) { return std::exp(-3.0 * p.y()); });
  const Values strain = sheet.field([](const Vec3& p) { return std::sin(20.0 * p.x()); });
  Values u = isotropic, other = isotropic;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += 0.05 * strain[i], other[i] += 0.05 * hash_signed(9, i);
  EXPECT_GT(displacement_correlation(u, isotropic, strain), 0.98);
  EXPECT_LT(std::abs(displacement_correlation(other, isotropic, strain)), 0.08);
  EXPECT_LT(std::abs(displacement_correlation(isotropic, isotropic, strain)), 0.05);
}

}  // namespace
}  // namespace wick::diffusion
