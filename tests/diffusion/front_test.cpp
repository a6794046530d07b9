/// Fronts of known length, roughness, dimension and anisotropy.
#include "diffusion/front.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "diffusion/front_shape.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

constexpr double spacing = 0.01;

Sheet unit_sheet() {
  return Sheet(testing::sheet(101, 117));
}

/// The front of a scalar given by its formula.
Front front_of(const Sheet& sheet, const std::function<double(const Vec3&)>& u) {
  return find_front(sheet.mesh, front_coordinates(sheet.mesh), sheet.field(u), 0.5);
}

/// A front that is given point by point.
Front polyline(const std::vector<Vec3>& points, bool closed = false) {
  FrontPiece piece;
  piece.closed = closed;
  for (const Vec3& p : points) piece.points.push_back({p});
  Front front;
  front.pieces.push_back(piece);
  return front;
}

/// y = amplitude sin(2π x/wavelength) over x = 0..1.
Front wave(double amplitude, double wavelength, int samples = 4000) {
  std::vector<Vec3> points;
  for (int k = 0; k <= samples; ++k) {
    const double x = k / double(samples);
    points.emplace_back(x, amplitude * std::sin(2.0 * M_PI * x / wavelength), 0.0);
  }
  return polyline(points);
}

TEST(Front, OfALinearFieldIsExact) {
  const Sheet sheet = unit_sheet();
  const Front front = front_of(sheet, [](const Vec3& p) { return 0.5 + 0.371 - p.y() - 0.2 * p.x(); });
  ASSERT_EQ(front.pieces.size(), 1u);
  EXPECT_FALSE(front.pieces[0].closed);
  EXPECT_NEAR(front.length(), std::sqrt(1.04), 1e-12);
  EXPECT_NEAR(front.covered(), 0.271, 1e-12);
  EXPECT_NEAR(band_tortuosity(front, std::sqrt(1.04)), 1.0, 1e-12);
  EXPECT_NEAR(relative_roughness(front, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(fine_roughness(front, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(box_dimension(front, 2 * spacing, 0.125).dimension, 1.0, 0.08);
}

TEST(Front, HasTheHigherSideOnItsLeft) {
  const Sheet sheet = unit_sheet();
  const Front front = front_of(sheet, [](const Vec3& p) { return 1.0 - p.y(); });
  const Vec3 along = front.pieces[0].points.back().position - front.pieces[0].points.front().position;
  EXPECT_LT(along.x(), 0.0);  // y below 1/2 is higher: it is on the left of a walk towards -x
}

TEST(Front, OfADiscConvergesWithTheSquareOfTheSpacing) {
  std::vector<double> error;
  for (const int n : {51, 101, 201}) {
    const Sheet sheet(testing::sheet(n, static_cast<int>(std::lround((n - 1) * 2.0 / std::sqrt(3.0))) + 1));
    const Front front = front_of(sheet, [](const Vec3& p) { return 0.5 + 0.3 - (p - Vec3(0.5, 0.5, 0.0)).norm(); });
    ASSERT_EQ(front.pieces.size(), 1u);
    EXPECT_TRUE(front.pieces[0].closed);
    error.push_back(std::abs(front.length() - 2.0 * M_PI * 0.3) + std::abs(front.area - M_PI * 0.09));
    EXPECT_NEAR(blob_tortuosity(front), 1.0, 1e-2);
  }
  EXPECT_GT(std::log2(error[0] / error[2]) / 2.0, 1.7);  // order 2, with the scatter of where the mesh cuts
}

TEST(Front, FindsHolesAndIslands) {
  const Sheet sheet = unit_sheet();
  const Front ring = front_of(
      sheet, [](const Vec3& p) { return std::abs((p - Vec3(0.5, 0.5, 0.0)).norm() - 0.3) < 0.1 ? 1.0 : 0.0; });
  EXPECT_EQ(ring.pieces.size(), 2u);
  EXPECT_EQ(ring.count(1.8), 1u);  // only the outer one is that long
  const Front none = front_of(sheet, [](const Vec3&) { return 0.0; });
  EXPECT_TRUE(none.pieces.empty());
  EXPECT_EQ(none.area, 0.0);
  EXPECT_TRUE(std::isinf(distance_to(none, Vec3::Zero())));
  const Front all = front_of(sheet, [](const Vec3&) { return 0.5; });
  EXPECT_TRUE(all.pieces.empty());
  EXPECT_NEAR(all.covered(), 1.0, 1e-14);
}

TEST(Front, OnAClosedSurfaceIsMeasuredThere) {
  const solid::ShellMesh sphere = solid::build_mesh(solid::icosphere(5, 1.0));
  Values u;
  for (const Vec3& p : sphere.rest) u.push_back(p.z());
  const Front front = find_front(sphere, front_coordinates(sphere), u, 0.5);
  ASSERT_EQ(front.pieces.size(), 1u);
  EXPECT_NEAR(front.length(), 2.0 * M_PI * std::sqrt(0.75), 5e-3);
  EXPECT_NEAR(front.area, M_PI, 5e-3);  // the cap 2π (1 - 0.5)
}

TEST(Front, InterpolatesFieldsAtItsSamples) {
  const Sheet sheet = unit_sheet();
  const Front front = front_of(sheet, [](const Vec3& p) { return 0.9 - p.y(); });
  const Values along = sheet.field([](const Vec3& p) { return 3.0 * p.x() + p.y(); });
  const std::vector<double>* fields[] = {&along};
  const SampledFront s = sample(front.pieces[0], 0.037, fields);
  for (std::size_t k = 0; k < s.position.size(); ++k)
    EXPECT_NEAR(s.field[0][k], 3.0 * s.position[k].x() + s.position[k].y(), 1e-12);
  EXPECT_NEAR(s.step, 1.0 / 27.0, 1e-12);
}

TEST(FrontShape, RoughnessOfACircleIsThatOfItsShrinking) {
  std::vector<Vec3> points;
  for (int k = 0; k < 2000; ++k)
    points.emplace_back(0.2 * std::cos(k * M_PI / 1e3), 0.2 * std::sin(k * M_PI / 1e3), 0);
  Front circle = polyline(points, true);
  circle.area = M_PI * 0.04;
  EXPECT_NEAR(relative_roughness(circle, 0.0), (1.0 - std::exp(-M_PI * M_PI / 32.0)) / std::sqrt(M_PI), 1e-4);
  EXPECT_NEAR(blob_tortuosity(circle), 1.0, 1e-5);
  EXPECT_NEAR(radial_harmonic(circle, Vec3::Zero(), 4), 0.0, 1e-12);
}

TEST(FrontShape, RoughnessOfAWaveIsWhatTheGaussianTakes) {
  // A Gaussian of width σ leaves exp(-k² σ²/2) of a wave; slopes of 6 % lengthen the arc by 0.1 %.
  for (const double wavelength : {0.02, 0.1, 0.2}) {
    const double amplitude = 0.01 * wavelength, k = 2.0 * M_PI / wavelength;
    const double expected = amplitude / std::sqrt(2.0) * (1.0 - std::exp(-0.5 * k * k * 0.04 * 0.04));
    EXPECT_NEAR(fine_roughness(wave(amplitude, wavelength), 0.0), expected, 0.01 * expected) << wavelength;
  }
}

TEST(FrontShape, CurvaturePowerCountsShortWavesOnly) {
  // κ = a k² sin(k x) has mean square a² k⁴/2.
  const double amplitude = 1e-4, k = 2.0 * M_PI / 0.02;
  const double expected = 0.5 * amplitude * amplitude * std::pow(k, 4);
  EXPECT_NEAR(fine_curvature_power(wave(amplitude, 0.02), 1.0 / 16.0, 1e-3, 0.0), expected, 0.03 * expected);
  const double k_long = 2.0 * M_PI / 0.25, long_power = 0.5 * 1e-4 * std::pow(k_long, 4);
  EXPECT_LT(fine_curvature_power(wave(1e-2, 0.25), 1.0 / 16.0, 1e-3, 0.0), 0.03 * long_power);
}

TEST(FrontShape, HarmonicsOfAStarAreItsAmplitudes) {
  std::vector<Vec3> points;
  for (int k = 0; k < 4000; ++k) {
    const double phi = k * M_PI / 2e3, r = 0.2 * (1.0 + 0.3 * std::cos(4.0 * phi) + 0.1 * std::sin(2.0 * phi));
    points.emplace_back(0.5 + r * std::cos(phi), 0.5 + r * std::sin(phi), 0.0);
  }
  const Front star = polyline(points, true);
  EXPECT_NEAR(radial_harmonic(star, Vec3(0.5, 0.5, 0.0), 4), 0.3, 1e-5);
  EXPECT_NEAR(radial_harmonic(star, Vec3(0.5, 0.5, 0.0), 2), 0.1, 1e-5);
}

TEST(FrontShape, DimensionOfAKochCurve) {
  std::vector<std::complex<double>> curve = {0.0, 1.0};
  for (int level = 0; level < 6; ++level) {
    std::vector<std::complex<double>> finer;
    for (std::size_t k = 0; k + 1 < curve.size(); ++k) {
      const std::complex<double> third = (curve[k + 1] - curve[k]) / 3.0;
      finer.insert(finer.end(), {curve[k], curve[k] + third, curve[k] + third + third * std::polar(1.0, M_PI / 3.0),
                                 curve[k] + 2.0 * third});
    }
    finer.push_back(1.0);
    curve = finer;
  }
  std::vector<Vec3> points;
  for (const auto& z : curve) points.emplace_back(z.real(), z.imag(), 0.0);
  const BoxDimension box = box_dimension(polyline(points), 1.0 / 243.0, 0.1);
  EXPECT_NEAR(box.dimension, std::log(4.0) / std::log(3.0),
              0.06);  // counts of eight scales scatter by some per cent
  EXPECT_GT(box.fit, 0.99);
}

TEST(FrontShape, DepartureIsTheDistanceOfTwoFronts) {
  const Sheet sheet = unit_sheet();
  const Front a = front_of(sheet, [](const Vec3& p) { return 0.9 - p.y(); });
  const Front b = front_of(sheet, [](const Vec3& p) { return 0.83 - p.y(); });
  EXPECT_NEAR(departure(a, b), 0.07, 1e-12);
}

TEST(FrontShape, SecondMomentsOfAnEllipticSpot) {
  const Sheet sheet = unit_sheet();
  const Values u = sheet.field([](const Vec3& p) {
    const double x = (p.x() - 0.5) / 0.1, y = (p.y() - 0.5) / 0.06;
    return std::exp(-0.5 * (x * x + y * y));
  });
  EXPECT_NEAR(second_moment_anisotropy(sheet.mesh, front_coordinates(sheet.mesh), u), 0.4, 1e-3);
}

}  // namespace
}  // namespace wick::diffusion
