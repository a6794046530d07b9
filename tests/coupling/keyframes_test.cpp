/// Obstacles that move as keyframes tell: they push, carry, and are seen by gas where they are.
#include <gtest/gtest.h>

#include "core/require.h"
#include "coupling/obstacles.h"
#include "coupling/world.h"
#include "tests/support/memory_state.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A slab that lies still, rises, turns by a quarter about z while it goes on, and stops.
ObstacleParams turning_slab() {
  ObstacleParams slab;
  slab.kind = ObstacleKind::box;
  slab.lower = Vec3(0.2, 0.4, 0.2);
  slab.upper = Vec3(0.8, 0.6, 0.25);
  slab.friction = 1.0;
  slab.keyframes = {{0.1, Vec3::Zero(), Vec3::Zero()},
                    {0.3, Vec3(0, 0, 0.1), Vec3::Zero()},
                    {0.8, Vec3(0.1, 0, 0.1), Vec3(0, 0, 90)}};
  return slab;
}

TEST(Keyframes, PutTheBodyWhereTheySay) {
  WorldParams params;
  params.shells.push_back(test::flat_sheet(5, 0.1, 0.9));
  params.shells[0].pins.push_back({.edge = PinEdge::upper_x});
  params.obstacles.push_back(turning_slab());
  World world(params);
  for (int n = 0; n < 60; ++n) {
    world.step(1.0 / 60);
    const double t = world.time();
    const Obstacle& slab = world.obstacles()[0];
    const double rise = 0.1 * std::clamp((t - 0.1) / 0.2, 0.0, 1.0), turned = std::clamp((t - 0.3) / 0.5, 0.0, 1.0);
    const Vec3 middle(0.5 + 0.1 * turned, 0.5, 0.225 + rise);
    EXPECT_LT((slab.pose.place(Vec3(0.5, 0.5, 0.225)) - middle).norm(), 1e-12) << t;
    const Vec3 end = middle + Eigen::AngleAxisd(turned * M_PI_2, Vec3::UnitZ()) * Vec3(0.3, 0.1, 0.025);
    EXPECT_LT((slab.pose.place(Vec3(0.8, 0.6, 0.25)) - end).norm(), 1e-12) << t;
    EXPECT_NEAR(sample_distance(slab, end).distance, 0.0, 1e-12) << t;
    if (t > 0.32 && t < 0.78) {
      // A point of the body moves as its velocity there says.
      EXPECT_NEAR(slab.spin.z(), M_PI_2 / 0.5, 1e-9);
      EXPECT_NEAR(slab.velocity_at(end).norm(), (Vec3(0.2, 0, 0) + slab.spin.cross(end - middle)).norm(), 1e-9);
    }
  }
}

/// A sheet that lies on the slab is lifted, carried and turned with it: friction holds it, and nothing is left
/// inside.
TEST(Keyframes, CarryASheetThatLiesOnThem) {
  WorldParams params;
  params.shells.push_back(test::flat_sheet(11, 0.15, 0.2502));
  params.obstacles.push_back(turning_slab());
  // Slowly: where the slab starts or stops at once, what lies on it slides by v²/(2 μ g), or flies.
  params.obstacles[0].keyframes[1].time = 0.9;
  params.obstacles[0].keyframes[2].time = 2.9;
  World world(params);
  const Vec3 first = (*world.shells()[0].x)[0];
  for (int n = 0; n < 180; ++n) {
    world.step(1.0 / 60);
    for (const Vec3& x : *world.shells()[0].x)
      ASSERT_GT(sample_distance(world.obstacles()[0], x).distance, -1e-4) << "frame " << n;
  }
  const Vec3 there = world.obstacles()[0].pose.place(first);
  EXPECT_LT(((*world.shells()[0].x)[0] - there).norm(), 0.01) << "it went along by 0.1 m and turned";
}

TEST(Keyframes, TheGasIsSweptAndARestartIsTheSame) {
  WorldParams params;
  params.smoke = test::closed_box(24);
  params.smoke->sides[5] = fluid::Side::open;
  params.obstacles.push_back(turning_slab());
  params.heat_sources.push_back({.center = Vec3(0.5, 0.5, 0.1), .radius = 0.1, .gas_smoke = 1e-3, .stop = 0.3});
  World whole(params), first(params), second(params);
  for (int n = 0; n < 50; ++n) {
    whole.step(1.0 / 60);
    ASSERT_LT(whole.ledgers().at("smoke").relative_error(), 1e-5) << "frame " << n;
    for (const float v : whole.smoke()->velocity[0]) ASSERT_TRUE(std::isfinite(v));
  }
  for (int n = 0; n < 30; ++n) first.step(1.0 / 60);
  test::continue_from(first, second);
  for (int n = 0; n < 20; ++n) second.step(1.0 / 60);
  EXPECT_EQ(second.state_hash(), whole.state_hash());
}

TEST(Keyframes, AreRefusedByPlace) {
  const auto pointer = [](const ObstacleParams& slab) {
    WorldParams params;
    params.shells.push_back(test::flat_sheet(5, 0.1, 0.9));
    params.obstacles.push_back(slab);
    try {
      World world(params);
    } catch (const Refusal& refusal) {
      return refusal.pointer();
    }
    return std::string();
  };
  ObstacleParams slab = turning_slab();
  EXPECT_EQ(pointer(slab), "");
  slab.keyframes[2].time = 0.3;
  EXPECT_EQ(pointer(slab), "/obstacles/0/keyframes/2/time");
  slab = turning_slab();
  slab.velocity = Vec3(1, 0, 0);
  EXPECT_EQ(pointer(slab), "/obstacles/0/velocity");
}

/// Whatever the speed of turning: finite, and nothing inside at the end.
TEST(Keyframes, ExtremesStayFinite) {
  for (const double degrees : {1.0, 170.0, 1e4})
    for (const double duration : {1e-6, 0.01, 1.0}) {
      WorldParams params;
      params.shells.push_back(test::flat_sheet(9, 0.3, 0.3));
      ObstacleParams slab = turning_slab();
      slab.keyframes = {{0.1, Vec3::Zero(), Vec3::Zero()},
                        {0.1 + duration, Vec3(0, 0, 0.3), Vec3(degrees, degrees, 0)}};
      params.obstacles.push_back(slab);
      World world(params);
      for (int n = 0; n < 30; ++n) world.step(1.0 / 60);
      for (const Vec3& x : *world.shells()[0].x) EXPECT_TRUE(x.allFinite()) << degrees << " in " << duration;
    }
}

}  // namespace
}  // namespace wick::coupling
