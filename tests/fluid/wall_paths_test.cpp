#include "fluid/wall_paths.h"

#include <gtest/gtest.h>

#include "fluid/advection.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;

/// Stirs what `inside` holds for 500 steps of up to `cells` cells; the largest value that ever got outside.
double leak(const Grid& g, const Sides& sides, const std::function<bool(const Vec3&)>& inside, Advection method,
            double cells) {
  const Walls walls = bag(g, inside);
  CellField q = cell_field(g, [&](const Vec3& x) { return inside(x) ? 1.0 : 0.0; });
  Transport t(g, sides, {});
  for (int step = 0; step < 500; ++step) {
    FaceField u = stirring(g, sides, walls, cells, step);
    join_periodic_faces(g, sides, u);
    t.set_flow(u, walls, g.h);
    CellField* const fields[] = {&q};
    t.carry(fields, method);
  }
  double most = 0.0;
  for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
    if (!inside(g.cell_center(i, j, k))) most = std::max(most, std::abs(double(q[g.cell(i, j, k)])));
  });
  return most;
}

const Grid box = {18, 16, 14, 1.0 / 18, Vec3::Zero()};
bool in_ball(const Vec3& x) {
  return (x - Vec3(0.5, 0.45, 0.4)).norm() < 0.27;
}
bool under_roof(const Vec3& x) {
  return x.z() + 0.4 * x.x() - 0.3 * x.y() < 0.5;
}

// Paths and samples go through open faces only, so not one bit may pass: the limit is exactly zero.
TEST(Walls, ABagOfClosedFacesHoldsItsSmoke) {
  EXPECT_EQ(leak(box, all_sides(Side::closed), in_ball, Advection::semi_lagrangian, 2.5), 0.0);
  EXPECT_EQ(leak(box, all_sides(Side::open), in_ball, Advection::maccormack, 2.5), 0.0);
  EXPECT_EQ(leak(box, all_sides(Side::open), in_ball, Advection::conservative, 0.5), 0.0);
}
TEST(Walls, APlateSplitsTheBox) {
  EXPECT_EQ(leak(box, all_sides(Side::closed), under_roof, Advection::maccormack, 6.0), 0.0);
  EXPECT_EQ(leak(box, all_sides(Side::closed), under_roof, Advection::conservative, 0.5), 0.0);
}

TEST(Walls, ASealedBagKeepsItsAmountInFluxForm) {
  const Walls walls = bag(box, in_ball);
  CellField q = cell_field(box, [](const Vec3& x) { return in_ball(x) ? 1.0 : 0.0; });
  const double before = sum(q);
  Transport t(box, all_sides(Side::open), {});
  for (int step = 0; step < 100; ++step) {
    t.set_flow(stirring(box, all_sides(Side::open), walls, 1.0, step), walls, box.h);
    CellField* const fields[] = {&q};
    EXPECT_EQ(t.carry(fields, Advection::conservative).out[0], 0.0);
  }
  EXPECT_NEAR(sum(q), before, 1e-6 * before);
}

TEST(Walls, PathsStopBeforeTheFirstClosedFace) {
  const Grid g = {8, 4, 4, 1.0, Vec3::Zero()};
  const Sides sides = all_sides(Side::closed);
  const Walls walls = bag(g, [](const Vec3& x) { return x.x() < 5.0; });
  WallMap map(g, sides);
  map.set(walls, 1);
  const WallPaths paths(g, sides, map);
  const WallPoint start = {{1.5F, 1.5F, 1.5F}, {1, 1, 1}, false};
  const WallPoint free = paths.walk(start, {2.0F, 1.0F, 0.0F});
  EXPECT_FALSE(free.clipped);
  EXPECT_EQ(free.cell, (Int3{3, 2, 1}));
  EXPECT_FLOAT_EQ(free.x[0], 3.5F);
  const WallPoint cut = paths.walk(start, {5.25F, 1.5F, 0.0F});
  EXPECT_TRUE(cut.clipped);
  EXPECT_EQ(cut.cell, (Int3{4, 2, 1}));
  EXPECT_FLOAT_EQ(cut.x[0], 5.0F);
  EXPECT_FLOAT_EQ(cut.x[1], 2.5F);
  EXPECT_TRUE(paths.walk(start, {0.0F, 0.0F, -9.0F}).clipped);
}

