#include "coupling/burning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "solid/primitives.h"

namespace wick::coupling {
namespace {

constexpr double kAmbient = 293.15, kReference = 1100.0;

TEST(MassLoss, ThresholdLawIsLinearInTimeAndStopsAtTheAsh) {
  BurningParams p;
  BurningState state = make_burning_state(4);
  const std::vector<double> theta = {0.0, p.ignition, 0.6, 5.0}, side(4, 0.0);
  const double dt = 0.01;
  for (int n = 0; n < 10; ++n) lose_mass(state, p, theta, side, kAmbient, kReference, dt);
  EXPECT_EQ(state.fraction_left[0], 1.0);
  EXPECT_EQ(state.fraction_left[1], 1.0);
  EXPECT_NEAR(state.fraction_left[2], 1.0 - p.rate * 0.1 * 0.4 / 0.8, 1e-12);
  EXPECT_NEAR(state.fraction_left[3], 1.0 - p.rate * 0.1, 1e-12);
  for (int n = 0; n < 1000; ++n) lose_mass(state, p, theta, side, kAmbient, kReference, dt);
  EXPECT_EQ(state.fraction_left[3], p.ash);
}

TEST(MassLoss, ArrheniusLawDoesNotDependOnTheStep) {
  BurningParams p;
  p.law = MassLoss::arrhenius;
  const std::vector<double> theta = {1.0}, side = {0.0};
  const auto left = [&](int steps) {
    BurningState state = make_burning_state(1);
    for (int n = 0; n < steps; ++n) lose_mass(state, p, theta, side, kAmbient, kReference, 0.5 / steps);
    return state.fraction_left[0];
  };
  const double rate = p.pre_exponential * std::exp(-p.activation_temperature / kReference);
  EXPECT_NEAR(left(1), p.ash + (1.0 - p.ash) * std::exp(-0.5 * rate), 1e-12);
  EXPECT_NEAR(left(1), left(64), 1e-12);
}

TEST(MassLoss, StaysInRangeAtExtremes) {
  const std::vector<double> side = {1.0};
  for (const MassLoss law : {MassLoss::threshold, MassLoss::arrhenius})
    for (const double theta : {-1.0, 0.0, 1e-9, 1.0, 1e3, 1e12})
      for (const double dt : {1e-9, 1.0, 1e9}) {
        BurningParams p;
        p.law = law;
        BurningState state = make_burning_state(1);
        const auto lost = lose_mass(state, p, {theta}, side, kAmbient, kReference, dt);
        EXPECT_GE(state.fraction_left[0], p.ash);
        EXPECT_LE(state.fraction_left[0], 1.0);
        EXPECT_EQ(lost[0], 1.0 - state.fraction_left[0]);
        EXPECT_LE(std::abs(state.curl[0]), 1.0);
      }
}

struct BurntSheet {
  solid::ShellMesh mesh;
  solid::ShellParams material;
  solid::ShellInputs base, inputs;
  BurntSheet() {
    const auto soup = solid::rectangle(20, 23, Vec2(1, 1), solid::Lattice::staggered);
    mesh = solid::build_mesh(soup.positions, soup.material, soup.triangles);
    base = inputs = solid::make_shell_inputs(mesh, material);
  }
};

TEST(Reshape, VirginSheetIsUnchanged) {
  BurntSheet s;
  const BurningParams p;
  reshape(s.inputs, s.base, s.mesh, make_burning_state(s.mesh.vertex_count()), p,
          s.material.density * s.material.thickness);
  EXPECT_EQ(s.inputs.rest_scale, s.base.rest_scale);
  EXPECT_EQ(s.inputs.rest_angle, s.base.rest_angle);
  for (std::size_t i = 0; i < s.mesh.vertex_count(); ++i) EXPECT_NEAR(s.inputs.mass[i], s.base.mass[i], 1e-15);
}

TEST(Reshape, AshShrinksWeakensAndCurlsToTheGivenRadius) {
  BurntSheet s;
  BurningParams p;
  BurningState state = make_burning_state(s.mesh.vertex_count());
  state.fraction_left.assign(s.mesh.vertex_count(), p.ash);
  state.curl.assign(s.mesh.vertex_count(), 1.0);
  const double areal = s.material.density * s.material.thickness;
  reshape(s.inputs, s.base, s.mesh, state, p, areal);
  for (const double scale : s.inputs.rest_scale) EXPECT_NEAR(scale, p.shrink, 1e-12);
  for (const double scale : s.inputs.stiffness_scale) EXPECT_NEAR(scale, p.weaken, 1e-12);
  double mass = 0.0;
  for (const double m : s.inputs.mass) mass += m;
  EXPECT_NEAR(mass, areal * p.ash, 1e-12);
  // The total turn across the sheet is its width over the radius: on equilateral triangles two of three
  // hinge directions share it, so compare the mean angle times hinges with sum of 2 (A0+A1)/(3|e|) / R.
  for (std::size_t h = 0; h < s.mesh.hinges.size(); ++h) {
    const auto& hinge = s.mesh.hinges[h];
    const double area = s.mesh.rest_area[hinge.triangle[0]] + s.mesh.rest_area[hinge.triangle[1]];
    const double edge = (s.mesh.rest[hinge.vertex[1]] - s.mesh.rest[hinge.vertex[0]]).norm();
    EXPECT_NEAR(s.inputs.rest_angle[h], std::min(2.0 * area / (3.0 * edge * p.curl_radius), M_PI_2), 1e-12);
  }
}

TEST(Reshape, OnlyTrianglesThatAreAshAllOverFallAway) {
  BurntSheet s;
  const BurningParams p;
  BurningState state = make_burning_state(s.mesh.vertex_count());
  for (std::size_t i = 0; i < s.mesh.vertex_count(); ++i)
    state.fraction_left[i] = s.mesh.rest[i].x() < 0.5 ? p.ash : 1.0;
  const auto keep = unburnt_triangles(s.mesh, state, p);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    bool all = true;
    for (const int v : s.mesh.triangles[t]) all = all && s.mesh.rest[v].x() < 0.5;
    EXPECT_EQ(keep[t], all ? 0 : 1);
  }
}

}  // namespace
}  // namespace wick::coupling
