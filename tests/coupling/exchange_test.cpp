#include "coupling/exchange.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "solid/primitives.h"

namespace wick::coupling {
namespace {

/// A flat sheet across the middle of a closed box of n^3 cells.
struct SplitBox {
  fluid::SmokeParams params;
  solid::ShellMesh mesh;
  std::vector<Vec3> v;
  std::unique_ptr<Raster> raster;
  fluid::SmokeState gas;
  std::vector<VertexStencil> stencils;

  explicit SplitBox(int n, double tilt = 0.1) {
    params.resolution = {n, n, n};
    params.sides.fill(fluid::Side::closed);
    auto soup = solid::rectangle(30, 35, Vec2(1.4, 1.4), solid::Lattice::staggered);
    for (Vec3& x : soup.positions) {
      x += Vec3(-0.2, -0.2, 0.5013);
      x.z() += tilt * (x.x() - 0.5);
    }
    mesh = solid::build_mesh(soup.positions, soup.material, soup.triangles);
    v.assign(mesh.vertex_count(), Vec3::Zero());
    raster = std::make_unique<Raster>(fluid::smoke_grid(params), params.sides);
    raster->see({surface()}, {});
    gas = fluid::make_smoke_state(params);
    stencils = vertex_stencils(*raster, 0, surface());
  }
  [[nodiscard]] SheetSurface surface() const { return {&mesh, &mesh.rest, &v}; }
  [[nodiscard]] bool above(std::size_t cell, double tilt = 0.1) const {
    const int n = params.resolution[0];
    const Vec3 c = raster->grid().cell_center(int(cell % n), int(cell / n % n), int(cell / (std::size_t(n) * n)));
    return c.z() > 0.5013 + tilt * (c.x() - 0.5);
  }
};

TEST(VertexStencils, EachFaceSeesItsOwnSideOnly) {
  for (const int n : {8, 17, 40}) {
    const SplitBox box(n);
    const auto normals = solid::vertex_normals(box.mesh, box.mesh.rest);
    std::size_t served = 0;
    for (std::size_t i = 0; i < box.mesh.vertex_count(); ++i)
      for (int side = 0; side < 2; ++side) {
        const auto& face = box.stencils[i].face[side];
        const bool up = (normals[i].z() > 0) == (side == 1);
        double sum = 0.0;
        for (int c = 0; c < face.count; ++c) {
          EXPECT_EQ(box.above(face.cell[c]), up) << "vertex " << i << " side " << side << " n " << n;
          sum += face.weight[c];
        }
        if (face.count == 0) continue;
        ++served;
        EXPECT_NEAR(sum, 1.0, 1e-5);
      }
    // Every vertex in the box sees both sides.
    std::size_t inside = 0;
    for (const Vec3& x : box.mesh.rest)
      if (x.x() > 0 && x.y() > 0 && x.x() < 1 && x.y() < 1) ++inside;
    EXPECT_GE(served, 2 * inside) << n;
  }
}

TEST(ExchangeHeat, WhatTheSheetGainsTheGasLoses) {
  for (const double convection : {1.0, 20.0, 1e6})
    for (const double dt : {1e-4, 1.0 / 30, 1e3}) {
      SplitBox box(20);
      for (float& t : box.gas.temperature) t = 700.0F;
      const std::size_t count = box.mesh.vertex_count();
      std::vector<double> theta(count, 0.1), capacity(count), heat(count, 0.0), side(count, 0.0);
      const double kelvin = 800.0;
      for (std::size_t i = 0; i < count; ++i) capacity[i] = 0.14 * box.mesh.vertex_area[i] * 1400 * kelvin;
      const double before = fluid::total_heat(box.gas, box.params);
      const double gained = exchange_heat(box.stencils, box.mesh.vertex_area, theta, capacity, {293, kelvin},
                                          convection, dt, box.params, box.gas, heat, side);
      EXPECT_GT(gained, 0.0);
      EXPECT_NEAR(std::accumulate(heat.begin(), heat.end(), 0.0), gained, 1e-12 * gained);
      // The gas is kept in float: 1e-7 of what it holds is its rounding.
      EXPECT_NEAR(before - fluid::total_heat(box.gas, box.params), gained, 1e-6 * before);
      for (std::size_t i = 0; i < count; ++i) EXPECT_LE(theta[i] + heat[i] / capacity[i], 700.0 / kelvin + 1e-9);
      for (const float t : box.gas.temperature) EXPECT_GE(t, 0.1 * kelvin - 1e-3);
    }
}

TEST(ExchangeHeat, TellsTheHotterSide) {
  SplitBox box(20);
  for (std::size_t c = 0; c < box.gas.temperature.size(); ++c)
    box.gas.temperature[c] = box.above(c) ? 500.0F : 0.0F;
  const std::size_t count = box.mesh.vertex_count();
  std::vector<double> theta(count, 0.0), capacity(count, 1.0), heat(count, 0.0), side(count, 0.0);
  exchange_heat(box.stencils, box.mesh.vertex_area, theta, capacity, {293, 800}, 20, 1e-6, box.params, box.gas,
                heat, side);
  const auto normals = solid::vertex_normals(box.mesh, box.mesh.rest);
  for (std::size_t i = 0; i < count; ++i)
    if (box.stencils[i].face[0].count && box.stencils[i].face[1].count) {
      EXPECT_GT(side[i] * normals[i].z(), 0.9);
    }
}

TEST(Deposit, BooksEverythingAndFeedsBothSidesAlike) {
  SplitBox box(24, 0.0);
  const std::size_t count = box.mesh.vertex_count();
  std::vector<double> smoke(count, 1e-6), heat(count, 1.0), flame(count, 0.7);
  const Deposited sum = deposit(box.stencils, smoke, heat, flame, 1e9, box.params, box.gas);
  EXPECT_NEAR(sum.smoke + sum.escaped_smoke, 1e-6 * double(count), 1e-15);
  EXPECT_NEAR(sum.heat + sum.escaped_heat, double(count), 1e-9);
  EXPECT_NEAR(fluid::total_smoke(box.gas, box.params), sum.smoke, 1e-6 * sum.smoke);
  EXPECT_NEAR(fluid::total_heat(box.gas, box.params), sum.heat, 1e-6 * sum.heat);
  double up = 0.0, all = 0.0;
  for (std::size_t c = 0; c < box.gas.density.size(); ++c) {
    all += box.gas.density[c];
    if (box.above(c, 0.0)) up += box.gas.density[c];
  }
  EXPECT_NEAR(up / all, 0.5, 1e-5);
}

TEST(Deposit, HeatsNoFurtherThanTheFlame) {
  SplitBox box(24, 0.0);
  const std::size_t count = box.mesh.vertex_count();
  const std::vector<double> smoke(count, 0.0), flame(count, 0.0), heat(count, 100.0);
  double unburnt = 0.0, released = 0.0, offered = 0.0;
  for (int n = 0; n < 50; ++n) {
    const Deposited sum = deposit(box.stencils, smoke, heat, flame, 2000.0, box.params, box.gas);
    EXPECT_NEAR(sum.heat + sum.unburnt_heat + sum.escaped_heat, 100.0 * double(count), 1e-7);
    unburnt += sum.unburnt_heat;
    released += sum.heat;
    offered += 100.0 * double(count);
  }
  EXPECT_LE(*std::max_element(box.gas.temperature.begin(), box.gas.temperature.end()), 2000.01F);
  EXPECT_GT(unburnt, 0.1 * offered);
  EXPECT_NEAR(fluid::total_heat(box.gas, box.params), released, 1e-6 * released);
}

TEST(PressureImpulse, OfAUniformJumpIsAreaTimesJump) {
  SplitBox box(32);
  std::vector<double> pressure(box.raster->grid().cells());
  for (std::size_t c = 0; c < pressure.size(); ++c) pressure[c] = box.above(c) ? 0.0 : 3.0;
  const std::vector<Vec3> impulse = pressure_impulse(*box.raster, {box.surface()}, pressure, 0.5);
  Vec3 sum = Vec3::Zero();
  for (const Vec3& j : impulse) sum += j;
  // The sheet spans the whole unit cross-section: force 3 N upwards for 0.5 s. Its tilt of 0.1 pushes along -x with
  // a tenth of that, seen in whole layers of 1/32.
  EXPECT_NEAR(sum.z(), 1.5, 1e-12);
  EXPECT_NEAR(sum.x(), -0.15, 1.5 / 32);
  EXPECT_NEAR(sum.y(), 0.0, 1e-12);
}

}  // namespace
}  // namespace wick::coupling
