#include "coupling/mesh_resolution.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/function_ref.h"

namespace wick::coupling {

namespace {

/// A point of the surface and what it stands for.
struct SurfacePoint {
  Vec3 x, normal;  ///< normal: unit, outward
  double area;     ///< [m2]
};

Vec3 area_vector(const std::vector<Vec3>& x, const Int3& t) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

/// Visits points of every triangle, the middles of n x n equal parts of it, none much wider than `step` unless the
/// triangle is a sliver: of those the points are as many as their area asks for.
void for_each_point(const std::vector<Vec3>& x, const std::vector<Int3>& triangles, double step,
                    FunctionRef<void(const SurfacePoint&)> visit) {
  double volume = 0.0;  // six times it; negative where all triangles are turned inside out
  for (const Int3& t : triangles) volume += x[t[0]].dot(x[t[1]].cross(x[t[2]]));
  for (const Int3& t : triangles) {
    const Vec3 area = area_vector(x, t);
    if (!(area.norm() > 0.0)) continue;
    const Vec3 a = x[t[0]], u = x[t[1]] - a, v = x[t[2]] - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const double wanted = std::min(longest / step, 2.0 + std::sqrt(8.0 * area.norm()) / step);
    const int n = std::max(1, static_cast<int>(std::ceil(wanted)));
    const Vec3 normal = area.normalized() * (volume < 0.0 ? -1.0 : 1.0);
    const double share = area.norm() / (double(n) * n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        visit({a + (u * (i + 1.0 / 3) + v * (j + 1.0 / 3)) / n, normal, share});
        if (i + j + 1 < n) visit({a + (u * (i + 2.0 / 3) + v * (j + 2.0 / 3)) / n, normal, share});
      }
  }
}

/// Way from `from` along the unit vector `along` to the triangle, and the triangle's normal; infinite where the
/// line passes it by.
double way_to(const Vec3& from, const Vec3& along, const std::vector<Vec3>& x, const Int3& t) {
  const Vec3 u = x[t[1]] - x[t[0]], v = x[t[2]] - x[t[0]], p = along.cross(v);
  const double det = u.dot(p);
  constexpr double missed = std::numeric_limits<double>::infinity();
  if (det == 0.0) return missed;
  const Vec3 d = from - x[t[0]], q = d.cross(u);
  const double b = d.dot(p) / det, c = along.dot(q) / det;
  return b >= 0.0 && c >= 0.0 && b + c <= 1.0 ? v.dot(q) / det : missed;
}

/// Thickness of the mesh behind a point, where it is less than `most` and what is behind faces the other way;
/// infinite elsewhere.
double thickness_at(const SurfacePoint& point, const std::vector<Vec3>& x, const std::vector<Int3>& triangles,
                    double most) {
  // Sides that meet at less than 25 degrees are those of a plate or a blade; others form an edge.
  constexpr double plate = 0.9;
  double nearest = most;
  bool faces_away = false;
  for (const Int3& t : triangles) {
    const double way = way_to(point.x, -point.normal, x, t);
    // The point's own triangle, met again by rounding, is no other side.
    if (!(way > 1e-6 * most && way < nearest)) continue;
    nearest = way;
    faces_away = std::abs(area_vector(x, t).normalized().dot(point.normal)) > plate;
  }
  return faces_away ? nearest : std::numeric_limits<double>::infinity();
}

/// Edges of the mesh at which it is a blade: two sides that meet at less than 60 degrees.
std::vector<std::pair<Vec3, Vec3>> blades(const std::vector<Vec3>& x, const std::vector<Int3>& triangles) {
  std::map<Int2, Vec3> normal_beside;
  std::vector<std::pair<Vec3, Vec3>> found;
  for (const Int3& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = area_vector(x, t).normalized();
      const int a = t[k], b = t[(k + 1) % 3];
      const auto [other, first] = normal_beside.try_emplace({std::min(a, b), std::max(a, b)}, normal);
      if (!first && other->second.dot(normal) < -0.5) found.emplace_back(x[a], x[b]);
    }
  return found;
}

double distance_to(const std::pair<Vec3, Vec3>& edge, const Vec3& x) {
  const Vec3 along = edge.second - edge.first;
  const double share = std::clamp((x - edge.first).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (edge.first + share * along - x).norm();
}

}  // namespace

MeshResolution resolution_of(const Obstacle& body, double spacing, const std::vector<Vec3>& positions,
                             const std::vector<Int3>& triangles) {
  constexpr double kMostPoints = 4e5;
  constexpr std::size_t kMostLines = 1000;  // each looks at every triangle
  constexpr double kThin = 1.9;             // spacings; two with room for rounding
  constexpr double kTip = 6.0;              // spacings
  constexpr double kSmallTip = 0.05;        // of the whole body
  const double h = spacing;
  Eigen::AlignedBox3d box;
  for (const Vec3& corner : positions) box.extend(corner);
  const double tip = std::max(kTip * h, kSmallTip * box.diagonal().norm());
  double area = 0.0;
  for (const Int3& t : triangles) area += area_vector(positions, t).norm();
  std::vector<SurfacePoint> doubtful;
  for_each_point(positions, triangles, std::max(h, std::sqrt(area / kMostPoints)), [&](const SurfacePoint& p) {
    if (!(sample_distance(body, p.x - 0.25 * h * p.normal).distance < -0.02 * h)) doubtful.push_back(p);
  });

  const std::vector<std::pair<Vec3, Vec3>> sharp = blades(positions, triangles);
  MeshResolution found;
  found.thickness = std::numeric_limits<double>::infinity();
  const std::size_t stride = 1 + doubtful.size() / kMostLines;
  for (std::size_t i = 0; i < doubtful.size(); i += stride) {
    const Vec3& x = doubtful[i].x;
    const double thickness = thickness_at(doubtful[i], positions, triangles, kThin * h);
    if (!std::isfinite(thickness)) continue;
    if (std::any_of(sharp.begin(), sharp.end(), [&](const auto& edge) { return distance_to(edge, x) < tip; }))
      continue;
    found.lost_area += static_cast<double>(stride) * doubtful[i].area;
    if (thickness >= found.thickness) continue;
    found.thickness = thickness;
    found.where = x;
  }
  for (const Int3& t : triangles)
    for (const int i : t) found.rounding = std::max(found.rounding, sample_distance(body, positions[i]).distance);
  return found;
}

}  // namespace wick::coupling
