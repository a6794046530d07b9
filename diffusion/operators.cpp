#include "diffusion/operators.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace wick::diffusion {

namespace {

/// Position of neighbour j in row i.
std::size_t find_entry(const SheetGraph& graph, int i, int j) {
  const auto begin = graph.column.begin() + graph.offset[i], end = graph.column.begin() + graph.offset[i + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, j) - graph.column.begin());
}

void build_rows(const solid::ShellMesh& mesh, SheetGraph& graph) {
  // Count neighbours, then place them.
  const std::size_t vertices = mesh.vertex_count();
  graph.offset.assign(vertices + 1, 0);
  for (const Int2& e : mesh.edges)
    for (const int i : e) ++graph.offset[i + 1];
  std::partial_sum(graph.offset.begin(), graph.offset.end(), graph.offset.begin());
  graph.column.resize(2 * mesh.edges.size());
  graph.entry_edge.resize(2 * mesh.edges.size());
  std::vector<std::pair<std::int32_t, std::int32_t>> row(2 * mesh.edges.size());
  std::vector<std::int32_t> next(graph.offset.begin(), graph.offset.end() - 1);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    const auto [i, j] = mesh.edges[e];
    row[next[i]++] = {j, static_cast<std::int32_t>(e)};
    row[next[j]++] = {i, static_cast<std::int32_t>(e)};
  }

  // Sort each row, so that results do not depend on the order of the edge list.
  for (std::size_t i = 0; i < vertices; ++i)
    std::sort(row.begin() + graph.offset[i], row.begin() + graph.offset[i + 1]);
  for (std::size_t k = 0; k < row.size(); ++k) std::tie(graph.column[k], graph.entry_edge[k]) = row[k];
}

/// Groups by counting sort on the component number; vertices of no triangle are in no group.
void group_components(const solid::ShellMesh& mesh, SheetGraph& graph) {
  std::int32_t count = 0;
  for (const std::int32_t c : mesh.component) count = std::max(count, c + 1);
  graph.components.offset.assign(count + 1, 0);
  for (const std::int32_t c : mesh.component)
    if (c >= 0) ++graph.components.offset[c + 1];
  std::partial_sum(graph.components.offset.begin(), graph.components.offset.end(), graph.components.offset.begin());
  graph.components.vertex.resize(graph.components.offset.back());
  std::vector<std::int32_t> next(graph.components.offset.begin(), graph.components.offset.end() - 1);
  for (std::size_t i = 0; i < mesh.component.size(); ++i)
    if (const std::int32_t c = mesh.component[i]; c >= 0) graph.components.vertex[next[c]++] = static_cast<int>(i);

  graph.whole.vertex = graph.components.vertex;
  std::sort(graph.whole.vertex.begin(), graph.whole.vertex.end());
  graph.whole.offset = {0, static_cast<std::int32_t>(graph.whole.vertex.size())};
}

}  // namespace

SheetGraph build_graph(const solid::ShellMesh& mesh) {
  SheetGraph graph;
  build_rows(mesh, graph);
  graph.corner.assign(mesh.edges.size(), {-1, -1});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Int3& v = mesh.triangles[t];
      auto& corner = graph.corner[graph.entry_edge[find_entry(graph, v[(k + 1) % 3], v[(k + 2) % 3])]];
      corner[corner[0] < 0 ? 0 : 1] = static_cast<std::int32_t>(3 * t + k);
    }
  group_components(mesh, graph);
  return graph;
}

std::vector<double> corner_cotangents(const solid::ShellMesh& mesh, const std::vector<Vec3>& x) {
  // A triangle thinner than a thousandth of its rest area counts as that: collapsed and inverted ones stay finite.
  constexpr double least_area_ratio = 1e-3;
  std::vector<double> corner(3 * mesh.triangles.size());
  parallel_for(mesh.triangles.size(), chunk, [&](std::size_t t) {
    const Int3& v = mesh.triangles[t];
    const double area = 0.5 * (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]).norm();
    const double rest = mesh.rest_area[t], bounded = std::max(area, least_area_ratio * rest);
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = x[v[(k + 1) % 3]] - x[v[k]], b = x[v[(k + 2) % 3]] - x[v[k]];
      corner[3 * t + k] = 0.25 * a.dot(b) / bounded * (rest / bounded);
    }
  });
  return corner;
}

std::vector<double> tensor_corners(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, double gain) {
  // Beyond these ratios nothing is left to see of a direction, and the matrix would lose its digits.
  constexpr double least = 1e-3, most = 1e3;
  std::vector<double> corner(3 * mesh.triangles.size());
  parallel_for(mesh.triangles.size(), chunk, [&](std::size_t t) {
    const Int3& v = mesh.triangles[t];
    Mat32 edges;
    edges << x[v[1]] - x[v[0]], x[v[2]] - x[v[0]];
    const Mat2& inverse = mesh.inverse_rest_edges[t];
    const Mat32 gradient = edges * inverse;

    // Principal stretches and directions of FᵀF = C; D has the same directions.
    const Mat2 c = gradient.transpose() * gradient;
    const double mean = 0.5 * (c(0, 0) + c(1, 1)), skew = 0.5 * (c(0, 0) - c(1, 1));
    const double half = std::sqrt(skew * skew + c(0, 1) * c(0, 1));
    const auto diffusivity = [&](double squared) {
      return std::clamp(1.0 + gain * (std::sqrt(std::max(squared, 0.0)) - 1.0), least, most);
    };
    const double d1 = diffusivity(mean + half), d2 = diffusivity(mean - half);
    const Mat2 direction = half > 0.0 ? Mat2((c - mean * Mat2::Identity()) / half) : Mat2(Mat2::Zero());
    const Mat2 d = 0.5 * (d1 + d2) * Mat2::Identity() + 0.5 * (d1 - d2) * direction;

    // Gradients of the hat functions: rows of B for corners 1 and 2, minus their sum for corner 0.
    Eigen::Matrix<double, 3, 2> hat;
    hat.row(1) = inverse.row(0);
    hat.row(2) = inverse.row(1);
    hat.row(0) = -hat.row(1) - hat.row(2);
    for (int k = 0; k < 3; ++k)
      corner[3 * t + k] = -mesh.rest_area[t] * hat.row((k + 1) % 3) * d * hat.row((k + 2) % 3).transpose();
  });
  return corner;
}

