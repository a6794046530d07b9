#pragma once
/// The staggered (MAC) grid: scalars at cell centres, velocity components at the centres of the faces
/// that they are normal to. x runs fastest, then y, then z.
#include <cstddef>
#include <vector>

#include "core/types.h"

namespace wick::fluid {

struct Grid {
  int nx = 0, ny = 0, nz = 0;  ///< cells, each >= 1
  double h = 0.0;              ///< edge of the cubic cell [m]
  Vec3 origin = Vec3::Zero();  ///< lower corner of cell (0,0,0) [m]

  [[nodiscard]] std::size_t cells() const { return std::size_t(nx) * ny * nz; }
  [[nodiscard]] std::size_t cell(int i, int j, int k) const {
    return i + std::size_t(nx) * (j + std::size_t(ny) * k);
  }
  [[nodiscard]] int size(int axis) const { return axis == 0 ? nx : axis == 1 ? ny : nz; }

  /// Faces normal to `axis`: one more than cells along it. Face (i,j,k) is the lower face of cell (i,j,k).
  [[nodiscard]] std::size_t faces(int axis) const {
    return std::size_t(nx + (axis == 0)) * (ny + (axis == 1)) * (nz + (axis == 2));
  }
  [[nodiscard]] std::size_t face(int axis, int i, int j, int k) const {
    return i + std::size_t(nx + (axis == 0)) * (j + std::size_t(ny + (axis == 1)) * k);
  }
  [[nodiscard]] Vec3 cell_center(int i, int j, int k) const { return origin + h * Vec3(i + 0.5, j + 0.5, k + 0.5); }
  [[nodiscard]] Vec3 face_center(int axis, int i, int j, int k) const {
    Vec3 offset(i + 0.5, j + 0.5, k + 0.5);
    offset[axis] -= 0.5;
    return origin + h * offset;
  }
};

/// Velocity on the faces [m/s]; component a has grid.faces(a) values.
using FaceField = std::array<std::vector<float>, 3>;
/// One value a cell.
using CellField = std::vector<float>;

inline FaceField make_face_field(const Grid& grid, float value = 0.0F) {
  FaceField field;
  for (int a = 0; a < 3; ++a) field[a].assign(grid.faces(a), value);
  return field;
}

/// What a side of the box does to the fluid. `open`: p = 0, free in- and outflow of ambient air.
/// `closed`: no flow through. `periodic`: joined to the opposite side (both must say so).
enum class Side { closed, open, periodic };

/// Sides in the order -x, +x, -y, +y, -z, +z.
using Sides = std::array<Side, 6>;

}  // namespace wick::fluid
