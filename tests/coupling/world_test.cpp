#include "coupling/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <queue>

#include "core/parallel.h"
#include "core/require.h"
#include "coupling/exchange.h"
#include "coupling/rasterize.h"
#include "solid/crossings.h"
#include "tests/support/memory_state.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A small burning sheet in a small box: everything that the main scene has.
WorldParams burning_world(int cells = 24, int vertices = 21) {
  WorldParams world;
  world.smoke = test::closed_box(cells);
  world.smoke->sides[5] = fluid::Side::open;
  world.smoke->scalar_advection = fluid::Advection::conservative;
  world.shells.push_back(test::flat_sheet(vertices, 0.6, 0.3));
  world.shells[0].pins.push_back({.edge = PinEdge::upper_x});
  world.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  world.diffusion->alpha = 2.5e-3;
  world.burning.emplace();
  world.heat_sources.push_back({.center = Vec3(0.2, 0.5, 0.3), .radius = 0.1, .stop = 0.5});
  return world;
}

TEST(World, LedgersCloseWhileASheetBurns) {
  World world(burning_world());
  for (int n = 0; n < 45; ++n) world.step(1.0 / 24);
  const auto& ledgers = world.ledgers();
  EXPECT_LT(ledgers.at("solid").relative_error(), 1e-10);
  // Gas is kept in float: every deposit is rounded to 6e-8 of the cell it falls into.
  EXPECT_LT(ledgers.at("smoke").relative_error(), 1e-6);
  EXPECT_LT(ledgers.at("heat").relative_error(), 1e-5);
  EXPECT_LT(-0.05, ledgers.at("solid").total_flow());
  EXPECT_GT(-1e-3, ledgers.at("solid").total_flow());  // it does burn
  EXPECT_GT(ledgers.at("smoke").stocks().at("grid"), 0.0);
}

TEST(World, HeatOnASheetAloneIsBookedToRounding) {
  WorldParams params = burning_world();
  params.smoke.reset();
  World world(params);
  for (int n = 0; n < 60; ++n) world.step(1.0 / 24);
  EXPECT_LT(world.ledgers().at("solid").relative_error(), 1e-12);
  EXPECT_LT(world.ledgers().at("heat").relative_error(), 1e-8);
  EXPECT_FALSE(world.ledgers().contains("smoke"));
  EXPECT_EQ(world.smoke(), nullptr);
}

std::uint64_t hash_after(int frames, int threads) {
  const ThreadLimit limit(threads);
  World world(burning_world());
  for (int n = 0; n < frames; ++n) world.step(1.0 / 24);
  return world.state_hash();
}

TEST(World, HasTheSameStateAtOneAndTwoThreads) {
  EXPECT_EQ(hash_after(12, 1), hash_after(12, 2));
}

TEST(World, ContinuesBitForBitFromItsState) {
  World whole(burning_world()), first(burning_world()), second(burning_world());
  for (int n = 0; n < 24; ++n) whole.step(1.0 / 24);
  for (int n = 0; n < 15; ++n) first.step(1.0 / 24);
  test::continue_from(first, second);
  EXPECT_EQ(first.state_hash(), second.state_hash());
  for (int n = 0; n < 9; ++n) second.step(1.0 / 24);
  EXPECT_EQ(whole.state_hash(), second.state_hash());
}

/// A frame that is stopped after each of its substeps, saved and gone on with in another world ends with the bits,
/// and with the counts, of one that was left alone.
TEST(World, ContinuesBitForBitWithinAFrame) {
  WorldParams params = burning_world();
  params.coupling.max_step = 1.0 / 150;
  World whole(params);
  auto parts = std::make_unique<World>(params);
  for (int n = 0; n < 6; ++n) {
    const FrameReport alone = whole.step(1.0 / 24);
    FrameReport report;
    int stops = 0;
    for (report = parts->step(1.0 / 24, [] { return true; }); !report.complete;
         report = parts->step(1.0 / 24, [] { return true; })) {
      ++stops;
      EXPECT_EQ(parts->frame(), n + 1);
      test::MemoryState store;
      parts->visit(store);
      store.saving = false;
      const std::uint64_t hash = parts->state_hash();
      parts = std::make_unique<World>(params);
      parts->visit(store);
      parts->restored();
      ASSERT_EQ(parts->state_hash(), hash);
    }
    EXPECT_EQ(stops, alone.substeps - 1);
    EXPECT_GE(alone.substeps, 7);
    EXPECT_EQ(report.substeps, alone.substeps);
    EXPECT_EQ(report.solves.at("pressure").iterations, alone.solves.at("pressure").iterations);
    ASSERT_EQ(parts->state_hash(), whole.state_hash()) << "frame " << n + 2;
  }
}

