#include "solid/shell_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/require.h"

namespace wick::solid {

namespace {

/// A triangle whose area is below this share of its longest edge squared is refused: its inverse edge
/// matrix would have lost half of the digits of a double.
constexpr double kSmallestAreaRatio = 1e-8;

std::string name_of(std::size_t triangle) {
  return "triangle " + std::to_string(triangle) + " (counted from 0)";
}

void refuse(std::size_t triangle, const std::string& what) {
  require(false, "", name_of(triangle) + " " + what);
}

void check_indices(const ShellMesh& mesh) {
  const auto count = static_cast<std::int64_t>(mesh.rest.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Int3& v = mesh.triangles[t];
    for (const int i : v)
      if (i < 0 || i >= count)
        refuse(t, "names vertex " + std::to_string(i) + " (the mesh has " + std::to_string(count) +
                      ") check the file");
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) refuse(t, "names a vertex twice (it has no area) remove it");
  }
}

void check_finite(const ShellMesh& mesh) {
  require(mesh.material.empty() || mesh.material.size() == mesh.rest.size(), "",
          "material coordinates: " + std::to_string(mesh.material.size()) + " for " +
              std::to_string(mesh.rest.size()) + " vertices (there must be one each, or none)");
  // Squares of squares of lengths are formed below; beyond this they would overflow.
  constexpr double largest = 1e60;
  for (std::size_t i = 0; i < mesh.rest.size(); ++i) {
    const bool good = mesh.rest[i].cwiseAbs().maxCoeff() < largest && mesh.rest[i].allFinite() &&
                      (mesh.material.empty() ||
                       (mesh.material[i].allFinite() && mesh.material[i].cwiseAbs().maxCoeff() < largest));
    require(good, "", "vertex " + std::to_string(i) + " (counted from 0) is not a finite position");
  }
}

bool precedes(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// Orthonormal frame (columns) in the plane of the triangle: the projection of the world axis nearest to
/// that plane, and the normal times it. The sums start at the corner whose position is lexicographically
/// smallest, so that not a bit depends on the numbering of the vertices.
Mat32 plane_frame(const std::array<Vec3, 3>& p) {
  int first = 0;
  for (int k = 1; k < 3; ++k)
    if (precedes(p[k], p[first])) first = k;
  const Vec3& origin = p[first];
  const Vec3 normal = (p[(first + 1) % 3] - origin).cross(p[(first + 2) % 3] - origin).normalized();
  // An axis must be nearer to the plane by more than rounding to be preferred to the one before it;
  // without this a sheet in a coordinate plane would change its axis from triangle to triangle.
  constexpr double tie = 1e-6;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(normal[k]) < std::abs(normal[axis]) - tie) axis = k;
  Mat32 frame;
  frame.col(0) = (Vec3::Unit(axis) - normal * normal[axis]).normalized();
  frame.col(1) = normal.cross(Vec3(frame.col(0)));
  return frame;
}

void lay_flat(ShellMesh& mesh, std::size_t t) {
  const Int3& v = mesh.triangles[t];
  const std::array<Vec3, 3> p = {mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]]};
  const Vec3 a = p[1] - p[0], b = p[2] - p[0];
  const double longest2 = std::max({a.squaredNorm(), b.squaredNorm(), (p[2] - p[1]).squaredNorm()});
  if (!(0.5 * a.cross(b).norm() > kSmallestAreaRatio * longest2))
    refuse(t, "has no area (its corners are on a line) remove it or move a corner");
  Mat2 edges;
  if (mesh.has_chart()) {
    edges.col(0) = mesh.material[v[1]] - mesh.material[v[0]];
    edges.col(1) = mesh.material[v[2]] - mesh.material[v[0]];
  } else {
    const Mat32 frame = plane_frame(p);
    edges.col(0) = frame.transpose() * a;
    edges.col(1) = frame.transpose() * b;
  }
  const double det = edges(0, 0) * edges(1, 1) - edges(0, 1) * edges(1, 0);
  if (!(0.5 * std::abs(det) > kSmallestAreaRatio * edges.colwise().squaredNorm().maxCoeff()))
    refuse(t, "has no area in material coordinates (its corners are on a line there)");
  Mat2& inverse = mesh.inverse_rest_edges[t];
  inverse << edges(1, 1), -edges(0, 1), -edges(1, 0), edges(0, 0);
  inverse /= det;
  mesh.rest_area[t] = 0.5 * std::abs(det);
}

