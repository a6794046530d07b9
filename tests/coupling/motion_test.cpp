/// Sheets whose movement is given: the shapes against their closed forms, replay, and driven sheets in the world.
#include "coupling/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/require.h"
#include "coupling/world.h"
#include "diffusion/strain.h"
#include "solid/primitives.h"
#include "tests/support/memory_state.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// Rounding of positions of about 1 m that are computed in a few operations.
constexpr double kRounding = 1e-14;

solid::ShellMesh square(int vertices = 21, Vec2 size = Vec2(1.0, 1.0)) {
  return solid::build_mesh(solid::rectangle(vertices, vertices, size, solid::Lattice::grid));
}

MotionParams motion(MotionKind kind, double amplitude, double wavelength = 0.3) {
  MotionParams p;
  p.kind = kind;
  p.amplitude = amplitude;
  p.wavelength = wavelength;
  return p;
}

TEST(MotionShapes, StretchHasTheSameStrainEverywhere) {
  const solid::ShellMesh mesh = square(11, Vec2(2.0, 0.7));
  for (const double a : {-0.2, 1e-3, 0.05, 0.4}) {
    const std::vector<Vec3> x = motion_at(motion(MotionKind::stretch, a), mesh, 0.0);
    // G00 = ((1 + a)² - 1)/2, all else 0; the rounding of edges of 0.07 m is amplified by their number.
    const double green = a + 0.5 * a * a;
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
      const Mat2 strain = diffusion::green_strain(mesh, x, t);
      EXPECT_NEAR(strain(0, 0), green, 1e-13);
      EXPECT_NEAR(strain(1, 1), 0.0, 1e-13);
      EXPECT_NEAR(diffusion::strain_measure(strain, diffusion::Measure::orthotropic, false), green * green, 1e-13);
    }
  }
}

TEST(MotionShapes, DentAndWaveHaveTheirHeights) {
  const solid::ShellMesh mesh = square();
  const std::vector<Vec3> dent = motion_at(motion(MotionKind::dent, 0.2, 0.15), mesh, 3.0);
  MotionParams flutter = motion(MotionKind::wave, 0.1, 0.4);
  flutter.period = 0.8;
  const double t = 0.3;
  const std::vector<Vec3> wave = motion_at(flutter, mesh, t);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const Vec3& r = mesh.rest[i];
    const double squared = (r - Vec3(0.5, 0.5, 0.0)).squaredNorm();
    EXPECT_NEAR(dent[i].z(), 0.2 * std::exp(-squared / (2.0 * 0.15 * 0.15)), kRounding);
    EXPECT_NEAR(wave[i].z(), 0.1 * r.x() * std::sin(2.0 * M_PI * (r.x() / 0.4 - t / 0.8)), kRounding);
    EXPECT_NEAR((dent[i] - r).head<2>().norm() + (wave[i] - r).head<2>().norm(), 0.0, kRounding);
  }
}

TEST(MotionShapes, StarIsTheSameAfterAQuarterTurn) {
  const int n = 21;
  const solid::ShellMesh mesh = square(n);
  const Vec3 middle(0.5, 0.5, 0.0);
  const std::vector<Vec3> x = motion_at(motion(MotionKind::star, 0.1), mesh, 0.0);
  double along_arm = 0.0, along_axis = 0.0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const Vec3 here = x[j * n + i] - middle, turned = x[i * n + (n - 1 - j)] - middle;
      EXPECT_NEAR((Vec3(-here.y(), here.x(), here.z()) - turned).norm(), 0.0, kRounding);
      const double pull = (here - (mesh.rest[j * n + i] - middle)).head<2>().norm();
      if (i == j) along_arm = std::max(along_arm, pull);
      if (2 * i == n - 1) along_axis = std::max(along_axis, pull);
    }
  // a (|d|/L)² at a corner, |d|² = 1/2; nothing between the arms.
  EXPECT_NEAR(along_arm, 0.05, kRounding);
  EXPECT_NEAR(along_axis, 0.0, kRounding);
}

