#include "solid/tear.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numeric>

#include "core/parallel.h"

namespace wick::solid {

namespace {

constexpr std::size_t kGrain = 1024;

/// U - 1 of one triangle as a tensor on its rest plane, in space.
Mat3 biot_strain(const ShellMesh& mesh, std::size_t t, const std::vector<Vec3>& x, double rest_scale) {
  const Int3& v = mesh.triangles[t];
  Mat32 now, rest;
  now << x[v[1]] - x[v[0]], x[v[2]] - x[v[0]];
  rest << mesh.rest[v[1]] - mesh.rest[v[0]], mesh.rest[v[2]] - mesh.rest[v[0]];
  const Mat32 f = now * mesh.inverse_rest_edges[t] / rest_scale;
  const Mat32 frame = rest * mesh.inverse_rest_edges[t];  // of the rest plane: orthonormal for isometric charts
  // The square root of a symmetric 2x2 matrix C: (C + sqrt(det C) 1) / sqrt(tr C + 2 sqrt(det C)).
  const Mat2 c = f.transpose() * f;
  const double root = std::sqrt(std::max(c.determinant(), 0.0));
  const double trace = std::sqrt(std::max(c.trace() + 2.0 * root, 1e-300));
  const Mat2 u = (c + root * Mat2::Identity()) / trace;
  return frame * (u - Mat2::Identity()) * frame.transpose();
}

/// Area-weighted means at the vertices; 0 where there is no triangle.
void gather(const ShellMesh& mesh, const std::vector<Mat3>& of_triangle, std::vector<Mat3>& of_vertex) {
  parallel_for(mesh.vertex_count(), kGrain, [&](std::size_t i) {
    Mat3 sum = Mat3::Zero();
    double area = 0.0;
    for (std::int32_t k = mesh.incident_offset[i]; k < mesh.incident_offset[i + 1]; ++k) {
      sum += mesh.rest_area[mesh.incident[k]] * of_triangle[mesh.incident[k]];
      area += mesh.rest_area[mesh.incident[k]];
    }
    of_vertex[i] = area > 0.0 ? Mat3(sum / area) : Mat3(Mat3::Zero());
  });
}

/// Those triangles of a vertex's star that lie on the far side of the plane through it across `direction`; none
/// where all do.
std::vector<std::int32_t> far_side(const ShellMesh& mesh, std::int32_t vertex, const Vec3& direction) {
  std::vector<std::int32_t> far;
  const std::int32_t first = mesh.incident_offset[vertex], end = mesh.incident_offset[vertex + 1];
  for (std::int32_t k = first; k < end; ++k) {
    const Int3& v = mesh.triangles[mesh.incident[k]];
    const Vec3 middle = (mesh.rest[v[0]] + mesh.rest[v[1]] + mesh.rest[v[2]]) / 3.0;
    if ((middle - mesh.rest[vertex]).dot(direction) > 0.0) far.push_back(mesh.incident[k]);
  }
  if (static_cast<std::int32_t>(far.size()) == end - first) far.clear();
  return far;
}

}  // namespace

std::vector<VertexStrain> vertex_strains(const ShellMesh& mesh, const std::vector<Vec3>& x,
                                         const std::vector<double>& rest_scale) {
  std::vector<Mat3> of_triangle(mesh.triangle_count()), of_vertex(mesh.vertex_count());
  parallel_for(mesh.triangle_count(), kGrain,
               [&](std::size_t t) { of_triangle[t] = biot_strain(mesh, t, x, rest_scale[t]); });
  gather(mesh, of_triangle, of_vertex);
  parallel_for(mesh.triangle_count(), kGrain, [&](std::size_t t) {
    const Int3& v = mesh.triangles[t];
    of_triangle[t] = (of_vertex[v[0]] + of_vertex[v[1]] + of_vertex[v[2]]) / 3.0;
  });
  gather(mesh, of_triangle, of_vertex);
  std::vector<VertexStrain> strains(mesh.vertex_count());
  parallel_for(mesh.vertex_count(), kGrain, [&](std::size_t i) {
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(of_vertex[i]);
    strains[i] = {solver.eigenvalues()[2], solver.eigenvectors().col(2)};
  });
  return strains;
}

MeshCut tear(const ShellMesh& mesh, const std::vector<VertexStrain>& strains, const std::vector<double>& strength,
             std::vector<Int3>& triangles) {
  std::vector<std::int32_t> over;
  for (std::size_t i = 0; i < strains.size(); ++i)
    if (strains[i].strain > strength[i]) over.push_back(static_cast<std::int32_t>(i));
  std::stable_sort(over.begin(), over.end(), [&](std::int32_t a, std::int32_t b) {
    return strains[a].strain * strength[b] > strains[b].strain * strength[a];
  });

  MeshCut cut;
  std::vector<std::uint8_t> relieved(over.empty() ? 0 : mesh.vertex_count(), 0);
  const auto relieve_star = [&](std::int32_t vertex, auto&& next) {
    for (std::int32_t k = mesh.incident_offset[vertex]; k < mesh.incident_offset[vertex + 1]; ++k)
      for (const std::int32_t i : mesh.triangles[mesh.incident[k]]) next(i);
  };
  CutSurface surface{mesh.rest, mesh.triangles, std::vector<double>(over.empty() ? 0 : mesh.vertex_count(), 0.0)};
  for (const std::int32_t vertex : over) {
    if (relieved[vertex]) continue;
    const std::vector<std::int32_t> far = far_side(mesh, vertex, strains[vertex].direction);
    if (far.empty()) continue;
    const Blend twin{static_cast<std::int32_t>(surface.rest.size()), vertex, vertex, 0.0};
    cut.blends.push_back(twin);
    surface.rest.push_back(Vec3(surface.rest[vertex]));
    surface.snapping.push_back(0.0);
    for (const std::int32_t t : far)
      std::replace(surface.triangles[t].begin(), surface.triangles[t].end(), vertex, twin.vertex);
    ++cut.born;
    relieve_star(vertex, [&](std::int32_t i) { relieve_star(i, [&](std::int32_t j) { relieved[j] = 1; }); });
  }
  if (!cut.any()) return cut;
  split_fans(surface, cut);
  triangles = std::move(surface.triangles);
  return cut;
}

}  // namespace wick::solid
