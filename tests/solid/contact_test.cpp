/// Obstacles: no penetration, Coulomb's law, moving floors.
#include <gtest/gtest.h>

#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

/// How far a sheet slides in a second down a plane at `angle`, and what Coulomb says.
double slide(double angle, double friction) {
  ShellParams params;
  params.air_drag = 0.0;
  Sheet sheet(equilateral(10, 10, 0.01), params);
  const Vec3 normal(std::sin(angle), 0.0, std::cos(angle));
  sheet.obstacles.push_back({"slope", PlaneShape{Vec3::Zero(), normal}, friction});
  const Vec3 down(std::cos(angle), 0.0, -std::sin(angle));
  for (Vec3& x : sheet.state.x) x = x.x() * down + x.y() * Vec3(0, 1, 0) + 0.5 * params.thickness * normal;
  sheet.gravity = Vec3(0, 0, -9.81);
  const std::vector<Vec3> start = sheet.state.x;
  sheet.run(1.0, 1.0 / 60.0);
  double way = 0.0;
  for (std::size_t i = 0; i < start.size(); ++i) way += (sheet.state.x[i] - start[i]).dot(down) / start.size();
  return way;
}

TEST(Friction, SticksIfAndOnlyIfTheSlopeIsBelowMu) {
  for (const double mu : {0.2, 0.5, 1.0}) {
    const double critical = std::atan(mu);
    EXPECT_LT(std::abs(slide(critical - 0.02, mu)), 1e-5) << mu;
    // Beyond it: a = g (sin α − μ cos α).
    const double angle = critical + 0.1;
    const double way = 0.5 * 9.81 * (std::sin(angle) - mu * std::cos(angle));
    EXPECT_NEAR(slide(angle, mu) / way, 1.0, 0.01) << mu;
  }
}

TEST(Contact, DrapesOverASphereWithoutPenetration) {
  ShellParams params;
  params.bending = 1e-6;
  Sheet sheet(equilateral(60, 60, 0.01), params);
  Vec3 center = Vec3::Zero();
  for (const Vec3& x : sheet.mesh.rest) center += x / double(sheet.mesh.vertex_count());
  sheet.obstacles.push_back({"ball", SphereShape{center - Vec3(0, 0, 0.16), 0.15}, 0.5});
  sheet.gravity = Vec3(0, 0, -9.81);
  for (int k = 0; k < 120; ++k) {
    const ShellStepReport report = sheet.step(1.0 / 60.0);
    for (const Vec3& x : sheet.state.x)
      ASSERT_GT(sample_distance(sheet.obstacles[0], x).distance, 0.5 * params.thickness - 1e-9) << k;
    if (k > 60) {
      EXPECT_GT(report.contacts, 100u);
    }
  }
  double lowest = 1.0;
  for (const Vec3& x : sheet.state.x) lowest = std::min(lowest, x.z());
  EXPECT_LT(lowest, -0.1);
}

TEST(Contact, AMovingFloorCarriesTheSheet) {
  ShellParams params;
  params.air_drag = 0.0;
  Sheet sheet(equilateral(8, 8, 0.01), params);
  for (Vec3& x : sheet.state.x) x.z() = 0.5 * params.thickness;
  sheet.gravity = Vec3(0, 0, -9.81);
  sheet.obstacles.push_back({"lift", PlaneShape{}, 0.5});
  const Vec3 velocity(0.3, 0.0, 0.2);
  sheet.obstacles[0].velocity = velocity;
  for (int k = 0; k < 60; ++k) {
    sheet.step(1.0 / 60.0);
    sheet.obstacles[0].pose.shift += velocity / 60.0;
  }
  for (const Vec3& v : sheet.state.v) EXPECT_LT((v - velocity).norm(), 1e-6);
  for (const Vec3& x : sheet.state.x) EXPECT_NEAR(x.z(), 0.2 + 0.5 * params.thickness, 1e-6);
}

TEST(Contact, OverlapAtTheStartIsUndoneWithoutGainingSpeed) {
  ShellParams params;
  params.air_drag = 0.0;
  Sheet sheet(equilateral(8, 8, 0.01), params);
  for (Vec3& x : sheet.state.x) x.z() = -0.03;
  sheet.obstacles.push_back({"floor", PlaneShape{}, 0.5});
  const ShellStepReport report = sheet.step(1.0 / 60.0);
  EXPECT_EQ(report.contacts, sheet.mesh.vertex_count());
  EXPECT_LT(report.max_speed, 1e-9);
  for (const Vec3& x : sheet.state.x) EXPECT_NEAR(x.z(), 0.5 * params.thickness, 1e-12);
}

TEST(Contact, FastSheetsDoNotPassSampledObstacles) {
  // A sampled slab, 4 cm thick; the sheet comes at 30 m/s, 2.5 cm a substep.
  SampledShape slab;
  slab.origin = Vec3(-0.1, -0.1, -0.1);
  slab.spacing = 0.01;
  slab.nodes = {31, 31, 21};
  for (int k = 0; k < 21; ++k)
    for (int j = 0; j < 31; ++j)
      for (int i = 0; i < 31; ++i) slab.distance.push_back(static_cast<float>(std::abs(0.01 * k - 0.1) - 0.02));
  ShellParams params;
  Sheet sheet(equilateral(8, 8, 0.01), params);
  for (Vec3& x : sheet.state.x) x.z() = 0.3;
  for (Vec3& v : sheet.state.v) v = Vec3(0, 0, -30.0);
  sheet.obstacles.push_back({"slab", slab, 0.3});
  sheet.run(0.2, 1.0 / 60.0);
  for (const Vec3& x : sheet.state.x) EXPECT_GT(x.z(), 0.019);
}

}  // namespace
}  // namespace wick::solid