TEST(MotionShapes, CrumpleIsSeededAndBounded) {
  const solid::ShellMesh mesh = square();
  MotionParams p = motion(MotionKind::crumple, 0.05);
  const std::vector<Vec3> first = motion_at(p, mesh, 0.0), again = motion_at(p, mesh, 5.0);
  p.seed = 2;
  const std::vector<Vec3> other = motion_at(p, mesh, 0.0);
  double highest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    EXPECT_EQ(first[i], again[i]);
    highest = std::max(highest, (first[i] - mesh.rest[i]).norm());
    difference = std::max(difference, (first[i] - other[i]).norm());
  }
  EXPECT_LE(highest, 15.0 / 8.0 * 0.05);  // |P| <= 1 in each of four octaves
  EXPECT_GT(highest, 0.1 * 0.05);
  EXPECT_GT(difference, 0.1 * 0.05);
}

TEST(MotionShapes, AmplitudeGrowsOverTheRamp) {
  const solid::ShellMesh mesh = square(5);
  MotionParams p = motion(MotionKind::dent, 0.2);
  p.ramp = 2.0;
  const std::size_t middle = 12;
  EXPECT_NEAR(motion_at(p, mesh, 0.0)[middle].z(), 0.0, kRounding);
  EXPECT_NEAR(motion_at(p, mesh, 0.5)[middle].z(), 0.05, kRounding);
  EXPECT_NEAR(motion_at(p, mesh, 9.0)[middle].z(), 0.2, kRounding);
}

MotionParams recorded(std::shared_ptr<MotionTrack> track) {
  MotionParams p;
  p.kind = MotionKind::recorded;
  p.file = "given";
  p.track = std::move(track);
  return p;
}

/// The rest shape lifted to each of the heights.
std::shared_ptr<MotionTrack> lifts(const solid::ShellMesh& mesh, const std::vector<double>& time,
                                   const std::vector<double>& height) {
  auto track = std::make_shared<MotionTrack>();
  track->time = time;
  for (const double z : height) {
    track->x.push_back(mesh.rest);
    for (Vec3& x : track->x.back()) x.z() += z;
  }
  return track;
}

TEST(MotionReplay, IsLinearBetweenItsTimesAndStandsStillOutside) {
  const solid::ShellMesh mesh = square(3);
  const MotionParams p = recorded(lifts(mesh, {1.0, 2.0, 4.0}, {0.0, 1.0, 0.0}));
  for (const auto& [t, z] :
       {std::pair{-5.0, 0.0}, {1.0, 0.0}, {1.25, 0.25}, {2.0, 1.0}, {3.0, 0.5}, {4.0, 0.0}, {1e9, 0.0}})
    for (const Vec3& x : motion_at(p, mesh, t)) EXPECT_DOUBLE_EQ(x.z(), z) << t;
}

std::string refused_pointer(const WorldParams& params) {
  try {
    const World world(params);
  } catch (const Refusal& refusal) {
    return refusal.pointer();
  }
  return "none";
}

TEST(MotionReplay, RefusesTheMotionOfAnotherSheet) {
  const solid::ShellMesh mesh = square(3), other = square(4);
  const auto refused = [&](const std::shared_ptr<MotionTrack>& track) {
    try {
      require_motion_fits(recorded(track), mesh, "/shells/0/motion");
    } catch (const Refusal& refusal) {
      EXPECT_EQ(refusal.pointer(), "/shells/0/motion/file");
      return std::string(refusal.what());
    }
    return std::string();
  };
  EXPECT_NE(refused(nullptr).find("missing"), std::string::npos);
  EXPECT_NE(refused(lifts(other, {0.0}, {0.0})).find("16 vertices (this one has 9)"), std::string::npos);
  const std::shared_ptr<MotionTrack> track = lifts(mesh, {0.0}, {0.5});
  track->rest = mesh.rest;
  track->triangles = mesh.triangles;
  EXPECT_EQ(refused(track), "");
  std::swap(track->triangles[0], track->triangles[1]);
  EXPECT_NE(refused(track).find("other triangles"), std::string::npos);
  track->triangles = mesh.triangles;
  track->rest[3].x() += 1e-6;
  EXPECT_NE(refused(track).find("another rest shape (vertex 3"), std::string::npos);
}

