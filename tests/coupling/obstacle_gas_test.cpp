/// Obstacles in the gas: plates thinner than a cell, and moving ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A box with a fire on its floor under a plate of a tenth of a millimetre, in cells of 42 mm.
WorldParams plate_world(fluid::Advection advection) {
  WorldParams params;
  params.smoke = test::closed_box(24);
  params.smoke->sides[5] = fluid::Side::open;
  params.smoke->scalar_advection = advection;
  params.obstacles.push_back(
      {.name = "plate", .kind = ObstacleKind::box, .lower = Vec3(-1, -1, 0.61), .upper = Vec3(2, 2, 0.6101)});
  params.heat_sources.push_back(
      {.center = Vec3(0.5, 0.5, 0.2), .radius = 0.1, .gas_power = 200.0, .gas_smoke = 1e-3, .stop = 1e9});
  params.coupling.max_step = 1.0 / 60;
  return params;
}

/// Smoke in the cells whose centre lies above (side 1) or below (-1) the height [kg].
double smoke_beyond(const World& world, const fluid::SmokeParams& params, double height, int side) {
  const fluid::Grid grid = fluid::smoke_grid(params);
  double sum = 0.0;
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i)
        if (side * (grid.cell_center(i, j, k).z() - height) > 0.0)
          sum += world.smoke()->density[grid.cell(i, j, k)] * std::pow(grid.h, 3);
  return sum;
}

/// Fills the lower half of the box with smoke.
class LowerHalf final : public StateVisitor {
 public:
  explicit LowerHalf(float density) : density_(density) {}
  void raw(std::string_view name, ScalarType /*type*/, std::size_t rows, std::size_t /*columns*/,
           const void* /*data*/, FunctionRef<void*(std::size_t)> resize) override {
    if (name == "density") std::fill_n(static_cast<float*>(resize(rows)), rows / 2, density_);
  }
  void strings(std::string_view /*name*/, std::vector<std::string>& /*values*/) override {}
  void begin_group(std::string_view /*name*/) override {}
  void end_group() override {}

 private:
  float density_;
};

TEST(ObstacleInGas, ThinPlateLetsNothingThrough) {
  for (const auto advection : {fluid::Advection::conservative, fluid::Advection::maccormack}) {
    const WorldParams params = plate_world(advection);
    World world(params);
    while (world.time() < 3.0) world.step(1.0 / 24);
    const double total = world.ledgers().at("smoke").stocks().at("grid");
    EXPECT_GT(total, 1e-3);
    EXPECT_LT(smoke_beyond(world, *params.smoke, 0.6101, 1), 1e-12 * total);
  }
}

TEST(ObstacleInGas, MovingPlateLeavesNothingBehind) {
  // Up a shaft whose lower half is full of smoke; the plate starts at its floor.
  for (const double thickness : {0.0001, 0.05, 0.2})
    for (const double speed : {0.05, 2.0, 20.0, 300.0}) {
      WorldParams params = plate_world(fluid::Advection::conservative);
      params.heat_sources.clear();
      params.smoke->sides[4] = fluid::Side::open;
      params.obstacles[0].lower.z() = -0.001 - thickness;
      params.obstacles[0].upper.z() = -0.001;
      params.obstacles[0].velocity.z() = speed;
      World world(params);
      LowerHalf fill(0.1F);
      world.visit(fill);
      const double all = 0.1 * 0.5;
      const double end = 0.55 / speed;
      for (int frame = 0; frame < 8; ++frame) world.step(end / 8);
      const double top = 0.549;  // of the plate
      EXPECT_LT(smoke_beyond(world, *params.smoke, top - thickness, -1), 1e-12 * all)
          << thickness << " m, " << speed;
      const Ledger& smoke = world.ledgers().at("smoke");
      EXPECT_NEAR(smoke_beyond(world, *params.smoke, top, 1) - smoke.flows().at("outflow"), all, 1e-5 * all)
          << thickness << " m, " << speed;
      EXPECT_NEAR(smoke.flows().contains("walled_in") ? smoke.flows().at("walled_in") : 0.0, 0.0, 1e-12 * all);
    }
}

TEST(ObstacleInGas, MovingBallKeepsTheBooksAndTheSmokeApart) {
  // Through a cloud and out of it: what it takes in it gives back before it, and the books close.
  for (const double speed : {0.5, 10.0}) {
    WorldParams params = plate_world(fluid::Advection::conservative);
    params.heat_sources[0].stop = 0.2;
    params.obstacles = {
        {.name = "ball", .center = Vec3(-0.3, 0.5, 0.25), .radius = 0.15, .velocity = Vec3(speed, 0.0, 0.0)}};
    World world(params);
    while (world.time() < 1.0) world.step(1.0 / 24);
    const Ledger& smoke = world.ledgers().at("smoke");
    EXPECT_LT(smoke.relative_error(), 1e-8) << speed;
    EXPECT_LT(world.ledgers().at("heat").relative_error(), 1e-8) << speed;
    EXPECT_LT(std::abs(smoke.flows().at("walled_in")), 1e-12) << speed;
  }
}

