#pragma once
/// What the tests of the diffusion room share: sheets, deformations and one-line steps.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/noise.h"
#include "diffusion/strain_diffusion.h"
#include "solid/primitives.h"
#include "solid/shell_mesh.h"

namespace wick::diffusion::testing {

using Values = std::vector<double>;

inline solid::ShellMesh sheet(int nx, int ny, const Vec2& size = Vec2(1.0, 1.0),
                              solid::Lattice lattice = solid::Lattice::staggered) {
  return solid::build_mesh(solid::rectangle(nx, ny, size, lattice));
}

/// The same rectangle with inner vertices moved by up to `share` of the spacing.
inline solid::ShellMesh jittered(int nx, int ny, double share, const Vec2& size = Vec2(1.0, 1.0)) {
  solid::TriangleSoup soup = solid::rectangle(nx, ny, size);
  const double h = size.x() / (nx - 1);
  for (int j = 1; j < ny - 1; ++j)
    for (int i = 1; i < nx - 1; ++i) {
      const int v = j * nx + i;
      const Vec2 d = share * h * Vec2(hash_signed(7, 2 * v), hash_signed(7, 2 * v + 1));
      soup.positions[v].head<2>() += d;
      soup.material[v] += d;
    }
  return solid::build_mesh(std::move(soup));
}

/// Bumps that stretch the sheet by some per cent, different from place to place.
inline std::vector<Vec3> crumple(const solid::ShellMesh& mesh, double amplitude = 0.03) {
  std::vector<Vec3> x = mesh.rest;
  for (Vec3& p : x)
    p.z() += amplitude * (std::sin(9.0 * p.x() + 4.0 * p.y()) + 0.6 * std::sin(17.0 * p.y() - 5.0 * p.x()) * p.x());
  return x;
}

inline Values areas(const solid::ShellMesh& mesh) {
  return mesh.vertex_area;
}

/// One sheet with everything that a step needs.
struct Sheet {
  solid::ShellMesh mesh;
  std::vector<Vec3> x;
  Values mass;
  explicit Sheet(solid::ShellMesh m) : mesh(std::move(m)), x(mesh.rest), mass(mesh.vertex_area) {}
  [[nodiscard]] DiffusionInput input() const { return {.mesh = &mesh, .x = &x, .mass = &mass}; }
  [[nodiscard]] Values field(const std::function<double(const Vec3&)>& f) const {
    Values u;
    for (const Vec3& p : mesh.rest) u.push_back(f(p));
    return u;
  }
  [[nodiscard]] double total(const Values& u) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) sum += mass[i] * u[i];
    return sum;
  }
};

/// A sheet without the triangles whose middles have low <= x <= high: two pieces, and orphans between them.
inline Sheet two_pieces(const solid::ShellMesh& whole, double low, double high) {
  std::vector<std::uint8_t> keep;
  for (const Int3& t : whole.triangles) {
    const double x = (whole.rest[t[0]] + whole.rest[t[1]] + whole.rest[t[2]]).x() / 3.0;
    keep.push_back(x < low || x > high ? 1 : 0);
  }
  return Sheet(solid::without_triangles(whole, keep));
}

/// Relative error of after = before + supplied - lost + sigma_source - excess.
inline double budget_error(const DiffusionReport& r) {
  const double expected = r.before + r.supplied - r.lost + r.sigma_source - r.excess;
  const double scale =
      std::max({std::abs(r.before), std::abs(r.supplied), std::abs(r.after), std::abs(r.sigma_source), 1e-290});
  return std::abs(r.after - expected) / scale;
}

inline double rms(const Values& a, const Values& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

inline double largest(const Values& a) {
  return *std::max_element(a.begin(), a.end());
}
inline double smallest(const Values& a) {
  return *std::min_element(a.begin(), a.end());
}

/// Isotropic linear diffusion with tight solves.
inline DiffusionParams plain_diffusion(double alpha) {
  DiffusionParams p;
  p.model = Model::isotropic;
  p.alpha = alpha;
  p.tolerance = 1e-12;
  return p;
}

}  // namespace wick::diffusion::testing
