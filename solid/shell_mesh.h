#pragma once
/// Triangle mesh of a thin shell: topology, rest shape and the constants that follow from them.
#include <cstdint>
#include <string>
#include <vector>

#include "core/types.h"

namespace wick::solid {

/// Inner edge with its two triangles: x0-x1 is the edge, x2 and x3 the opposite vertices.
struct Hinge {
  std::array<std::int32_t, 4> vertex;
  std::array<std::int32_t, 2> triangle;
};

struct ShellMesh {
  std::vector<Vec3> rest;       ///< rest positions [m], V
  std::vector<Vec2> material;   ///< material coordinates [m], V; empty without a global chart
  std::vector<Int3> triangles;  ///< vertex indices, T
  // Derived by build_mesh:
  std::vector<Int2> edges;                    ///< unique, ascending
  std::vector<double> rest_length;            ///< per edge, in 3D rest space [m]
  std::vector<Hinge> hinges;                  ///< inner edges
  std::vector<Mat2> inverse_rest_edges;       ///< B = [X1-X0, X2-X0]^-1 per triangle [1/m]
  std::vector<double> rest_area;              ///< per triangle [m2]
  std::vector<double> vertex_area;            ///< a third of the incident areas [m2]
  std::vector<std::int32_t> incident_offset;  ///< V+1: triangles of vertex i are incident[offset[i]..offset[i+1])
  std::vector<std::int32_t> incident;
  std::vector<std::int32_t>
      component;  ///< connected component of each vertex, by number of first vertex order; -1: in no triangle

  [[nodiscard]] std::size_t vertex_count() const { return rest.size(); }
  [[nodiscard]] std::size_t triangle_count() const { return triangles.size(); }
  [[nodiscard]] bool has_chart() const { return !material.empty(); }
};

/// Builds all derived data. Without material coordinates each triangle is laid flat in a frame of its own
/// whose first axis does not depend on the order of its vertices (the projection of the world axis that the
/// triangle sees best), so that C is invariant under cyclic relabelling.
/// Throws Refusal (scene_invalid) naming the first bad triangle or vertex: index out of range, NaN, repeated
/// vertex, zero area, edge with three triangles, orientations that disagree, parts that meet in a vertex alone.
ShellMesh build_mesh(std::vector<Vec3> rest, std::vector<Vec2> material, std::vector<Int3> triangles);

/// The same sheet without the triangles where keep[t] == 0; vertex numbers stay, orphans belong to no triangle, and
/// what is left may meet in a vertex alone.
ShellMesh without_triangles(const ShellMesh& mesh, const std::vector<std::uint8_t>& keep);

/// The sheet of triangles that a cut has left of a mesh, with all derived data. What is left may meet in a vertex
/// alone, vertices may belong to no triangle. Throws Refusal where a triangle has no area.
ShellMesh rebuild_mesh(std::vector<Vec3> rest, std::vector<Vec2> material, std::vector<Int3> triangles);

/// Area-weighted vertex normals of positions x (V), zero for orphans.
std::vector<Vec3> vertex_normals(const ShellMesh& mesh, const std::vector<Vec3>& x);

}  // namespace wick::solid