/// A sheet held at one side that falls, wet at the other.
WorldParams swinging(int vertices = 13) {
  WorldParams world;
  world.shells.push_back(test::flat_sheet(vertices, 0.5, 0.3));
  world.shells[0].material.young_warp = world.shells[0].material.young_weft = 1e6;
  world.shells[0].pins.push_back({.edge = PinEdge::lower_x});
  world.diffusion = diffusion::make_preset(diffusion::Preset::wetting);
  world.heat_sources.push_back({.center = Vec3(0.7, 0.5, 0.3), .radius = 0.2, .stop = 1e9});
  return world;
}

std::vector<float> shown(const World& world, const std::string& name) {
  const ShellView view = world.shells().front();
  for (const auto& [each, values] : view.values)
    if (each == name) return values;
  return {};
}

TEST(MotionReplay, GivesTheRecordedRunAgain) {
  constexpr double kFrame = 1.0 / 60;
  const WorldParams params = swinging();
  World original(params);
  auto track = std::make_shared<MotionTrack>();
  std::vector<std::vector<float>> u;
  for (int n = 0; n < 20; ++n) {
    const int substeps = n > 0 ? original.step(kFrame).substeps : 1;
    ASSERT_EQ(substeps, 1);
    track->time.push_back(original.time());
    track->x.push_back(*original.shells().front().x);
    u.push_back(shown(original, "u"));
  }
  EXPECT_LT(track->x.back().back().z(), 0.25) << "it does fall";
  EXPECT_GT(*std::max_element(u.back().begin(), u.back().end()), 0.1F);

  WorldParams driven = params;
  driven.shells[0].pins.clear();
  driven.shells[0].motion = recorded(track);
  World replay(driven);
  const std::vector<std::string> models = replay.models();
  EXPECT_EQ(std::count(models.begin(), models.end(), "shell"), 0);
  for (std::size_t n = 0; n < track->x.size(); ++n) {
    if (n > 0) replay.step(kFrame);
    const std::vector<Vec3>& x = *replay.shells().front().x;
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LE((x[i] - track->x[n][i]).norm(), 1e-15 * x[i].norm());
    EXPECT_EQ(shown(replay, "u"), u[n]) << n;
  }
}

/// A sheet across a closed box, moved along its normal; the box is open above and below.
WorldParams piston(MotionKind kind, CouplingScheme scheme = CouplingScheme::simultaneous) {
  WorldParams world;
  world.coupling.scheme = scheme;
  world.gravity.setZero();
  world.smoke = test::closed_box(16);
  world.smoke->sides[4] = world.smoke->sides[5] = fluid::Side::open;
  world.shells.push_back(test::flat_sheet(9, 1.2, 0.4));
  const solid::ShellMesh mesh = square(9, Vec2(1.2, 1.2));
  if (kind == MotionKind::none) return world;
  auto track = std::make_shared<MotionTrack>();
  const World at_rest(world);
  for (const double t : {0.0, 1.0}) {
    track->time.push_back(t);
    track->x.push_back(*at_rest.shells().front().x);
    for (Vec3& x : track->x.back()) x.z() += 0.5 * t;
  }
  world.shells[0].motion = recorded(track);
  return world;
}

/// The gas beside a sheet of 0.14 kg/m2 that is driven at 0.5 m/s takes its velocity, to the tolerance of the
/// pressure solve, and the sheet keeps to its motion: it has no mass that the gas could move.
TEST(MotionInGas, PushesTheGasAndIsNotPushedBack) {
  for (const CouplingScheme scheme : {CouplingScheme::simultaneous, CouplingScheme::partitioned}) {
    WorldParams params = piston(MotionKind::recorded, scheme);
    World world(params);
    for (int n = 0; n < 6; ++n) world.step(1.0 / 48);
    const double height = 0.4 + 0.5 * world.time();
    for (const Vec3& x : *world.shells().front().x) EXPECT_NEAR(x.z(), height, kRounding);
    for (const Vec3& v : *world.shells().front().v) EXPECT_NEAR(v.z(), 0.5, 1e-11);
    const auto& up = world.smoke()->velocity[2];
    const fluid::Grid grid = fluid::smoke_grid(*params.smoke);
    for (const int k : {2, 14}) EXPECT_NEAR(up[grid.face(2, 8, 8, k)], 0.5, 1e-3) << k;
  }
}

