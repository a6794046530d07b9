#pragma once
/// Small worlds that several tests step.
#include "coupling/world.h"

namespace wick::test {

/// A box of still air, closed on all sides, n cells along each edge of 1 m.
inline fluid::SmokeParams closed_box(int n) {
  fluid::SmokeParams smoke;
  smoke.resolution = {n, n, n};
  smoke.width = 1.0;
  smoke.sides.fill(fluid::Side::closed);
  smoke.vorticity = 0.0;
  smoke.active_window = false;
  return smoke;
}

/// A square sheet of `cells` triangles pairs along its edge, in the plane z = height, centred at x = y = 0.5.
inline coupling::ShellSection flat_sheet(int vertices, double edge, double height) {
  coupling::ShellSection shell;
  shell.mesh.kind = coupling::MeshKind::rectangle;
  shell.mesh.vertices = {vertices, vertices};
  shell.mesh.size = Vec2(edge, edge);
  shell.mesh.position = Vec3(0.5 - 0.5 * edge, 0.5 - 0.5 * edge, height);
  return shell;
}

/// A sphere of cloth around the middle of the box.
inline coupling::ShellSection bag(int level, double radius) {
  coupling::ShellSection shell;
  shell.name = "bag";
  shell.mesh.kind = coupling::MeshKind::icosphere;
  shell.mesh.subdivisions = level;
  shell.mesh.radius = radius;
  shell.mesh.position = Vec3(0.5, 0.5, 0.5);
  return shell;
}

}  // namespace wick::test
