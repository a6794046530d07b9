#include "fluid/forces.h"

#include <gtest/gtest.h>

#include "fluid/advection.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;
const Walls no_walls;

SmokeParams small_box() {
  SmokeParams p;
  p.resolution = {6, 5, 4};
  p.width = 0.6;
  return p;
}

TEST(Forces, FadingFollowsItsExponentialAndIsBooked) {
  SmokeParams p = small_box();
  p.dissipation = 2.0, p.cooling = 0.5, p.flame_life = 0.25;
  SmokeState s = make_smoke_state(p);
  for (std::size_t i = 0; i < s.density.size(); ++i) {
    s.density[i] = 0.01F * float(i), s.temperature[i] = float(i) - 50.0F, s.flame[i] = 0.5F;
  }
  const SmokeState before = s;
  const Faded faded = fade(s, p, 0.1);
  for (std::size_t i = 0; i < s.density.size(); ++i) {
    ASSERT_FLOAT_EQ(s.density[i], before.density[i] * std::exp(-0.2F));
    ASSERT_FLOAT_EQ(s.temperature[i], before.temperature[i] * std::exp(-0.05F));
    ASSERT_FLOAT_EQ(s.flame[i], 0.5F * std::exp(-0.4F));
  }
  EXPECT_NEAR(total_smoke(before, p) - total_smoke(s, p), faded.smoke, 1e-12 * total_smoke(before, p));
  EXPECT_NEAR(total_heat(before, p) - total_heat(s, p), faded.heat, 1e-9 * std::abs(total_heat(before, p)));
}

TEST(Forces, SourcesArriveInFull) {
  const SmokeParams p = small_box();
  SmokeState s = make_smoke_state(p);
  SmokeSources sources;
  sources.cell = {7, 7, 30};
  sources.smoke = {1e-3, 2e-3, 5e-4};
  sources.heat = {10.0, -3.0, 100.0};
  sources.flame = {0.2, 0.9, 0.4};
  add_sources(s, sources, p);
  EXPECT_NEAR(total_smoke(s, p), 3.5e-3, 1e-9);
  EXPECT_NEAR(total_heat(s, p), 107.0, 1e-4);
  EXPECT_FLOAT_EQ(s.flame[7], 0.9F);
  EXPECT_FLOAT_EQ(s.flame[30], 0.4F);
}

TEST(Forces, HotAirRisesAgainstAnyGravityAndSmokeWeighsItDown) {
  SmokeParams p = small_box();
  p.buoyancy_heat = 0.7, p.buoyancy_smoke = 2.0;
  SmokeState s = make_smoke_state(p);
  std::fill(s.temperature.begin(), s.temperature.end(), 100.0F);
  std::fill(s.density.begin(), s.density.end(), 0.06F);
  const Grid g = smoke_grid(p);
  Padded pull;
  pull.reshape(p.resolution, {1, 1, 1});
  lift(s, p, pull);
  pull.fill_ghosts(scalar_ghosts(all_sides(Side::closed)));
  SmokeSources sources;
  sources.gravity = Vec3(3.0, -2.0, 5.0);
  FaceField body = make_face_field(g, 0.25F);
  sources.body_force = &body;
  add_buoyancy(s.velocity, pull, sources, g, no_walls, 0.1);
  const double up = 0.7 * 100.0 / 393.15 - 2.0 * 0.06 / 1.2;
  for (int a = 0; a < 3; ++a) {
    for (const float u : s.velocity[a]) ASSERT_NEAR(u, 0.1 * (0.25 - sources.gravity[a] * up), 1e-6);
  }
}

/// Velocity that confinement adds to flow `u` in one step of 1 s with eps 1.
FaceField confined(const Grid& g, const Sides& sides, const FaceField& u, const Walls& walls) {
  Transport t(g, sides, {});
  t.set_flow(u, walls, 1.0);
  Confinement c(g, sides);
  FaceField pushed = make_face_field(g);
  c.add(pushed, t.flow(), walls, 1.0, 1.0);
  return pushed;
}

TEST(Forces, ConfinementSpinsUpAVortexAndNothingElse) {
  const Grid g = {32, 32, 1, 1.0 / 32, Vec3::Zero()};
  Sides sides = all_sides(Side::closed);
  sides[4] = sides[5] = Side::periodic;
  const auto swirl = [](const Vec3& x) {
    const Vec3 r = x - Vec3(0.5, 0.5, x.z());
    return Vec3(Vec3(-r.y(), r.x(), 0) * std::exp(-r.squaredNorm() / 0.02));
  };
  const FaceField u = face_field(g, swirl);
  const FaceField push = confined(g, sides, u, no_walls);
  // N points to the core, where ω = 2 e_z: left of it N x ω = (1,0,0) x (0,0,2) = (0,-2,0), along the flow there.
  const int j = 16, i = 13;
  EXPECT_LT(push[1][g.face(1, i, j, 0)], 0.0F);
  EXPECT_LT(u[1][g.face(1, i, j, 0)], 0.0F);
  sides = all_sides(Side::periodic);
  const FaceField still = confined(g, sides, face_field(g, [](const Vec3&) { return Vec3(1, 2, 0); }), no_walls);
  for (const float v : still[0]) ASSERT_NEAR(v, 0.0F, 1e-7F);
  // The size where the vorticity falls toward one side only: eps h |ω|.
  const double r = 3.5 / 32,
               omega = (2 - 2 * (r * r + 0.25 / 1024) / 0.02) * std::exp(-(r * r + 0.25 / 1024) / 0.02);
  EXPECT_NEAR(std::abs(push[1][g.face(1, 12, 16, 0)]), omega / 32, 0.08 * omega / 32);
}

TEST(Forces, ConfinementLeavesCellsNearWallsAlone) {
  const Grid g = {12, 12, 12, 1.0 / 12, Vec3::Zero()};
  const Walls walls = bag(g, [](const Vec3& x) { return x.x() < 0.5; });  // marked near everywhere
  const FaceField push =
      confined(g, all_sides(Side::closed), stirring(g, all_sides(Side::closed), walls, 1.0, 1), walls);
  for (int a = 0; a < 3; ++a) {
    for (const float v : push[a]) ASSERT_EQ(v, 0.0F);
  }
}

}  // namespace
}  // namespace wick::fluid
