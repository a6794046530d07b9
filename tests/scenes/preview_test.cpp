/// Obstacles in previews: every shape is where its distance says, hides what is behind it, and is hidden.
#include "scenes/preview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solid/primitives.h"

namespace wick::scenes {
namespace {

/// A camera at 2 m from the origin that looks along +y.
PreviewParams camera() {
  PreviewParams p;
  p.size = {60, 60};
  p.from = Vec3(0, -2, 0);
  p.at = Vec3::Zero();
  p.view_angle = 40;
  return p;
}

Picture draw(const std::vector<Obstacle>& obstacles, const std::vector<coupling::ShellView>& shells = {}) {
  return draw_preview(camera(), shells, {}, obstacles, nullptr, nullptr);
}

Obstacle body(decltype(Obstacle::shape) shape) {
  Obstacle obstacle;
  obstacle.shape = std::move(shape);
  return obstacle;
}

/// Pixels that differ from the picture without obstacles, as a bitmap.
std::vector<bool> covered(const Picture& with, const Picture& without) {
  std::vector<bool> covered;
  for (std::size_t n = 0; n < with.rgb.size(); n += 3)
    covered.push_back(!std::equal(&with.rgb[n], &with.rgb[n] + 3, &without.rgb[n]));
  return covered;
}
std::vector<bool> covered(const Obstacle& obstacle) {
  return covered(draw({obstacle}), draw({}));
}
long count(const std::vector<bool>& bits) {
  return std::count(bits.begin(), bits.end(), true);
}

/// Distances of a ball at the nodes of a grid, as an obstacle from a mesh has them.
SampledShape sampled_ball(double radius) {
  SampledShape shape{.origin = Vec3::Constant(-0.6), .spacing = 0.04, .nodes = {31, 31, 31}, .distance = {}};
  for (int k = 0; k < 31; ++k)
    for (int j = 0; j < 31; ++j)
      for (int i = 0; i < 31; ++i)
        shape.distance.push_back(static_cast<float>((shape.origin + 0.04 * Vec3(i, j, k)).norm() - radius));
  return shape;
}

/// The byte of a linear shade below 0.8: the sRGB curve.
int byte_of(double v) {
  return static_cast<int>(
      std::lround(255.0 * (v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055)));
}

TEST(Preview, EvenSmokeDimsByTheLawOfBeerAndLambert) {
  // A box of 1 m, 64 cells deep, in the middle of the picture; one optical depth along the way through it, and half
  // of one upwards from its middle.
  fluid::SmokeParams params;
  params.resolution = {64, 64, 64};
  params.width = 1.0;
  params.lower = Vec3::Constant(-0.5);
  fluid::SmokeState gas = fluid::make_smoke_state(params);
  const PreviewParams p = camera();
  const double density = 1.0 / p.smoke_extinction;
  for (const bool block : {false, true}) {
    // Filled all the way, or in a block of whose surroundings rays leap over.
    std::fill(gas.density.begin(), gas.density.end(), 0.0F);
    const fluid::Grid g = fluid::smoke_grid(params);
    const int first = block ? 16 : 0;
    for (int k = 0; k < 64; ++k)
      for (int j = first; j < 64 - first; ++j)
        for (int i = 0; i < 64; ++i) gas.density[g.cell(i, j, k)] = static_cast<float>(density);
    const Picture seen = draw_preview(p, {}, {}, {}, &gas, &params), empty = draw({});
    const std::size_t middle = 3 * (std::size_t(30) * 60 + 30);
    const double length = block ? 0.5 : 1.0, clear = std::exp(-length), light = 0.35 + 0.65 * std::exp(-0.25);
    const Vec3 smoke(0.75, 0.73, 0.70), top(0.30, 0.34, 0.40), bottom(0.62, 0.62, 0.60);
    for (int c = 0; c < 3; ++c) {
      const double sky = 0.5 * (top[c] + bottom[c]);
      EXPECT_NEAR(empty.rgb[middle + c], byte_of(sky), 1);
      EXPECT_NEAR(seen.rgb[middle + c], byte_of(clear * sky + (1.0 - clear) * light * smoke[c]), 2) << block;
    }
  }
}

TEST(Preview, DrawsEveryShapeOfObstacle) {
  // A ball of 0.4 m at 2 m is seen under an angle whose tangent is 0.4 / sqrt(4 - 0.16), with 82.4 pixels a unit.
  const double radius = 82.4 * 0.4 / std::sqrt(4 - 0.16);
  const std::vector<bool> ball = covered(body(SphereShape{Vec3::Zero(), 0.4}));
  EXPECT_NEAR(count(ball), M_PI * radius * radius, 25) << "half a pixel around the rim is 27 pixels";
  // Met within 0.3 pixels, and between nodes 4 cm apart known to 0.5 mm: half a pixel at the rim.
  EXPECT_NEAR(count(covered(body(sampled_ball(0.4)))), M_PI * radius * radius, 55);
  // The front of a box of 0.6 m is 1.7 m away.
  const double side = 82.4 * 0.6 / 1.7;
  const std::vector<bool> box = covered(body(BoxShape{Vec3::Constant(-0.3), Vec3::Constant(0.3)}));
  EXPECT_NEAR(count(box), side * side, 2 * side);
  // A floor fills the picture from the horizon down.
  const std::vector<bool> floor = covered(body(PlaneShape{Vec3(0, 0, -0.3), Vec3::UnitZ()}));
  EXPECT_NEAR(count(floor), 30 * 60, 120);
  EXPECT_TRUE(floor[59 * 60 + 30]);
  EXPECT_FALSE(floor[20 * 60 + 30]);
}

TEST(Preview, DrawsObstaclesWhereTheyHaveMoved) {
  Obstacle ball = body(SphereShape{Vec3::Zero(), 0.3});
  ball.pose.shift = Vec3(0.5, 0, 0);
  const std::vector<bool> seen = covered(ball);
  EXPECT_FALSE(seen[30 * 60 + 30]);
  EXPECT_TRUE(seen[30 * 60 + 30 + 20]);
}

TEST(Preview, LeavesOutWhatHoldsTheEye) {
  EXPECT_EQ(count(covered(body(SphereShape{Vec3(0, -2, 0), 0.5}))), 0);
  EXPECT_EQ(count(covered(body(PlaneShape{Vec3(0, 0, 1), Vec3::UnitZ()}))), 0);
}

TEST(Preview, SheetsAndObstaclesHideEachOther) {
  const solid::ShellMesh mesh = solid::build_mesh(solid::rectangle(5, 5, Vec2(1.0, 1.0)));
  std::vector<Vec3> x, still(mesh.vertex_count(), Vec3::Zero());
  for (const Vec3& rest : mesh.rest) x.emplace_back(rest.x() - 0.5, 0.0, rest.y() - 0.5);
  const coupling::ShellView sheet{"sheet", &mesh, &x, &still, {}, &mesh};
  const Obstacle before = body(SphereShape{Vec3(0, -0.5, 0), 0.2});
  const Obstacle behind = body(SphereShape{Vec3(0, 0.5, 0), 0.2});
  const Picture alone = draw({}, {sheet});
  EXPECT_GT(count(covered(draw({before}, {sheet}), alone)), 100);
  EXPECT_EQ(count(covered(draw({behind}, {sheet}), alone)), 0);
  const Picture both = draw({before, behind}, {sheet});
  EXPECT_EQ(both.rgb, draw({behind, before}, {sheet}).rgb) << "whatever their order";
}

}  // namespace
}  // namespace wick::scenes
