#pragma once
/// Flows and walls that the tests of the fluid room share.
#include <cmath>
#include <functional>
#include <numbers>

#include "core/noise.h"
#include "fluid/padded.h"
#include "fluid/walls.h"

namespace wick::fluid::test {

constexpr Sides all_sides(Side side) {
  return {side, side, side, side, side, side};
}

inline void for_each(const Int3& size, const std::function<void(int, int, int)>& body) {
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) body(i, j, k);
    }
  }
}

/// Samples a velocity at the faces.
inline FaceField face_field(const Grid& g, const std::function<Vec3(const Vec3&)>& u) {
  FaceField field = make_face_field(g);
  for (int a = 0; a < 3; ++a) {
    for_each(lattice_size(g, a), [&](int i, int j, int k) {
      field[a][g.face(a, i, j, k)] = static_cast<float>(u(g.face_center(a, i, j, k))[a]);
    });
  }
  return field;
}

inline CellField cell_field(const Grid& g, const std::function<double(const Vec3&)>& q) {
  CellField field(g.cells());
  for_each({g.nx, g.ny, g.nz},
           [&](int i, int j, int k) { field[g.cell(i, j, k)] = static_cast<float>(q(g.cell_center(i, j, k))); });
  return field;
}

/// Velocity in the x-y plane whose discrete divergence is zero: differences of a stream function at edges.
inline FaceField stream_flow(const Grid& g, const std::function<double(double, double)>& psi) {
  FaceField u = make_face_field(g);
  const auto at = [&](int i, int j) { return psi(g.origin.x() + i * g.h, g.origin.y() + j * g.h); };
  for_each(lattice_size(g, 0), [&](int i, int j, int k) {
    u[0][g.face(0, i, j, k)] = static_cast<float>((at(i, j + 1) - at(i, j)) / g.h);
  });
  for_each(lattice_size(g, 1), [&](int i, int j, int k) {
    u[1][g.face(1, i, j, k)] = static_cast<float>(-(at(i + 1, j) - at(i, j)) / g.h);
  });
  return u;
}

/// Closes the faces between cells that `inside` tells apart.
inline Walls bag(const Grid& g, const std::function<bool(const Vec3&)>& inside) {
  Walls w;
  w.any = true;
  w.solid.assign(g.cells(), 0);
  w.near.assign(g.cells(), 1);
  w.velocity = make_face_field(g);
  for (int a = 0; a < 3; ++a) {
    w.closed[a].assign(g.faces(a), 0);
    for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
      Int3 below = {i, j, k};
      if (--below[a] < 0) return;
      const bool here = inside(g.cell_center(i, j, k)), there = inside(g.cell_center(below[0], below[1], below[2]));
      if (here != there) w.closed[a][g.face(a, i, j, k)] = 1;
    });
  }
  return w;
}

/// A velocity without any order, different at each step; 0 on closed faces and sides.
inline FaceField stirring(const Grid& g, const Sides& sides, const Walls& walls, double speed, std::uint64_t seed) {
  FaceField u = make_face_field(g);
  for (int a = 0; a < 3; ++a) {
    for (std::size_t f = 0; f < u[a].size(); ++f) {
      if (walls.any && walls.closed[a][f]) continue;
      u[a][f] = static_cast<float>(speed * hash_signed(3 * seed + a, f));
    }
    for_each(lattice_size(g, a), [&](int i, int j, int k) {
      const Int3 f = {i, j, k};
      if ((f[a] == 0 && sides[2 * a] == Side::closed) || (f[a] == g.size(a) && sides[2 * a + 1] == Side::closed)) {
        u[a][g.face(a, i, j, k)] = 0.0F;
      }
    });
  }
  return u;
}

inline double sum(const CellField& q) {
  double total = 0.0;
  for (const float v : q) total += v;
  return total;
}

/// Root mean square difference.
inline double distance(const CellField& a, const CellField& b) {
  double s = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) s += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
  return std::sqrt(s / double(a.size()));
}

}  // namespace wick::fluid::test
