/// The ways in which gas and sheets can be stepped together: simultaneous against partitioned, window against full
/// box.
#include <gtest/gtest.h>

#include <cmath>

#include "core/require.h"
#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A paper flag that hangs in still air and is lit at its free end.
WorldParams lit_flag(int cells) {
  WorldParams world;
  world.smoke = test::closed_box(cells);
  for (const int side : {0, 1, 2, 3, 5}) world.smoke->sides[side] = fluid::Side::open;
  world.shells.push_back(test::flat_sheet(17, 0.4, 0.4));
  world.shells[0].pins.push_back({.edge = PinEdge::upper_x});
  world.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  world.diffusion->alpha = 2.5e-3;
  world.burning.emplace();
  world.burning->rim =
      BurntRim::whole;  // vertices keep their places on the sheet, so that two runs can be compared
  world.heat_sources.push_back({.center = Vec3(0.3, 0.5, 0.4), .radius = 0.08, .gas_power = 50.0, .stop = 0.5});
  return world;
}

struct Difference {
  double apart = 0.0, moved = 0.0;  ///< mean over the vertices [m]
};
Difference compare(const World& a, const World& b, const std::vector<Vec3>& start) {
  const auto &x = *a.shells()[0].x, &y = *b.shells()[0].x;
  Difference d;
  for (std::size_t i = 0; i < x.size(); ++i) {
    d.apart += (x[i] - y[i]).norm() / double(x.size());
    d.moved += (x[i] - start[i]).norm() / double(x.size());
  }
  return d;
}

TEST(ActiveWindow, ABurningSheetMovesAsInTheFullBox) {
  WorldParams params = lit_flag(32);
  World full(params);
  params.smoke->active_window = true;
  World windowed(params);
  const std::vector<Vec3> start = *full.shells()[0].x;
  for (int n = 0; n < 18; ++n) full.step(1.0 / 24), windowed.step(1.0 / 24);
  const Difference d = compare(full, windowed, start);
  // The window ends eight and more cells away from all that moves, at p = 0: a few percent of the pressure there.
  EXPECT_LT(d.apart, 0.05 * d.moved);
  const double smoke = full.ledgers().at("smoke").stocks().at("grid");
  EXPECT_GT(smoke, 0.0);
  EXPECT_NEAR(windowed.ledgers().at("smoke").stocks().at("grid"), smoke, 0.05 * smoke);
  EXPECT_LT(windowed.ledgers().at("solid").relative_error(), 1e-10);
}

TEST(PartitionedScheme, FollowsTheSimultaneousOne) {
  WorldParams params = lit_flag(24);
  World together(params);
  params.coupling.scheme = CouplingScheme::partitioned;
  World partitioned(params);
  const std::vector<Vec3> start = *together.shells()[0].x;
  int steps = 0;
  for (int n = 0; n < 24; ++n) together.step(1.0 / 24), steps += partitioned.step(1.0 / 24).substeps;
  EXPECT_LT(steps, 24 * 16) << "no runaway";
  const Difference d = compare(together, partitioned, start);
  // Its force lags by some steps, so that it is a likeness, no equal: within a third of the way that the sheet
  // went.
  EXPECT_LT(d.apart, 0.33 * d.moved);
}

TEST(PartitionedScheme, EndsByNameWhenItRunsAway) {
  WorldParams params = lit_flag(24);
  params.shells[0].material.thickness = 2e-5;
  params.coupling.scheme = CouplingScheme::partitioned;
  params.coupling.relaxation = 1.0;
  World world(params);
  try {
    for (int n = 0; n < 48; ++n) world.step(1.0 / 24);
    FAIL() << "ten times the added mass that an unrelaxed scheme bears, and no runaway";
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.code(), ExitCode::numerical_failure);
    EXPECT_EQ(refusal.pointer(), "/coupling/scheme");
  }
}

}  // namespace
}  // namespace wick::coupling
