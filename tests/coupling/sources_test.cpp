/// Regions that heat sheets and gas.
#include "coupling/sources.h"

#include <gtest/gtest.h>

#include "core/require.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

WorldParams world_with_box() {
  WorldParams world;
  world.shells.push_back(test::flat_sheet(21, 1.0, 0.5));
  world.shells[0].moves = false;
  world.diffusion.emplace();
  world.heat_sources.push_back({.kind = SourceKind::box,
                                .lower = Vec3(0.0, 0.0, 0.4),
                                .upper = Vec3(1.0, 0.101, 0.6),
                                .velocity = Vec3(0.0, 0.5, 0.0)});
  return world;
}

TEST(HeatSource, BoxHeatsTheVerticesInsideItAndMoves) {
  const WorldParams world = world_with_box();
  std::vector<std::string> warnings;
  const Sheet sheet = build_sheet(world.shells[0], "/shells/0", world, warnings);
  for (const double time : {0.0, 0.6}) {
    const SheetSupply supply = sheet_supply(world, sheet, 293.15, 806.85, time, 0.1);
    for (std::size_t i = 0; i < sheet.mesh.vertex_count(); ++i) {
      const double y = sheet.state.x[i].y() - 0.5 * time;
      EXPECT_EQ(supply.rate[i] > 0.0, y >= 0.0 && y <= 0.101) << sheet.state.x[i].transpose();
    }
  }
}

TEST(HeatSource, BoxSpreadsItsPowerOverItsCells) {
  WorldParams world = world_with_box();
  world.smoke = test::closed_box(10);
  world.heat_sources[0] = {.kind = SourceKind::box,
                           .lower = Vec3(0.2, 0.2, 0.2),
                           .upper = Vec3(0.4, 0.6, 0.3),
                           .gas_power = 50.0,
                           .gas_smoke = 1e-3,
                           .stop = 10.0};
  const fluid::Grid grid = fluid::smoke_grid(*world.smoke);
  const fluid::SmokeSources sources = gas_sources(world, grid, fluid::Walls{}, 0.0, 0.1);
  EXPECT_EQ(sources.cell.size(), 2u * 4u * 1u);
  double heat = 0.0, smoke = 0.0;
  for (const double joule : sources.heat) heat += joule;
  for (const double kg : sources.smoke) smoke += kg;
  EXPECT_NEAR(heat, 5.0, 1e-12);
  EXPECT_NEAR(smoke, 1e-4, 1e-16);
}

TEST(HeatSource, ThatReachesNoGasIsReported) {
  WorldParams params;
  params.smoke = test::closed_box(16);
  params.heat_sources.push_back({.center = Vec3(0.5, 0.5, 0.5), .radius = 0.1, .gas_smoke = 1e-3, .stop = 1e30});
  HeatSourceParams& source = params.heat_sources[0];
  const auto warnings = [&] { return World(params).warnings(); };
  EXPECT_TRUE(warnings().empty());

  source.center.z() = 1.03;  // reaches into the box by more than half a cell
  EXPECT_TRUE(warnings().empty());
  source.center.z() = 3.0;
  const std::string outside =
      "/heat_sources/0/gas_smoke: has no effect (the source is outside the box of the gas all the time)";
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_EQ(warnings()[0], outside);
  source.velocity = Vec3(0, 0, -1);  // comes in at 1.9 s
  EXPECT_TRUE(warnings().empty());
  source.stop = 1.5;
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_EQ(warnings()[0], outside);

  source = {.center = Vec3(0.5, 0.5, 0.5), .radius = 0.1, .gas_power = 10.0, .stop = 2.0};
  params.obstacles.push_back({.center = Vec3(0.5, 0.5, 0.5), .radius = 0.25});
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_EQ(warnings()[0], "/heat_sources/0/gas_power: has no effect (no cell of gas lies in the source)");
  params.obstacles[0].velocity = Vec3(1, 0, 0);  // lets it free
  EXPECT_TRUE(warnings().empty());
}

TEST(HeatSource, BoxWithoutExtentIsRefusedByName) {
  WorldParams world = world_with_box();
  world.heat_sources[0].upper = world.heat_sources[0].lower;
  try {
    check_world(world);
    FAIL() << "accepted";
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.pointer(), "/heat_sources/0/upper");
  }
}

}  // namespace
}  // namespace wick::coupling
