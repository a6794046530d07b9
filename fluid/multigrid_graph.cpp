#include "fluid/multigrid_graph.h"

#include <cmath>
#include <cstring>
#include <numeric>

#include "core/parallel.h"

namespace wick::fluid {

std::int32_t Graph::beside(Int3 at, int side) const {
  const int a = side / 2;
  at[a] += side % 2 == 0 ? -1 : 1;
  if (at[a] < 0 || at[a] >= n[a]) {
    if (!wraps[a]) return -1;
    at[a] = at[a] < 0 ? n[a] - 1 : 0;
  }
  return box(at);
}

float Graph::regular_outside(const Int3& at, int side) const {
  const int a = side / 2;
  return open[side] && at[a] == (side % 2 == 0 ? 0 : n[a] - 1) ? 1.0F : 0.0F;
}

float Graph::outside_weight(const Int3& at, const Node& node) const {
  float sum = 0.0F;
  for (int side = 0; side < 6; ++side) {
    if (node.outside[side] == 0.0F) continue;
    const int a = side / 2;
    const float x = static_cast<float>(at[a]) + 0.5F + node.center[a];
    const float distance = side % 2 == 0 ? x : extent[a] - x;
    sum += stiffness[a] * node.outside[side] / distance;
  }
  return sum;
}

void Graph::clear() {
  for (const Record& record : records) state[record.box] = regular;
  for (const std::int32_t b : empties) state[b] = regular;
  records.clear();
  empties.clear();
  nodes.clear();
  links.clear();
}

Graph finest_graph(const Grid& grid, const Sides& sides) {
  Graph graph;
  graph.n = {grid.nx, grid.ny, grid.nz};
  for (int a = 0; a < 3; ++a) {
    graph.extent[a] = static_cast<float>(graph.n[a]);
    graph.halves[a] = graph.n[a] > 1;
    graph.wraps[a] = sides[2 * a] == Side::periodic && graph.n[a] > 1;
  }
  for (int side = 0; side < 6; ++side) graph.open[side] = sides[side] == Side::open;
  graph.state.assign(grid.cells(), Graph::regular);
  return graph;
}

Graph coarser_graph(const Graph& fine) {
  Graph graph;
  for (int a = 0; a < 3; ++a) {
    graph.n[a] = (fine.n[a] + 1) / 2;
    graph.extent[a] = fine.halves[a] ? 0.5F * fine.extent[a] : fine.extent[a];
    // Relative to the coarsened axes, whose coefficient is kept at 1, thin slabs get stiffer across:
    // area grows with every coarsened axis, distance does not.
    graph.stiffness[a] = fine.halves[a] ? fine.stiffness[a] : 4.0F * fine.stiffness[a];
    graph.halves[a] = graph.n[a] > 1;
    graph.wraps[a] = fine.wraps[a] && graph.n[a] > 1;
  }
  graph.open = fine.open;
  graph.finest = false;
  graph.state.assign(std::size_t(graph.n[0]) * graph.n[1] * graph.n[2], Graph::regular);
  return graph;
}

namespace {

/// What the finest level asks of the walls.
class FaceMap {
 public:
  FaceMap(const Grid& grid, const Walls& walls, const Graph& graph, const std::vector<Graph::WeakFace>& weak)
      : grid_(grid), walls_(walls), graph_(graph) {
    for (const Graph::WeakFace& face : weak) {
      auto& weights = weak_[face.axis];
      if (weights.empty()) weights.assign(grid.faces(face.axis), 0.0F);
      weights[face.face] += face.weight;
    }
  }

  [[nodiscard]] bool solid(std::int32_t cell) const { return walls_.solid[cell] != 0; }

  /// Area of the face of fluid cell `at` on a side: 1 open, 0 closed, the coefficient of a weak face.
  [[nodiscard]] float area(const Int3& at, int side) const {
    const int a = side / 2;
    const std::int32_t other = graph_.beside(at, side);
    if (other >= 0 && solid(other)) return 0.0F;
    if (other < 0 && graph_.regular_outside(at, side) == 0.0F) return 0.0F;
    Int3 face = at;
    face[a] += side % 2;
    // A periodic face is stored twice; either copy may name it closed.
    const bool twice = graph_.wraps[a] && (face[a] == 0 || face[a] == graph_.n[a]);
    Int3 twin = face;
    if (twice) twin[a] = graph_.n[a] - face[a];
    if (!closed(a, face) && !closed(a, twin)) return 1.0F;
    return weak(a, face) + (twice ? weak(a, twin) : 0.0F);
  }

  /// Whether a face of positive area is a weak one.
  [[nodiscard]] bool yields(const Int3& at, int side) const {
    const int a = side / 2;
    Int3 face = at;
    face[a] += side % 2;
    if (closed(a, face)) return true;
    if (!graph_.wraps[a] || (face[a] != 0 && face[a] != graph_.n[a])) return false;
    face[a] = graph_.n[a] - face[a];
    return closed(a, face);
  }

