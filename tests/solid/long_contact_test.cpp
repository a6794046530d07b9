/// Cloth that falls, folds and is drawn through a ring for 500 frames: no crossing in any of them.
#include <gtest/gtest.h>

#include "tests/solid/sheet_group.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0;

/// Runs and judges every frame.
void run_without_crossings(Group& group, int frames) {
  for (int n = 0; n < frames; ++n) {
    group.step(kFrame);
    ASSERT_EQ(group.crossings(), 0U) << "frame " << n;
    ASSERT_EQ(group.contact->report().impossible, 0U) << "frame " << n;
  }
  ASSERT_TRUE(group.finite());
}

Sheet& falling_cloth(Group& group, int vertices, double width, const Vec3& middle,
                     const std::vector<Obstacle>& on) {
  const double spacing = width / (vertices - 1);
  const Vec3 half(0.5 * width, 0.5 * width * std::sqrt(0.75), 0.0);
  Sheet& sheet =
      group.add(moved(equilateral(vertices, vertices, spacing), Mat3::Identity(), middle - half), cotton());
  sheet.gravity = Vec3(0, 0, -9.81);
  sheet.obstacles = on;
  return sheet;
}

const Obstacle kFloor{"floor", PlaneShape{Vec3(0, 0, -0.5), Vec3::UnitZ()}, 0.5};

double lowest(const Sheet& sheet) {
  double z = INFINITY;
  for (const Vec3& x : sheet.state.x) z = std::min(z, x.z());
  return z;
}

TEST(LongContact, ClothOnABall) {
  Group group;
  falling_cloth(group, 100, 1.0, Vec3(0, 0, 0.02), {{"ball", SphereShape{Vec3(0, 0, -0.25), 0.25}, 0.3}, kFloor});
  run_without_crossings(group, 500);
  for (const Vec3& v : group.sheets[0]->state.v) EXPECT_LT(v.norm(), 1.0);
  EXPECT_LT(lowest(*group.sheets[0]), -0.3);
}

TEST(LongContact, ClothOnAKnifeEdge) {
  Group group;
  falling_cloth(group, 100, 1.0, Vec3(0.03, 0, 0.02),
                {{"knife", BoxShape{Vec3(-0.002, -1, -0.5), Vec3(0.002, 1, 0)}, 0.3}, kFloor});
  run_without_crossings(group, 500);
  EXPECT_LT(lowest(*group.sheets[0]), -0.3);
}

/// Two sheets on a floor, one on the other, whose ends are folded over to the other side together and let go.
TEST(LongContact, TwoSheetsFoldedOverEachOther) {
  constexpr double kWidth = 0.7, kRadius = 0.3;
  Group group;
  std::vector<std::vector<Vec3>> from;
  for (int k = 0; k < 2; ++k) {
    Sheet& sheet = falling_cloth(group, 71, kWidth, Vec3(0.02 * k, 0.01 * k, -0.498 + 0.003 * k), {kFloor});
    sheet.pin_where([&](const Vec3& x) { return x.x() > 0.5 * kWidth + 0.02 * k - 0.005; });
    from.push_back(sheet.pins.target);
  }
  for (int n = 1; n <= 500; ++n) {
    const double turn = std::min(n / 120.0, 1.0) * M_PI;
    const Vec3 way = kRadius * Vec3(std::cos(turn) - 1.0, 0.0, std::sin(turn) + 0.02 * turn);
    for (int k = 0; k < 2; ++k) {
      Sheet& sheet = *group.sheets[k];
      for (std::size_t i = 0; i < sheet.pins.target.size(); ++i) sheet.pins.target[i] = from[k][i] + way;
      if (n == 150) sheet.pins = {};
    }
    run_without_crossings(group, 1);
  }
  for (const auto& sheet : group.sheets) EXPECT_LT(std::sqrt(2.0 * energy_of_motion(*sheet) / mass(*sheet)), 0.01);
}

/// A ring, as a distance that is sampled: what a mesh becomes.
Obstacle ring(double radius, double tube, double spacing) {
  SampledShape shape;
  shape.spacing = spacing;
  shape.origin = Vec3(-radius - 3.0 * tube, -radius - 3.0 * tube, -3.0 * tube);
  for (int k = 0; k < 3; ++k) shape.nodes[k] = static_cast<int>(std::ceil(-2.0 * shape.origin[k] / spacing)) + 1;
  for (int k = 0; k < shape.nodes[2]; ++k)
    for (int j = 0; j < shape.nodes[1]; ++j)
      for (int i = 0; i < shape.nodes[0]; ++i) {
        const Vec3 p = shape.origin + spacing * Vec3(i, j, k);
        shape.distance.push_back(static_cast<float>(std::hypot(std::hypot(p.x(), p.y()) - radius, p.z()) - tube));
      }
  return {"ring", shape, 0.1};
}

TEST(LongContact, ClothDrawnThroughARing) {
  Group group;
  group.params.friction = group.params.kinetic_friction = 0.1;
  Sheet& cloth = falling_cloth(group, 80, 0.6, Vec3(0, 0, 0.05), {ring(0.08, 0.02, 0.004)});
  cloth.params.substeps = 60;
  cloth.solver = ShellSolver(cloth.mesh, cloth.params);
  cloth.pin_where([](const Vec3& x) { return x.head<2>().norm() < 0.01; });
  const std::vector<Vec3> from = cloth.pins.target;
  for (int n = 1; n <= 500; ++n) {
    for (std::size_t k = 0; k < from.size(); ++k) cloth.pins.target[k] = from[k] - Vec3(0, 0, 0.1 * n * kFrame);
    run_without_crossings(group, 1);
  }
  for (const Vec3& x : cloth.state.x) EXPECT_LT(x.z(), 0.0) << "all of it is through";
}

}  // namespace
}  // namespace wick::solid