struct HalfEdge {
  std::int32_t low, high, triangle, opposite;
  bool forward;  ///< the triangle runs from low to high
};

/// Half edges in the order (low, high): bucketed by the low vertex, then sorted inside each small bucket.
std::vector<HalfEdge> sorted_half_edges(const ShellMesh& mesh) {
  std::vector<std::int32_t> offset(mesh.vertex_count() + 1, 0);
  for (const Int3& v : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++offset[std::min(v[k], v[(k + 1) % 3]) + 1];
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  std::vector<HalfEdge> halves(3 * mesh.triangle_count());
  std::vector<std::int32_t> next(offset.begin(), offset.end() - 1);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Int3& v = mesh.triangles[t];
      const int a = v[k], b = v[(k + 1) % 3];
      halves[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t),
                                        v[(k + 2) % 3], a < b};
    }
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i)
    std::sort(halves.begin() + offset[i], halves.begin() + offset[i + 1], [](const HalfEdge& a, const HalfEdge& b) {
      return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
  return halves;
}

void find_edges(ShellMesh& mesh) {
  const std::vector<HalfEdge> halves = sorted_half_edges(mesh);
  mesh.edges.clear();
  mesh.rest_length.clear();
  mesh.hinges.clear();
  mesh.edges.reserve(halves.size() / 2 + 1);
  mesh.rest_length.reserve(halves.size() / 2 + 1);
  mesh.hinges.reserve(halves.size() / 2 + 1);
  for (std::size_t i = 0, end = 0; i < halves.size(); i = end) {
    const HalfEdge& a = halves[i];
    for (end = i + 1; end < halves.size() && halves[end].low == a.low && halves[end].high == a.high;) ++end;
    const std::string edge = "edge " + std::to_string(a.low) + "-" + std::to_string(a.high);
    if (end - i > 2)
      refuse(halves[i + 2].triangle,
             "shares " + edge + " with two others (a sheet has at most two at an edge) split it");
    mesh.edges.push_back({a.low, a.high});
    mesh.rest_length.push_back((mesh.rest[a.high] - mesh.rest[a.low]).norm());
    if (end - i < 2) continue;
    const HalfEdge& b = halves[i + 1];
    if (a.forward == b.forward)
      refuse(b.triangle, "is turned the other way round than its neighbour " + std::to_string(a.triangle) +
                             " across " + edge + " (both run along it in the same direction) flip one");
    const HalfEdge& front = a.forward ? a : b;
    const HalfEdge& back = a.forward ? b : a;
    mesh.hinges.push_back({{a.low, a.high, front.opposite, back.opposite}, {front.triangle, back.triangle}});
  }
}

void find_incidence(ShellMesh& mesh) {
  mesh.incident_offset.assign(mesh.vertex_count() + 1, 0);
  mesh.vertex_area.assign(mesh.vertex_count(), 0.0);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (const int i : mesh.triangles[t]) {
      ++mesh.incident_offset[i + 1];
      mesh.vertex_area[i] += mesh.rest_area[t] / 3.0;
    }
  std::partial_sum(mesh.incident_offset.begin(), mesh.incident_offset.end(), mesh.incident_offset.begin());
  mesh.incident.resize(3 * mesh.triangle_count());
  std::vector<std::int32_t> next(mesh.incident_offset.begin(), mesh.incident_offset.end() - 1);
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    for (const int i : mesh.triangles[t]) mesh.incident[next[i]++] = static_cast<std::int32_t>(t);
}

void find_components(ShellMesh& mesh) {
  mesh.component.assign(mesh.vertex_count(), -1);
  std::vector<std::int32_t> stack;
  std::int32_t count = 0;
  for (std::size_t seed = 0; seed < mesh.vertex_count(); ++seed) {
    if (mesh.component[seed] >= 0 || mesh.incident_offset[seed] == mesh.incident_offset[seed + 1]) continue;
    mesh.component[seed] = count;
    stack.push_back(static_cast<std::int32_t>(seed));
    while (!stack.empty()) {
      const std::int32_t i = stack.back();
      stack.pop_back();
      for (std::int32_t k = mesh.incident_offset[i]; k < mesh.incident_offset[i + 1]; ++k)
        for (const int j : mesh.triangles[mesh.incident[k]])
          if (mesh.component[j] < 0) {
            mesh.component[j] = count;
            stack.push_back(j);
          }
    }
    ++count;
  }
}

void derive_topology(ShellMesh& mesh) {
  find_edges(mesh);
  find_incidence(mesh);
  find_components(mesh);
}

/// Refuses a vertex where parts meet that share no edge there: there is no way round it from one to the other, so
/// it has no normal and no hinge holds the parts together. Corners of triangles are joined across the hinges at
/// their vertex; each vertex must be left with one set of corners.
void require_one_fan(const ShellMesh& mesh) {
  std::vector<std::int32_t> parent(3 * mesh.triangle_count());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  const auto corner = [&](std::int32_t triangle, std::int32_t vertex) {
    const Int3& v = mesh.triangles[triangle];
    return 3 * triangle + (v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2);
  };
  for (const Hinge& hinge : mesh.hinges)
    for (const std::int32_t end : {hinge.vertex[0], hinge.vertex[1]})
      parent[root(corner(hinge.triangle[0], end))] = root(corner(hinge.triangle[1], end));
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const auto vertex = static_cast<std::int32_t>(i);
    const std::int32_t first = mesh.incident_offset[i], end = mesh.incident_offset[i + 1];
    for (std::int32_t k = first + 1; k < end; ++k)
      require(root(corner(mesh.incident[k], vertex)) == root(corner(mesh.incident[first], vertex)), "",
              "vertex " + std::to_string(i) + " (counted from 0) joins triangles " +
                  std::to_string(mesh.incident[first]) + " and " + std::to_string(mesh.incident[k]) +
                  " at a point alone (parts of a sheet must share edges) give each part a vertex of its own");
  }
}

}  // namespace