TEST(World, BuildsOnlyWhatTheSceneNames) {
  WorldParams cloth;
  cloth.shells.push_back(test::flat_sheet(10, 0.5, 0.5));
  EXPECT_EQ(World(cloth).models(), (std::vector<std::string>{"shell"}));
  WorldParams plume;
  plume.smoke = test::closed_box(8);
  EXPECT_EQ(World(plume).models(), (std::vector<std::string>{"smoke"}));
  WorldParams heated;
  heated.shells.push_back(test::flat_sheet(10, 0.5, 0.5));
  heated.shells[0].moves = false;
  heated.diffusion.emplace();
  EXPECT_EQ(World(heated).models(), (std::vector<std::string>{"diffusion"}));
}

/// Smoke outside the bag, found by flooding the grid from its corner through open faces.
double smoke_outside(const World& world, const fluid::SmokeParams& smoke) {
  const ShellView view = world.shells().front();
  const std::vector<Vec3> still(view.x->size(), Vec3::Zero());
  Raster raster(fluid::smoke_grid(smoke), smoke.sides);
  raster.see({{view.mesh, view.x, &still}}, {});
  const fluid::Grid& g = raster.grid();
  std::vector<std::uint8_t> seen(g.cells(), 0);
  std::queue<Int3> todo;
  const Int3 corner = {0, 0, g.nz - 1};  // above the bag and every floor
  todo.push(corner);
  seen[g.cell(corner[0], corner[1], corner[2])] = 1;
  double outside = 0.0;
  while (!todo.empty()) {
    const Int3 at = todo.front();
    todo.pop();
    outside += world.smoke()->density[g.cell(at[0], at[1], at[2])] * std::pow(g.h, 3);
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        Int3 q = at, face = at;
        q[axis] += step;
        if (step > 0) ++face[axis];
        if (q[axis] < 0 || q[axis] >= g.size(axis) ||
            raster.walls().closed[axis][g.face(axis, face[0], face[1], face[2])])
          continue;
        if (seen[g.cell(q[0], q[1], q[2])]++) continue;
        todo.push(q);
      }
  }
  return outside;
}

/// A bag with a smoking heat source inside.
WorldParams bag_world(fluid::Advection advection) {
  WorldParams world;
  world.smoke = test::closed_box(32);
  world.smoke->scalar_advection = advection;
  world.shells.push_back(test::bag(3, 0.2));
  world.heat_sources.push_back(
      {.center = Vec3(0.5, 0.5, 0.5), .radius = 0.06, .gas_power = 20.0, .gas_smoke = 1e-4, .stop = 1e9});
  world.coupling.max_step = 1.0 / 60;
  return world;
}

/// Runs 500 steps, in which smoke comes into the bag and none may leave it.
void expect_no_leak(const WorldParams& params) {
  World world(params);
  int steps = 0;
  while (steps < 500) steps += world.step(1.0 / 24).substeps;
  const double total = world.ledgers().at("smoke").stocks().at("grid");
  EXPECT_GT(total, 1e-6);
  EXPECT_LT(smoke_outside(world, *params.smoke), 1e-12 * total);
}

TEST(World, CarriedBagLeaksNothing) {
  for (const auto advection : {fluid::Advection::conservative, fluid::Advection::maccormack}) {
    WorldParams params = bag_world(advection);
    params.gravity = Vec3(0, 0, -9.81);
    params.shells[0].pins.push_back(
        {.point = Vec3(0.5, 0.5, 0.5), .radius = 0.5, .velocity = Vec3(0.11, 0.07, 0.05), .stop_time = 2.0});
    params.heat_sources[0].velocity = Vec3(0.11, 0.07, 0.05);
    params.heat_sources[0].stop = 0.5;
    expect_no_leak(params);
  }
}

