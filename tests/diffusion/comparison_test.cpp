/// The models that the paper's method is compared with: tensor, noise, strain with noise.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "diffusion/operators.h"
#include "diffusion/perlin.h"
#include "diffusion/strain.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

Values spot(const Sheet& sheet, double width) {
  return sheet.field(
      [&](const Vec3& p) { return std::exp(-0.5 * (p - Vec3(0.5, 0.5, 0.0)).squaredNorm() / (width * width)); });
}

/// Second moment of u along `direction`, about its centroid.
double moment(const Sheet& sheet, const Values& u, const Vec3& direction) {
  double mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double s = sheet.mesh.rest[i].dot(direction);
    mean += sheet.mass[i] * u[i] * s / sheet.total(u);
    square += sheet.mass[i] * u[i] * s * s / sheet.total(u);
  }
  return square - mean * mean;
}

DiffusionParams tensor_params(double gain) {
  DiffusionParams p = testing::plain_diffusion(1e-3);
  p.model = Model::tensor;
  p.tensor_gain = gain;
  return p;
}

TEST(Tensor, MomentsGrowAlongThePrincipalStretches) {
  // D = α (1 + k (q - 1)) along the stretch q, α across it; a spot's moment grows by 2 D dt in every step.
  for (const double turn : {0.0, 30.0}) {
    Sheet sheet(testing::sheet(101, 117));
    const double q = 1.3, gain = 2.0, phi = turn * M_PI / 180.0;
    const Vec3 along(std::cos(phi), std::sin(phi), 0.0), across(-along.y(), along.x(), 0.0);
    for (Vec3& p : sheet.x) p += (q - 1.0) * p.dot(along) * along;
    Values u = spot(sheet, 0.05);
    const double first = moment(sheet, u, along), second = moment(sheet, u, across), total = sheet.total(u);
    DiffusionSolver solver(tensor_params(gain));
    const double dt = 0.1;
    const int steps = 10;
    for (int n = 0; n < steps; ++n) solver.step(u, sheet.input(), dt);
    // 1 %: the spot's tail just reaches the border.
    EXPECT_NEAR((moment(sheet, u, along) - first) / (2e-3 * dt * steps), 1.0 + gain * (q - 1.0), 0.016);
    EXPECT_NEAR((moment(sheet, u, across) - second) / (2e-3 * dt * steps), 1.0, 0.01);
    EXPECT_NEAR(sheet.total(u) / total, 1.0, 1e-12);
  }
}

TEST(Tensor, IsIsotropicWhereNothingIsStretched) {
  Sheet sheet(testing::jittered(31, 36, 0.2));
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& p : sheet.x) p = turn * p + Vec3(1, 2, 3);
  Values a = spot(sheet, 0.1), b = a;
  DiffusionSolver tensor(tensor_params(8.0)), isotropic(testing::plain_diffusion(1e-3));
  for (int n = 0; n < 10; ++n) tensor.step(a, sheet.input(), 0.1), isotropic.step(b, sheet.input(), 0.1);
  EXPECT_LT(testing::rms(a, b), 1e-11);
}

TEST(Tensor, StaysInRangeOnAnyDeformation) {
  for (const double amplitude : {0.05, 1.0, 50.0}) {
    Sheet sheet(testing::jittered(31, 36, 0.3));
    sheet.x = testing::crumple(sheet.mesh, amplitude);
    for (std::size_t i = 0; i < 40; ++i) sheet.x[i] = sheet.x[0];  // collapsed triangles
    Values u = spot(sheet, 0.05);
    const double total = sheet.total(u), most = testing::largest(u);
    DiffusionParams p = tensor_params(8.0);
    DiffusionSolver solver(p);
    for (const double dt : {1e-6, 1e-2, 1.0, 1e6}) {
      solver.step(u, sheet.input(), dt);
      EXPECT_GE(testing::smallest(u), 0.0);
      EXPECT_LE(testing::largest(u), most * (1.0 + 1e-9));
      EXPECT_NEAR(sheet.total(u) / total, 1.0, 1e-12);
    }
  }
}

TEST(Perlin, VanishesOnTheLatticeAndIsSmoothBetween) {
  for (int i = -3; i < 3; ++i)
    for (int j = -3; j < 3; ++j) EXPECT_EQ(perlin(Vec3(i, j, i - j), 7), 0.0);
  double sum = 0.0, square = 0.0, most = 0.0, kink = 0.0;
  const double step = 1e-3;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 p(100.0 * hash_signed(1, n), 100.0 * hash_signed(2, n), 100.0 * hash_signed(3, n));
    const double value = perlin(p, 7);
    sum += value;
    square += value * value;
    most = std::max(most, std::abs(value));
    const Vec3 wall(std::round(p.x()), p.y(), p.z());
    const Vec3 aside(step, 0, 0);
    kink = std::max(kink, std::abs(perlin(wall + aside, 7) - 2.0 * perlin(wall, 7) + perlin(wall - aside, 7)));
  }
  EXPECT_NEAR(sum / 20000, 0.0, 0.01);
  EXPECT_GT(square / 20000, 0.02);
  EXPECT_LE(most, 1.0);
  EXPECT_LT(kink, 10.0 * step * step);  // a kink in the slope would be of the size of the step
  EXPECT_NE(perlin(Vec3(0.3, 0.4, 0.5), 7), perlin(Vec3(0.3, 0.4, 0.5), 8));
}

DiffusionParams noise_params(Model model) {
  DiffusionParams p = make_preset(Preset::wetting);
  p.model = model;
  p.alpha = 1e-2;
  return p;
}

TEST(Noise, KnowsNothingOfTheDeformation) {
  const DiffusionParams p = noise_params(Model::noise);
  Sheet flat(testing::sheet(41, 47)), crumpled(testing::sheet(41, 47));
  crumpled.x = testing::crumple(crumpled.mesh);
  Values a = spot(flat, 0.1), b = a;
  const double total = flat.total(a);
  DiffusionSolver one(p), other(p);
  for (int n = 0; n < 5; ++n) one.step(a, flat.input(), 1.0 / 60.0), other.step(b, crumpled.input(), 1.0 / 60.0);
  EXPECT_EQ(a, b);
  EXPECT_NEAR(flat.total(a) / total, 1.0, 1e-12);
  // c = level max(0, a P): not everywhere, and of the size of the level.
  const Values& c = one.strain_vertex();
  EXPECT_GT(testing::largest(c), 0.1 * p.gain * p.noise.level / 60.0);
  EXPECT_LE(testing::largest(c), p.gain * p.noise.level / 60.0);
  EXPECT_EQ(testing::smallest(c), 0.0);
}

TEST(Noise, OfSizeZeroLeavesStrainAlone) {
  Sheet sheet(testing::sheet(41, 47));
  sheet.x = testing::crumple(sheet.mesh);
  DiffusionParams p = noise_params(Model::strain_noise);
  p.noise.amplitude = 0.0;
  Values a = spot(sheet, 0.1), b = a, c = a;
  DiffusionSolver modulated(p), plain(noise_params(Model::strain_constrained)),
      noisy(noise_params(Model::strain_noise));
  for (int n = 0; n < 5; ++n) {
    modulated.step(a, sheet.input(), 1.0 / 60.0);
    plain.step(b, sheet.input(), 1.0 / 60.0);
    noisy.step(c, sheet.input(), 1.0 / 60.0);
  }
  EXPECT_EQ(a, b);
  EXPECT_GT(testing::rms(b, c), 1e-5);
  EXPECT_NEAR(sheet.total(c) / sheet.total(b), 1.0, 1e-12);
}

}  // namespace
}  // namespace wick::diffusion
