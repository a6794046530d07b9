#include <gtest/gtest.h>

#include "fluid/pressure.h"
#include "wall_shapes.h"

namespace wick::fluid {
namespace {

struct Shape {
  const char* name;
  void (*add)(const Grid&, Walls&);
};
const std::array<Shape, 6> shapes = {{
    {"sphere", [](const Grid& g, Walls& w) { add_sphere_obstacle(g, w, Vec3(0.5, 0.5, 0.3), 0.15); }},
    {"flat", add_flat_sheet},
    {"tilted", add_tilted_sheet},
    {"wrinkled", add_wrinkled_sheet},
    {"rolled", add_rolled_sheet},
    {"bag", [](const Grid& g, Walls& w) { add_bag(g, w); }},
}};

SolveReport run(const Grid& grid, const Sides& sides, const Walls& walls, double tolerance, FaceField& velocity,
                std::vector<double>& pressure) {
  PressureSolver solver(grid, sides, {.tolerance = tolerance});
  return solver.project(velocity, pressure, {.density = 1.2, .dt = 0.01, .walls = &walls});
}

TEST(PressureWalls, FlowIsDivergenceFreeAroundEveryShape) {
  const Grid grid{.nx = 33, .ny = 30, .nz = 31, .h = 1.0 / 32};
  for (const Shape& shape : shapes)
    for (const Sides& sides : {open_top, all_closed, Sides{P, P, P, P, P, P}, Sides{O, O, P, P, C, O}}) {
      Walls walls = no_walls(grid);
      shape.add(grid, walls);
      FaceField velocity = stirred_velocity(grid);
      std::vector<double> pressure;
      const SolveReport report = run(grid, sides, walls, 1e-9, velocity, pressure);
      EXPECT_TRUE(report.converged) << shape.name;
      // Float velocities of order 1: rounding of a few 1e-7/h.
      EXPECT_LT(max_divergence(grid, velocity, &walls, nullptr), 2e-6 / grid.h) << shape.name;
      for (int a = 0; a < 3; ++a)
        for (std::size_t f = 0; f < grid.faces(a); ++f)
          EXPECT_TRUE(walls.closed[a][f] == 0 || velocity[a][f] == 0.0F);
    }
}

TEST(PressureWalls, IterationsDoNotGrowWithResolution) {
  for (const Shape& shape : shapes) {
    int coarse = 0;
    for (const int n : {64, 128}) {
      const Grid grid = unit_grid(n);
      Walls walls = no_walls(grid);
      shape.add(grid, walls);
      FaceField velocity = stirred_velocity(grid);
      std::vector<double> pressure;
      const SolveReport report = run(grid, open_top, walls, 1e-6, velocity, pressure);
      EXPECT_TRUE(report.converged) << shape.name;
      EXPECT_LE(report.iterations, 10) << shape.name << ' ' << n;
      EXPECT_TRUE(n == 64 || report.iterations <= coarse + 1) << shape.name;
      coarse = report.iterations;
    }
  }
}

TEST(PressureWalls, ThinAndLongBoxesWithWallsConverge) {
  for (const Int3 n :
       {Int3{1, 30, 40}, Int3{40, 1, 1}, Int3{4, 4, 256}, Int3{256, 4, 4}, Int3{63, 2, 5}, Int3{1, 1, 1}})
    for (const Sides& sides : {open_top, all_closed, Sides{P, P, P, P, P, P}}) {
      const Grid grid{.nx = n[0], .ny = n[1], .nz = n[2], .h = 1.0 / 32};
      Walls walls = no_walls(grid);
      // One face in eleven is closed: dead ends, channels and a few sealed pockets.
      for (int a = 0; a < 3; ++a)
        for (std::size_t f = 0; f < grid.faces(a); ++f) walls.closed[a][f] = hash_index(a, f) % 11 == 0;
      FaceField velocity = stirred_velocity(grid);
      std::vector<double> pressure;
      const SolveReport report = run(grid, sides, walls, 1e-6, velocity, pressure);
      EXPECT_TRUE(report.converged) << n[0] << ' ' << n[1] << ' ' << n[2];
      EXPECT_LE(report.iterations, 60);
    }
}

TEST(PressureWalls, ARandomMazeConverges) {
  const Grid grid = unit_grid(24);
  for (const int odds : {2, 3, 5}) {
    Walls walls = no_walls(grid);
    for (int a = 0; a < 3; ++a)
      for (std::size_t f = 0; f < grid.faces(a); ++f) walls.closed[a][f] = hash_index(a + 9, f) % odds == 0;
    FaceField velocity = stirred_velocity(grid);
    std::vector<double> pressure;
    const SolveReport report = run(grid, open_top, walls, 1e-6, velocity, pressure);
    EXPECT_TRUE(report.converged) << odds;
    EXPECT_LE(report.iterations, 60) << odds;
  }
}

TEST(PressureWalls, NothingButWalls) {
  const Grid grid = unit_grid(9);
  Walls walls = no_walls(grid);
  for (int a = 0; a < 3; ++a) walls.closed[a].assign(grid.faces(a), 1);
  FaceField velocity = stirred_velocity(grid);
  std::vector<double> pressure;
  EXPECT_TRUE(run(grid, open_top, walls, 1e-6, velocity, pressure).converged);
  EXPECT_EQ(max_divergence(grid, velocity, &walls, nullptr), 0.0);
  walls.solid.assign(grid.cells(), 1);
  EXPECT_TRUE(run(grid, all_closed, walls, 1e-6, velocity, pressure).converged);
}

TEST(PressureWalls, SealedPocketsKeepMeanZeroAndTheirOwnBalance) {
  const Grid grid = unit_grid(32);
  Walls walls = no_walls(grid);
  add_bag(grid, walls, Vec3(0.3, 0.3, 0.3), 0.15);
  add_bag(grid, walls, Vec3(0.7, 0.7, 0.6), 0.2);
  // The first bag is blown up by its own wall: no divergence-free flow exists in it, elsewhere it does.
  for_inner_faces(grid, [&](int a, std::size_t face, const Vec3& low, const Vec3& high) {
    const Vec3 center(0.3, 0.3, 0.3);
    if (walls.closed[a][face] && (0.5 * (low + high) - center).norm() < 0.2)
      walls.velocity[a][face] = (low - center).norm() < 0.15 ? 0.1F : -0.1F;
  });
  FaceField velocity = stirred_velocity(grid);
  std::vector<double> pressure;
  const SolveReport report = run(grid, open_top, walls, 1e-8, velocity, pressure);
  EXPECT_TRUE(report.converged);
  EXPECT_GT(report.rhs_sum, 1e-3);
  std::array<double, 2> sum{};
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 32; ++i) {
        const Vec3 x = grid.cell_center(i, j, k);
        if ((x - Vec3(0.3, 0.3, 0.3)).norm() <= 0.15) sum[0] += pressure[grid.cell(i, j, k)];
        if ((x - Vec3(0.7, 0.7, 0.6)).norm() <= 0.2) sum[1] += pressure[grid.cell(i, j, k)];
      }
  EXPECT_NEAR(sum[0], 0.0, 1e-8);
  EXPECT_NEAR(sum[1], 0.0, 1e-8);
}

TEST(PressureWalls, MovingWallsPushTheGas) {
  // A plate across an open duct moves up: all gas above moves with it.
  const Grid grid{.nx = 8, .ny = 8, .nz = 24, .h = 0.1};
  Walls walls = no_walls(grid);
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 8; ++i) {
      const std::size_t face = grid.face(2, i, j, 11);
      walls.closed[2][face] = 1;
      walls.velocity[2][face] = 0.25F;
    }
  FaceField velocity = make_face_field(grid);
  std::vector<double> pressure;
  EXPECT_TRUE(run(grid, {C, C, C, C, O, O}, walls, 1e-10, velocity, pressure).converged);
  for (int k = 0; k <= 24; ++k) EXPECT_NEAR(velocity[2][grid.face(2, 3, 5, k)], 0.25F, 1e-6F);
}

TEST(PressureWalls, ARebuiltHierarchyEqualsANewOne) {
  const Grid grid = unit_grid(32);
  PressureSolver reused(grid, open_top, {.tolerance = 1e-6});
  for (const Shape& shape : shapes) {
    Walls walls = no_walls(grid);
    shape.add(grid, walls);
    FaceField velocity = stirred_velocity(grid), fresh_velocity = velocity;
    std::vector<double> pressure, fresh_pressure;
    reused.project(velocity, pressure, {.density = 1.2, .dt = 0.01, .walls = &walls});
    run(grid, open_top, walls, 1e-6, fresh_velocity, fresh_pressure);
    EXPECT_EQ(pressure, fresh_pressure) << shape.name;
  }
}

}  // namespace
}  // namespace wick::fluid