TEST(Walls, SamplesSeeTheirOwnSideOnly) {
  const Grid g = {8, 4, 4, 1.0, Vec3::Zero()};
  const Sides sides = all_sides(Side::closed);
  Walls walls = bag(g, [](const Vec3& x) { return x.x() < 5.0; });
  WallMap map(g, sides);
  map.set(walls, 1);
  const WallPaths paths(g, sides, map);
  Padded q;
  q.reshape({8, 4, 4}, {1, 1, 1});
  q.assign(cell_field(g, [](const Vec3& x) { return x.x() < 5.0 ? 1.0 : 7.0; }), 1.0F);
  q.fill_ghosts(scalar_ghosts(sides));
  const WallSample left = paths.sample_scalar(q, {{5.0F, 2.2F, 2.0F}, {4, 2, 2}, true});
  EXPECT_EQ(left.value, 1.0F);
  EXPECT_TRUE(left.thinned);
  EXPECT_EQ(paths.sample_scalar(q, {{5.0F, 2.2F, 2.0F}, {5, 2, 2}, true}).value, 7.0F);

  // The face of the wall shows its velocity, 3, to both sides; tangential velocity does not cross it.
  Padded u, v;
  FaceField field =
      face_field(g, [](const Vec3& x) { return Vec3(x.x() == 5.0 ? 3.0 : 0.0, x.x() < 5.0 ? 1.0 : 2.0, 0); });
  u.reshape({9, 4, 4}, {0, 1, 1});
  u.assign(field[0], 1.0F);
  u.fill_ghosts(velocity_ghosts(sides, 0, {}, 1.0));
  v.reshape({8, 5, 4}, {1, 0, 1});
  v.assign(field[1], 1.0F);
  v.fill_ghosts(velocity_ghosts(sides, 1, {}, 1.0));
  EXPECT_FLOAT_EQ(paths.sample_velocity(u, 0, {{4.75F, 1.5F, 1.5F}, {4, 1, 1}, false}).value, 2.25F);
  EXPECT_FLOAT_EQ(paths.sample_velocity(u, 0, {{5.25F, 1.5F, 1.5F}, {5, 1, 1}, false}).value, 2.25F);
  EXPECT_FLOAT_EQ(paths.sample_velocity(v, 1, {{4.9F, 1.5F, 1.5F}, {4, 1, 1}, false}).value, 1.0F);
  EXPECT_FLOAT_EQ(paths.sample_velocity(v, 1, {{5.1F, 1.5F, 1.5F}, {5, 1, 1}, false}).value, 2.0F);
}

TEST(Walls, FarFromWallsBothPathsAgree) {
  // One closed face in a corner: everywhere else the careful path must give what the fast one gives.
  const Grid g = {14, 12, 10, 1.0 / 14, Vec3::Zero()};
  for (const Side side : {Side::closed, Side::open, Side::periodic}) {
    const Sides sides = all_sides(side);
    Walls one_face = bag(g, [](const Vec3&) { return false; });
    one_face.closed[0][g.face(0, 7, 6, 5)] = 1;
    FaceField u = stirring(g, sides, one_face, 0.9, 3);
    join_periodic_faces(g, sides, u);
    const Walls none;
    for (const auto method : {Advection::semi_lagrangian, Advection::maccormack}) {
      CellField fast = cell_field(g, [](const Vec3& x) { return std::sin(20 * x.x() + 7 * x.y() - 9 * x.z()); });
      CellField careful = fast;
      FaceField fast_u = u, careful_u = u;
      Transport t(g, sides, {});
      CellField* const a[] = {&fast};
      CellField* const b[] = {&careful};
      t.set_flow(u, none, g.h);
      t.carry(a, method), t.carry(fast_u, method);
      t.set_flow(u, one_face, g.h);
      t.carry(b, method), t.carry(careful_u, method);
      for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
        // Within two cells of the face the wall is seen; beyond, only the rounding of positions differs.
        if (std::abs(i - 6.5) <= 3 && std::abs(j - 6) <= 2 && std::abs(k - 5) <= 2) return;
        ASSERT_NEAR(fast[g.cell(i, j, k)], careful[g.cell(i, j, k)], 2e-5)
            << int(side) << int(method) << " " << i << j << k;
        ASSERT_NEAR(fast_u[0][g.face(0, i, j, k)], careful_u[0][g.face(0, i, j, k)], 2e-5)
            << int(side) << " " << i << " " << j << " " << k;
      });
    }
  }
}

}  // namespace
}  // namespace wick::fluid
