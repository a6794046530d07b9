/// Motion: free fall, momentum, energy, drag, pins, and the same bits at any number of threads.
#include <gtest/gtest.h>

#include "core/noise.h"
#include "core/parallel.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

Vec3 random_vector(std::uint64_t seed, std::uint64_t i) {
  return {hash_signed(seed, 3 * i), hash_signed(seed, 3 * i + 1), hash_signed(seed, 3 * i + 2)};
}

TEST(FreeFall, IsThatOfTheScheme) {
  ShellParams params;
  params.air_drag = 0.0;
  params.substeps = 20;  // the rounding of v = (x⁺ − x)/h grows with their number
  Sheet sheet(equilateral(9, 9, 0.02), params);
  sheet.gravity = Vec3(1.0, -2.0, -9.81);
  const std::vector<Vec3> start = sheet.state.x;
  const int steps = 30;
  int substeps = 0;
  for (int k = 0; k < steps; ++k) substeps += sheet.step(1.0 / 60.0).substeps;
  EXPECT_EQ(substeps, steps * params.substeps);
  // vₙ = n h g, xₙ = x₀ + n (n+1)/2 h² g.
  const double h = 0.5 / substeps;
  for (std::size_t i = 0; i < start.size(); ++i) {
    EXPECT_LT((sheet.state.v[i] - 0.5 * sheet.gravity).norm(), 1e-10);
    EXPECT_LT((sheet.state.x[i] - start[i] - 0.5 * h * h * substeps * (substeps + 1) * sheet.gravity).norm(),
              1e-12);
  }
}

TEST(Momentum, OfAFreeSheetIsKept) {
  ShellParams params;
  params.air_drag = 0.0;
  Sheet sheet(equilateral(20, 20, 0.01), params);
  double scale = 0.0;
  for (std::size_t i = 0; i < sheet.state.v.size(); ++i) {
    sheet.state.v[i] = Vec3(1.0, 0.5, -0.3) + 0.5 * random_vector(1, i);
    scale += sheet.inputs.mass[i] * sheet.state.v[i].norm();
  }
  for (int k = 0; k < 20; ++k) {
    const Vec3 linear = sheet.momentum(), angular = sheet.angular_momentum();
    sheet.step(1.0 / 60.0);
    EXPECT_LT((sheet.momentum() - linear).norm() / scale, 1e-12);
    EXPECT_LT((sheet.angular_momentum() - angular).norm() / (scale * 0.2), 1e-10);
  }
}

TEST(Pendulum, KeepsItsEnergy) {
  ShellParams params;
  params.air_drag = 0.0;
  params.damping = 0.0;
  Sheet sheet(rectangle(2, 2, {0.4, 1.0}, Lattice::grid), params);
  // A plate hung by its upper edge, 30 degrees out of the vertical: the mass of its lower corners swings.
  for (Vec3& x : sheet.state.x) x = Vec3(x.x(), -x.y() * std::cos(M_PI / 6), x.y() * std::sin(M_PI / 6));
  sheet.pin_where([](const Vec3& X) { return X.y() < 1e-9; });
  sheet.gravity = Vec3(0, -9.81, 0);
  double rest = 0.0;
  for (std::size_t i = 0; i < sheet.mesh.vertex_count(); ++i)
    rest -= sheet.inputs.mass[i] * 9.81 * sheet.mesh.rest[i].y();
  const double before = sheet.energy() - rest;
  // Period 2π sqrt(L/g), 1.7 % longer at 30 degrees.
  sheet.run(10.0 * 1.017 * 2.0 * M_PI * std::sqrt(1.0 / 9.81), 1.0 / 60.0);
  const double after = sheet.energy() - rest;
  EXPECT_GT(after / before, 0.95);
  EXPECT_LT(after / before, 1.01);
}

