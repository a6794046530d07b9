#include "fluid/pressure.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/parallel.h"
#include "wall_shapes.h"

namespace wick::fluid {
namespace {

struct Projected {
  SolveReport report;
  FaceField velocity;
  std::vector<double> pressure;
};

Projected project(const Grid& grid, const Sides& sides, const Walls* walls, double tolerance,
                  const CellField* expansion = nullptr, int max_iterations = 200) {
  Projected result{.report = {}, .velocity = stirred_velocity(grid), .pressure = {}};
  PressureSolver solver(grid, sides, {.tolerance = tolerance, .max_iterations = max_iterations});
  const ProjectionInput input{.density = 1.2, .dt = 0.01, .walls = walls, .expansion = expansion};
  result.report = solver.project(result.velocity, result.pressure, input);
  return result;
}

/// Velocities are floats of order 1: a difference over h carries a rounding of a few 1e-7/h.
double rounding(const Grid& grid) {
  return 2e-6 / grid.h;
}

TEST(Pressure, EmptyBoxesAreDivergenceFreeForAnySides) {
  const Grid grid{.nx = 12, .ny = 10, .nz = 9, .h = 0.1};
  for (const Sides& sides : {open_top, all_closed, Sides{P, P, P, P, P, P}, Sides{P, P, C, O, O, O}}) {
    const Projected result = project(grid, sides, nullptr, 1e-5);
    EXPECT_TRUE(result.report.converged);
    EXPECT_LT(result.report.residual_after, 1e-12);
    EXPECT_LT(max_divergence(grid, result.velocity, nullptr, nullptr), rounding(grid));
  }
}

TEST(Pressure, MultigridAgreesWithTransforms) {
  for (const Int3 n : {Int3{16, 16, 16}, Int3{13, 21, 7}, Int3{1, 17, 30}, Int3{5, 1, 64}})
    for (const Sides& sides : {open_top, all_closed, Sides{P, P, P, P, P, P}, Sides{P, P, C, O, O, O}}) {
      const Grid grid{.nx = n[0], .ny = n[1], .nz = n[2], .h = 0.1};
      const Walls walls = no_walls(grid);
      const Projected exact = project(grid, sides, nullptr, 1e-5), iterated = project(grid, sides, &walls, 1e-11);
      EXPECT_TRUE(iterated.report.converged) << n[0] << ' ' << n[1] << ' ' << n[2];
      // Closed sides and the flow itself set the scale of p; the tolerance leaves 1e-11 times the condition number.
      double largest = 0.0, difference = 0.0;
      for (std::size_t c = 0; c < grid.cells(); ++c) {
        largest = std::max(largest, std::abs(exact.pressure[c]));
        difference = std::max(difference, std::abs(exact.pressure[c] - iterated.pressure[c]));
      }
      EXPECT_LT(difference, 1e-7 * largest) << n[0] << ' ' << n[1] << ' ' << n[2];
    }
}

TEST(Pressure, ExpansionIsMetInAnOpenBox) {
  const Grid grid = unit_grid(16);
  CellField expansion(grid.cells(), 0.0F);
  expansion[grid.cell(8, 8, 3)] = 5.0F;
  Walls walls = no_walls(grid);
  add_sphere_obstacle(grid, walls, Vec3(0.5, 0.5, 0.6), 0.2);
  for (const Walls* w : {static_cast<const Walls*>(nullptr), static_cast<const Walls*>(&walls)}) {
    const Projected result = project(grid, open_top, w, 1e-9, &expansion);
    EXPECT_LT(max_divergence(grid, result.velocity, w, &expansion), rounding(grid));
  }
}

TEST(Pressure, AClosedBoxThatCannotExpandSaysSo) {
  const Grid grid = unit_grid(8);
  const CellField expansion(grid.cells(), 2.0F);
  const Projected result = project(grid, all_closed, nullptr, 1e-6, &expansion);
  // Wanted: 2/s in a volume of 1 m³. The mean is taken out, what is left is divergence-free.
  EXPECT_NEAR(result.report.rhs_sum, 2.0, 1e-5);
  EXPECT_LT(max_divergence(grid, result.velocity, nullptr, nullptr), rounding(grid));
}

TEST(Pressure, HydrostaticPressureBalancesGravityExactly) {
  // u* = -g dt e_z in a closed box: p = -rho g z + const, linear, exact on the grid.
  const Grid grid = unit_grid(10);
  FaceField velocity = make_face_field(grid);
  for (float& w : velocity[2]) w = -0.0981F;
  std::vector<double> pressure;
  PressureSolver solver(grid, all_closed, {});
  solver.project(velocity, pressure, {.density = 1.2, .dt = 0.01});
  for (int k = 0; k < 10; ++k)
    EXPECT_NEAR(pressure[grid.cell(3, 4, k)], 1.2 * 9.81 * (0.5 - (k + 0.5) * grid.h), 1e-6);
  for (const auto& component : velocity)
    for (const float u : component) EXPECT_NEAR(u, 0.0F, 1e-7F);
}

TEST(Pressure, AWarmStartSavesIterations) {
  const Grid grid = unit_grid(24);
  Walls walls = no_walls(grid);
  add_flat_sheet(grid, walls);
  PressureSolver solver(grid, open_top, {.tolerance = 1e-6});
  const ProjectionInput input{.density = 1.2, .dt = 0.01, .walls = &walls};
  std::vector<double> pressure;
  FaceField velocity = stirred_velocity(grid);
  const SolveReport cold = solver.project(velocity, pressure, input);
  velocity = stirred_velocity(grid);
  const SolveReport warm = solver.project(velocity, pressure, input);
  EXPECT_GT(cold.iterations, 2);
  EXPECT_EQ(warm.iterations, 0);
  EXPECT_LE(warm.residual_before, 1e-6);
}

TEST(Pressure, ReportsTheTrueResidualWhenItMustStopEarly) {
  const Grid grid = unit_grid(24);
  Walls walls = no_walls(grid);
  add_bag(grid, walls);
  const Projected result = project(grid, open_top, &walls, 1e-9, nullptr, 2);
  EXPECT_FALSE(result.report.converged);
  EXPECT_EQ(result.report.iterations, 2);
  EXPECT_GT(result.report.residual_after, 1e-9);
  EXPECT_LT(result.report.residual_after, 0.1);
}

TEST(Pressure, NanIsReportedAndDoesNotHang) {
  const Grid grid = unit_grid(12);
  Walls walls = no_walls(grid);
  add_flat_sheet(grid, walls);
  for (const Walls* w : {static_cast<const Walls*>(nullptr), static_cast<const Walls*>(&walls)})
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
      FaceField velocity = stirred_velocity(grid);
      velocity[0][grid.face(0, 5, 5, 5)] = bad;
      std::vector<double> pressure;
      PressureSolver solver(grid, open_top, {});
      EXPECT_FALSE(solver.project(velocity, pressure, {.density = 1.2, .dt = 0.01, .walls = w}).converged);
    }
}

TEST(Pressure, ABadGuessIsDropped) {
  const Grid grid = unit_grid(12);
  Walls walls = no_walls(grid);
  add_flat_sheet(grid, walls);
  for (const double bad : {1e30, std::numeric_limits<double>::quiet_NaN()}) {
    FaceField velocity = stirred_velocity(grid);
    std::vector<double> pressure(grid.cells(), 0.0);
    pressure[7] = bad;
    PressureSolver solver(grid, open_top, {.tolerance = 1e-6});
    EXPECT_TRUE(solver.project(velocity, pressure, {.density = 1.2, .dt = 0.01, .walls = &walls}).converged);
  }
}

TEST(Pressure, ScalesOverManyDecades) {
  const Grid grid = unit_grid(12);
  Walls walls = no_walls(grid);
  add_tilted_sheet(grid, walls);
  for (const double scale : {1e-30, 1e-10, 1e10, 1e30}) {
    FaceField velocity = stirred_velocity(grid);
    for (auto& component : velocity)
      for (float& u : component) u *= static_cast<float>(scale);
    std::vector<double> pressure;
    PressureSolver solver(grid, open_top, {.tolerance = 1e-6});
    EXPECT_TRUE(solver.project(velocity, pressure, {.density = 1000.0, .dt = 1e-6, .walls = &walls}).converged)
        << scale;
    EXPECT_LT(max_divergence(grid, velocity, &walls, nullptr), 1e-3 * scale / grid.h) << scale;
  }
}

TEST(Pressure, RestIsLeftAlone) {
  const Grid grid = unit_grid(8);
  Walls walls = no_walls(grid);
  add_flat_sheet(grid, walls);
  FaceField velocity = make_face_field(grid);
  std::vector<double> pressure;
  PressureSolver solver(grid, open_top, {});
  const SolveReport report = solver.project(velocity, pressure, {.density = 1.2, .dt = 0.01, .walls = &walls});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.iterations, 0);
  for (const double p : pressure) EXPECT_EQ(p, 0.0);
}

TEST(Pressure, HasTheSameBitsAtAnyThreadCount) {
  const Grid grid{.nx = 40, .ny = 36, .nz = 44, .h = 1.0 / 40};
  Walls walls = no_walls(grid);
  add_rolled_sheet(grid, walls);
  add_sphere_obstacle(grid, walls, Vec3(0.2, 0.2, 0.2), 0.1);
  for (const Sides& sides : {open_top, all_closed, Sides{P, P, C, C, P, P}}) {
    std::vector<Projected> results;
    for (const int threads : {1, 2, 3}) {
      const ThreadLimit limit(threads);
      results.push_back(project(grid, sides, &walls, 1e-6));
    }
    for (const int other : {1, 2}) {
      EXPECT_EQ(results[0].report.iterations, results[other].report.iterations);
      EXPECT_EQ(results[0].pressure, results[other].pressure);
      EXPECT_EQ(results[0].velocity, results[other].velocity);
    }
  }
}

}  // namespace
}  // namespace wick::fluid
