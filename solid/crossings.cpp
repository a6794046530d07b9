#include "solid/crossings.h"

#include <algorithm>
#include <mutex>
#include <tuple>

#include "core/parallel.h"
#include "solid/box_tree.h"
#include "solid/exact_predicates.h"

namespace wick::solid {

namespace {

/// An edge or a triangle of a sheet, and its bounding box.
struct Part {
  std::int32_t sheet, index;
};
struct Parts {
  std::vector<Part> parts;
  std::vector<Box> boxes;

  template <class Vertices>
  void add(std::size_t sheet, std::size_t index, const Vertices& vertices, const std::vector<Vec3>& x) {
    Box box;
    for (const std::int32_t v : vertices) box.add(x[v]);
    parts.push_back({static_cast<std::int32_t>(sheet), static_cast<std::int32_t>(index)});
    boxes.push_back(box);
  }
};

bool cross(std::span<const PosedSheet> sheets, const Part& edge, const Part& triangle) {
  const Int2& e = sheets[edge.sheet].mesh->edges[edge.index];
  const Int3& t = sheets[triangle.sheet].mesh->triangles[triangle.index];
  if (edge.sheet == triangle.sheet)
    for (const std::int32_t v : t)
      if (v == e[0] || v == e[1]) return false;
  const std::vector<Vec3>&x = *sheets[edge.sheet].x, &y = *sheets[triangle.sheet].x;
  return segment_meets_triangle(x[e[0]], x[e[1]], y[t[0]], y[t[1]], y[t[2]]);
}

}  // namespace

std::vector<Crossing> find_crossings(std::span<const PosedSheet> sheets) {
  constexpr std::size_t kChunk = 256;
  Parts edges, triangles;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    const ShellMesh& mesh = *sheets[s].mesh;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) edges.add(s, e, mesh.edges[e], *sheets[s].x);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) triangles.add(s, t, mesh.triangles[t], *sheets[s].x);
  }
  const BoxTree tree(edges.boxes);
  std::vector<Crossing> found;
  std::mutex mutex;
  parallel_chunks(triangles.parts.size(), kChunk, [&](std::size_t begin, std::size_t end) {
    std::vector<Crossing> here;
    for (std::size_t t = begin; t < end; ++t) {
      const Part& triangle = triangles.parts[t];
      tree.for_overlaps(triangles.boxes[t], [&](std::int32_t e) {
        const Part& edge = edges.parts[e];
        if (cross(sheets, edge, triangle)) here.push_back({edge.sheet, edge.index, triangle.sheet, triangle.index});
      });
    }
    const std::scoped_lock lock(mutex);
    found.insert(found.end(), here.begin(), here.end());
  });
  const auto key = [](const Crossing& c) {
    return std::make_tuple(c.triangle_sheet, c.triangle, c.edge_sheet, c.edge);
  };
  std::sort(found.begin(), found.end(), [&](const Crossing& a, const Crossing& b) { return key(a) < key(b); });
  return found;
}

}  // namespace wick::solid