TEST(Drag, RelaxesToTheWind) {
  ShellParams params;
  params.air_drag = 2.0;
  Sheet sheet(equilateral(5, 5, 0.02), params);
  sheet.wind.assign(sheet.mesh.vertex_count(), Vec3(3, 0, 1));
  sheet.run(0.5, 1.0 / 60.0);
  // v = wind (1 − e^{−kt}), exact for a sheet that moves as a whole.
  EXPECT_LT((sheet.state.v[7] - (1.0 - std::exp(-1.0)) * Vec3(3, 0, 1)).norm(), 1e-9);
}

TEST(Pins, ArriveAtTheirTargetsAndMoveInBetween) {
  ShellParams params;
  Sheet sheet(equilateral(6, 6, 0.02), params);
  sheet.pin_where([](const Vec3&) { return true; });
  for (Vec3& t : sheet.pins.target) t += Vec3(0.01, 0.02, 0.03);
  const std::vector<Vec3> target = sheet.pins.target;
  sheet.step(1.0 / 60.0);
  for (std::size_t i = 0; i < target.size(); ++i) {
    EXPECT_EQ(sheet.state.x[i], target[i]);
    EXPECT_LT((sheet.state.v[i] - 60.0 * Vec3(0.01, 0.02, 0.03)).norm(), 1e-9);
  }
}

TEST(Rest, CurvedMeshesStayAtRest) {
  ShellParams params;
  for (TriangleSoup soup : {icosphere(3, 0.1), cylinder(0.05, 0.2, 24, 12), equilateral(12, 12, 0.01)}) {
    Sheet sheet(std::move(soup), params);
    sheet.run(0.5, 1.0 / 60.0);
    for (std::size_t i = 0; i < sheet.state.x.size(); ++i)
      EXPECT_LT((sheet.state.x[i] - sheet.mesh.rest[i]).norm(), 1e-9);
  }
}

TEST(RestScale, ShrinksTheSheetByIt) {
  ShellParams params;
  params.air_drag = 5.0;
  for (const double scale : {0.6, 0.9, 1.2}) {
    Sheet sheet(equilateral(12, 12, 0.01), params);
    sheet.inputs.rest_scale.assign(sheet.mesh.triangle_count(), scale);
    sheet.run(3.0, 1.0 / 60.0);
    for (std::size_t e = 0; e < sheet.mesh.edges.size(); ++e) {
      const auto& [a, b] = sheet.mesh.edges[e];
      EXPECT_NEAR((sheet.state.x[a] - sheet.state.x[b]).norm() / (scale * sheet.mesh.rest_length[e]), 1.0, 1e-3);
    }
  }
}

TEST(RestAngle, BendsTheSheetToIt) {
  ShellParams params;
  params.bending = 1e-4;
  params.air_drag = 5.0;
  Sheet sheet(rectangle(2, 2, {0.01, 0.01}, Lattice::grid), params);
  for (const double angle : {0.5, -0.5, 2.0}) {
    sheet.inputs.rest_angle = {angle};
    sheet.run(3.0, 1.0 / 60.0);
    EXPECT_NEAR(elastic_energy(sheet.mesh, params, sheet.inputs, sheet.state.x).bending, 0.0, 1e-12) << angle;
  }
}

TEST(Determinism, SameBitsAtOneAndTwoThreads) {
  const auto hash = [](int threads) {
    ThreadLimit limit(threads);
    ShellParams params;
    Sheet sheet(equilateral(90, 90, 0.01), params);
    for (std::size_t h = 0; h < sheet.inputs.rest_angle.size(); h += 3)
      sheet.inputs.rest_angle[h] = 0.3 * hash_signed(5, h);
    sheet.pin_where([](const Vec3& X) { return X.y() < 1e-9; });
    sheet.gravity = Vec3(0, 3, -9.81);
    sheet.obstacles.push_back({"ball", SphereShape{Vec3(0.45, 0.4, -0.11), 0.1}});
    for (int k = 0; k < 5; ++k) sheet.step(1.0 / 60.0);
    StateHash h;
    visit(h, sheet.state);
    return h.digest();
  };
  EXPECT_EQ(hash(1), hash(2));
}

}  // namespace
}  // namespace wick::solid
