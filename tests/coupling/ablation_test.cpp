/// Sheets that burn through: the mesh is cut along the rim of the ash, and what is cut off is booked.
#include <gtest/gtest.h>

#include <set>

#include "core/parallel.h"
#include "coupling/world.h"
#include "tests/support/memory_state.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A sheet hung by its four corners and lit in its middle.
WorldParams lit_in_the_middle(int vertices = 31) {
  WorldParams world;
  world.shells.push_back(test::flat_sheet(vertices, 0.3, 0.3));
  for (const double x : {0.35, 0.65})
    for (const double y : {0.35, 0.65}) world.shells[0].pins.push_back({.point = Vec3(x, y, 0.3), .radius = 0.015});
  world.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  world.diffusion->alpha = 1e-3;
  world.burning.emplace();
  world.heat_sources.push_back({.center = Vec3(0.5, 0.5, 0.3), .radius = 0.03, .stop = 0.5});
  return world;
}

long euler_characteristic(const solid::ShellMesh& mesh) {
  long vertices = 0;
  for (const std::int32_t part : mesh.component) vertices += part >= 0 ? 1 : 0;
  return vertices - static_cast<long>(mesh.edges.size()) + static_cast<long>(mesh.triangle_count());
}

int parts(const solid::ShellMesh& mesh) {
  int last = -1;
  for (const std::int32_t part : mesh.component) last = std::max(last, part);
  return last + 1;
}

/// From a hole to a ring to nothing, in at least 100 cuts, with every gram and joule booked.
TEST(Ablation, ASheetLitInItsMiddleBecomesARingAndFallsApart) {
  World world(lit_in_the_middle());
  int cuts = 0, ring = 0, most_parts = 0;
  std::size_t triangles = world.shells()[0].mesh->triangle_count();
  const double whole = world.ledgers().at("solid").stocks().at("sheet");
  for (int n = 0; n < 600 && triangles > 0; ++n) {
    world.step(1.0 / 60);
    const solid::ShellMesh& mesh = *world.shells()[0].mesh;
    ASSERT_NO_THROW(solid::build_mesh(mesh.rest, mesh.material, mesh.triangles)) << "frame " << n;
    cuts += mesh.triangle_count() != std::exchange(triangles, mesh.triangle_count()) ? 1 : 0;
    ring += parts(mesh) == 1 && euler_characteristic(mesh) == 0 ? 1 : 0;
    most_parts = std::max(most_parts, parts(mesh));
    ASSERT_LT(world.ledgers().at("solid").relative_error(), 1e-10) << "frame " << n;
    ASSERT_LT(world.ledgers().at("heat").relative_error(), 1e-8) << "frame " << n;
  }
  EXPECT_GE(cuts, 100);
  EXPECT_GT(ring, 20);
  EXPECT_GT(most_parts, 1);
  EXPECT_EQ(triangles, 0u) << "all of it burns";
  EXPECT_NEAR(world.ledgers().at("solid").stocks().at("sheet"), 0.0, 1e-12 * whole);
}

/// The rim follows the contour of /burning/removal: nothing is left that has clearly less of its mass.
TEST(Ablation, TheRimLiesOnTheContour) {
  const WorldParams params = lit_in_the_middle();
  World world(params);
  std::size_t looked_at = 0;
  for (int n = 0; n < 150; ++n) {
    world.step(1.0 / 60);
    const ShellView view = world.shells()[0];
    if (view.mesh->triangle_count() == 0) break;
    const std::vector<float>* charred = nullptr;
    for (const auto& [name, values] : view.values)
      if (name == "char") charred = &values;
    ASSERT_NE(charred, nullptr);
    for (const Int3& v : view.mesh->triangles) {
      double most = 0.0;
      for (const int i : v) most = std::max(most, 1.0 - double((*charred)[i]));
      EXPECT_GE(most, params.burning->removal - 1e-6) << "frame " << n;
      ++looked_at;
    }
  }
  EXPECT_GT(looked_at, 10000u);
}

TEST(Ablation, PinsLetGoOfWhatHasBurnt) {
  WorldParams params = lit_in_the_middle(21);
  params.shells[0].pins.resize(1);
  params.heat_sources[0].center = Vec3(0.35, 0.35, 0.3);
  World world(params);
  for (int n = 0; n < 60; ++n) world.step(1.0 / 60);
  const double then = world.shells()[0].v->back().z();
  double lowest_before = INFINITY, lowest = INFINITY;
  for (const Vec3& x : *world.shells()[0].x) lowest_before = std::min(lowest_before, x.z());
  for (int n = 0; n < 60; ++n) world.step(1.0 / 60);
  for (const Vec3& x : *world.shells()[0].x) lowest = std::min(lowest, x.z());
  EXPECT_LT(lowest, lowest_before - 2.0) << "it falls freely; " << then;
}

