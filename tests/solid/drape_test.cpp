/// A square of cloth falls over a ball and hangs from it: contact, friction and rest at length.
#include <gtest/gtest.h>

#include <array>

#include "core/parallel.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0, kBall = 0.25, kHalf = 0.5;

struct Drape {
  std::uint64_t hash = 0;
  double largest_speed = 0.0;  ///< at the end [m/s]
  double deepest = 0.0;        ///< least distance to the ball, less half the thickness, of all frames [m]
  double fallen = 0.0;         ///< energy lost from start to end [J]
  double lowest = 0.0,
         offset = 0.0;  ///< height of the lowest vertex, drift of the mean off the axis, at the end [m]
  bool finite = true;
};

/// 100 x 100 vertices of cotton in air, 1 m wide, dropped from 1 cm above the ball.
Drape drape(int frames, int threads) {
  ThreadLimit limit(threads);
  ShellParams params;
  params.thickness = 4e-4;
  params.density = 400.0;
  params.young_warp = params.young_weft = 5e6;
  params.bending = 1e-5;
  params.air_drag = 2.0;
  params.substeps = 100;  // below some 60 the strain that a sweep leaves behind weighs in the elastic energy
  Sheet sheet(rectangle(100, 100, {2.0 * kHalf, 2.0 * kHalf}), params);
  const Vec3 middle(kHalf, kHalf, 0.0);
  sheet.obstacles.push_back({"ball", SphereShape{middle - Vec3(0, 0, kBall + 0.01), kBall}, 0.5});
  sheet.gravity = Vec3(0, 0, -9.81);
  Drape result;
  result.deepest = 1.0;
  const double before = sheet.energy();
  for (int k = 1; k <= frames; ++k) {
    result.largest_speed = sheet.step(kFrame).max_speed;
    for (const Vec3& x : sheet.state.x)
      result.deepest =
          std::min(result.deepest, sample_distance(sheet.obstacles[0], x).distance - 0.5 * params.thickness);
  }
  result.fallen = before - sheet.energy();
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : sheet.state.x) {
    result.lowest = std::min(result.lowest, x.z());
    mean += x / static_cast<double>(sheet.state.x.size());
  }
  result.offset = (mean - middle).head<2>().norm();
  result.finite = sheet.finite();
  StateHash hash;
  visit(hash, sheet.state);
  result.hash = hash.digest();
  return result;
}

/// Holds for a drape of any length.
void expect_sound(const Drape& cloth) {
  EXPECT_TRUE(cloth.finite);
  // Contact puts vertices on the surface up to rounding.
  EXPECT_GT(cloth.deepest, -1e-9);
  // Contact, friction and air take energy, elastic energy counted. It need not fall in every frame: where a
  // fold snaps taut, the strain that one sweep leaves behind stands for more energy than the motion had.
  EXPECT_GT(cloth.fallen, 0.0);
}

TEST(Drape, FallsOverABallTheSameAtOneAndTwoThreads) {
  const Drape one = drape(60, 1), two = drape(60, 2);
  expect_sound(one);
  EXPECT_EQ(one.hash, two.hash);
  // Rows of the rim have swung down by at least half of the overhang.
  EXPECT_LT(one.lowest, -0.25);
}

TEST(LongDrape, ComesToRestOnABall) {
  const Drape one = drape(500, 1), two = drape(500, 2);
  expect_sound(one);
  EXPECT_EQ(one.hash, two.hash);
  // At rest: a hundredth of the speed of free fall over half the width.
  EXPECT_LT(one.largest_speed, 0.01 * std::sqrt(2.0 * 9.81 * kHalf));
  // Friction keeps it on the top.
  EXPECT_LT(one.offset, 0.1 * kBall);
}

}  // namespace
}  // namespace wick::solid