TEST(World, FreeBagThatFallsAndBucklesLeaksNothing) {
  WorldParams params = bag_world(fluid::Advection::conservative);
  params.gravity = Vec3(0, 0, -3.0);
  params.shells[0].velocity = Vec3(0.2, 0.1, 0.0);
  params.heat_sources[0].stop = 0.3;  // before the bag has fallen so far that the source is outside
  params.obstacles.push_back({.name = "floor", .kind = ObstacleKind::plane, .center = Vec3(0, 0, 0.1)});
  expect_no_leak(params);
}

TEST(World, SimultaneousSolveKeepsTheMomentumOfGasAndSheet) {
  // A periodic box has no walls: what the sheet gains the gas loses.
  fluid::SmokeParams smoke = test::closed_box(24);
  smoke.sides.fill(fluid::Side::periodic);
  const ShellSection section = test::flat_sheet(16, 0.5, 0.47);
  WorldParams params;
  params.shells.push_back(section);
  const World world(params);
  const ShellView view = world.shells().front();
  const std::size_t count = view.x->size();
  const std::vector<Vec3> v(count, Vec3(0.1, -0.2, 1.5));
  Raster raster(fluid::smoke_grid(smoke), smoke.sides);
  const SheetSurface surface{view.mesh, view.x, &v};
  raster.see({surface}, {});
  for (const double areal : {0.01, 0.14, 30.0}) {
    std::vector<double> inverse(count);
    for (std::size_t i = 0; i < count; ++i) inverse[i] = 1.0 / (areal * view.mesh->vertex_area[i]);
    const fluid::MovableWalls movable = movable_walls(raster, {surface}, inverse);
    fluid::PressureParams pressure_params;
    pressure_params.tolerance = 1e-11;
    pressure_params.max_iterations = 500;
    fluid::PressureSolver solver(raster.grid(), smoke.sides, pressure_params);
    fluid::FaceField u = fluid::make_face_field(raster.grid());
    const auto gas_momentum = [&](int axis) {
      // Periodic: the first and the last layer of faces are the same faces.
      double sum = 0.0;
      const fluid::Grid& g = raster.grid();
      for (int k = 0; k < g.nz; ++k)
        for (int j = 0; j < g.ny; ++j)
          for (int i = 0; i < g.nx; ++i) {
            const std::size_t f = g.face(axis, i, j, k);
            if (!raster.walls().closed[axis][f]) sum += u[axis][f];
          }
      return 1.2 * std::pow(g.h, 3) * sum;
    };
    std::vector<double> pressure(raster.grid().cells(), 0.0);
    std::vector<Vec3> impulse;
    const SolveReport solve = solver.project(
        u, pressure, {.density = 1.2, .dt = 0.01, .walls = &raster.walls(), .movable = &movable}, &impulse);
    EXPECT_TRUE(solve.converged) << areal << ": " << solve.residual_after << " after " << solve.iterations;
    Vec3 given = Vec3::Zero();
    for (const Vec3& j : impulse) given += j;
    EXPECT_LT(given.z(), -1e-4);  // the gas resists
    // Float velocities are rounded by 6e-8 each; over 14,000 faces with random signs that is far below 1e-8 of the
    // sum.
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(gas_momentum(axis) + given[axis], 0.0, 1e-8 * std::abs(given.z()));
  }
}

TEST(World, RefusesWhatDoesNotFitTogether) {
  const auto pointer_of = [](const WorldParams& params) -> std::string {
    try {
      World world(params);
    } catch (const Refusal& refusal) {
      return refusal.pointer();
    }
    return "accepted";
  };
  EXPECT_EQ(pointer_of({}), "/shells");
  WorldParams params = burning_world();
  params.diffusion.reset();
  EXPECT_EQ(pointer_of(params), "/burning");
  params = burning_world();
  params.wind.emplace();
  EXPECT_EQ(pointer_of(params), "/wind");
  params = burning_world();
  params.heat.reference_temperature = 200;
  EXPECT_EQ(pointer_of(params), "/heat/reference_temperature");
  params = burning_world();
  params.shells.push_back(params.shells[0]);
  EXPECT_EQ(pointer_of(params), "/shells/1/name");
  params = burning_world();
  params.shells[0].pins[0] = {.vertices = {1000000}};
  EXPECT_EQ(pointer_of(params), "/shells/0/pins/0/vertices");
  params = burning_world();
  params.shells[0].pins[0] = {.point = Vec3(50, 0, 0), .radius = 0.1};
  EXPECT_EQ(pointer_of(params), "/shells/0/pins/0");
  params = burning_world();
  params.smoke->sides[0] = fluid::Side::periodic;
  EXPECT_EQ(pointer_of(params), "/smoke/sides");
  params = burning_world();
  params.shells[0].mesh.kind = MeshKind::file;
  EXPECT_EQ(pointer_of(params), "/shells/0/mesh/file");
}

