#include "diffusion/front.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wick::diffusion {

namespace {

/// Position of the edge {a, b} in the ascending list of edges.
std::int32_t edge_number(const solid::ShellMesh& mesh, std::int32_t a, std::int32_t b) {
  const Int2 key = {std::min(a, b), std::max(a, b)};
  return static_cast<std::int32_t>(std::lower_bound(mesh.edges.begin(), mesh.edges.end(), key) -
                                   mesh.edges.begin());
}

/// Which crossed edge follows which: each triangle that the front passes leads from one of its edges to another.
struct Links {
  std::vector<std::int32_t> next, previous;  ///< per edge, -1: none
};

Links link_crossed_edges(const solid::ShellMesh& mesh, const std::vector<std::uint8_t>& passed) {
  Links links{std::vector<std::int32_t>(mesh.edges.size(), -1), std::vector<std::int32_t>(mesh.edges.size(), -1)};
  for (const Int3& v : mesh.triangles) {
    std::int32_t enter = -1, leave = -1;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = v[k], b = v[(k + 1) % 3];
      if (passed[a] == passed[b]) continue;
      // Walking round the triangle, the front leaves where the passed side begins: so it stays on the left.
      (passed[a] != 0 ? enter : leave) = edge_number(mesh, a, b);
    }
    if (enter < 0) continue;
    links.next[enter] = leave;
    links.previous[leave] = enter;
  }
  return links;
}

FrontPoint crossing(const Int2& edge, const std::vector<Vec3>& x, const std::vector<double>& u, double level) {
  const auto [a, b] = edge;
  const double t = std::clamp((level - u[a]) / (u[b] - u[a]), 0.0, 1.0);
  return {(1.0 - t) * x[a] + t * x[b], a, b, t};
}

/// Share of a triangle with u >= level, u linear in it.
double passed_share(std::array<double, 3> u, double level) {
  std::sort(u.begin(), u.end());
  if (u[0] >= level) return 1.0;
  if (u[2] < level) return 0.0;
  // A tip is similar to the triangle: its share is the product of the shares of the two edges it cuts.
  if (u[1] < level) return (u[2] - level) / (u[2] - u[0]) * (u[2] - level) / (u[2] - u[1]);
  return 1.0 - (level - u[0]) / (u[1] - u[0]) * (level - u[0]) / (u[2] - u[0]);
}

double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 edge = b - a;
  const double length2 = edge.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * edge).squaredNorm();
}

}  // namespace

double FrontPiece::length() const {
  double sum = 0.0;
  for (std::size_t k = 1; k < points.size(); ++k) sum += (points[k].position - points[k - 1].position).norm();
  if (closed && points.size() > 1) sum += (points.front().position - points.back().position).norm();
  return sum;
}

double Front::length() const {
  double sum = 0.0;
  for (const FrontPiece& piece : pieces) sum += piece.length();
  return sum;
}

std::size_t Front::count(double least_length) const {
  return static_cast<std::size_t>(std::count_if(
      pieces.begin(), pieces.end(), [&](const FrontPiece& piece) { return piece.length() >= least_length; }));
}

std::vector<Vec3> front_coordinates(const solid::ShellMesh& mesh) {
  if (!mesh.has_chart()) return mesh.rest;
  std::vector<Vec3> x;
  x.reserve(mesh.material.size());
  for (const Vec2& m : mesh.material) x.emplace_back(m.x(), m.y(), 0.0);
  return x;
}

Front find_front(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, const std::vector<double>& u,
                 double level) {
  Front front;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Int3& v = mesh.triangles[t];
    front.sheet_area += mesh.rest_area[t];
    front.area += mesh.rest_area[t] * passed_share({u[v[0]], u[v[1]], u[v[2]]}, level);
  }
  std::vector<std::uint8_t> passed(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) passed[i] = u[i] >= level ? 1 : 0;
  const Links links = link_crossed_edges(mesh, passed);

  // Follow each chain from its beginning; what is left over then are closed chains.
  std::vector<std::uint8_t> taken(mesh.edges.size(), 0);
  const auto follow = [&](std::size_t first, bool closed) {
    FrontPiece piece;
    piece.closed = closed;
    for (auto e = static_cast<std::int32_t>(first); e >= 0 && taken[e] == 0; e = links.next[e]) {
      taken[e] = 1;
      piece.points.push_back(crossing(mesh.edges[e], x, u, level));
    }
    front.pieces.push_back(std::move(piece));
  };
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    if (links.next[e] >= 0 && links.previous[e] < 0) follow(e, false);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    if (links.next[e] >= 0 && taken[e] == 0) follow(e, true);
  return front;
}

double distance_to(const Front& front, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const FrontPiece& piece : front.pieces) {
    const std::size_t n = piece.points.size();
    for (std::size_t k = 0; k + 1 < n + (piece.closed ? 1 : 0); ++k)
      nearest =
          std::min(nearest, squared_distance(p, piece.points[k].position, piece.points[(k + 1) % n].position));
  }
  return std::sqrt(nearest);
}

SampledFront sample(const FrontPiece& piece, double spacing, std::span<const std::vector<double>* const> fields) {
  SampledFront result;
  result.closed = piece.closed;
  result.field.resize(fields.size());
  std::vector<FrontPoint> points = piece.points;
  if (piece.closed && !points.empty()) points.push_back(points.front());
  const double length = piece.length();
  const auto intervals = static_cast<std::size_t>(std::max(3.0, std::round(length / spacing)));
  result.step = length / static_cast<double>(intervals);

  // Walk along the points; a closed piece ends one step before it would repeat itself.
  const std::size_t count = intervals + (piece.closed ? 0 : 1);
  std::size_t k = 1;
  double behind = 0.0;  // arc length at points[k - 1]
  for (std::size_t n = 0; n < count && points.size() > 1; ++n) {
    const double s = result.step * static_cast<double>(n);
    double segment = (points[k].position - points[k - 1].position).norm();
    while (k + 1 < points.size() && behind + segment < s) {
      behind += segment;
      ++k;
      segment = (points[k].position - points[k - 1].position).norm();
    }
    const double share = segment > 0.0 ? std::clamp((s - behind) / segment, 0.0, 1.0) : 0.0;
    result.position.push_back((1.0 - share) * points[k - 1].position + share * points[k].position);
    for (std::size_t f = 0; f < fields.size(); ++f)
      result.field[f].push_back((1.0 - share) * points[k - 1].value(*fields[f]) +
                                share * points[k].value(*fields[f]));
  }
  return result;
}

}  // namespace wick::diffusion
