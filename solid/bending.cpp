#include "solid/bending.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace wick::solid {

namespace {

Triple<double> triple(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

double cotangent(const Vec3& a, const Vec3& b) {
  return a.dot(b) / a.cross(b).norm();
}

/// Mean over all directions d of the square of the isometric c under unit curvature along d. With the hinge laid
/// flat, c = dᵀ S d, S = ½ Σ K_i X_i X_iᵀ, and the mean over the circle is (3 (S₀₀² + S₁₁²) + 2 S₀₀ S₁₁ + 4
/// S₀₁²)/8.
double mean_squared_response(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  const std::array<double, 4> K = isometric_weights(x0, x1, x2, x3);
  const Vec3 e = x1 - x0;
  const double length = e.norm();
  const auto flat = [&](const Vec3& x, double side) {
    const Vec3 d = x - x0;
    return Vec2(d.dot(e) / length, side * d.cross(e).norm() / length);
  };
  const std::array<Vec2, 4> X = {Vec2(0.0, 0.0), Vec2(length, 0.0), flat(x2, 1.0), flat(x3, -1.0)};
  Mat2 S = Mat2::Zero();
  for (int i = 0; i < 4; ++i) S += 0.5 * K[i] * X[i] * X[i].transpose();
  return (3.0 * (S(0, 0) * S(0, 0) + S(1, 1) * S(1, 1)) + 2.0 * S(0, 0) * S(1, 1) + 4.0 * S(0, 1) * S(0, 1)) / 8.0;
}

}  // namespace

double dihedral_angle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  return hinge_angle(triple(x0), triple(x1), triple(x2), triple(x3)).angle;
}

std::array<double, 4> isometric_weights(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  const Vec3 e0 = x1 - x0, e1 = x2 - x0, e2 = x3 - x0, e3 = x2 - x1, e4 = x3 - x1;
  const double c01 = cotangent(e0, e1), c02 = cotangent(e0, e2), c03 = cotangent(-e0, e3), c04 = cotangent(-e0, e4);
  return {c03 + c04, c01 + c02, -c01 - c03, -c02 - c04};
}

double hinge_area(const ShellMesh& mesh, std::size_t hinge) {
  const auto& t = mesh.hinges[hinge].triangle;
  return mesh.rest_area[t[0]] + mesh.rest_area[t[1]];
}

std::vector<double> hinge_stiffness(const ShellMesh& mesh, double bending) {
  std::vector<double> stiffness(mesh.hinges.size());
  for (std::size_t h = 0; h < mesh.hinges.size(); ++h) {
    const auto& v = mesh.hinges[h].vertex;
    const double area = hinge_area(mesh, h);
    const double response =
        mean_squared_response(mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]], mesh.rest[v[3]]);
    // ½ k 3/A ⟨c²⟩ = B A/6. 3 on equilateral hinges; the floor keeps slivers, whose response can vanish,
    // from becoming rigid.
    const double multiple = std::max(9.0 * response / (area * area), 0.5);
    stiffness[h] = bending / multiple;
  }
  return stiffness;
}

double flexural_rigidity(const ShellParams& params) {
  if (params.bending > 0.0) return params.bending;
  const double young = std::sqrt(params.young_warp * params.young_weft);
  return young * std::pow(params.thickness, 3) / (12.0 * (1.0 - params.poisson * params.poisson));
}

}  // namespace wick::solid