  /// Cells of row (j, k) that are solid or have a closed face, appended to `cells`. `marks` is work space.
  void touched_in_row(int j, int k, std::vector<std::uint8_t>& marks, std::vector<std::int32_t>& cells) const {
    const int nx = grid_.nx;
    marks.assign(nx + 8, 0);
    const auto add = [&](const std::uint8_t* row) {
      for (int i = 0; i < nx; ++i) marks[i] |= row[i];
    };
    // Faces of the row, and both copies of periodic ones.
    const std::uint8_t* x = walls_.closed[0].data() + grid_.face(0, 0, j, k);
    add(x);
    add(x + 1);
    if (graph_.wraps[0]) marks[0] |= x[nx], marks[nx - 1] |= x[0];
    for (const int jj : {j, j + 1}) add_faces(1, jj, k, add);
    for (const int kk : {k, k + 1}) add_faces(2, j, kk, add);
    // Solid cells close their faces, marked or not.
    const std::uint8_t* solids = walls_.solid.data() + grid_.cell(0, j, k);
    add(solids);
    for (int i = 1; i < nx; ++i) marks[i] |= solids[i - 1], marks[i - 1] |= solids[i];
    if (graph_.wraps[0]) marks[0] |= solids[nx - 1], marks[nx - 1] |= solids[0];
    for (const int side : {2, 3, 4, 5})
      if (const std::int32_t other = graph_.beside({0, j, k}, side); other >= 0) add(walls_.solid.data() + other);

    for (int i = 0; i < nx; i += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, marks.data() + i, 8);
      if (eight == 0) continue;
      for (int m = i; m < std::min(i + 8, nx); ++m)
        if (marks[m] != 0 && touched({m, j, k})) cells.push_back(graph_.box({m, j, k}));
    }
  }

 private:
  [[nodiscard]] bool closed(int a, const Int3& face) const {
    return walls_.closed[a][grid_.face(a, face[0], face[1], face[2])] != 0;
  }
  [[nodiscard]] float weak(int a, const Int3& face) const {
    return weak_[a].empty() ? 0.0F : weak_[a][grid_.face(a, face[0], face[1], face[2])];
  }

  /// Adds the marks of a row of y or z faces, and of its other copy.
  template <class Add>
  void add_faces(int a, int j, int k, Add&& add) const {
    add(walls_.closed[a].data() + grid_.face(a, 0, j, k));
    Int3 at = {0, j, k};
    if (!graph_.wraps[a] || (at[a] != 0 && at[a] != graph_.n[a])) return;
    at[a] = graph_.n[a] - at[a];
    add(walls_.closed[a].data() + grid_.face(a, 0, at[1], at[2]));
  }

  [[nodiscard]] bool touched(const Int3& at) const {
    if (solid(graph_.box(at))) return true;
    for (int side = 0; side < 6; ++side) {
      const float usual = graph_.beside(at, side) >= 0 ? 1.0F : graph_.regular_outside(at, side);
      if (area(at, side) != usual) return true;
    }
    return false;
  }

  const Grid& grid_;
  const Walls& walls_;
  const Graph& graph_;
  std::array<std::vector<float>, 3> weak_;
};

}  // namespace

void build_finest(const Grid& grid, const Walls& walls, const std::vector<Graph::WeakFace>& weak, Graph& graph) {
  graph.clear();
  const FaceMap faces(grid, walls, graph, weak);

  // Find the cells that walls touch, a plane at a time.
  std::vector<std::vector<std::int32_t>> touched(grid.nz);
  parallel_for(grid.nz, 2, [&](std::size_t k) {
    std::vector<std::uint8_t> marks;
    for (int j = 0; j < grid.ny; ++j) faces.touched_in_row(j, static_cast<int>(k), marks, touched[k]);
  });
  for (const auto& plane : touched)
    for (const std::int32_t cell : plane) {
      if (faces.solid(cell)) {
        graph.state[cell] = Graph::empty;
        graph.empties.push_back(cell);
        continue;
      }
      const auto number = static_cast<std::uint32_t>(graph.records.size());
      graph.state[cell] = static_cast<std::int32_t>(number);
      graph.records.push_back({.box = cell, .node_begin = number, .node_count = 1, .child_local = {}});
    }

  // One node a cell, up to six links each.
  graph.nodes.assign(graph.records.size(), {});
  graph.links.resize(6 * graph.records.size());
  parallel_for(graph.records.size(), 1024, [&](std::size_t r) {
    const Int3 at = graph.place(graph.records[r].box);
    Graph::Node& node = graph.nodes[r];
    node.link_begin = node.link_end = static_cast<std::uint32_t>(6 * r);
    for (int side = 0; side < 6; ++side) {
      const float area = faces.area(at, side);
      const std::int32_t other = graph.beside(at, side);
      if (other < 0)
        node.outside[side] = area;
      else if (area > 0.0F)
        graph.links[node.link_end++] = {.box = other,
                                        .local = 0,
                                        .area = area,
                                        .weight = area,
                                        .side = static_cast<std::uint8_t>(side),
                                        .weak = faces.yields(at, side)};
    }
  });
}

