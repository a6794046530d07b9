/// Whatever the parameters, positions and velocities stay finite.
#include <gtest/gtest.h>

#include <limits>

#include "core/noise.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

TEST(Extremes, StiffnessDensityThicknessGravityAndStepAThousandTimesEitherWay) {
  int runs = 0;
  for (const double stiffness : {1e-3, 1.0, 1e3})
    for (const double density : {1e-3, 1.0, 1e3})
      for (const double thickness : {1e-3, 1.0, 1e3})
        for (const double gravity : {0.0, 1.0, 1e3})
          for (const double step : {1e-3, 1.0, 60.0}) {
            ShellParams params;
            params.young_warp = params.young_weft = 2e8 * stiffness;
            params.density *= density;
            params.thickness *= thickness;
            // Long steps with one substep a frame, short ones with the default.
            params.substeps = step > 1.0 ? 1 : 20;
            Sheet sheet(equilateral(9, 9, 0.01), params);
            sheet.pin_where([](const Vec3& X) { return X.y() < 1e-9; });
            sheet.obstacles.push_back({"ball", SphereShape{Vec3(0.04, 0.05, -0.03), 0.02}});
            sheet.gravity = Vec3(0, 0, -9.81 * gravity);
            for (int k = 0; k < 10; ++k) sheet.step(step / 60.0);
            ASSERT_TRUE(sheet.finite())
                << stiffness << " " << density << " " << thickness << " " << gravity << " " << step;
            ++runs;
          }
  EXPECT_EQ(runs, 243);
}

TEST(Extremes, AThousandTimesTheStepWithFewSubsteps) {
  ShellParams params;
  params.substeps = 1;
  Sheet sheet(equilateral(9, 9, 0.01), params);
  sheet.gravity = Vec3(0, 0, -9.81);
  EXPECT_EQ(sheet.step(1000.0 / 60.0).substeps, 1000);
  EXPECT_TRUE(sheet.finite());
  EXPECT_EQ(sheet.step(1e-9).substeps, 1);
  EXPECT_TRUE(sheet.finite());
  EXPECT_EQ(sheet.step(0.0).substeps, 0);
}

TEST(Extremes, CrushedInvertedAndScrambledSheetsRecover) {
  ShellParams params;
  params.air_drag = 2.0;
  for (int kind = 0; kind < 6; ++kind) {
    Sheet sheet(equilateral(12, 12, 0.01), params);
    for (std::size_t i = 0; i < sheet.state.x.size(); ++i) {
      Vec3& x = sheet.state.x[i];
      if (kind == 0) x = Vec3::Zero();       // a point
      if (kind == 1) x = Vec3(x.x(), 0, 0);  // a line
      if (kind == 2) x = -x;                 // turned over
      if (kind == 3) x = 0.1 * Vec3(hash_signed(1, 3 * i), hash_signed(1, 3 * i + 1), hash_signed(1, 3 * i + 2));
      if (kind == 4) x *= 3.0;
      if (kind == 5) x *= 1000.0;
    }
    sheet.run(2.0, 1.0 / 60.0);
    ASSERT_TRUE(sheet.finite()) << kind;
    const ShellStepReport report = sheet.step(1.0 / 60.0);
    EXPECT_LT(report.max_speed, 1e3) << kind;
    if (kind == 2 || kind == 4) {
      EXPECT_LT(report.max_stretch, 0.1) << kind;
    }
  }
}

TEST(Extremes, ForcesThatAreNoNumbersAreCountedAndDropped) {
  ShellParams params;
  Sheet sheet(equilateral(6, 6, 0.01), params);
  sheet.force.assign(sheet.mesh.vertex_count(), Vec3::Zero());
  sheet.force[7] = Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  sheet.force[9] = Vec3(0, std::numeric_limits<double>::infinity(), 1e300);
  const ShellStepReport report = sheet.step(1.0 / 60.0);
  EXPECT_GE(report.limited, 2u);
  EXPECT_TRUE(sheet.finite());
}

TEST(Extremes, BurntToNothing) {
  ShellParams params;
  Sheet sheet(equilateral(8, 8, 0.01), params);
  sheet.gravity = Vec3(0, 0, -9.81);
  for (std::size_t t = 0; t < sheet.mesh.triangle_count(); t += 2) {
    sheet.inputs.stiffness_scale[t] = 0.0;
    sheet.inputs.rest_scale[t] = 0.0;
  }
  for (std::size_t i = 0; i < sheet.inputs.mass.size(); i += 3) sheet.inputs.mass[i] *= 1e-9;
  sheet.run(0.5, 1.0 / 60.0);
  EXPECT_TRUE(sheet.finite());
}

TEST(Extremes, TwoTrianglesNoTrianglesAndOrphans) {
  ShellParams params;
  Sheet two(rectangle(2, 2, {0.1, 0.1}, Lattice::grid), params);
  two.gravity = Vec3(0, 0, -9.81);
  two.run(0.2, 1.0 / 60.0);
  EXPECT_TRUE(two.finite());
  Sheet none({{{0, 0, 0}, {1, 0, 0}}, {}, {}}, params);
  none.gravity = Vec3(0, 0, -9.81);
  none.run(0.2, 1.0 / 60.0);
  EXPECT_EQ(none.state.x[1], Vec3(1, 0, 0));
  Sheet empty({}, params);
  empty.run(0.1, 1.0 / 60.0);
}

TEST(Extremes, AFanOfAHundredTrianglesHasMoreColorsThanBits) {
  TriangleSoup fan;
  fan.positions.push_back(Vec3::Zero());
  const int n = 100;
  for (int k = 0; k < n; ++k)
    fan.positions.emplace_back(0.1 * std::cos(2 * M_PI * k / n), 0.1 * std::sin(2 * M_PI * k / n), 0.0);
  for (int k = 0; k < n; ++k) fan.triangles.push_back({0, 1 + k, 1 + (k + 1) % n});
  ShellParams params;
  Sheet sheet(std::move(fan), params);
  sheet.pin_where([](const Vec3& X) { return X.norm() < 1e-9; });
  sheet.gravity = Vec3(0, 0, -9.81);
  sheet.run(0.5, 1.0 / 60.0);
  EXPECT_TRUE(sheet.finite());
  EXPECT_LT(sheet.step(1.0 / 60.0).max_stretch, 0.5);
}

TEST(Extremes, TwoHundredThousandTriangles) {
  ShellParams params;
  Sheet sheet(rectangle(318, 317, {1.0, 1.0}), params);
  EXPECT_GT(sheet.mesh.triangle_count(), 200000u);
  sheet.gravity = Vec3(0, 0, -9.81);
  sheet.step(1.0 / 60.0);
  EXPECT_TRUE(sheet.finite());
}

}  // namespace
}  // namespace wick::solid
