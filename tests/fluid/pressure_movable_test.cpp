#include "fluid/pressure_movable.h"

#include <gtest/gtest.h>

#include <numeric>

#include "fluid/pressure.h"
#include "wall_shapes.h"

namespace wick::fluid {
namespace {

constexpr double density = 1.2, dt = 0.01;

/// A horizontal sheet across the whole box above plane k: one mass a face, or one for all (rigid).
struct Piston {
  Walls walls;
  MovableWalls movable;
};
Piston make_piston(const Grid& grid, int k, double mass_per_face, bool rigid, float speed) {
  Piston piston{no_walls(grid), {}};
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const std::size_t face = grid.face(2, i, j, k);
      piston.walls.closed[2][face] = 1;
      piston.walls.velocity[2][face] = speed;
      const int dof = rigid ? 0 : i + grid.nx * j;
      piston.movable.axis.push_back(2);
      piston.movable.face.push_back(static_cast<std::int64_t>(face));
      piston.movable.dof.push_back({dof, dof, dof});
      piston.movable.weight.push_back({0.5, 0.25, 0.25});
    }
  if (rigid)
    piston.movable.inverse_mass = {1.0 / (mass_per_face * grid.nx * grid.ny)};
  else
    piston.movable.inverse_mass.assign(std::size_t(grid.nx) * grid.ny, 1.0 / mass_per_face);
  return piston;
}

TEST(MovableWalls, APistonInAClosedBoxIsStoppedByTheGas) {
  const Grid grid{.nx = 8, .ny = 6, .nz = 16, .h = 0.1};
  for (const bool rigid : {true, false}) {
    const Piston piston = make_piston(grid, 7, 0.02, rigid, 0.5F);
    FaceField velocity = make_face_field(grid);
    std::vector<double> pressure;
    std::vector<Vec3> impulse;
    PressureSolver solver(grid, all_closed, {.tolerance = 1e-12});
    const ProjectionInput input{.density = density, .dt = dt, .walls = &piston.walls, .movable = &piston.movable};
    EXPECT_TRUE(solver.project(velocity, pressure, input, &impulse).converged);
    double flow = 0.0;
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 8; ++i) flow += velocity[2][grid.face(2, i, j, 7)];
    // The gas cannot be compressed, so the net flow of the sheet is nothing; a rigid one stops dead.
    EXPECT_NEAR(flow, 0.0, 1e-6);
    EXPECT_LT(max_divergence(grid, velocity, &piston.walls, nullptr), 1e-5);
    if (rigid) {
      EXPECT_NEAR(impulse[0][2], -0.5 * 0.02 * 48, 1e-8);
    }
  }
}

TEST(MovableWalls, ADuctMovesAsOneBodyAtAnyMassRatio) {
  // Gas of length L at rest, a rigid sheet of mass m moving at 1 m/s: together they go on with
  // m / (m + rho A L), whatever the ratio. The faces of the sheet carry no gas, so that L is 15 cells of 16.
  const Grid grid{.nx = 4, .ny = 4, .nz = 16, .h = 0.1};
  const double gas = density * 0.4 * 0.4 * 1.5;
  for (const double ratio : {1e-3, 1e-1, 1.0, 10.0, 1e3}) {
    const Piston piston = make_piston(grid, 7, ratio * gas / 16, true, 1.0F);
    FaceField velocity = make_face_field(grid);
    std::vector<double> pressure;
    std::vector<Vec3> impulse;
    PressureSolver solver(grid, {C, C, C, C, O, O}, {.tolerance = 1e-12});
    const ProjectionInput input{.density = density, .dt = dt, .walls = &piston.walls, .movable = &piston.movable};
    const SolveReport report = solver.project(velocity, pressure, input, &impulse);
    EXPECT_TRUE(report.converged) << ratio;
    const double together = ratio / (1.0 + ratio);
    for (const int k : {0, 3, 7, 11, 16}) EXPECT_NEAR(velocity[2][grid.face(2, 1, 2, k)], together, 1e-6) << ratio;
    EXPECT_NEAR(impulse[0][2] / (ratio * gas), together - 1.0, 1e-8) << ratio;
  }
}

/// A wrinkled sheet whose faces hang on a coarse square mesh of masses by uneven weights.
MovableWalls hang_on_masses(const Grid& grid, const Walls& walls, double areal_mass, int mesh) {
  MovableWalls movable;
  for (int a = 0; a < 3; ++a) {
    std::size_t face = 0;
    for (int k = 0; k < grid.nz + (a == 2); ++k)
      for (int j = 0; j < grid.ny + (a == 1); ++j)
        for (int i = 0; i < grid.nx + (a == 0); ++i, ++face) {
          if (!walls.closed[a][face]) continue;
          const Vec3 x = grid.face_center(a, i, j, k);
          const int u = std::min(static_cast<int>(x[0] * (mesh - 1)), mesh - 2);
          const int v = std::min(static_cast<int>(x[1] * (mesh - 1)), mesh - 2);
          const double s = hash_unit(a, face), t = (1.0 - s) * hash_unit(a + 3, face);
          movable.axis.push_back(static_cast<std::uint8_t>(a));
          movable.face.push_back(static_cast<std::int64_t>(face));
          movable.dof.push_back({u + mesh * v, u + 1 + mesh * v, u + mesh * (v + 1)});
          movable.weight.push_back({s, t, 1.0 - s - t});
        }
  }
  movable.inverse_mass.assign(std::size_t(mesh) * mesh, mesh * mesh / areal_mass);
  return movable;
}

