#pragma once
/// Marching triangles on a sheet: what lies below a level is trimmed away along its isocontour [Losasso, Irving,
/// Guendelman, Fedkiw 2006]. The level is linear on each triangle; material stays where it is positive.
///
/// Vertices close to the contour are moved onto it along an edge, on the rest shape and with all that they carry;
/// elsewhere a new vertex is put on each edge that the contour crosses. So no edge becomes much shorter than the
/// distance at which vertices are moved, however often a front that travels on is cut anew.
#include <cstdint>
#include <vector>

#include "core/types.h"

namespace wick::solid {

/// Whatever a vertex carries becomes value(a) + share (value(b) - value(a)). Blends are applied in their order; one
/// whose vertex is the number of vertices so far makes a new vertex.
struct Blend {
  std::int32_t vertex, a, b;
  double share;
};

template <class T>
void apply(const std::vector<Blend>& blends, std::vector<T>& values) {
  for (const Blend& blend : blends) {
    const T value = values[blend.a] + blend.share * (values[blend.b] - values[blend.a]);
    if (static_cast<std::size_t>(blend.vertex) < values.size())
      values[blend.vertex] = value;
    else
      values.push_back(value);
  }
}

/// Triangles to be cut, and where their vertices rest.
struct CutSurface {
  std::vector<Vec3> rest;        ///< V [m]
  std::vector<Int3> triangles;   ///< T, a manifold with or without rim, alike oriented
  std::vector<double> snapping;  ///< distance to the contour up to which a vertex is moved onto it [m], V
  /// Densities that are linear on each triangle, V each, with the least that each may be. They go along; where a
  /// vertex is moved, its value is that which keeps the integral over what stays.
  std::vector<std::vector<double>> density = {};
  std::vector<double> least = {};
};

struct MeshCut {
  std::vector<Blend> blends;
  std::size_t moved = 0, born = 0;    ///< vertices put onto the contour
  std::size_t removed = 0, made = 0;  ///< triangles
  [[nodiscard]] bool any() const { return !blends.empty() || removed > 0; }
};

/// Cuts `surface` along level = 0 (V), in place. Old vertices keep their numbers, new ones follow. A second cut
/// along the same level does nothing. Parts that would meet in one vertex alone get one each.
MeshCut cut_below(CutSurface& surface, std::vector<double> level);

/// Gives each fan of triangles around a vertex a vertex of its own, but for the first, and adds them to `cut`.
void split_fans(CutSurface& surface, MeshCut& cut);

/// Mean rest length of the edges at each vertex [m], V; 0 for vertices without an edge.
std::vector<double> edge_spacing(const std::vector<Vec3>& rest, const std::vector<Int2>& edges);

}  // namespace wick::solid
