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

}  // namespace
}  // namespace wick::coupling