TEST(Ablation, TheSameBitsAtOneAndTwoThreadsAndAfterARestart) {
  WorldParams params = lit_in_the_middle(21);
  params.contact.emplace();
  params.smoke = test::closed_box(16);
  params.smoke->sides[5] = fluid::Side::open;
  const auto hash_at = [&](int threads) {
    const ThreadLimit limit(threads);
    World world(params);
    for (int n = 0; n < 90; ++n) world.step(1.0 / 60);
    EXPECT_LT(world.shells()[0].mesh->triangle_count(), 780u);
    return world.state_hash();
  };
  const std::uint64_t whole = hash_at(1);
  EXPECT_EQ(hash_at(2), whole);
  World first(params), second(params);
  for (int n = 0; n < 70; ++n) first.step(1.0 / 60);
  test::continue_from(first, second);
  EXPECT_EQ(second.state_hash(), first.state_hash());
  for (int n = 0; n < 20; ++n) second.step(1.0 / 60);
  EXPECT_EQ(second.state_hash(), whole);
}

/// Small pieces fall as embers: with their mass and heat, at the speed at which their drag bears them, until they
/// go out.
TEST(Ablation, SmallPiecesBecomeEmbers) {
  WorldParams params = lit_in_the_middle();
  params.gravity = Vec3::Zero();  // unpinned it stays where it is
  params.shells[0].pins.clear();
  params.burning->ember_size = 0.03;
  params.burning->ember_life = 1.0;
  World world(params);
  std::size_t most = 0;
  std::int64_t last = -1;
  for (int n = 0; n < 600; ++n) {
    world.step(1.0 / 60);
    const EmberView embers = world.embers();
    most = std::max(most, embers.x->size());
    for (const std::int64_t id : *embers.id) last = std::max(last, id);
    ASSERT_LT(world.ledgers().at("solid").relative_error(), 1e-10) << "frame " << n;
    ASSERT_LT(world.ledgers().at("heat").relative_error(), 1e-8) << "frame " << n;
  }
  EXPECT_GT(most, 0u);
  EXPECT_GT(last, 0);
  EXPECT_EQ(world.embers().x->size(), 0u) << "all have gone out";
}

TEST(Ablation, EmbersFallAtTheSpeedThatTheirDragBears) {
  WorldParams params = lit_in_the_middle();
  EmberState embers;
  embers.x = {Vec3(0.5, 0.5, 0.9), Vec3(0.2, 0.5, 0.9)};
  embers.v = {Vec3(3, 0, 0), Vec3(0, 0, -40)};
  embers.mass = {1e-6, 4e-6};
  embers.area = {2e-5, 2e-5};
  embers.heat_capacity = {0.1, 0.4};
  embers.theta = {0.8, 0.8};
  embers.age = {0.0, 0.0};
  embers.id = {0, 1};
  params.burning->ember_life = 10.0;
  double radiated = 0.0;
  for (int n = 0; n < 400; ++n) radiated += step_embers(embers, params, {}, {}, nullptr, 0.01).radiated;
  ASSERT_EQ(embers.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    // m g = 1/2 rho c_d A/2 v^2 with rho = 1.2 kg/m3, c_d = 1.2.
    const double speed = std::sqrt(embers.mass[n] * 9.81 / (0.5 * 1.2 * 1.2 * 0.5 * 2e-5));
    EXPECT_NEAR(embers.v[n].z(), -speed, 1e-3 * speed);
    EXPECT_LT(std::abs(embers.v[n].x()), 1e-3 * speed);
    EXPECT_NEAR(embers.theta[n], 0.8 * std::exp(-params.heat.loss * 4.0), 1e-12);
  }
  EXPECT_NEAR(radiated, 0.5 * 0.8 - embers.total_heat(), 1e-12);
  // Any length of step leaves them slower than they would fall without air.
  const EmberLoss lost = step_embers(embers, params, {}, {}, nullptr, 1e3);
  EXPECT_EQ(embers.size(), 0u);
  EXPECT_NEAR(lost.mass, 5e-6, 1e-18);
}

