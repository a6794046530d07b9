#include "diffusion/strain.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Values;

/// Right triangle (0,0), (1,0), (0,1) of area 1/2.
solid::ShellMesh unit_triangle() {
  return solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)},
                           {{0, 1, 2}});
}

double measure(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, Measure m, bool tension = false) {
  return strain_measure(green_strain(mesh, x, 0), m, tension);
}

constexpr double rounding = 1e-14;  // a dozen operations on numbers of size 1

TEST(Strain, GoldenNumbersOfOneTriangle) {
  const solid::ShellMesh mesh = unit_triangle();
  std::vector<Vec3> x = mesh.rest;
  x[1].x() = 1.2;
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic), 0.0484, rounding);
  DiffusionParams p;
  p.measure = Measure::orthotropic;
  p.gain_form = Gain::literal;
  p.gain = 1.0;
  Values s, c;
  triangle_strain(p, mesh, x, nullptr, s);
  vertex_strain(p, mesh, s, 0.1, c);
  for (const double value : c) EXPECT_NEAR(value, 0.0121 / 3.0, rounding);
  p.delta = 10.0;
  triangle_strain(p, mesh, x, nullptr, s);
  EXPECT_NEAR(s[0], 0.0484 / 11.0, rounding);

  x = mesh.rest;
  x[2].x() = 0.3;
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic), 0.024525, rounding);

  x = mesh.rest;
  x[1].x() = std::sqrt(1.2);
  x[2].y() = std::sqrt(0.8);
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic), 0.0, rounding);
  EXPECT_NEAR(measure(mesh, x, Measure::invariant), 0.005, rounding);

  x = mesh.rest;
  for (Vec3& p3 : x) p3 *= 0.8;
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic), 0.1296, rounding);
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic, true), 0.0, rounding);
}

TEST(Strain, NullDirectionDisappearsInATurnedFrame) {
  const double s = std::sqrt(0.5);
  const std::vector<Vec3> rest = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  std::vector<Vec2> turned;
  for (const Vec3& r : rest) turned.emplace_back(s * (r.x() - r.y()), s * (r.x() + r.y()));
  const solid::ShellMesh mesh = solid::build_mesh(rest, turned, {{0, 1, 2}});
  const std::vector<Vec3> x = {Vec3(0, 0, 0), Vec3(std::sqrt(1.2), 0, 0), Vec3(0, std::sqrt(0.8), 0)};
  EXPECT_NEAR(measure(mesh, x, Measure::orthotropic), 0.01, rounding);
  EXPECT_NEAR(measure(mesh, x, Measure::invariant), 0.005, rounding);
}

TEST(Strain, InvariantMeasureIsTheMeanOverFramesAndBothAreObjective) {
  // e = (0.3, -0.1): between 0.04 and 0.08 orthotropic, 0.06 on average.
  double sum = 0.0, low = 1.0, high = 0.0;
  constexpr int angles = 64;
  for (int k = 0; k < angles; ++k) {
    const Eigen::Rotation2Dd r(M_PI * k / angles);
    const Mat2 g = r.toRotationMatrix().transpose() * Vec2(0.3, -0.1).asDiagonal() * r.toRotationMatrix();
    const double s = strain_measure(g, Measure::orthotropic, false);
    EXPECT_NEAR(strain_measure(g, Measure::invariant, false), 0.06, rounding);
    sum += s / angles;
    low = std::min(low, s);
    high = std::max(high, s);
  }
  EXPECT_NEAR(low, 0.04, rounding);
  EXPECT_NEAR(high, 0.08, rounding);
  EXPECT_NEAR(sum, 0.06, rounding);

  solid::ShellMesh mesh = testing::jittered(9, 9, 0.25);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vec3> x = testing::crumple(mesh), rotated;
  for (const Vec3& p : x) rotated.push_back(turn * p + Vec3(3, -1, 2));
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    EXPECT_NEAR((green_strain(mesh, x, t) - green_strain(mesh, rotated, t)).norm(), 0.0, 1e-12);
}

TEST(Strain, RigidMotionHasNone) {
  const solid::ShellMesh mesh = testing::sheet(12, 14);
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  std::vector<Vec3> x;
  for (const Vec3& p : mesh.rest) x.push_back(turn * p + Vec3(1, 2, 3));
  Values s;
  triangle_strain(DiffusionParams{}, mesh, x, nullptr, s);
  // (eps times position over edge length) squared.
  EXPECT_LT(testing::largest(s), 1e-26);
}

