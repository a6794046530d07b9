/// Regions that heat sheets and gas.
#include "coupling/heat_sources.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/require.h"
#include "coupling/world_parts.h"
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

TEST(HeatSource, BoxHeatsTheVerticesInsideIt) {
  WorldParams world = world_with_box();
  world.heat_sources[0].velocity.setZero();
  std::vector<std::string> warnings;
  const Sheet sheet = build_sheet(world.shells[0], "/shells/0", world, warnings);
  const SheetSupply supply = sheet_supply(world, sheet, 293.15, 806.85, 0.0, 0.1);
  for (std::size_t i = 0; i < sheet.mesh.vertex_count(); ++i) {
    const double y = sheet.state.x[i].y();
    EXPECT_EQ(supply.rate[i] > 0.0, y >= 0.0 && y <= 0.101) << sheet.state.x[i].transpose();
  }
}

// A vertex that a source of length L along its way passes at speed V is in it for L/V, in however many steps it
// passes, and however thin it is.
TEST(HeatSource, ThatMovesHeatsEachVertexForAsLongAsItPasses) {
  WorldParams world = world_with_box();
  std::vector<std::string> warnings;
  const Sheet sheet = build_sheet(world.shells[0], "/shells/0", world, warnings);
  HeatSourceParams& source = world.heat_sources[0];
  source.stop = 1e9;
  const auto seconds = [&](double passing, int steps) {
    std::vector<double> sum(sheet.mesh.vertex_count(), 0.0);
    const double dt = passing / steps;
    for (int n = 0; n < steps; ++n) {
      const SheetSupply supply = sheet_supply(world, sheet, 293.15, 806.85, n * dt, dt);
      for (std::size_t i = 0; supply.any && i < sum.size(); ++i)
        sum[i] += supply.rate[i] / (source.rate * sheet.heat_capacity[i]) * dt;
    }
    return sum;
  };
  for (const double length : {1e-6, 0.002, 0.101})
    for (const double speed : {0.5, 50.0, 1e6})
      for (const int steps : {1, 7, 100}) {
        source.kind = SourceKind::box;
        source.velocity = Vec3(0.0, speed, 0.0);
        source.lower.y() = -0.201 - length;
        source.upper.y() = -0.201;
        const double passing = 2.0 / speed;  // until it has left the sheet of 1 m
        for (const double s : seconds(passing, steps)) EXPECT_NEAR(s * speed, length, 1e-9) << speed;

        source.kind = SourceKind::ball;
        source.radius = 0.5 * length;
        source.center = Vec3(sheet.state.x[0].x(), -0.201, 0.5);
        const std::vector<double> along = seconds(passing, steps);
        for (std::size_t i = 0; i < along.size(); ++i) {
          const double aside = sheet.state.x[i].x() - source.center.x();
          const double chord = std::sqrt(std::max(0.0, length * length - 4.0 * aside * aside));
          EXPECT_NEAR(along[i] * speed, chord, 1e-9) << speed << " at " << sheet.state.x[i].transpose();
        }
      }
}

TEST(HeatSource, BoxSpreadsItsPowerOverItsCells) {
  WorldParams world = world_with_box();
  world.smoke = test::closed_box(10);
  const fluid::Grid grid = fluid::smoke_grid(*world.smoke);
  HeatSourceParams& source = world.heat_sources[0];
  source = {.kind = SourceKind::box,
            .lower = Vec3(0.2, 0.2, 0.2),
            .upper = Vec3(0.4, 0.6, 0.3),
            .gas_power = 50.0,
            .gas_smoke = 1e-3,
            .stop = 10.0};
  for (const bool between_centres : {false, true}) {
    if (between_centres) source.lower.z() = 0.28, source.upper.z() = 0.29;
    const fluid::SmokeSources sources = gas_sources(world, grid, fluid::Walls{}, 0.0, 0.1);
    EXPECT_EQ(sources.cell.size(), 2u * 4u * 1u);
    for (const std::int64_t c : sources.cell) EXPECT_EQ(c / 100, 2);
    double heat = 0.0, smoke = 0.0;
    for (const double joule : sources.heat) heat += joule;
    for (const double kg : sources.smoke) smoke += kg;
    EXPECT_NEAR(heat, 5.0, 1e-12);
    EXPECT_NEAR(smoke, 1e-4, 1e-16);
  }
}

// Of a source that crosses the box the gas gets power times the time in the box, along the way, at any speed and
// step.
TEST(HeatSource, ThatMovesGivesToTheGasAllAlongItsWay) {
  WorldParams world;
  world.smoke = test::closed_box(20);
  const fluid::Grid grid = fluid::smoke_grid(*world.smoke);
  for (const double speed : {1.0, 400.0, 1e7})
    for (const int steps : {1, 10, 1000}) {
      world.heat_sources = {{.center = Vec3(-0.5, 0.48, 0.52),
                             .radius = 0.1,
                             .velocity = Vec3(speed, 0, 0),
                             .gas_power = 50.0,
                             .stop = 1e9}};
      const double dt = 2.0 / speed / steps;
      std::vector<double> along(20, 0.0);
      for (int n = 0; n < steps; ++n) {
        const fluid::SmokeSources sources = gas_sources(world, grid, fluid::Walls{}, n * dt, dt);
        for (std::size_t s = 0; s < sources.cell.size(); ++s)
          along[static_cast<std::size_t>(sources.cell[s] % 20)] += sources.heat[s];
      }
      double all = 0.0;
      for (const double joule : along) all += joule;
      // While its rim alone is inside, it gives as soon as a cell centre lies in it.
      EXPECT_GT(all * speed, 50.0);
      EXPECT_LT(all * speed, 50.0 * 1.2);
      for (int i = 3; i < 17; ++i) EXPECT_NEAR(along[i], 50.0 / 20.0 / speed, 0.3 * 50.0 / 20.0 / speed) << i;
    }
}

TEST(HeatSource, ManySourcesTakeNoMoreMemoryThanTheGrid) {
  WorldParams world;
  world.smoke = test::closed_box(12);
  const fluid::Grid grid = fluid::smoke_grid(*world.smoke);
  for (int n = 0; n < 40; ++n)
    world.heat_sources.push_back({.kind = SourceKind::box,
                                  .lower = Vec3(-1, -1, -1.0 - n),
                                  .upper = Vec3(2, 2, -0.5 - n),
                                  .velocity = Vec3(0, 0, n % 2 == 0 ? 0.0 : 1e4),
                                  .gas_power = 50.0,
                                  .stop = 1e9});
  world.heat_sources[0].upper.z() = 2.0;
  const fluid::SmokeSources sources = gas_sources(world, grid, fluid::Walls{}, 0.0, 1.0);
  EXPECT_EQ(sources.cell.size(), grid.cells());
  // Half of them pass, each for its own and the box's height; rims without a centre give nothing.
  const double passing = 20 * 50.0 * 1.5 / 1e4;
  double heat = 0.0;
  for (const double joule : sources.heat) heat += joule;
  EXPECT_NEAR(heat, 50.0 + passing, 0.1 * passing);
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

  // Its rim passes along the side, and holds no centre of a cell.
  source = {
      .center = Vec3(-0.5, 1.05, 0.5), .radius = 0.06, .velocity = Vec3(1, 0, 0), .gas_power = 10.0, .stop = 9.0};
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_EQ(warnings()[0], "/heat_sources/0/gas_power: has no effect (no cell of gas lies in the source)");

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