/// A burning sheet at rest, or moved by its pins, above a plate of a millimetre through all of the box.
WorldParams sheet_over_plate(double height, const Vec3& velocity) {
  WorldParams params;
  params.smoke = test::closed_box(32);
  params.smoke->sides.fill(fluid::Side::open);
  params.shells.push_back(test::flat_sheet(21, 0.6, height));
  if (velocity.isZero())
    params.shells[0].moves = false;
  else
    params.shells[0].pins.push_back(
        {.point = Vec3(0.5, 0.5, height), .radius = 9.0, .velocity = velocity, .stop_time = 9.0});
  params.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  params.burning.emplace();
  params.obstacles.push_back(
      {.name = "plate", .kind = ObstacleKind::box, .lower = Vec3(-1, -1, 0.499), .upper = Vec3(2, 2, 0.5)});
  params.heat_sources.push_back({.center = Vec3(0.5, 0.5, height), .radius = 0.12, .stop = 5.0});
  return params;
}

TEST(ObstacleInGas, SheetOnAThinPlateSmokesOnItsOwnSide) {
  // In the plate's cell, and carried down towards it.
  for (const auto& [height, speed] : {std::pair(0.505, 0.0), std::pair(0.5005, 0.0), std::pair(0.62, 0.15)}) {
    const WorldParams params = sheet_over_plate(height, Vec3(0, 0, -speed));
    World world(params);
    while (world.time() < 0.75) world.step(1.0 / 24);
    const Ledger& smoke = world.ledgers().at("smoke");
    EXPECT_GT(smoke.flows().at("burning"), 1e-6);
    EXPECT_LT(smoke_beyond(world, *params.smoke, 0.4995, -1), 1e-9 * smoke.flows().at("burning")) << height;
    EXPECT_LT(smoke.relative_error(), 1e-7);
    EXPECT_LT(std::abs(smoke.flows().at("escaped")), 1e-2 * smoke.flows().at("burning")) << height;
  }
}

TEST(ObstacleInGas, MovingBoxOfThinPlatesKeepsItsSmoke) {
  for (const Vec3& velocity : {Vec3(0.8, 0, 0), Vec3(0.5, 0.5, 0.5)}) {
    WorldParams params = plate_world(fluid::Advection::conservative);
    params.smoke = test::closed_box(32);
    params.smoke->sides.fill(fluid::Side::open);
    params.obstacles.clear();
    const double low = 0.2, high = 0.55, thick = 0.001;
    for (int axis = 0; axis < 3; ++axis)
      for (const double at : {low, high}) {
        Vec3 lower = Vec3::Constant(low - thick), upper = Vec3::Constant(high + thick);
        lower[axis] = at - thick;
        upper[axis] = at + thick;
        params.obstacles.push_back(
            {.name = "wall", .kind = ObstacleKind::box, .lower = lower, .upper = upper, .velocity = velocity});
      }
    params.heat_sources = {
        {.center = Vec3(0.37, 0.37, 0.37), .radius = 0.06, .velocity = velocity, .gas_smoke = 1e-4, .stop = 0.2}};
    World world(params);
    while (world.time() < 0.5) world.step(1.0 / 48);
    const fluid::Grid grid = fluid::smoke_grid(*params.smoke);
    double outside = 0.0, total = 0.0;
    for (int k = 0; k < grid.nz; ++k)
      for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
          const double kg = world.smoke()->density[grid.cell(i, j, k)] * std::pow(grid.h, 3);
          const Vec3 p = grid.cell_center(i, j, k) - world.time() * velocity;
          total += kg;
          if (p.minCoeff() < low || p.maxCoeff() > high) outside += kg;
        }
    EXPECT_GT(total, 1e-5);
    EXPECT_LT(outside, 1e-9 * total) << velocity.transpose();
    EXPECT_LT(world.ledgers().at("smoke").relative_error(), 1e-7);
  }
}

TEST(ObstacleInGas, ClosingSlotLetsItsSmokeOutAtItsSides) {
  WorldParams params = plate_world(fluid::Advection::conservative);
  params.smoke = test::closed_box(32);
  params.smoke->sides.fill(fluid::Side::open);
  params.obstacles = {
      {.name = "box", .kind = ObstacleKind::box, .lower = Vec3(0.2, 0.2, 0.3), .upper = Vec3(0.8, 0.8, 0.5)},
      {.name = "lid",
       .kind = ObstacleKind::box,
       .lower = Vec3(0.1, 0.1, 0.72),
       .upper = Vec3(0.9, 0.9, 0.725),
       .velocity = Vec3(0, 0, -0.25)}};
  params.heat_sources = {
      {.center = Vec3(0.5, 0.5, 0.6), .radius = 0.06, .gas_power = 5.0, .gas_smoke = 4e-5, .stop = 0.2}};
  World world(params);
  while (world.time() < 0.85) world.step(1.0 / 24);
  const Ledger& smoke = world.ledgers().at("smoke");
  EXPECT_LT(std::abs(smoke.flows().at("walled_in")), 1e-9 * smoke.flows().at("sources"));
}

TEST(ObstacleInGas, WhatIsPushedOutOfAnOpenSideIsOutflow) {
  WorldParams params = plate_world(fluid::Advection::conservative);
  params.heat_sources[0].stop = 0.1;
  params.heat_sources[0].center.z() = 0.8;
  params.obstacles[0].velocity = Vec3(0, 0, 0.5);
  World world(params);
  while (world.time() < 1.0) world.step(1.0 / 24);
  const Ledger& smoke = world.ledgers().at("smoke");
  EXPECT_LT(std::abs(smoke.flows().at("walled_in")), 1e-9 * smoke.flows().at("sources"));
  EXPECT_LT(smoke.stocks().at("grid"), 1e-9 * smoke.flows().at("sources")) << "all is pushed out";
  EXPECT_LT(smoke.relative_error(), 1e-7);
}

}  // namespace
}  // namespace wick::coupling