/// The frame in which triangles fall away still shows the C that the diffusion added, and what burnt away is no
/// longer measured.
TEST(World, ShowsWhatIsLeftWhenTrianglesFallAway) {
  WorldParams params = burning_world();
  params.shells[0].mesh.wrinkle = 0.02;
  World world(params);
  std::size_t triangles = world.shells()[0].mesh->triangle_count();
  int seen = 0;
  for (int n = 0; n < 60 && seen < 3; ++n) {
    world.step(1.0 / 24);
    const ShellView view = world.shells()[0];
    if (view.mesh->triangle_count() == std::exchange(triangles, view.mesh->triangle_count())) continue;
    ++seen;
    float largest = 0.0F, hottest = 0.0F;
    for (const auto& [name, values] : view.values)
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (name == "C") largest = std::max(largest, values[i]);
        if (name == "u" && view.mesh->vertex_area[i] > 0.0) hottest = std::max(hottest, values[i]);
      }
    EXPECT_GT(largest, 0.0F);
    EXPECT_NEAR(world.shell_metrics().begin()->second.at("theta_max"), hottest, 1e-6);
  }
  EXPECT_EQ(seen, 3);
}

TEST(World, TellsOfSheetsThatReachOutOfTheGas) {
  WorldParams params = burning_world();
  EXPECT_TRUE(World(params).warnings().empty());
  params.shells[0].mesh.position.x() += 0.5;
  const std::vector<std::string> found = World(params).warnings();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NE(found[0].find("vertices are outside the box of the gas at the start"), std::string::npos) << found[0];
}

TEST(World, TellsOfSheetsThatPassThroughEachOtherAtTheStart) {
  WorldParams params;
  params.shells = {test::flat_sheet(5, 0.5, 0.3), test::flat_sheet(5, 0.5, 0.4), test::bag(2, 0.2)};
  params.shells[0].name = "low";
  params.shells[1].name = "high";
  params.shells[0].mesh.position.z() = 0.35;
  EXPECT_EQ(World(params).warnings().size(), 2U);
  params.shells[0].mesh.position.z() = 0.29;  // below the bag
  const std::vector<std::string> found = World(params).warnings();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].starts_with("/shells/2: passes through /shells/1 at the start (")) << found[0];
  params.contact.emplace();
  EXPECT_THROW(World{params}, Refusal);
  params.contact->allow_crossings = true;
  EXPECT_EQ(World(params).warnings().size(), 1U);
}

/// A free sheet falls on a held one under a burning one, in gas: none crosses, and all goes on to the same bits
/// from a state.
TEST(World, SheetsThatTouchAreStepsOfOneState) {
  WorldParams params = burning_world();
  params.contact.emplace();
  params.contact->sheets.thickness = 4e-3;
  params.shells.push_back(test::flat_sheet(15, 0.4, 0.26));
  params.shells.push_back(test::flat_sheet(9, 0.4, 0.25));
  params.shells[1].name = "below";
  params.shells[2].name = "held";
  params.shells[2].moves = false;
  World whole(params), first(params), second(params);
  const auto crossings = [](const World& world) {
    std::vector<solid::PosedSheet> posed;
    for (const ShellView& view : world.shells()) posed.push_back({view.mesh, view.x});
    return solid::find_crossings(posed).size();
  };
  for (int n = 0; n < 10; ++n) {
    whole.step(1.0 / 24);
    ASSERT_EQ(crossings(whole), 0U) << "frame " << n;
  }
  for (int n = 0; n < 6; ++n) first.step(1.0 / 24);
  test::continue_from(first, second);
  for (int n = 0; n < 4; ++n) second.step(1.0 / 24);
  EXPECT_EQ(second.state_hash(), whole.state_hash());
  const std::vector<std::string> models = whole.models();
  EXPECT_NE(std::find(models.begin(), models.end(), "contact"), models.end());
  for (const Vec3& x : *whole.shells()[1].x) EXPECT_GT(x.z(), 0.25) << "it lies on the held one";
}

}  // namespace
}  // namespace wick::coupling
