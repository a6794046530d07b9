/// Contact of sheets at the ends of every parameter: finite, and without crossings unless something held forces
/// them.
#include <gtest/gtest.h>

#include "tests/solid/sheet_group.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0;

/// Layers of a rumpled sheet that fall on each other and on a floor.
void add_layers(Group& group, int layers, const ShellParams& p) {
  for (int k = 0; k < layers; ++k) {
    TriangleSoup soup = equilateral(15, 13, 0.014 + 1e-4 * k);
    for (Vec3& x : soup.positions) x.z() = 0.004 * std::sin(40.0 * x.x() + k) * std::cos(50.0 * x.y());
    Sheet& sheet = group.add(moved(soup, turn_about(Vec3::UnitZ(), 11.0 * k), Vec3(0, 0, 0.02 + 0.012 * k)), p);
    sheet.gravity = Vec3(0, 0, -9.81);
    sheet.obstacles.push_back({"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5});
  }
}

void expect_sound(Group& group, int frames, double dt = kFrame) {
  ASSERT_EQ(group.crossings(), 0U);
  for (int n = 0; n < frames; ++n) {
    group.step(dt);
    ASSERT_TRUE(group.finite()) << "frame " << n;
    ASSERT_EQ(group.crossings(), 0U) << "frame " << n;
    EXPECT_EQ(group.contact->report().impossible, 0U) << "frame " << n;
  }
}

TEST(ContactExtremes, Substeps) {
  for (const int substeps : {1, 2, 5, 60, 200}) {
    SCOPED_TRACE(substeps);
    Group group;
    ShellParams p = cotton();
    p.substeps = substeps;
    add_layers(group, 2, p);
    expect_sound(group, 20);
  }
}

TEST(ContactExtremes, ThicknessFromAMillionthToATenthOfTheSheet) {
  for (const double share : {1e-6, 1e-4, 1e-2, 1e-1}) {
    SCOPED_TRACE(share);
    Group group;
    group.params.thickness = 0.2 * share;
    add_layers(group, 2, cotton());
    expect_sound(group, 20);
    EXPECT_EQ(group.contact->lowered() > 0, share > 0.05);
  }
}

TEST(ContactExtremes, FrictionSweepsAndReach) {
  for (const double friction : {0.0, 0.1, 10.0, 100.0})
    for (const int sweeps : {1, 20})
      for (const double reach : {0.01, 10.0}) {
        SCOPED_TRACE(::testing::Message() << friction << ", " << sweeps << " sweeps, reach " << reach);
        Group group;
        group.params.friction = friction;
        group.params.kinetic_friction = 0.5 * friction;
        group.params.sweeps = sweeps;
        group.params.reach = reach;
        add_layers(group, 2, cotton());
        expect_sound(group, 8);
      }
}

TEST(ContactExtremes, TwelveLayersAtOnce) {
  Group group;
  add_layers(group, 12, cotton());
  expect_sound(group, 30);
}

/// A sheet between two plates that close until a hundredth of it is left.
TEST(ContactExtremes, CrushedToAHundredth) {
  Group group;
  TriangleSoup soup = equilateral(17, 17, 0.0125);
  for (Vec3& x : soup.positions) x = Vec3(x.x() - 0.1, 0.01 * std::sin(37.0 * x.y() + 11.0 * x.x()), x.y() - 0.09);
  Sheet& sheet = group.add(std::move(soup), cotton());
  const double speed = 0.2, height = 0.11, end = 0.001;
  sheet.obstacles.push_back({"floor", PlaneShape{Vec3(0, 0, -height), Vec3::UnitZ()}, 0.5, Vec3(0, 0, speed)});
  sheet.obstacles.push_back({"roof", PlaneShape{Vec3(0, 0, height), -Vec3::UnitZ()}, 0.5, Vec3(0, 0, -speed)});
  const int frames = static_cast<int>((height - end) / speed / kFrame);
  for (int n = 0; n < frames; ++n) {
    group.step(kFrame);
    for (Obstacle& o : sheet.obstacles) o.pose.shift += kFrame * o.velocity;
    ASSERT_EQ(group.crossings(), 0U) << "frame " << n;
  }
  ASSERT_TRUE(group.finite());
}

/// Triangles a hundred times as long as wide, and frames from a microsecond to a second.
TEST(ContactExtremes, SliversAndFrameLengths) {
  for (const double dt : {1e-6, 1e-3, 0.05, 1.0}) {
    SCOPED_TRACE(dt);
    Group group;
    for (int k = 0; k < 2; ++k) {
      TriangleSoup soup = rectangle(3, 60, {0.2, 0.06}, Lattice::grid);
      for (Vec3& x : soup.positions) x.z() = 0.002 * std::sin(90.0 * x.y());
      Sheet& sheet =
          group.add(moved(soup, turn_about(Vec3::UnitZ(), 40.0 * k), Vec3(0, 0, 0.01 + 0.01 * k)), cotton());
      sheet.gravity = Vec3(0, 0, -9.81);
      sheet.obstacles.push_back({"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5});
    }
    expect_sound(group, dt > 0.5 ? 2 : 10, dt);
  }
}

/// Masses that differ by a million, and speeds at which a substep crosses everything.
TEST(ContactExtremes, MassesAndSpeeds) {
  for (const double density : {0.16, 160.0, 1.6e5})
    for (const double speed : {0.0, 30.0, 3000.0}) {
      SCOPED_TRACE(::testing::Message() << density << " kg/m3, " << speed << " m/s");
      Group group;
      ShellParams heavy = cotton();
      heavy.density = density;
      group.add(moved(equilateral(9, 9, 0.02), Mat3::Identity(), Vec3(-0.02, -0.02, 0.0)), cotton());
      Sheet& upper =
          group.add(moved(equilateral(9, 9, 0.013), turn_about(Vec3(1, 1, 0), 15), Vec3(0, 0, 0.03)), heavy);
      for (Vec3& v : upper.state.v) v = Vec3(0, 0, -speed);
      upper.gravity = Vec3(0, 0, -9.81);
      expect_sound(group, 6);
    }
}

}  // namespace
}  // namespace wick::solid
