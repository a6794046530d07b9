#include "diffusion/strain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffusion/perlin.h"
#include "diffusion/sums.h"

namespace wick::diffusion {

Mat2 green_strain(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, std::size_t t, double rest_scale) {
  // Fᵀ F = Bᵀ (Eᵀ E) B needs only the lengths and the angle of the deformed edges.
  const Int3& v = mesh.triangles[t];
  const Vec3 a = x[v[1]] - x[v[0]], b = x[v[2]] - x[v[0]];
  const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm();
  const Mat2& inverse = mesh.inverse_rest_edges[t];
  const double p = inverse(0, 0), q = inverse(1, 0), r = inverse(0, 1), s = inverse(1, 1);
  const double scale = 1.0 / (rest_scale * rest_scale);
  Mat2 green;
  green(0, 0) = 0.5 * (scale * (p * p * aa + 2.0 * p * q * ab + q * q * bb) - 1.0);
  green(1, 1) = 0.5 * (scale * (r * r * aa + 2.0 * r * s * ab + s * s * bb) - 1.0);
  green(0, 1) = green(1, 0) = 0.5 * scale * (p * r * aa + (p * s + q * r) * ab + q * s * bb);
  return green;
}

double strain_measure(Mat2 g, Measure measure, bool tension_only) {
  if (tension_only) {
    // Principal strains are mean ± half; keep their directions: G = mean I + half N, N traceless and of unit size.
    const double mean = 0.5 * (g(0, 0) + g(1, 1)), quarter = 0.5 * (g(0, 0) - g(1, 1));
    const double half = std::sqrt(quarter * quarter + g(0, 1) * g(0, 1));
    const double e1 = std::max(mean + half, 0.0), e2 = std::max(mean - half, 0.0);
    const Mat2 direction = half > 0.0 ? Mat2((g - mean * Mat2::Identity()) / half) : Mat2(Mat2::Zero());
    g = 0.5 * (e1 + e2) * Mat2::Identity() + 0.5 * (e1 - e2) * direction;
  }
  const double trace = g(0, 0) + g(1, 1), difference = g(0, 0) - g(1, 1), shear = g(0, 1) * g(0, 1);
  if (measure == Measure::orthotropic) return trace * trace + shear;
  return trace * trace + (difference * difference + 4.0 * shear) / 8.0;
}

namespace {

/// Signed dihedral angle of a hinge, 0 when flat; 0 as well where a triangle has collapsed.
double dihedral_angle(const solid::Hinge& hinge, const std::vector<Vec3>& x) {
  const auto& [a, b, c, d] = hinge.vertex;
  const Vec3 axis = x[b] - x[a];
  const Vec3 n1 = axis.cross(x[c] - x[a]), n2 = (x[d] - x[a]).cross(axis);
  return std::atan2(n1.cross(n2).dot(axis), axis.norm() * n1.dot(n2));
}

/// Adds λ λ_b h_b² (κ1 + κ2 - H0)²: each hinge carries θ |e| of integrated curvature, half of it in each of its
/// triangles.
void add_bending(double gain, const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                 std::vector<double>& strain) {
  std::vector<double> curvature(strain.size(), 0.0);
  for (const solid::Hinge& hinge : mesh.hinges) {
    double angle = dihedral_angle(hinge, x) - dihedral_angle(hinge, mesh.rest);
    angle -= 2.0 * M_PI * std::round(angle / (2.0 * M_PI));
    const double length = (mesh.rest[hinge.vertex[1]] - mesh.rest[hinge.vertex[0]]).norm();
    for (const std::int32_t t : hinge.triangle) curvature[t] += 0.5 * angle * length;
  }
  for (std::size_t t = 0; t < strain.size(); ++t) {
    const double mean = curvature[t] / mesh.rest_area[t];
    strain[t] += gain * mean * mean;
  }
}

}  // namespace

void triangle_strain(const DiffusionParams& params, const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                     const std::vector<double>* rest_scale, std::vector<double>& strain) {
  strain.resize(mesh.triangle_count());
  const bool scaled = params.reference == Reference::current && rest_scale != nullptr;
  const double lambda = 1.0 / (1.0 + params.delta);
  parallel_for(strain.size(), chunk, [&](std::size_t t) {
    const Mat2 g = green_strain(mesh, x, t, scaled ? (*rest_scale)[t] : 1.0);
    strain[t] = lambda * strain_measure(g, params.measure, params.tension_only);
  });
  if (params.bending_gain != 0.0) add_bending(lambda * params.bending_gain, mesh, x, strain);
}

void vertex_strain(const DiffusionParams& params, const solid::ShellMesh& mesh, const std::vector<double>& strain,
                   double dt, std::vector<double>& c) {
  // A vertex that gains this many times a full one already takes all there is; the bound keeps products finite.
  constexpr double most = 1e30;
  const bool density = params.gain_form == Gain::density;
  c.resize(mesh.vertex_count());
  parallel_for(c.size(), chunk, [&](std::size_t i) {
    double energy = 0.0;
    for (std::int32_t k = mesh.incident_offset[i]; k < mesh.incident_offset[i + 1]; ++k) {
      const std::int32_t t = mesh.incident[k];
      energy += mesh.rest_area[t] * strain[t];
    }
    const double share = energy / 6.0, area = mesh.vertex_area[i];  // both a third of all triangles around
    const double value = params.gain * (density ? dt * (area > 0.0 ? share / area : 0.0) : share);
    c[i] = std::min(value, most);
  });
}

void apply_noise(const DiffusionParams& params, const solid::ShellMesh& mesh, double dt, std::vector<double>& c) {
  const NoiseParams& n = params.noise;
  const bool alone = params.model == Model::noise;
  if (!alone && params.model != Model::strain_noise) return;
  const bool density = params.gain_form == Gain::density;
  parallel_for(c.size(), chunk, [&](std::size_t i) {
    const Vec3 at = mesh.has_chart() ? Vec3(mesh.material[i].x(), mesh.material[i].y(), 0.0) : mesh.rest[i];
    const double p = n.amplitude * perlin(n.frequency * at, static_cast<std::uint64_t>(n.seed));
    if (!alone) {
      c[i] *= std::max(0.0, 1.0 + p);
      return;
    }
    // c = ½ S everywhere gives κ dt c, or κ A c with A a third of the areas around.
    const double unit = params.gain * n.level * (density ? dt : mesh.vertex_area[i]);
    c[i] = std::min(unit * std::max(0.0, p), 1e30);
  });
}

}  // namespace wick::diffusion
