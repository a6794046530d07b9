/// Open sides: still air at p = 0 outside. What comes in is ambient and brings no energy along, what goes out
/// goes unhindered.
#include <gtest/gtest.h>

#include "fluid/advection.h"
#include "fluid/smoke.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;
const Walls no_walls;

/// A row of cells between two open sides, without anything that would slow the air across it.
SmokeParams duct(int n) {
  SmokeParams p;
  p.resolution = {n, 1, 1};
  p.sides = all_sides(Side::periodic);
  p.sides[0] = p.sides[1] = Side::open;
  p.vorticity = 0.0;
  p.active_window = false;
  return p;
}

SmokeSources weightless() {
  SmokeSources s;
  s.gravity = Vec3::Zero();
  return s;
}

// Air of length L that comes in with head -ρu²/2 and leaves at p = 0: du/dt = -u²/(2L), u = u0/(1 + u0 t/(2L)).
// Steps of 0.005 L/u make an error of order u dt/L.
TEST(OpenSides, ADuctSlowsByTheHeadOfItsInflow) {
  for (const double u0 : {1.0, -1.0}) {
    const SmokeParams p = duct(32);
    SmokeState s = make_smoke_state(p);
    for (float& u : s.velocity[0]) u = static_cast<float>(u0);
    SmokeSolver solver(p);
    const double dt = 0.005;
    for (int step = 1; step <= 400; ++step) {
      solver.step(s, weightless(), no_walls, dt);
      const double wanted = u0 / (1.0 + step * dt / 2.0);
      for (const float u : s.velocity[0]) ASSERT_NEAR(u, wanted, 0.01 * std::abs(wanted)) << step;
    }
  }
}

// A push a along the duct, as of warm air in a chimney: du/dt = a - u²/(2L), u = U tanh(a t/U), U = √(2 a L).
TEST(OpenSides, AChimneyDrawsAsBernoulliSays) {
  const double push = 0.5, limit = std::sqrt(2.0 * push), dt = 0.005;
  const SmokeParams p = duct(32);
  const Grid g = smoke_grid(p);
  SmokeState s = make_smoke_state(p);
  SmokeSolver solver(p);
  const FaceField force = face_field(g, [push](const Vec3&) { return Vec3(push, 0, 0); });
  SmokeSources sources = weightless();
  sources.body_force = &force;
  for (int step = 1; step <= 2000; ++step) {
    solver.step(s, sources, no_walls, dt);
    const double wanted = limit * std::tanh(push * step * dt / limit);
    for (const float u : s.velocity[0]) ASSERT_NEAR(u, wanted, 0.01 * limit) << step;
  }
}

// With one cell a step paths end on values exactly: still air takes the place of moving air, cell by cell.
TEST(OpenSides, WhatComesInDoesNotMoveAlongTheSide) {
  SmokeParams p;
  p.resolution = {8, 6, 5};
  p.sides = {Side::open, Side::open, Side::closed, Side::closed, Side::closed, Side::closed};
  const Grid g = smoke_grid(p);
  for (const Advection scheme : {Advection::semi_lagrangian, Advection::maccormack}) {
    Transport transport(g, p.sides, {});
    const FaceField flow = face_field(g, [](const Vec3&) { return Vec3(1, 0, 0); });
    FaceField carried = face_field(g, [](const Vec3&) { return Vec3(0, 1, 2); });
    for (int step = 1; step <= 3; ++step) {
      transport.set_flow(flow, no_walls, g.h);
      transport.carry(carried, scheme);
    }
    for (int a = 1; a < 3; ++a) {
      for_each(lattice_size(g, a), [&](int i, int j, int k) {
        ASSERT_NEAR(carried[a][g.face(a, i, j, k)], i < 3 ? 0.0 : a, 1e-6) << i << " " << j << " " << k;
      });
    }
  }
}

// Two vortices of opposite sign push each other through an open side. Energy may not come in; once they have
// gone a twentieth of it may be left in what they drew along.
TEST(OpenSides, AVortexPairLeaves) {
  SmokeParams p;
  p.resolution = {64, 64, 1};
  p.sides = {Side::open, Side::open, Side::open, Side::open, Side::periodic, Side::periodic};
  p.vorticity = 0.0;
  p.active_window = false;
  const Grid g = smoke_grid(p);
  const auto energy = [&](const FaceField& u) {
    double e = 0.0;
    for (int a = 0; a < 2; ++a) {
      for (const float v : u[a]) e += double(v) * v;
    }
    return e;
  };
  SmokeState s = make_smoke_state(p);
  s.velocity = stream_flow(g, [](double x, double y) {
    const auto vortex = [&](double at) { return std::exp(-(std::pow(x - 0.5, 2) + std::pow(y - at, 2)) / 0.005); };
    return 0.1 * (vortex(0.57) - vortex(0.43));
  });
  SmokeSolver solver(p);
  const double start = energy(s.velocity);
  double before = start;
  for (int step = 0; step < 400; ++step) {
    solver.step(s, weightless(), no_walls, 0.01);
    const double now = energy(s.velocity);
    ASSERT_LE(now, before + 0.001 * start) << step;
    before = now;
  }
  std::printf("vortex pair: energy left %.5f\n", before / start);
  EXPECT_LT(before, 0.05 * start);
}

// Warm air above cold under an open top: weight and pressure balance to the rounding of floats, over 100 steps.
TEST(OpenSides, AWarmLayerUnderAnOpenTopStaysAtRest) {
  SmokeParams p;
  p.resolution = {8, 8, 24};
  p.active_window = false;
  SmokeState s = make_smoke_state(p);
  s.temperature = cell_field(smoke_grid(p), [](const Vec3& x) { return 40.0 * std::max(x.z() - 1.0, 0.0); });
  SmokeSolver solver(p);
  for (int step = 0; step < 100; ++step) {
    ASSERT_LT(solver.step(s, {}, no_walls, 0.02).max_speed, 1e-5) << step;
  }
}

}  // namespace
}  // namespace wick::fluid