TEST(MotionInGas, ContinuesBitForBitFromItsState) {
  WorldParams params = piston(MotionKind::recorded);
  params.shells[0].motion = motion(MotionKind::wave, 0.05, 0.5);
  params.shells[0].motion.period = 0.3;
  params.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  params.burning.emplace();
  params.burning->ignition = 0.05;
  params.burning->rate = 20.0;
  params.heat_sources.push_back({.center = Vec3(0.4, 0.5, 0.4), .radius = 0.2, .rate = 50.0, .stop = 0.5});
  World whole(params), first(params), second(params);
  for (int n = 0; n < 24; ++n) whole.step(1.0 / 24);
  for (int n = 0; n < 15; ++n) first.step(1.0 / 24);
  test::continue_from(first, second);
  for (int n = 0; n < 9; ++n) second.step(1.0 / 24);
  EXPECT_EQ(whole.state_hash(), second.state_hash());
  EXPECT_LT(whole.shell_metrics().at("sheet").at("mass"),
            0.99 * whole.shell_metrics().at("sheet").at("area") * 0.14)
      << "it does burn";
}

/// Char shrinks the rest shape of a computed sheet; of one whose shape is given, neither place nor strain know of
/// it.
TEST(MotionOfBurningSheets, KeepsTheRestShape) {
  WorldParams params = swinging();
  params.shells[0].pins.clear();
  params.shells[0].motion = motion(MotionKind::stretch, 0.01);
  params.burning.emplace();
  params.burning->shrink = 0.5;
  params.burning->ignition = 0.05;
  params.burning->rate = 20.0;
  params.burning->removal = 0.0;
  World world(params);
  const std::vector<Vec3> start = *world.shells().front().x;
  for (int n = 0; n < 30; ++n) world.step(1.0 / 30);
  EXPECT_EQ(*world.shells().front().x, start);
  const std::vector<float> c = shown(world, "C"), charred = shown(world, "char");
  EXPECT_GT(*std::max_element(charred.begin(), charred.end()), 0.5F);
  // S is the same on every triangle, whatever has burnt of it; C is kept in single precision here.
  const float most = *std::max_element(c.begin(), c.end());
  EXPECT_GT(most, 0.0F);
  for (const float each : c) EXPECT_TRUE(each == 0.0F || std::abs(each - most) < 1e-5F * most);
}

TEST(MotionRefusals, NameWhatTheMotionOverrules) {
  const WorldParams plain = [] {
    WorldParams world = swinging(5);
    world.shells[0].pins.clear();
    world.shells[0].motion = motion(MotionKind::dent, 0.01);
    return world;
  }();
  const auto with = [&](const std::function<void(WorldParams&)>& change) {
    WorldParams world = plain;
    change(world);
    return refused_pointer(world);
  };
  EXPECT_EQ(refused_pointer(plain), "none");
  EXPECT_EQ(with([](WorldParams& w) { w.shells[0].pins.push_back({.edge = PinEdge::lower_x}); }), "/shells/0/pins");
  EXPECT_EQ(with([](WorldParams& w) { w.shells[0].moves = false; }), "/shells/0/moves");
  EXPECT_EQ(with([](WorldParams& w) { w.shells[0].velocity.x() = 1.0; }), "/shells/0/velocity");
  EXPECT_EQ(with([](WorldParams& w) { w.shells[0].mesh.wrinkle = 0.1; }), "/shells/0/mesh/wrinkle");
  EXPECT_EQ(with([](WorldParams& w) { w.wind.emplace(); }), "/wind");
  EXPECT_EQ(with([](WorldParams& w) { w.obstacles.emplace_back(); }), "/obstacles");
  const auto beside_a_computed_one = [](WorldParams& w) {
    w.shells.push_back(test::flat_sheet(5, 0.5, 1.0));
    w.shells.back().name = "computed";
    w.wind.emplace();
    w.obstacles.emplace_back();
  };
  EXPECT_EQ(with(beside_a_computed_one), "none");
}

}  // namespace
}  // namespace wick::coupling
