#pragma once
/// Walls of known shape in a unit box, for tests and benchmarks of everything that flows around them.
#include <cmath>
#include <functional>
#include <numbers>

#include "core/noise.h"
#include "fluid/pressure.h"

namespace wick::fluid {

inline Walls no_walls(const Grid& grid) {
  Walls walls;
  walls.any = true;
  walls.solid.assign(grid.cells(), 0);
  for (int a = 0; a < 3; ++a) walls.closed[a].assign(grid.faces(a), 0);
  walls.velocity = make_face_field(grid);
  return walls;
}

/// Calls body(axis, face, low cell centre, high cell centre) for all faces between two cells.
template <class Body>
void for_inner_faces(const Grid& grid, Body&& body) {
  for (int a = 0; a < 3; ++a)
    for (int k = (a == 2); k < grid.nz; ++k)
      for (int j = (a == 1); j < grid.ny; ++j)
        for (int i = (a == 0); i < grid.nx; ++i) {
          const Vec3 high = grid.cell_center(i, j, k);
          body(a, grid.face(a, i, j, k), Vec3(high - grid.h * Vec3::Unit(a)), high);
        }
}

/// Closes faces whose two cells lie on different sides of `side` (a sign) where the middle is on the sheet.
inline void close_between(const Grid& grid, Walls& walls, const std::function<int(const Vec3&)>& side,
                          const std::function<bool(const Vec3&)>& on_sheet) {
  for_inner_faces(grid, [&](int a, std::size_t face, const Vec3& low, const Vec3& high) {
    if (side(low) != side(high) && on_sheet(0.5 * (low + high))) walls.closed[a][face] = 1;
  });
}

inline bool in_square(const Vec3& x) {
  return std::abs(x[0] - 0.5) < 0.3 && std::abs(x[1] - 0.5) < 0.3;
}

inline void add_sphere_obstacle(const Grid& grid, Walls& walls, const Vec3& center, double radius) {
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i)
        if ((grid.cell_center(i, j, k) - center).norm() < radius) walls.solid[grid.cell(i, j, k)] = 1;
  for_inner_faces(grid, [&](int a, std::size_t face, const Vec3& low, const Vec3& high) {
    if ((low - center).norm() < radius || (high - center).norm() < radius) walls.closed[a][face] = 1;
  });
}

/// A plate of 0.6 × 0.6 on the odd face plane nearest to the middle.
inline void add_flat_sheet(const Grid& grid, Walls& walls) {
  const double z = (2 * (grid.nz / 4) + 1) * grid.h;
  close_between(
      grid, walls, [=](const Vec3& x) { return x[2] > z; }, in_square);
}

inline void add_tilted_sheet(const Grid& grid, Walls& walls) {
  close_between(
      grid, walls, [](const Vec3& x) { return x[2] > 0.48 + 0.4 * (x[0] - 0.5) + 0.7 * (x[1] - 0.5); }, in_square);
}

inline void add_wrinkled_sheet(const Grid& grid, Walls& walls) {
  close_between(
      grid, walls,
      [](const Vec3& x) {
        const double wave = 0.06 * std::sin(40 * x[0] + 7 * x[1]) + 0.05 * std::sin(31 * x[1] - 11 * x[0]);
        return x[2] > 0.5 + wave;
      },
      in_square);
}

/// A sheet rolled up around the y axis: r = 0.05 + 0.04 turns, three and a half turns.
inline void add_rolled_sheet(const Grid& grid, Walls& walls) {
  const auto turn = [](const Vec3& x) {
    const Vec3 d = x - Vec3(0.5, 0.5, 0.5);
    const double angle = std::atan2(d[2], d[0]) / (2 * std::numbers::pi);
    return (std::hypot(d[0], d[2]) - 0.05) / 0.04 - angle;
  };
  const auto inside = [&](const Vec3& x) { return std::abs(x[1] - 0.5) < 0.3; };
  for_inner_faces(grid, [&](int a, std::size_t face, const Vec3& low, const Vec3& high) {
    double t0 = turn(low), t1 = turn(high);
    // Unwrap the jump of the angle behind the axis.
    if (t1 - t0 > 0.5) t1 -= 1.0;
    if (t0 - t1 > 0.5) t0 -= 1.0;
    const double m = std::max(t0, t1);
    if (inside(0.5 * (low + high)) && std::floor(t0) != std::floor(t1) && m > 0.0 && m < 3.5)
      walls.closed[a][face] = 1;
  });
}

inline void add_bag(const Grid& grid, Walls& walls, const Vec3& center = Vec3(0.5, 0.5, 0.5),
                    double radius = 0.27) {
  close_between(
      grid, walls, [=](const Vec3& x) { return (x - center).norm() > radius; }, [](const Vec3&) { return true; });
}

/// A smooth jet and white noise, the same at any resolution up to the noise.
inline FaceField stirred_velocity(const Grid& grid, double noise = 0.3) {
  FaceField velocity = make_face_field(grid);
  for (int a = 0; a < 3; ++a) {
    std::size_t face = 0;
    for (int k = 0; k < grid.nz + (a == 2); ++k)
      for (int j = 0; j < grid.ny + (a == 1); ++j)
        for (int i = 0; i < grid.nx + (a == 0); ++i, ++face) {
          const Vec3 x = grid.face_center(a, i, j, k) - grid.origin;
          const double jet = a == 2 ? std::exp(-40.0 * (x - Vec3(0.5, 0.5, 0.3)).squaredNorm()) : 0.0;
          velocity[a][face] = static_cast<float>(jet + noise * hash_signed(17 + a, face));
        }
  }
  return velocity;
}

inline Grid unit_grid(int n) {
  return {.nx = n, .ny = n, .nz = n, .h = 1.0 / n};
}

constexpr Side C = Side::closed, O = Side::open, P = Side::periodic;
constexpr Sides open_top = {C, C, C, C, C, O};
constexpr Sides all_closed = {C, C, C, C, C, C};

}  // namespace wick::fluid