TEST(Strain, RelabellingTheCornersChangesNothing) {
  for (const bool chart : {true, false}) {
    solid::TriangleSoup soup = chart ? solid::rectangle(7, 8, Vec2(1, 1)) : solid::icosphere(2, 1.0);
    const solid::ShellMesh mesh = solid::build_mesh(soup);
    for (Int3& t : soup.triangles) t = {t[1], t[2], t[0]};
    const solid::ShellMesh relabelled = solid::build_mesh(soup);
    std::vector<Vec3> x = testing::crumple(mesh);
    for (const Measure m : {Measure::orthotropic, Measure::invariant}) {
      DiffusionParams p;
      p.measure = m;
      Values s, c, s2, c2;
      triangle_strain(p, mesh, x, nullptr, s);
      vertex_strain(p, mesh, s, 0.1, c);
      triangle_strain(p, relabelled, x, nullptr, s2);
      vertex_strain(p, relabelled, s2, 0.1, c2);
      for (std::size_t i = 0; i < c.size(); ++i) EXPECT_NEAR(c2[i], c[i], 1e-13 * testing::largest(c)) << i;
    }
  }
}

TEST(Strain, DensityDoesNotDependOnTheMeshAndLiteralDoes) {
  DiffusionParams p;
  p.gain = 1.0;
  std::vector<double> literal;
  for (const auto& mesh : {testing::sheet(13, 15), testing::jittered(13, 15, 0.25), testing::sheet(25, 29)}) {
    std::vector<Vec3> x = mesh.rest;
    for (Vec3& v : x) v.x() *= 1.1;
    Values s, c;
    p.gain_form = Gain::density;
    triangle_strain(p, mesh, x, nullptr, s);
    vertex_strain(p, mesh, s, 1.0, c);
    // Stretch of 10 %: e = 0.105, S = e²(1 + 1/8), c = S/2.
    for (const double value : c) EXPECT_NEAR(value, 0.5 * 0.105 * 0.105 * 1.125, 1e-12);
    p.gain_form = Gain::literal;
    vertex_strain(p, mesh, s, 1.0, c);
    literal.push_back(c[c.size() / 2]);
  }
  EXPECT_NEAR(literal[0] / literal[2], 4.0, 1e-9);
}

TEST(Strain, CurrentReferenceForgivesFreeShrinkage) {
  const solid::ShellMesh mesh = testing::sheet(6, 7);
  std::vector<Vec3> x = mesh.rest;
  for (Vec3& v : x) v *= 0.8;
  const Values scale(mesh.triangle_count(), 0.8);
  DiffusionParams p;
  p.measure = Measure::orthotropic;
  Values s;
  triangle_strain(p, mesh, x, &scale, s);
  for (const double value : s) EXPECT_NEAR(value, 0.1296, 1e-12);
  p.reference = Reference::current;
  triangle_strain(p, mesh, x, &scale, s);
  for (const double value : s) EXPECT_NEAR(value, 0.0, 1e-12);
}

TEST(Strain, BendingTermSeesTheCurvatureOfARoll) {
  // Roll the sheet up to radius R: κ1 + κ2 = 1/R; the polygon's angles give it to O(h²) in the interior.
  const double radius = 0.4;
  const solid::ShellMesh mesh = testing::sheet(60, 60);
  std::vector<Vec3> x;
  for (const Vec3& v : mesh.rest)
    x.emplace_back(radius * std::sin(v.x() / radius), v.y(), radius * std::cos(v.x() / radius));
  DiffusionParams with, without;
  with.bending_gain = 1e-3;
  Values a, b;
  triangle_strain(with, mesh, x, nullptr, a);
  triangle_strain(without, mesh, x, nullptr, b);
  for (std::size_t t = 0; t < a.size(); ++t) {
    const Vec3 center =
        (mesh.rest[mesh.triangles[t][0]] + mesh.rest[mesh.triangles[t][1]] + mesh.rest[mesh.triangles[t][2]]) / 3.0;
    if (center.x() < 0.1 || center.x() > 0.9 || center.y() < 0.1 || center.y() > 0.9) continue;
    EXPECT_NEAR((a[t] - b[t]) / (1e-3 / (radius * radius)), 1.0, 0.01);
  }
}

}  // namespace
}  // namespace wick::diffusion
