/// The momentum of gas and sheet over whole steps of a world. Transport of velocity conserves no momentum, and
/// sides and obstacles take some: both are booked, and what is left is the exchange of gas and sheet, which must
/// balance.
#include <gtest/gtest.h>

#include "coupling/exchange.h"
#include "coupling/obstacles.h"
#include "coupling/sheet.h"
#include "coupling/world.h"
#include "fluid/advection.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

constexpr double dt = 1.0 / 200;

/// A crumpled sheet that is thrown into still air beside a ball at rest; no gravity.
WorldParams thrown_sheet(CouplingScheme scheme) {
  WorldParams params;
  params.gravity = Vec3::Zero();
  params.smoke = test::closed_box(24);
  params.smoke->pressure = {.tolerance = 1e-11, .max_iterations = 500};
  ShellSection sheet = test::flat_sheet(21, 0.5, 0.35);
  sheet.mesh.rotation = Vec3(15.0, -10.0, 0.0);
  sheet.mesh.position = Vec3(0.25, 0.2, 0.35);
  sheet.mesh.wrinkle = 0.02;
  sheet.velocity = Vec3(0.3, -0.2, 1.0);
  sheet.material.air_drag = 0.0;
  // Heavy enough for the partitioned scheme to bear all of the force of the last step.
  sheet.material.thickness = 2e-3;
  params.shells.push_back(sheet);
  params.obstacles.push_back({.center = Vec3(0.5, 0.5, 0.8), .radius = 0.1});
  params.coupling.scheme = scheme;
  return params;
}

Vec3 momentum_of_sheet(const World& world, const WorldParams& params) {
  const ShellView sheet = world.shells().front();
  const solid::ShellParams& material = params.shells[0].material;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < sheet.v->size(); ++i)
    sum += material.density * material.thickness * sheet.mesh->vertex_area[i] * (*sheet.v)[i];
  return sum;
}

/// Of the gas that can flow: closed faces move with their wall.
Vec3 momentum_of_gas(const fluid::Grid& grid, const fluid::Walls& walls, double density,
                     const fluid::FaceField& velocity) {
  Vec3 sum = Vec3::Zero();
  for (int a = 0; a < 3; ++a)
    for (std::size_t f = 0; f < velocity[a].size(); ++f)
      if (walls.closed[a][f] == 0) sum[a] += velocity[a][f];
  return density * std::pow(grid.h, 3) * sum;
}

/// Impulse of the pressure on the gas from the sides of the box and from solid cells, and on the sheet from the
/// gas.
struct Push {
  Vec3 from_walls = Vec3::Zero(), on_sheet = Vec3::Zero();
};
Push push_of(const Raster& raster, const std::vector<double>& pressure) {
  const fluid::Grid& grid = raster.grid();
  const fluid::Walls& walls = raster.walls();
  Push push;
  for (int a = 0; a < 3; ++a)
    for (int k = 0; k < grid.nz + (a == 2); ++k)
      for (int j = 0; j < grid.ny + (a == 1); ++j)
        for (int i = 0; i < grid.nx + (a == 0); ++i) {
          const Int3 high = {i, j, k};
          Int3 low = high;
          --low[a];
          const auto fluid_pressure = [&](const Int3& at) -> std::optional<double> {
            if (at[a] < 0 || at[a] == grid.size(a)) return {};
            const std::size_t cell = grid.cell(at[0], at[1], at[2]);
            if (walls.solid[cell] != 0) return {};
            return pressure[cell];
          };
          const std::optional<double> below = fluid_pressure(low), above = fluid_pressure(high);
          // Between two cells of gas lies the sheet, or a part of the ball.
          const std::size_t face = grid.face(a, i, j, k);
          if (below && above && walls.closed[a][face] != 0) {
            if (raster.hit_at(a, face) >= 0)
              push.on_sheet[a] += *below - *above;
            else
              push.from_walls[a] += *above - *below;
          }
          if (below && !above) push.from_walls[a] -= *below;
          if (above && !below) push.from_walls[a] += *above;
        }
  const double scale = dt * grid.h * grid.h;
  return {scale * push.from_walls, scale * push.on_sheet};
}

