#pragma once
/// Bending of hinges x0-x1 with wings x2 and x3. Hinges that are flat at rest use the isometric form [Bergou 2006]:
///   c = Σ K_i x_i,  energy = ½ k 3/(A₀+A₁) |c|²,
/// the others the dihedral angle: energy = ½ k 3|e|²/(A₀+A₁) (θ − θ₀)². Both agree for small angles. k is
/// B/3 on equilateral meshes (B flexural rigidity): the factor 2/√3 of [Seung 1988].
#include "solid/lanes.h"
#include "solid/shell.h"

namespace wick::solid {

/// Signed angle between the normals of the two triangles, in (−π, π]: positive for a ridge seen from the
/// side to which the normals point, 0 when flat.
double dihedral_angle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

/// K_i of the isometric form from the rest shape; they sum to zero and vanish on every affine flat layout.
std::array<double, 4> isometric_weights(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

/// Stiffness k of each hinge for the flexural rigidity `bending` [N m]: rolled to any cylinder, averaged over
/// its direction, the hinge has the energy of its third of the two triangles in plate theory, B (A₀+A₁)/6 κ².
std::vector<double> hinge_stiffness(const ShellMesh& mesh, double bending);

/// B of the parameters, or that of a homogeneous plate, Y t³/(12 (1 − ν²)), when they leave it open.
double flexural_rigidity(const ShellParams& params);

/// A₀+A₁ of the flat rest triangles.
double hinge_area(const ShellMesh& mesh, std::size_t hinge);

/// arctan(y/x) in the right quadrant, lane by lane; 0 at the origin. Relative error some 1e-16.
template <class T>
T arc_tangent(const T& y, const T& x) {
  const T zero = constant<T>(0.0), one = constant<T>(1.0);
  const T ax = larger<T>(x, -x), ay = larger<T>(y, -y);
  const T t = smaller<T>(ax, ay) / larger<T>(larger<T>(ax, ay), constant<T>(1e-300));
  // Bring t ∈ [0, 1] to |r| ≤ tan(π/8) by arctan t = π/4 + arctan((t−1)/(t+1)), then sum the Taylor series;
  // the first term left out is below 1e-17.
  const auto far = t > constant<T>(0.41421356237309503);
  const T r = far ? (t - one) / (t + one) : t;
  const T r2 = r * r;
  T series = constant<T>(1.0 / 41.0);
  for (int k = 19; k >= 0; --k) series = 1.0 / (2 * k + 1) - r2 * series;
  T angle = r * series + (far ? constant<T>(0.78539816339744831) : zero);
  angle = ay > ax ? 1.57079632679489662 - angle : angle;
  angle = x < zero ? 3.14159265358979324 - angle : angle;
  return y < zero ? -angle : angle;
}

template <class T>
struct HingeAngle {
  T angle;
  std::array<Triple<T>, 4> gradient;  ///< dθ/dx_i [1/m]
};

template <class T>
HingeAngle<T> hinge_angle(const Triple<T>& x0, const Triple<T>& x1, const Triple<T>& x2, const Triple<T>& x3) {
  const Triple<T> e = x1 - x0;
  const Triple<T> n1 = cross(x2 - x0, x2 - x1), n2 = cross(x3 - x1, x3 - x0);
  // The floors only meet collapsed edges and wings, where the angle means nothing and the gradient must stay
  // finite.
  const T length2 = larger<T>(dot(e, e), constant<T>(1e-60));
  const T length = square_root(length2);
  const T floor = 1e-16 * length2 * length2;
  const T over1 = 1.0 / larger<T>(dot(n1, n1), floor), over2 = 1.0 / larger<T>(dot(n2, n2), floor);
  const T inverse = 1.0 / length;
  const T angle = arc_tangent<T>(dot(cross(n1, n2), e) * inverse, dot(n1, n2));
  const Triple<T> u1 = over1 * n1, u2 = over2 * n2;
  const T s1 = dot(x2 - x1, e) * inverse, s2 = dot(x3 - x1, e) * inverse;
  const T r1 = dot(x2 - x0, e) * inverse, r2 = dot(x3 - x0, e) * inverse;
  return {angle, {(-s1) * u1 + (-s2) * u2, r1 * u1 + r2 * u2, (-length) * u1, (-length) * u2}};
}

/// One XPBD projection of a flat hinge. c is linear in x, so damping needs no second look at the start of the
/// substep when it is done on y = x + γ (x − xⁿ):  λ = −c(y)/((1+γ) Σ w K² + α̃),  y += (1+γ) w K λ.
/// `softness` is (A₀+A₁)/(3 k h²); k1..k3 are the weights of vertices 1 to 3.
template <class T>
void project_flat_hinge(const T& k1, const T& k2, const T& k3, const T& softness, double one_plus_gamma,
                        Vertex<T>& v0, Vertex<T>& v1, Vertex<T>& v2, Vertex<T>& v3) {
  const T k0 = -(k1 + k2 + k3);
  const T g0 = one_plus_gamma * v0.w * k0, g1 = one_plus_gamma * v1.w * k1;
  const T g2 = one_plus_gamma * v2.w * k2, g3 = one_plus_gamma * v3.w * k3;
  const T s = -1.0 / (g0 * k0 + g1 * k1 + g2 * k2 + g3 * k3 + softness);
  const Triple<T> lambda = s * (k1 * (v1.p - v0.p) + k2 * (v2.p - v0.p) + k3 * (v3.p - v0.p));
  v0.p = v0.p + g0 * lambda;
  v1.p = v1.p + g1 * lambda;
  v2.p = v2.p + g2 * lambda;
  v3.p = v3.p + g3 * lambda;
}

/// One XPBD projection of a hinge on its dihedral angle; `softness` is (A₀+A₁)/(3 k |e|² h²).
template <class T>
void project_bent_hinge(const T& rest_angle, const T& softness, double gamma, std::array<Vertex<T>, 4>& v,
                        const std::array<Triple<T>, 4>& previous) {
  const HingeAngle<T> now = hinge_angle(v[0].p, v[1].p, v[2].p, v[3].p);
  constexpr double pi = 3.14159265358979324;
  T c = now.angle - rest_angle;
  c = c > constant<T>(pi) ? c - 2.0 * pi : c;
  c = c < constant<T>(-pi) ? c + 2.0 * pi : c;
  T rate = constant<T>(0.0), weight = constant<T>(0.0);
  for (int k = 0; k < 4; ++k) {
    rate = rate + dot(now.gradient[k], v[k].p - previous[k]);
    weight = weight + v[k].w * dot(now.gradient[k], now.gradient[k]);
  }
  const T lambda = -(c + gamma * rate) / ((1.0 + gamma) * weight + softness);
  for (int k = 0; k < 4; ++k) v[k].p = v[k].p + (v[k].w * lambda) * now.gradient[k];
}

}  // namespace wick::solid
