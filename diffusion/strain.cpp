#include "diffusion/strain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "diffusion/perlin.h"
#include "diffusion/sums.h"

namespace wick::diffusion {

Mat2 green_strain(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, std::size_t t, double rest_scale) {
  const Int3& v = mesh.triangles[t];
  Mat32 edges;
  edges << x[v[1]] - x[v[0]], x[v[2]] - x[v[0]];
  const Mat32 gradient = edges * mesh.inverse_rest_edges[t] / rest_scale;
  return 0.5 * (gradient.transpose() * gradient - Mat2::Identity());
}

double strain_measure(Mat2 g, Measure measure, bool tension_only) {
  // Principal strains: mean ± half their difference.
  const double mean = 0.5 * (g(0, 0) + g(1, 1)), quarter = 0.5 * (g(0, 0) - g(1, 1));
  const double half = std::sqrt(quarter * quarter + g(0, 1) * g(0, 1));
  double e1 = mean + half, e2 = mean - half;
  if (tension_only) {
    // Keep the principal directions: G = mean I + half N with N traceless and of unit size.
    e1 = std::max(e1, 0.0);
    e2 = std::max(e2, 0.0);
    const Mat2 direction = half > 0.0 ? Mat2((g - mean * Mat2::Identity()) / half) : Mat2(Mat2::Zero());
    g = 0.5 * (e1 + e2) * Mat2::Identity() + 0.5 * (e1 - e2) * direction;
  }
  const double trace = e1 + e2, difference = e1 - e2;
  if (measure == Measure::invariant) return trace * trace + difference * difference / 8.0;
  return g(0, 0) * g(0, 0) + g(1, 1) * g(1, 1) + 2.0 * g(0, 0) * g(1, 1) + g(0, 1) * g(0, 1);
}

namespace {

/// Signed dihedral angle of a hinge, 0 when flat; 0 as well where a triangle has collapsed.
double dihedral_angle(const solid::Hinge& hinge, const std::vector<Vec3>& x) {
  const auto& [a, b, c, d] = hinge.vertex;
  const Vec3 axis = x[b] - x[a];
  const Vec3 n1 = axis.cross(x[c] - x[a]), n2 = (x[d] - x[a]).cross(axis);
  return std::atan2(n1.cross(n2).dot(axis), axis.norm() * n1.dot(n2));
}

/// Adds λ_b h_b² (κ1 + κ2 - H0)²: each hinge carries θ |e| of integrated curvature, half of it in each of its
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
  parallel_for(strain.size(), chunk, [&](std::size_t t) {
    const Mat2 g = green_strain(mesh, x, t, scaled ? (*rest_scale)[t] : 1.0);
    strain[t] = strain_measure(g, params.measure, params.tension_only);
  });
  if (params.bending_gain != 0.0) add_bending(params.bending_gain, mesh, x, strain);
  const double lambda = 1.0 / (1.0 + params.delta);
  parallel_for(strain.size(), chunk, [&](std::size_t t) { strain[t] *= lambda; });
}

void vertex_strain(const DiffusionParams& params, const solid::ShellMesh& mesh, const std::vector<double>& strain,
                   double dt, std::vector<double>& c) {
  // A vertex that gains this many times a full one already takes all there is; the bound keeps products finite.
  constexpr double most = 1e30;
  c.resize(mesh.vertex_count());
  parallel_for(c.size(), chunk, [&](std::size_t i) {
    double energy = 0.0, area = 0.0;
    for (std::int32_t k = mesh.incident_offset[i]; k < mesh.incident_offset[i + 1]; ++k) {
      const std::int32_t t = mesh.incident[k];
      energy += 0.5 * mesh.rest_area[t] * strain[t];
      area += mesh.rest_area[t];
    }
    const bool density = params.gain_form == Gain::density;
    const double value = params.gain * (density ? dt * (area > 0.0 ? energy / area : 0.0) : energy / 3.0);
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
