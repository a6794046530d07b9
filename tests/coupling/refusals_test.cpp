/// What a world refuses by name before its first frame, and what it reports instead of hiding it.
#include <gtest/gtest.h>

#include "core/require.h"
#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

std::string pointer_of_refusal(const WorldParams& params) {
  try {
    const World world(params);
  } catch (const Refusal& refusal) {
    return refusal.pointer();
  }
  return "accepted";
}

TEST(Refused, CellsTooSmallForVolumes) {
  WorldParams params;
  params.smoke = test::closed_box(16);
  params.smoke->width = 1e-4;
  EXPECT_EQ(pointer_of_refusal(params), "/smoke/width");
  params.smoke->width = 1.7e-3;
  EXPECT_EQ(pointer_of_refusal(params), "accepted");
}

TEST(Refused, WrinklesLargerThanTheSheet) {
  WorldParams params;
  params.shells.push_back(test::flat_sheet(5, 0.5, 0.5));
  params.shells[0].mesh.wrinkle = 1000.0;
  EXPECT_EQ(pointer_of_refusal(params), "/shells/0/mesh/wrinkle");
}

TEST(Refused, SheetsInsideAnObstacle) {
  WorldParams params;
  params.shells.push_back(test::flat_sheet(5, 0.5, 0.5));
  params.obstacles.push_back(
      {.name = "block", .kind = ObstacleKind::box, .lower = Vec3::Constant(-9), .upper = Vec3::Constant(9)});
  EXPECT_EQ(pointer_of_refusal(params), "/obstacles/0");
  params.obstacles[0].upper = Vec3(0.5, 9, 9);  // half of the sheet looks out
  EXPECT_EQ(pointer_of_refusal(params), "/obstacles/0");
  params.obstacles[0].upper = Vec3(9, 9, 0.51);  // a floor a little too high
  EXPECT_EQ(pointer_of_refusal(params), "accepted");
}

TEST(Reported, AClosedBoxThatAnObstacleEnters) {
  WorldParams params;
  params.smoke = test::closed_box(16);
  params.obstacles.push_back(
      {.name = "ball", .center = Vec3(0.5, 0.5, -0.2), .radius = 0.3, .velocity = Vec3(0, 0, 3)});
  World world(params);
  EXPECT_GT(world.step(1.0 / 24).squeezed_steps, 0);

  params.smoke->sides[5] = fluid::Side::open;
  World open(params);
  EXPECT_EQ(open.step(1.0 / 24).squeezed_steps, 0);

  // Inside the box it leaves behind it what it takes before it.
  params.smoke->sides[5] = fluid::Side::closed;
  params.obstacles[0].center.z() = 0.5;
  params.obstacles[0].radius = 0.2;
  World inside(params);
  EXPECT_EQ(inside.step(1.0 / 24).squeezed_steps, 0);
}

}  // namespace
}  // namespace wick::coupling
