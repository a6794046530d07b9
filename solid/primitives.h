#pragma once
/// Sheets that need no file: rectangles on three lattices, spheres, tubes; and regular refinement.
#include "solid/shell_mesh.h"

namespace wick::solid {

/// What build_mesh takes: positions [m], material coordinates [m] (empty without a chart), triangles.
struct TriangleSoup {
  std::vector<Vec3> positions;
  std::vector<Vec2> material;
  std::vector<Int3> triangles;
};

/// How the vertices of a rectangle lie. `staggered`: odd rows are shifted by half a spacing and their ends squared
/// off; with a height of (ny-1) sqrt(3)/2 spacings it is equilateral, hence isotropic in bending and for the
/// umbrella. `grid`: squares with one diagonal. `union_jack`: squares with alternating diagonals.
enum class Lattice { staggered, grid, union_jack };

/// nx x ny vertices, 2(nx-1)(ny-1) triangles, on [0, size.x] x [0, size.y] in the plane z = 0, normals up;
/// material coordinates equal x and y. Vertex j*nx + i is in row j. nx, ny >= 2.
TriangleSoup rectangle(int nx, int ny, const Vec2& size, Lattice lattice = Lattice::staggered);

/// Icosahedron refined `level` times (20 * 4^level triangles) and pushed to the sphere; normals outward.
TriangleSoup icosphere(int level, double radius);

/// Open tube about the z axis, from z = 0 to height, n_around x n_up vertices, rows staggered; normals outward.
/// It has no global chart.
TriangleSoup cylinder(double radius, double height, int n_around, int n_up);

/// Splits each triangle in four at the midpoints of its edges; material coordinates are halved as well.
TriangleSoup subdivide(const TriangleSoup& soup);

inline ShellMesh build_mesh(TriangleSoup soup) {
  return build_mesh(std::move(soup.positions), std::move(soup.material), std::move(soup.triangles));
}

}  // namespace wick::solid