/// The velocity just before the projection of a step without forces.
fluid::FaceField carried(const fluid::SmokeParams& smoke, const Raster& raster, fluid::FaceField velocity) {
  fluid::Transport transport(raster.grid(), smoke.sides, {});
  fluid::impose_walls(raster.grid(), smoke.sides, raster.walls(), velocity);
  transport.set_flow(velocity, raster.walls(), dt);
  transport.carry(velocity, smoke.velocity_advection);
  fluid::impose_walls(raster.grid(), smoke.sides, raster.walls(), velocity);
  return velocity;
}

/// What one step of the world has exchanged, by three books.
struct Exchange {
  Vec3 lost_by_gas = Vec3::Zero();  ///< from its velocities, less what walls gave
  double rounding = 0.0;            ///< of that: the projection rounds each velocity once to a float
  Vec3 on_sheet = Vec3::Zero();     ///< pressure on the faces that the sheet closes
  Vec3 gained = Vec3::Zero();       ///< by the sheet, from its velocities
};
Exchange step(World& world, const WorldParams& params) {
  const fluid::SmokeParams& smoke = *params.smoke;
  Raster raster(fluid::smoke_grid(smoke), smoke.sides);
  const ShellView sheet = world.shells().front();
  std::vector<std::string> warnings;
  raster.see({{sheet.mesh, sheet.x, sheet.v}}, build_obstacles(params, warnings));
  const Vec3 sheet_before = momentum_of_sheet(world, params);
  const fluid::FaceField arrived = carried(smoke, raster, world.smoke()->velocity);
  const FrameReport report = world.step(dt);
  EXPECT_EQ(report.substeps, 1);
  EXPECT_EQ(report.unconverged_solves, 0);

  const Push push = push_of(raster, world.smoke()->pressure);
  const fluid::FaceField& velocity = world.smoke()->velocity;
  const auto of_gas = [&](const fluid::FaceField& u) {
    return momentum_of_gas(raster.grid(), raster.walls(), smoke.air_density, u);
  };
  double squares = 0.0;
  for (const auto& component : velocity)
    for (const float u : component) squares += double(u) * u;
  // Roundings of either sign by up to 2⁻²⁴ each, added up as a random walk of at most three standard deviations.
  const double rounding =
      std::sqrt(3.0 * squares) * std::ldexp(1.0, -24) * smoke.air_density * std::pow(raster.grid().h, 3);
  return {of_gas(arrived) + push.from_walls - of_gas(velocity), rounding, push.on_sheet,
          momentum_of_sheet(world, params) - sheet_before};
}

void expect_gas_loses_what_pushes(const Exchange& e) {
  EXPECT_LT((e.lost_by_gas - e.on_sheet).norm(), 1e-8 * e.on_sheet.norm() + e.rounding);
}

TEST(Momentum, OfGasAndSheetBalancesOverStepsOfTheSimultaneousScheme) {
  const WorldParams params = thrown_sheet(CouplingScheme::simultaneous);
  World world(params);
  for (int n = 0; n < 12; ++n) {
    SCOPED_TRACE(n);
    const Exchange e = step(world, params);
    ASSERT_GT(e.gained.norm(), 1e-4);
    EXPECT_LT((e.gained - e.on_sheet).norm(), 1e-8 * e.gained.norm());
    expect_gas_loses_what_pushes(e);
  }
}

TEST(Momentum, OfGasAndSheetBalancesOverStepsOfThePartitionedScheme) {
  WorldParams params = thrown_sheet(CouplingScheme::partitioned);
  for (const double relaxation : {1.0, 0.5}) {
    params.coupling.relaxation = relaxation;
    World world(params);
    // A relaxed sheet gets a running mean of what the gas loses.
    Vec3 mean = Vec3::Zero();
    for (int n = 0; n < 12; ++n) {
      SCOPED_TRACE(n);
      const Exchange e = step(world, params);
      mean += relaxation * (e.on_sheet - mean);
      ASSERT_GT(e.gained.norm(), 1e-4);
      EXPECT_LT((e.gained - mean).norm(), 1e-8 * e.gained.norm());
      expect_gas_loses_what_pushes(e);
    }
  }
}

}  // namespace
}  // namespace wick::coupling
