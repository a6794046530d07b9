#pragma once
/// Strain measure of each triangle and the increment C of each vertex [Kim 2017, Eqs 4, 5].
#include <vector>

#include "diffusion/strain_diffusion.h"

namespace wick::diffusion {

/// Green strain of triangle t: G = (F^T F - I)/2 with F = E B, E = [x1-x0, x2-x0] and B the inverse rest edges.
/// The paper writes D_m for the deformed and D_s for the rest edges.
Mat2 green_strain(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, std::size_t t, double rest_scale = 1.0);

/// orthotropic: (G00 + G11)² + G01² [Eq 5]; invariant: its mean over all frames, (e1+e2)² + (e1-e2)²/8.
double strain_measure(Mat2 green, Measure measure, bool tension_only);

/// S per triangle, λ = 1/(1+δ) included; `rest_scale` null: 1. Adds the bending term when its gain is not 0.
void triangle_strain(const DiffusionParams& params, const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                     const std::vector<double>* rest_scale, std::vector<double>& strain);

/// density: C_i = κ dt c_i with c_i = (1/2) Σ A_t S_t / Σ A_t, the same on every mesh and for every dt.
/// literal: C_i = κ Σ A_t S_t/6 per step, a third of A S/2 from each incident triangle [Eq 4].
void vertex_strain(const DiffusionParams& params, const solid::ShellMesh& mesh, const std::vector<double>& strain,
                   double dt, std::vector<double>& c);

/// What the models noise and strain_noise make of C, in place: kappa dt level a max(0, P(f X)), or
/// C max(0, 1 + a P(f X)), with P Perlin's noise at the material coordinates X (rest positions without a chart).
void apply_noise(const DiffusionParams& params, const solid::ShellMesh& mesh, double dt, std::vector<double>& c);

}  // namespace wick::diffusion
