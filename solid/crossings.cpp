#include "solid/crossings.h"

#include <algorithm>
#include <mutex>
#include <tuple>

#include "core/parallel.h"
#include "solid/exact_predicates.h"

namespace wick::solid {

namespace {

/// Bounding box of an edge or a triangle.
struct Part {
  std::int32_t sheet, index;
  Vec3 low, high;
};

template <class Vertices>
Part part_of(std::int32_t sheet, std::int32_t index, const Vertices& vertices, const std::vector<Vec3>& x) {
  Part part{sheet, index, x[vertices[0]], x[vertices[0]]};
  for (const std::int32_t v : vertices) {
    part.low = part.low.cwiseMin(x[v]);
    part.high = part.high.cwiseMax(x[v]);
  }
  return part;
}

bool overlap(const Part& a, const Part& b) {
  return (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all();
}

/// Every edge and every triangle of the sheets.
struct Parts {
  std::vector<Part> edges, triangles;
};

Parts collect(std::span<const PosedSheet> sheets) {
  Parts parts;
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    const ShellMesh& mesh = *sheets[s].mesh;
    const auto sheet = static_cast<std::int32_t>(s);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
      parts.edges.push_back(part_of(sheet, static_cast<std::int32_t>(e), mesh.edges[e], *sheets[s].x));
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      parts.triangles.push_back(part_of(sheet, static_cast<std::int32_t>(t), mesh.triangles[t], *sheets[s].x));
  }
  return parts;
}

/// Tree of boxes over parts, cut at the median along the longest side; a node's first half follows it at once.
class BoxTree {
 public:
  explicit BoxTree(std::vector<Part> parts) : parts_(std::move(parts)) {
    if (!parts_.empty()) build(0, parts_.size());
  }

  /// Calls body(part) for every part whose box meets that of `query`.
  template <class Body>
  void for_overlaps(const Part& query, Body&& body) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const bool meets = overlap(node.bounds, query);
      if (meets && node.end - node.begin <= kLeaf)
        for (std::size_t k = node.begin; k < node.end; ++k)
          if (overlap(parts_[k], query)) body(parts_[k]);
      n = meets ? n + 1 : node.after;
    }
  }

 private:
  static constexpr std::size_t kLeaf = 8;
  struct Node {
    Part bounds;
    std::size_t begin, end;
    std::size_t after;  ///< the node that follows its last descendant
  };

  void build(std::size_t begin, std::size_t end) {
    Part bounds = parts_[begin];
    for (std::size_t k = begin + 1; k < end; ++k) {
      bounds.low = bounds.low.cwiseMin(parts_[k].low);
      bounds.high = bounds.high.cwiseMax(parts_[k].high);
    }
    const std::size_t node = nodes_.size();
    nodes_.push_back({bounds, begin, end, 0});
    if (end - begin > kLeaf) {
      int axis = 0;
      (bounds.high - bounds.low).maxCoeff(&axis);
      const std::size_t middle = begin + (end - begin) / 2;
      const auto at = [&](std::size_t k) { return parts_.begin() + static_cast<std::ptrdiff_t>(k); };
      std::nth_element(at(begin), at(middle), at(end),
                       [axis](const Part& a, const Part& b) { return a.low[axis] < b.low[axis]; });
      build(begin, middle);
      build(middle, end);
    }
    nodes_[node].after = nodes_.size();
  }

  std::vector<Part> parts_;
  std::vector<Node> nodes_;
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
  Parts parts = collect(sheets);
  const BoxTree edges(std::move(parts.edges));
  std::vector<Crossing> found;
  std::mutex mutex;
  parallel_chunks(parts.triangles.size(), kChunk, [&](std::size_t begin, std::size_t end) {
    std::vector<Crossing> here;
    for (std::size_t t = begin; t < end; ++t) {
      const Part& triangle = parts.triangles[t];
      edges.for_overlaps(triangle, [&](const Part& edge) {
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