ShellMesh rebuild_mesh(std::vector<Vec3> rest, std::vector<Vec2> material, std::vector<Int3> triangles) {
  ShellMesh mesh;
  mesh.rest = std::move(rest);
  mesh.material = std::move(material);
  mesh.triangles = std::move(triangles);
  check_finite(mesh);
  check_indices(mesh);
  mesh.inverse_rest_edges.resize(mesh.triangle_count());
  mesh.rest_area.resize(mesh.triangle_count());
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) lay_flat(mesh, t);
  derive_topology(mesh);
  return mesh;
}

ShellMesh build_mesh(std::vector<Vec3> rest, std::vector<Vec2> material, std::vector<Int3> triangles) {
  // Half edges are counted in 32 bits.
  constexpr std::size_t most = 700'000'000;
  require(triangles.size() <= most && rest.size() <= most, "",
          "mesh: too many vertices or triangles (the limit is 7e8)");
  ShellMesh mesh = rebuild_mesh(std::move(rest), std::move(material), std::move(triangles));
  require_one_fan(mesh);
  return mesh;
}

ShellMesh without_triangles(const ShellMesh& mesh, const std::vector<std::uint8_t>& keep) {
  ShellMesh result;
  result.rest = mesh.rest;
  result.material = mesh.material;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    if (!keep[t]) continue;
    result.triangles.push_back(mesh.triangles[t]);
    result.inverse_rest_edges.push_back(mesh.inverse_rest_edges[t]);
    result.rest_area.push_back(mesh.rest_area[t]);
  }
  derive_topology(result);
  return result;
}

std::vector<Vec3> vertex_normals(const ShellMesh& mesh, const std::vector<Vec3>& x) {
  std::vector<Vec3> normals(mesh.vertex_count(), Vec3::Zero());
  for (const Int3& v : mesh.triangles) {
    const Vec3 area_vector = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]);
    for (const int i : v) normals[i] += area_vector;
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    n = length > 0.0 ? Vec3(n / length) : Vec3::Zero();
  }
  return normals;
}

}  // namespace wick::solid
