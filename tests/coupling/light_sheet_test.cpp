/// The simultaneous solve from sheets a thousand times lighter than the gas of a layer of cells to sheets a
/// thousand times heavier: iterations against those of the same sheet held fixed, and what is left of the
/// divergence.
#include <gtest/gtest.h>

#include "tests/coupling/hung_sheets.h"

namespace wick::coupling {
namespace {

using test::HungSheet;
using test::SheetShape;

struct Case {
  SheetShape shape;
  int cells;
};

class LightSheets : public testing::TestWithParam<Case> {};

SolveReport solve(const HungSheet& sheet, int cells, const fluid::MovableWalls* movable) {
  const fluid::Grid grid = fluid::unit_grid(cells);
  fluid::FaceField velocity = fluid::stirred_velocity(grid);
  std::vector<double> pressure;
  fluid::PressureSolver solver(grid, fluid::open_top, {.tolerance = 1e-6, .max_iterations = 400});
  return solver.project(velocity, pressure,
                        {.density = 1.2, .dt = 0.01, .walls = &sheet.raster.walls(), .movable = movable});
}

/// `edge`: of triangles, in cells.
void expect_few_iterations(const Case& sheet_case, double edge, const std::vector<double>& ratios) {
  const auto [shape, cells] = sheet_case;
  HungSheet sheet(shape, cells, static_cast<int>(cells * 0.6 / edge) + 1, 1.0);
  const int fixed = solve(sheet, cells, nullptr).iterations;
  for (const double ratio : ratios) {
    sheet.set_mass(ratio * 1.2 / cells);
    const SolveReport report = solve(sheet, cells, &sheet.movable);
    testing::Test::RecordProperty("iterations_at_" + std::to_string(ratio), report.iterations);
    EXPECT_TRUE(report.converged) << ratio;
    EXPECT_LE(report.iterations, 1.5 * fixed) << "mass ratio " << ratio;
  }
}

TEST_P(LightSheets, TakeAtMostOneAndAHalfTimesTheIterationsOfAFixedSheet) {
  expect_few_iterations(GetParam(), 1.0, {1e-2, 1e-1, 1.0, 10.0, 1e3});
}

/// A thousandth of the gas's mass is lighter than any cloth in air. Where the mesh is finer than the grid each face
/// has masses of its own, and the sheet is all short cuts; where it is coarser, one mass ties many faces together.
TEST(LongLightSheets, TakeAsFewOnAnyMeshFromAThousandthToAThousandTimesTheMassOfTheGas) {
  for (const SheetShape shape : {SheetShape::flat, SheetShape::tilted, SheetShape::wrinkled, SheetShape::folded})
    for (const int cells : {64, 128})
      for (const double edge : {0.5, 1.0, 2.0}) {
        SCOPED_TRACE(test::sheet_shape_names[int(shape)] + std::string("_") + std::to_string(cells) + " edge " +
                     std::to_string(edge));
        expect_few_iterations({shape, cells}, edge, {1e-3, 3e-3, 1e-2, 3e-2, 0.1, 1.0, 10.0, 1e3});
      }
}

INSTANTIATE_TEST_SUITE_P(Shapes, LightSheets,
                         testing::Values(Case{SheetShape::flat, 64}, Case{SheetShape::tilted, 64},
                                         Case{SheetShape::wrinkled, 64}, Case{SheetShape::folded, 64},
                                         Case{SheetShape::flat, 128}, Case{SheetShape::tilted, 128},
                                         Case{SheetShape::wrinkled, 128}, Case{SheetShape::folded, 128}),
                         [](const testing::TestParamInfo<Case>& sheet) {
                           return test::sheet_shape_names[int(sheet.param.shape)] + std::string("_") +
                                  std::to_string(sheet.param.cells);
                         });

double rms_divergence(const fluid::Grid& grid, const fluid::FaceField& u, const fluid::Walls& walls) {
  double sum = 0.0;
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        if (walls.solid[grid.cell(i, j, k)]) continue;
        const double out = double(u[0][grid.face(0, i + 1, j, k)]) - u[0][grid.face(0, i, j, k)] +
                           u[1][grid.face(1, i, j + 1, k)] - u[1][grid.face(1, i, j, k)] +
                           u[2][grid.face(2, i, j, k + 1)] - u[2][grid.face(2, i, j, k)];
        sum += out * out / (grid.h * grid.h);
      }
  return std::sqrt(sum / static_cast<double>(grid.cells()));
}

TEST(SheetsAndObstacles, LeaveADivergenceOfTheToleranceOrOfFloatVelocities) {
  const int cells = 48;
  const fluid::Grid grid = fluid::unit_grid(cells);
  for (const double ratio : {1e-2, 10.0}) {
    const HungSheet sheet(SheetShape::tilted, cells, 30, ratio * 1.2 / cells);
    fluid::Walls walls = sheet.raster.walls();
    fluid::add_sphere_obstacle(grid, walls, Vec3(0.5, 0.5, 0.2), 0.12);
    for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
      fluid::FaceField u = fluid::stirred_velocity(grid);
      std::vector<double> pressure;
      fluid::PressureSolver solver(grid, fluid::open_top, {.tolerance = tolerance, .max_iterations = 100});
      fluid::ProjectionInput input{.density = 1.2, .dt = 0.01, .walls = &walls, .movable = &sheet.movable};
      fluid::FaceField walled = u;
      for (int a = 0; a < 3; ++a) fluid::move_with_walls(walls, a, walled[a]);
      for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
          walled[0][grid.face(0, 0, i, j)] = walled[0][grid.face(0, cells, i, j)] = 0.0F;
          walled[1][grid.face(1, i, 0, j)] = walled[1][grid.face(1, i, cells, j)] = 0.0F;
          walled[2][grid.face(2, i, j, 0)] = 0.0F;
        }
      const double before = rms_divergence(grid, walled, walls);
      const SolveReport report = solver.project(u, pressure, input);
      ASSERT_TRUE(report.converged);
      // Each of six velocities below 1.3 m/s is rounded once in the projection: sqrt(6) 2⁻²⁴ 1.3/h at most.
      const double floor = std::sqrt(6.0) * 6e-8 * 1.3 / grid.h;
      EXPECT_LE(rms_divergence(grid, u, walls), report.residual_after * before * 1.01 + floor) << tolerance;
    }
  }
}

}  // namespace
}  // namespace wick::coupling