namespace {

/// Cells on the two sides of a face; -1: outside the box.
std::array<std::int32_t, 2> cells_beside(const Graph& graph, const Graph::WeakFace& weak) {
  const int a = weak.axis;
  const std::int64_t nx = graph.n[0] + (a == 0), ny = graph.n[1] + (a == 1);
  Int3 high = {int(weak.face % nx), int(weak.face / nx % ny), int(weak.face / (nx * ny))}, low = high;
  --low[a];
  if (graph.wraps[a] && low[a] < 0) low[a] = graph.n[a] - 1;
  if (graph.wraps[a] && high[a] == graph.n[a]) high[a] = 0;
  return {low[a] < 0 ? -1 : graph.box(low), high[a] == graph.n[a] ? -1 : graph.box(high)};
}

/// Makes one of parts that have a weak face between them; what such a face joins to an open part is open.
void merge_parts(const Graph& finest, const std::vector<Graph::WeakFace>& weak, std::vector<std::int32_t>& part,
                 int& parts) {
  // The last entry stands for the open part.
  std::vector<std::int32_t> root(parts + 1);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t n) {
    while (root[n] != n) n = root[n];
    return n;
  };
  for (const Graph::WeakFace& face : weak) {
    if (face.weight <= 0.0F) continue;
    const auto [low, high] = cells_beside(finest, face);
    const auto part_of = [&](std::int32_t c) { return find(c >= 0 && part[c] >= 0 ? part[c] : parts); };
    const std::int32_t a = part_of(low), b = part_of(high);
    root[std::min(a, b)] = std::max(a, b);
  }
  std::vector<std::int32_t> number(parts + 1, -1);
  int left = 0;
  for (std::int32_t n = 0; n < parts; ++n)
    if (root[n] == n) number[n] = left++;
  for (std::int32_t n = 0; n < parts; ++n) number[n] = number[find(n)];
  for (std::int32_t& p : part)
    if (p >= 0) p = number[p];
  parts = left;
  if (parts == 0) part.clear();
}

}  // namespace

std::vector<std::int32_t> closed_parts(const std::vector<Graph>& graphs, const std::vector<Graph::WeakFace>& weak,
                                       int& parts) {
  parts = 0;
  const Graph& last = graphs.back();
  const auto any_outside = [](const Graph::Node& node) {
    return std::any_of(node.outside.begin(), node.outside.end(), [](float area) { return area > 0.0F; });
  };
  // Number the nodes of the single last box that no open side holds.
  std::vector<std::int32_t> box_label(1, -1), node_label(last.nodes.size(), -1);
  if (last.state[0] == Graph::regular && std::none_of(last.open.begin(), last.open.end(), [](bool o) { return o; }))
    box_label[0] = parts++;
  for (std::size_t n = 0; n < last.nodes.size(); ++n)
    if (!any_outside(last.nodes[n])) node_label[n] = parts++;
  if (parts == 0) return {};

  // Hand the numbers down to the finer nodes.
  for (std::size_t l = graphs.size() - 1; l-- > 0;) {
    const Graph &fine = graphs[l], &coarse = graphs[l + 1];
    std::vector<std::int32_t> finer_box(fine.state.size(), -1), finer_node(fine.nodes.size(), -1);
    const auto of_parent = [&](std::int32_t parent, std::int32_t local) {
      return coarse.state[parent] >= 0                ? node_label[coarse.node_of(parent, local)]
             : coarse.state[parent] == Graph::regular ? box_label[parent]
                                                      : -1;
    };
    parallel_for(fine.state.size(), 1U << 14, [&](std::size_t f) {
      const auto b = static_cast<std::int32_t>(f);
      const Int3 at = fine.place(b);
      const std::int32_t parent = coarse.box({at[0] / 2, at[1] / 2, at[2] / 2});
      const int q = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
      if (fine.state[f] == Graph::regular)
        finer_box[f] =
            of_parent(parent, coarse.state[parent] >= 0 ? coarse.records[coarse.state[parent]].child_local[q] : 0);
      if (fine.state[f] < 0) return;
      const Graph::Record& record = fine.records[fine.state[f]];
      for (std::uint32_t m = 0; m < record.node_count; ++m)
        finer_node[record.node_begin + m] = of_parent(parent, fine.nodes[record.node_begin + m].parent);
      finer_box[f] = finer_node[record.node_begin];
    });
    box_label.swap(finer_box);
    node_label.swap(finer_node);
  }
  if (graphs.size() == 1 && !node_label.empty()) box_label[0] = node_label[0];
  merge_parts(graphs.front(), weak, box_label, parts);
  return box_label;
}

}  // namespace wick::fluid