TEST(MovableWalls, GasAndMassesExchangeMomentumExactly) {
  const Grid grid = unit_grid(24);
  Walls walls = no_walls(grid);
  add_wrinkled_sheet(grid, walls);
  const MovableWalls movable = hang_on_masses(grid, walls, 0.2, 25);
  FaceField velocity = stirred_velocity(grid);
  std::vector<double> pressure;
  std::vector<Vec3> impulse;
  PressureSolver solver(grid, all_closed, {.tolerance = 1e-8});
  const ProjectionInput input{.density = density, .dt = dt, .walls = &walls, .movable = &movable};
  EXPECT_TRUE(solver.project(velocity, pressure, input, &impulse).converged);
  EXPECT_LT(max_divergence(grid, velocity, &walls, nullptr), 2e-6 / grid.h * 10);

  // Along each line of cells the open faces take -dt h² (p_high - p_low); with the closed faces' share, given
  // to the masses, only the pressure on the two ends of the box is left.
  const double h2 = grid.h * grid.h;
  Vec3 gas = Vec3::Zero(), masses = Vec3::Zero(), ends = Vec3::Zero();
  for (const Vec3& one : impulse) masses += one;
  for_inner_faces(grid, [&](int a, std::size_t face, const Vec3& low, const Vec3& high) {
    const auto at = [&](const Vec3& x) {
      return pressure[grid.cell(int(x[0] / grid.h), int(x[1] / grid.h), int(x[2] / grid.h))];
    };
    if (!walls.closed[a][face]) gas[a] -= dt * h2 * (at(high) - at(low));
  });
  const int n = 24;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      ends[0] += dt * h2 * (pressure[grid.cell(0, i, j)] - pressure[grid.cell(n - 1, i, j)]);
      ends[1] += dt * h2 * (pressure[grid.cell(i, 0, j)] - pressure[grid.cell(i, n - 1, j)]);
      ends[2] += dt * h2 * (pressure[grid.cell(i, j, 0)] - pressure[grid.cell(i, j, n - 1)]);
    }
  // Sums of some 1e4 terms in double.
  EXPECT_LT((gas + masses - ends).norm(), 1e-12 * (1.0 + gas.norm() + masses.norm()));
  EXPECT_GT(masses.norm(), 0.0);
}

TEST(MovableWalls, AllMassRatiosConverge) {
  const Grid grid = unit_grid(32);
  Walls walls = no_walls(grid);
  add_wrinkled_sheet(grid, walls);
  // From a sheet 1000 times lighter than a layer of cells of gas to one 1000 times heavier; meshes finer and
  // coarser than the grid. Light and coarse is the hardest: faces between masses follow rigidly.
  for (const int mesh : {9, 49})
    for (const double ratio : {1e-3, 1e-1, 1.0, 1e3}) {
      const MovableWalls movable = hang_on_masses(grid, walls, ratio * density * grid.h, mesh);
      FaceField velocity = stirred_velocity(grid);
      std::vector<double> pressure;
      PressureSolver solver(grid, open_top, {.tolerance = 1e-6, .max_iterations = 1000});
      const ProjectionInput input{.density = density, .dt = dt, .walls = &walls, .movable = &movable};
      const SolveReport report = solver.project(velocity, pressure, input);
      RecordProperty("iterations_" + std::to_string(mesh) + "_" + std::to_string(ratio), report.iterations);
      EXPECT_TRUE(report.converged) << mesh << ' ' << ratio << ' ' << report.iterations;
    }
}

TEST(MovableWalls, TheTermIsSymmetric) {
  const Grid grid = unit_grid(10);
  Walls walls = no_walls(grid);
  add_tilted_sheet(grid, walls);
  const MovableTerm term(grid, open_top, walls, hang_on_masses(grid, walls, 0.05, 7), density);
  const auto noise = [&](int seed) {
    std::vector<double> values;
    for (const MovableTerm::Cell& cell : term.cells()) values.push_back(hash_signed(seed, cell.number));
    return values;
  };
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const auto a = noise(1), b = noise(2);
  std::vector<double> product_a(a.size(), 0.0), product_b = product_a;
  term.add_product(a, 1.0, product_a);
  term.add_product(b, 1.0, product_b);
  EXPECT_NEAR(dot(b, product_a), dot(a, product_b), 1e-12 * std::abs(dot(a, product_a)));
  EXPECT_NEAR(dot(a, product_a), term.quadratic(a), 1e-12 * std::abs(dot(a, product_a)));
  if (!term.light()) {
    EXPECT_LT(dot(a, product_a), 0.0) << "T is at most its faces";
  }
}

}  // namespace
}  // namespace wick::fluid