namespace {

/// Areal amount of each triangle: harmonic mean of M_i/A_i, as for conductors in series.
void triangle_density(const solid::ShellMesh& mesh, const std::vector<double>& mass, std::vector<double>& density) {
  density.resize(mesh.triangles.size());
  parallel_for(density.size(), chunk, [&](std::size_t t) {
    double resistance = 0.0;
    bool conducts = true;
    for (const int i : mesh.triangles[t]) {
      conducts = conducts && mass[i] > 0.0;
      resistance += mesh.vertex_area[i] / mass[i];
    }
    density[t] = conducts ? 3.0 / resistance : 0.0;
  });
}

void build_cotan(const solid::ShellMesh& mesh, const SheetGraph& graph, bool clamp,
                 const std::vector<double>& corner, const std::vector<double>& mass, SheetOperator& result) {
  std::vector<double>& density = result.scratch;
  triangle_density(mesh, mass, density);
  parallel_for(mesh.edges.size(), chunk, [&](std::size_t e) {
    double weight = 0.0;
    for (const std::int32_t c : graph.corner[e])
      if (c >= 0) weight += density[c / 3] * corner[c];
    result.edge[e] = clamp ? std::max(weight, 0.0) : weight;
  });
  result.storage = mass;
}

/// Edge length in shape x; one that has collapsed counts as a thousandth of its rest length, so 1/d stays finite.
double bounded_length(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, std::size_t e) {
  const auto [i, j] = mesh.edges[e];
  return std::max((x[i] - x[j]).norm(), 1e-3 * mesh.rest_length[e]);
}

}  // namespace

void build_operator(const solid::ShellMesh& mesh, const SheetGraph& graph, const OperatorChoice& choice,
                    const std::vector<Vec3>& x, const std::vector<double>& corner, const std::vector<double>& mass,
                    SheetOperator& result) {
  const std::size_t edges = mesh.edges.size();
  result.edge.resize(edges);
  if (choice.kind == Operator::cotan) return build_cotan(mesh, graph, choice.clamp, corner, mass, result);

  // Gather lengths first; each vertex then adds its own, in row order.
  std::vector<double>& length = result.scratch;
  length.resize(edges);
  parallel_for(edges, chunk, [&](std::size_t e) { length[e] = bounded_length(mesh, x, e); });
  const double mean =
      edges == 0 ? 1.0 : sum_of(edges, [&](std::size_t e) { return length[e]; }) / static_cast<double>(edges);
  const bool umbrella = choice.kind == Operator::umbrella;
  parallel_for(edges, chunk, [&](std::size_t e) {
    result.edge[e] = umbrella ? 2.0 * choice.umbrella_factor / length[e] : 4.0 / (mean * mean);
  });
  result.storage.resize(mesh.vertex_count());
  parallel_for(mesh.vertex_count(), chunk, [&](std::size_t i) {
    double sum = 0.0;
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k)
      sum += umbrella ? length[graph.entry_edge[k]] : 1.0;
    result.storage[i] = sum;
  });
}

void assemble(const SheetGraph& graph, const SheetOperator& op, double diffusion, const std::vector<double>& extra,
              const std::vector<double>& factor, SheetMatrix& matrix) {
  const std::size_t vertices = op.storage.size();
  matrix.graph = &graph;
  matrix.diffusion = diffusion;
  for (auto* field : {&matrix.storage, &matrix.row_sum, &matrix.diagonal}) field->resize(vertices);
  matrix.entry.resize(graph.column.size());
  // Vertices that hold nothing get a storage that weighs nothing in sums, yet keeps the matrix regular.
  const double most = parallel_max(vertices, chunk, 0.0, [&](std::size_t begin, std::size_t end) {
    return *std::max_element(op.storage.begin() + static_cast<std::ptrdiff_t>(begin),
                             op.storage.begin() + static_cast<std::ptrdiff_t>(end));
  });
  const double nothing = most > 0.0 ? 1e-20 * most : 1.0;
  parallel_for(vertices, chunk, [&](std::size_t i) {
    const bool holds = op.storage[i] > 0.0;
    matrix.storage[i] = holds ? op.storage[i] : nothing;
    matrix.row_sum[i] = matrix.storage[i] + (holds && !extra.empty() ? extra[i] : 0.0);
    double sum = 0.0;
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
      const std::int32_t e = graph.entry_edge[k];
      const double value = diffusion * op.edge[e] * (factor.empty() ? 1.0 : factor[e]);
      matrix.entry[k] = -value;
      sum += value;
    }
    matrix.diagonal[i] = matrix.row_sum[i] + sum;
  });
}

double diffusive_outflow(const SheetMatrix& matrix, const std::vector<double>& u, std::size_t i) {
  double sum = 0.0;
  for (std::int32_t k = matrix.graph->offset[i]; k < matrix.graph->offset[i + 1]; ++k)
    sum -= matrix.entry[k] * (u[i] - u[matrix.graph->column[k]]);
  return sum;
}

}  // namespace wick::diffusion
