#include "fluid/implicit_diffusion.h"

#include <gtest/gtest.h>

#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;
constexpr double pi = std::numbers::pi;
const Walls no_walls;
DiffusionWork work;

// A discrete cosine is an eigenvector: one implicit step divides it by 1 + 4 c sin²(kh/2), to float rounding.
TEST(ImplicitDiffusion, DampsADiscreteModeByItsFactor) {
  for (const Side side : {Side::closed, Side::periodic}) {
    for (const double number : {0.01, 1.0, 400.0}) {
      const Grid g = {32, 4, 3, 1.0 / 32, Vec3::Zero()};
      const double k = side == Side::closed ? pi : 2 * pi;
      const auto mode = [&](const Vec3& x) { return 3.0 + std::cos(k * x.x()); };
      CellField q = cell_field(g, mode);
      const DiffusionInput input = {.coefficient = number * g.h * g.h, .dt = 1.0, .tolerance = 1e-10};
      const SolveReport report = diffuse(g, all_sides(side), no_walls, input, q, work);
      EXPECT_TRUE(report.converged);
      EXPECT_LE(report.residual_after, 1e-9);
      const double s = std::sin(0.5 * k * g.h), factor = 1.0 / (1.0 + 4.0 * number * s * s);
      for (int i = 0; i < g.nx; ++i) {
        const double expected = 3.0 + factor * std::cos(k * g.cell_center(i, 0, 0).x());
        ASSERT_NEAR(q[g.cell(i, 2, 1)], expected, 1e-6);
      }
    }
  }
}

TEST(ImplicitDiffusion, KeepsTheSumAndCrossesNoWall) {
  const Grid g = {20, 18, 16, 0.05, Vec3::Zero()};
  const auto inside = [](const Vec3& x) { return (x - Vec3(0.5, 0.4, 0.4)).norm() < 0.25; };
  const Walls walls = bag(g, inside);
  CellField q = cell_field(g, [&](const Vec3& x) { return inside(x) ? 1.0 + x.x() : 0.0; });
  const double before = sum(q);
  for (int step = 0; step < 10; ++step)
    diffuse(g, all_sides(Side::open), walls, {.coefficient = 0.1, .dt = 0.1}, q, work);
  EXPECT_NEAR(sum(q), before, 1e-6 * before);
  for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
    if (inside(g.cell_center(i, j, k))) return;
    ASSERT_EQ(q[g.cell(i, j, k)], 0.0F);
  });
}

// Between a side at rest and one that moves, the steady flow is linear: exact on any grid.
TEST(ImplicitDiffusion, DrivesCouetteFlow) {
  const Grid g = {3, 12, 4, 0.1, Vec3::Zero()};
  Sides sides = all_sides(Side::periodic);
  sides[2] = sides[3] = Side::closed;
  SideMotion motion = {.no_slip = true};
  for (Vec3& v : motion.velocity) v = Vec3::Zero();
  motion.velocity[3] = Vec3(2.0, 0, -1.0);
  FaceField u = make_face_field(g);
  for (int step = 0; step < 40; ++step) {
    diffuse(g, sides, motion, no_walls, {.coefficient = 1.0, .dt = 10.0, .tolerance = 1e-9}, u, work);
  }
  for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
    const double share = (j + 0.5) / 12.0;
    ASSERT_NEAR(u[0][g.face(0, i, j, k)], 2.0 * share, 1e-5);
    ASSERT_NEAR(u[2][g.face(2, i, j, k)], -share, 1e-5);
    ASSERT_NEAR(u[1][g.face(1, i, j, k)], 0.0, 1e-6);
  });
}

TEST(ImplicitDiffusion, FreeSlipLeavesUniformFlowAlone) {
  const Grid g = {8, 6, 5, 0.1, Vec3::Zero()};
  Sides sides = all_sides(Side::closed);
  sides[0] = sides[1] = Side::open;
  FaceField u = face_field(g, [](const Vec3&) { return Vec3(1.5, 0, 0); });
  const FaceField before = u;
  EXPECT_EQ(diffuse(g, sides, {}, no_walls, {.coefficient = 3.0, .dt = 1.0}, u, work).iterations, 0);
  EXPECT_EQ(u, before);
}

TEST(ImplicitDiffusion, WallsKeepTheirVelocityAndDragWhatIsBeside) {
  const Grid g = {10, 10, 10, 0.1, Vec3::Zero()};
  Walls walls = bag(g, [](const Vec3& x) { return x.z() < 0.5; });
  FaceField u = make_face_field(g);
  for (std::size_t f = 0; f < u[2].size(); ++f) {
    if (walls.closed[2][f]) u[2][f] = walls.velocity[2][f] = 1.0F;
  }
  diffuse(g, all_sides(Side::closed), {}, walls, {.coefficient = 0.01, .dt = 0.2}, u, work);
  EXPECT_EQ(u[2][g.face(2, 4, 4, 5)], 1.0F);
  EXPECT_GT(u[2][g.face(2, 4, 4, 6)], 0.1F);
  EXPECT_NEAR(u[2][g.face(2, 4, 4, 6)], u[2][g.face(2, 4, 4, 4)], 1e-6);
}

}  // namespace
}  // namespace wick::fluid
