#pragma once
/// Sheets of known shape hung in a unit box of gas, for tests and benchmarks of the simultaneous solve.
#include <cmath>
#include <numbers>

#include "coupling/exchange.h"
#include "coupling/rasterize.h"
#include "solid/primitives.h"
#include "tests/fluid/wall_shapes.h"

namespace wick::test {

enum class SheetShape { flat, tilted, wrinkled, folded };
constexpr const char* sheet_shape_names[] = {"flat", "tilted", "wrinkled", "folded"};

/// Where material point (s, t) in [0,1]² of a sheet of edge 0.6 m is.
inline Vec3 place_on_sheet(SheetShape shape, double s, double t) {
  const double x = 0.6 * (s - 0.5), y = 0.6 * (t - 0.5);
  const auto at = [](double a, double b, double c) { return Vec3(0.5 + a, 0.503 + b, 0.497 + c); };
  switch (shape) {
    case SheetShape::flat:
      return at(x, y, 0.0);
    case SheetShape::tilted:
      return at(0.87 * x, 0.8 * y, 0.4 * x + 0.6 * y);
    case SheetShape::wrinkled:
      return at(x, y, 0.04 * std::sin(40 * x + 7 * y) + 0.03 * std::sin(31 * y - 11 * x));
    case SheetShape::folded: {
      // Two leaves 0.04 m apart and a round spine.
      const double radius = 0.02, leaf = 0.5 * (0.6 - std::numbers::pi * radius), u = 0.6 * s;
      if (u < leaf) return at(-0.15 + leaf - u, y, -radius);
      if (u > 0.6 - leaf) return at(-0.15 + u - 0.6 + leaf, y, radius);
      const double angle = (u - leaf) / radius;
      return at(-0.15 - radius * std::sin(angle), y, -radius * std::cos(angle));
    }
  }
  return Vec3::Zero();
}

/// A sheet with `vertices` along each edge, of a mass of `areal` [kg/m2], seen by a grid of n cells an axis.
struct HungSheet {
  solid::ShellMesh mesh;
  std::vector<Vec3> x, v;
  coupling::Raster raster;
  fluid::MovableWalls movable;

  HungSheet(SheetShape shape, int n, int vertices, double areal)
      : mesh(solid::build_mesh(solid::rectangle(vertices, vertices, Vec2(0.6, 0.6)))),
        raster(fluid::unit_grid(n), fluid::open_top) {
    for (const Vec3& rest : mesh.rest) x.push_back(place_on_sheet(shape, rest[0] / 0.6, rest[1] / 0.6));
    v.assign(x.size(), Vec3::Zero());
    raster.see({surface()}, {});
    set_mass(areal);
  }
  [[nodiscard]] coupling::SheetSurface surface() const { return {&mesh, &x, &v}; }
  void set_mass(double areal) {
    std::vector<double> inverse;
    for (const double area : mesh.vertex_area) inverse.push_back(1.0 / (areal * area));
    movable = coupling::movable_walls(raster, {surface()}, std::move(inverse));
  }
};

}  // namespace wick::test