/// Ash is never taken back, and of what is consumed at least the share that does not burn falls as ash; little more
/// than what is cut off has left.
TEST(Ablation, AshIsWhatDoesNotBurn) {
  for (const double snap : {0.05, 0.3, 0.45})
    for (const bool tube : {false, true}) {
      WorldParams params = lit_in_the_middle(24);
      params.shells[0].pins.clear();
      params.shells[0].moves = false;
      if (tube) {
        params.shells[0].mesh.kind = MeshKind::cylinder;
        params.shells[0].mesh.vertices = {40, 30};
        params.shells[0].mesh.size = Vec2(0.05, 0.2);
        params.shells[0].mesh.position = Vec3(0.5, 0.5, 0.3);
      }
      params.burning->rim_snap = snap;
      params.burning->rate = 6.0;
      params.heat.loss = 0.02;
      params.heat_sources[0].radius = 0.06;
      World world(params);
      const double whole = world.ledgers().at("solid").stocks().at("sheet");
      double fallen = 0.0;
      for (int n = 0; n < 500; ++n) {
        world.step(1.0 / 60);
        const auto& flows = world.ledgers().at("solid").flows();
        const double now = flows.contains("ash") ? -flows.at("ash") : 0.0;
        ASSERT_GE(now, fallen - 1e-12 * whole) << snap << ", frame " << n;
        fallen = now;
      }
      EXPECT_EQ(world.shells()[0].mesh->triangle_count(), 0u) << snap;
      EXPECT_GE(fallen / whole, params.burning->ash) << snap << " " << tube;
      EXPECT_LE(fallen / whole, 1.2 * params.burning->removal) << snap << " " << tube;
    }
}

/// Whole triangles, as sheets with a motion of their own lose them: a subset of those of the start.
TEST(Ablation, WholeTrianglesStayThoseOfTheStart) {
  WorldParams params = lit_in_the_middle(21);
  params.burning->rim = BurntRim::whole;
  World whole(params);
  params.burning->rim = BurntRim::cut;
  params.shells[0].pins.clear();
  params.shells[0].motion.kind = MotionKind::dent;
  params.shells[0].motion.amplitude = 0.005;
  World driven(params);
  for (World* world : {&whole, &driven}) {
    const std::vector<Int3> all = world->shells()[0].mesh->triangles;
    const std::set<Int3> first(all.begin(), all.end());
    for (int n = 0; n < 200; ++n) world->step(1.0 / 60);
    const std::vector<Int3>& left = world->shells()[0].mesh->triangles;
    EXPECT_LT(left.size(), all.size());
    for (const Int3& v : left) EXPECT_TRUE(first.contains(v));
    EXPECT_EQ(world->shells()[0].x->size(), 441u);
    EXPECT_LT(world->ledgers().at("solid").relative_error(), 1e-12);
  }
}

/// Any size of the snapping distance, frame, rate and mesh: sound meshes, closed ledgers.
TEST(Ablation, ExtremesStaySound) {
  const auto run = [](const WorldParams& params, double frame, const std::string& what) {
    World world(params);
    for (int n = 0; n < 40; ++n) {
      world.step(frame);
      for (const ShellView& view : world.shells()) {
        ASSERT_NO_THROW(solid::build_mesh(view.mesh->rest, {}, view.mesh->triangles)) << what << ", frame " << n;
        for (const Vec3& x : *view.x) ASSERT_TRUE(x.allFinite()) << what << ", frame " << n;
      }
      ASSERT_LT(world.ledgers().at("solid").relative_error(), 1e-10) << what << ", frame " << n;
    }
  };
  for (const double snap : {0.05, 0.45}) {
    WorldParams params = lit_in_the_middle(15);
    params.burning->rim_snap = snap;
    run(params, 1.0 / 24, "snap");
  }
  for (const double frame : {1e-3, 0.5}) run(lit_in_the_middle(15), frame, "frame");
  for (const double rate : {0.1, 1e3, 1e6}) {
    WorldParams params = lit_in_the_middle(15);
    params.burning->rate = rate;
    run(params, 1.0 / 24, "rate");
  }
  for (const double removal : {0.09, 0.5, 0.999}) {
    WorldParams params = lit_in_the_middle(15);
    params.burning->removal = removal;
    run(params, 1.0 / 24, "removal");
  }
  WorldParams two = lit_in_the_middle(2);
  two.heat_sources[0].radius = 1.0;
  run(two, 1.0 / 24, "two triangles, lit everywhere at once");
  WorldParams ball;
  ball.shells.push_back(test::bag(3, 0.2));
  ball.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  ball.burning.emplace();
  ball.heat_sources.push_back({.center = Vec3(0.5, 0.5, 0.7), .radius = 0.05, .stop = 0.5});
  run(ball, 1.0 / 24, "a ball");
}

}  // namespace
}  // namespace wick::coupling
