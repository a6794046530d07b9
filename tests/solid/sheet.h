#pragma once
/// A shell with everything that a step needs, for the tests of this folder.
#include <cmath>

#include "solid/primitives.h"
#include "solid/shell.h"

namespace wick::solid {

struct Sheet {
  Sheet(TriangleSoup soup, const ShellParams& p)
      : mesh(build_mesh(std::move(soup))), params(p), inputs(make_shell_inputs(mesh, p)), solver(mesh, p) {
    state.x = mesh.rest;
    state.v.assign(mesh.vertex_count(), Vec3::Zero());
  }

  [[nodiscard]] ShellLoads loads() const { return {inputs, pins, obstacles, force, wind, gravity}; }
  ShellStepReport step(double dt) { return solver.step(state, mesh, loads(), dt); }
  void run(double seconds, double dt) {
    const int steps = static_cast<int>(std::ceil(seconds / dt));
    for (int k = 0; k < steps; ++k) step(dt);
  }
  /// Holds the vertices that `chosen(rest position)` picks where they are now.
  template <class Choice>
  void pin_where(Choice&& chosen) {
    for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
      if (!chosen(mesh.rest[i])) continue;
      pins.vertex.push_back(static_cast<std::int32_t>(i));
      pins.target.push_back(state.x[i]);
    }
  }
  [[nodiscard]] Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < state.x.size(); ++i) sum += inputs.mass[i] * state.v[i];
    return sum;
  }
  [[nodiscard]] Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < state.x.size(); ++i) {
      const Vec3 &x = state.x[i], v = inputs.mass[i] * state.v[i];
      sum += Vec3(x.y() * v.z() - x.z() * v.y(), x.z() * v.x() - x.x() * v.z(), x.x() * v.y() - x.y() * v.x());
    }
    return sum;
  }
  [[nodiscard]] double energy() const {
    const ShellEnergy elastic = elastic_energy(mesh, params, inputs, state.x);
    double sum = elastic.stretching + elastic.bending;
    for (std::size_t i = 0; i < state.x.size(); ++i)
      sum += inputs.mass[i] * (0.5 * state.v[i].squaredNorm() - gravity.dot(state.x[i]));
    return sum;
  }
  [[nodiscard]] bool finite() const {
    for (std::size_t i = 0; i < state.x.size(); ++i)
      if (!state.x[i].allFinite() || !state.v[i].allFinite()) return false;
    return true;
  }

  ShellMesh mesh;
  ShellParams params;
  ShellInputs inputs;
  ShellSolver solver;
  ShellState state;
  Pins pins;
  std::vector<Obstacle> obstacles;
  std::vector<Vec3> force, wind;
  Vec3 gravity = Vec3::Zero();
};

/// Staggered lattice of nx x ny vertices whose triangles are equilateral with side `spacing`.
inline TriangleSoup equilateral(int nx, int ny, double spacing) {
  return rectangle(nx, ny, Vec2((nx - 1) * spacing, (ny - 1) * spacing * std::sqrt(0.75)));
}

}  // namespace wick::solid
