#pragma once
/// Stretching and shearing: the Green strain of a triangle as one constraint of three components, with the
/// plane-stress law of an orthotropic St. Venant-Kirchhoff sheet as its compliance.
///   F = [x₁−x₀, x₂−x₀] B,  G = (FᵀF − I)/2,  c = (G₀₀, G₁₁, 2 G₀₁),  energy = ½ A t cᵀ C c
#include "solid/lanes.h"
#include "solid/shell.h"

namespace wick::solid {

/// Plane-stress compliance per thickness, S = (t C)⁻¹ [m/N]: the strain c under a force per width N is S N.
struct MembraneLaw {
  double warp;     ///< S₀₀ = 1/(t Y₁)
  double poisson;  ///< S₀₁ = −ν/(t √(Y₁Y₂))
  double weft;     ///< S₁₁ = 1/(t Y₂)
  double shear;    ///< S₂₂ = 1/(t G)
};
MembraneLaw membrane_law(const ShellParams& params);

/// Rows of B for the corners 1 and 2; corner 0 has minus their sum.
template <class T>
struct RestEdges {
  T b10, b11, b20, b21;
};

template <class T>
struct Strain {
  T g00, g11, g01_twice;
};

/// Columns of the deformation gradient, F = [f, g].
template <class T>
struct Deformation {
  Triple<T> f, g;
};

template <class T>
Deformation<T> deformation(const RestEdges<T>& b, const Triple<T>& edge1, const Triple<T>& edge2) {
  return {b.b10 * edge1 + b.b20 * edge2, b.b11 * edge1 + b.b21 * edge2};
}

template <class T>
Strain<T> green_strain(const Deformation<T>& F) {
  return {0.5 * (dot(F.f, F.f) - 1.0), 0.5 * (dot(F.g, F.g) - 1.0), dot(F.f, F.g)};
}

/// Directional derivative of c along a motion whose deformation gradient is D: ċ = (f·ḟ, g·ġ, f·ġ + g·ḟ).
template <class T>
Strain<T> strain_rate(const Deformation<T>& F, const Deformation<T>& D) {
  return {dot(F.f, D.f), dot(F.g, D.g), dot(F.f, D.g) + dot(F.g, D.f)};
}

/// Jᵀλ at a corner whose row of B is (b0, b1): ∂G_ab/∂x_k = (B_ka f_b + B_kb f_a)/2.
template <class T>
Triple<T> pull_back(const Deformation<T>& F, const Strain<T>& lambda, const T& b0, const T& b1) {
  return b0 * (lambda.g00 * F.f + lambda.g01_twice * F.g) + b1 * (lambda.g11 * F.g + lambda.g01_twice * F.f);
}

/// Solves the symmetric positive definite system [a00 a01 a02; . a11 a12; . . a22] x = r by L D Lᵀ.
template <class T>
Strain<T> solve_symmetric(const T& a00, const T& a01, const T& a02, const T& a11, const T& a12, const T& a22,
                          const Strain<T>& r) {
  // A collapsed triangle leaves J W Jᵀ singular; when the compliance is below rounding the later pivots would
  // be noise. The floor keeps them positive; directions it acts on have no gradient and move nothing.
  constexpr double floor = 1e-13;
  const T i0 = 1.0 / a00;
  const T l10 = a01 * i0, l20 = a02 * i0;
  const T i1 = 1.0 / larger<T>(a11 - l10 * a01, floor * a11);
  const T e12 = a12 - l20 * a01;
  const T l21 = e12 * i1;
  const T d2 = larger<T>(a22 - l20 * a02 - l21 * e12, floor * a22);
  const T y1 = r.g11 - l10 * r.g00;
  const T z2 = (r.g01_twice - l20 * r.g00 - l21 * y1) / d2;
  const T z1 = y1 * i1 - l21 * z2;
  return {r.g00 * i0 - l10 * z1 - l20 * z2, z1, z2};
}

/// One XPBD projection of a triangle [Macklin 2016, Eqs 17-18, 26] with Rayleigh damping γ,
///   ((1+γ) J W Jᵀ + α̃) λ = −(c + γ J (x − xⁿ)),   x += W Jᵀ λ,   α̃ = S/(A h²).
/// One sweep from λ = 0 leaves some (1+γ) J W Jᵀ/2 + α̃ of strain per λ: what damping adds to that softens the
/// sheet. So γ is b/h only as far as it adds no more than the larger of α̃ and a quarter of J W Jᵀ,
///   γ = min(b/h tr α̃/(tr α̃ + tr J W Jᵀ), 1/4 + tr α̃/tr J W Jᵀ),
/// which tends to b/h as h falls; but where the strain is so large that the sheet would be crushed undamped, at
/// least
///   b/h s tr J W Jᵀ/(tr α̃ + tr J W Jᵀ), s from 0 to 1 while the strain grows to a half.
/// `previous` are the corners at the start of the substep; `softness` is 1/(A h² stiffness scale), `damping` b/h.
template <class T>
void project_triangle(const RestEdges<T>& b, const T& softness, const MembraneLaw& law, double damping,
                      Vertex<T>& v0, Vertex<T>& v1, Vertex<T>& v2, const Triple<T>& previous0,
                      const Triple<T>& previous1, const Triple<T>& previous2) {
  const Triple<T> edge1 = v1.p - v0.p, edge2 = v2.p - v0.p;
  const Deformation<T> F = deformation(b, edge1, edge2);
  const Triple<T> old1 = previous1 - previous0, old2 = previous2 - previous0;
  const Deformation<T> D = deformation(b, edge1 - old1, edge2 - old2);
  const Strain<T> c = green_strain(F);
  // The gradient of the start of the substep makes the projection central about xⁿ, so that nothing is lost in
  // turning (as in SHAKE); but it leaves the transverse stiffness of taut triangles explicit, which the gradient at
  // x damps. A triangle passes from the one to the other while its strain grows to a tenth.
  const T square = c.g00 * c.g00 + c.g11 * c.g11 + 0.5 * c.g01_twice * c.g01_twice;
  const T back = larger<T>(constant<T>(0.0), 1.0 - 100.0 * square);
  const Deformation<T> J = {F.f - back * D.f, F.g - back * D.g};

  // J W Jᵀ from the Gram matrix of F and m = Σ w_k B_kᵀ B_k.
  const T b00 = -(b.b10 + b.b20), b01 = -(b.b11 + b.b21);
  const T n00 = v0.w * b00 * b00 + v1.w * b.b10 * b.b10 + v2.w * b.b20 * b.b20;
  const T n01 = v0.w * b00 * b01 + v1.w * b.b10 * b.b11 + v2.w * b.b20 * b.b21;
  const T n11 = v0.w * b01 * b01 + v1.w * b.b11 * b.b11 + v2.w * b.b21 * b.b21;
  const T weight = n00 + n11, compliance = (law.warp + law.weft) * softness;
  const T large = smaller<T>(constant<T>(1.0), 4.0 * square);
  const T resolved = smaller<T>(damping * compliance / (compliance + weight), 0.25 + compliance / weight);
  const T gamma = larger<T>(resolved, damping * large * weight / (compliance + weight));
  const T scale = 1.0 + gamma;
  const T m00 = scale * n00, m01 = scale * n01, m11 = scale * n11;

  const Strain<T> rate = strain_rate(J, D);
  const Strain<T> r = {-(c.g00 + gamma * rate.g00), -(c.g11 + gamma * rate.g11),
                       -(c.g01_twice + gamma * rate.g01_twice)};
  const T ff = dot(J.f, J.f), gg = dot(J.g, J.g), fg = dot(J.f, J.g);
  const Strain<T> lambda =
      solve_symmetric<T>(m00 * ff + softness * law.warp, m01 * fg + softness * law.poisson, m00 * fg + m01 * ff,
                         m11 * gg + softness * law.weft, m01 * gg + m11 * fg,
                         m00 * gg + 2.0 * m01 * fg + m11 * ff + softness * law.shear, r);

  Triple<T> d0 = v0.w * pull_back(J, lambda, b00, b01);
  Triple<T> d1 = v1.w * pull_back(J, lambda, b.b10, b.b11);
  Triple<T> d2 = v2.w * pull_back(J, lambda, b.b20, b.b21);

  // c is quadratic, so one Newton step from a crushed triangle overshoots without bound; no corner may move by more
  // than the size of the triangle, at rest (the root of the area, 1/(2 |det B|)) or now. All three are cut alike,
  // which keeps momentum.
  const T largest2 = larger<T>(larger<T>(dot(d0, d0), dot(d1, d1)), dot(d2, d2));
  const T det = b.b10 * b.b21 - b.b11 * b.b20;
  const T moved = largest2 * larger<T>(det, -det), allowed = larger<T>(constant<T>(1.0), c.g00 + c.g11);
  if (any_greater(moved, allowed)) {
    const T cut = square_root(allowed / larger<T>(moved, allowed));
    d0 = cut * d0;
    d1 = cut * d1;
    d2 = cut * d2;
  }
  v0.p = v0.p + d0;
  v1.p = v1.p + d1;
  v2.p = v2.p + d2;
}

}  // namespace wick::solid
