/// Which cells changed sides while a sheet moved: crossings of still points with moving triangles.
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "coupling/rasterize.h"

namespace wick::coupling {

namespace {

constexpr std::size_t kTriangleGrain = 512;

/// Coefficients of a cubic polynomial in t, constant first.
using Cubic = std::array<double, 4>;

double evaluate(const Cubic& c, double t) {
  return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/// Sign changes of the cubic on (from, to], found by bisection on an interval where it is monotone.
void add_root(const Cubic& c, double from, double to, std::vector<double>& roots) {
  double low = evaluate(c, from), high = evaluate(c, to);
  if ((low < 0.0) == (high < 0.0)) return;
  for (int step = 0; step < 60 && to - from > 1e-15; ++step) {
    const double middle = 0.5 * (from + to);
    const double value = evaluate(c, middle);
    if ((value < 0.0) == (low < 0.0))
      from = middle;
    else
      to = middle;
  }
  roots.push_back(0.5 * (from + to));
}

/// Roots on (0, 1] where the cubic changes sign: split at the extrema, each piece is monotone.
std::vector<double> sign_changes(const Cubic& c) {
  std::vector<double> cuts = {0.0};
  const double a = 3 * c[3], b = 2 * c[2], d = c[1];
  const double discriminant = b * b - 4 * a * d;
  if (discriminant > 0) {
    const double s = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    for (const double t : {a != 0.0 ? s / a : -1.0, s != 0.0 ? d / s : -1.0})
      if (t > 0.0 && t < 1.0) cuts.push_back(t);
  }
  cuts.push_back(1.0);
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> roots;
  for (std::size_t n = 0; n + 1 < cuts.size(); ++n) add_root(c, cuts[n], cuts[n + 1], roots);
  return roots;
}

/// Number of times that the triangle p(t) = p + t d, t in (0, 1], passes through the origin.
int crossings(const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& d) {
  // Coplanarity with the origin: det[p0, p1, p2](t), a cubic.
  const auto det = [](const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); };
  const Cubic cubic = {det(p[0], p[1], p[2]), det(d[0], p[1], p[2]) + det(p[0], d[1], p[2]) + det(p[0], p[1], d[2]),
                       det(d[0], d[1], p[2]) + det(d[0], p[1], d[2]) + det(p[0], d[1], d[2]),
                       det(d[0], d[1], d[2])};
  int count = 0;
  for (const double t : sign_changes(cubic)) {
    std::array<Vec3, 3> q;
    for (int k = 0; k < 3; ++k) q[k] = p[k] + t * d[k];
    const Vec3 normal = (q[1] - q[0]).cross(q[2] - q[0]);
    const double s0 = q[1].cross(q[2]).dot(normal), s1 = q[2].cross(q[0]).dot(normal),
                 s2 = q[0].cross(q[1]).dot(normal);
    if (s0 >= 0 && s1 >= 0 && s2 >= 0) ++count;
  }
  return count;
}

/// Cells that triangle t passes, once for each crossing.
void add_swept(const fluid::Grid& grid, const Int3& t, const std::vector<Vec3>& before,
               const std::vector<Vec3>& after, std::vector<std::int64_t>& cells) {
  std::array<Vec3, 3> p, d;
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
  for (int k = 0; k < 3; ++k) {
    p[k] = (before[t[k]] - grid.origin) / grid.h - Vec3::Constant(0.5) + grid_line_offset();
    d[k] = (after[t[k]] - before[t[k]]) / grid.h;
    low = low.cwiseMin(p[k]).cwiseMin(p[k] + d[k]);
    high = high.cwiseMax(p[k]).cwiseMax(p[k] + d[k]);
  }
  if (!low.allFinite() || !high.allFinite()) return;
  Int3 first, last;
  for (int a = 0; a < 3; ++a) {
    first[a] = static_cast<int>(std::ceil(std::clamp(low[a], 0.0, double(grid.size(a)))));
    last[a] = static_cast<int>(std::floor(std::clamp(high[a], -1.0, double(grid.size(a) - 1))));
  }
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const Vec3 center(i, j, k);
        const int count = crossings({p[0] - center, p[1] - center, p[2] - center}, d);
        for (int n = 0; n < count; ++n) cells.push_back(static_cast<std::int64_t>(grid.cell(i, j, k)));
      }
}

}  // namespace

std::vector<std::int64_t> swept_cells(const fluid::Grid& grid, const solid::ShellMesh& mesh,
                                      const std::vector<Vec3>& before, const std::vector<Vec3>& after) {
  const std::size_t triangles = mesh.triangle_count();
  std::vector<std::vector<std::int64_t>> found((triangles + kTriangleGrain - 1) / kTriangleGrain);
  parallel_chunks(triangles, kTriangleGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      add_swept(grid, mesh.triangles[t], before, after, found[begin / kTriangleGrain]);
  });
  std::vector<std::int64_t> passed;
  for (const auto& part : found) passed.insert(passed.end(), part.begin(), part.end());
  std::sort(passed.begin(), passed.end());

  // An even number of passes leaves the cell on the side it was on.
  std::vector<std::int64_t> swept;
  for (std::size_t begin = 0, end = 0; begin < passed.size(); begin = end) {
    while (end < passed.size() && passed[end] == passed[begin]) ++end;
    if ((end - begin) % 2 == 1) swept.push_back(passed[begin]);
  }
  return swept;
}

}  // namespace wick::coupling
