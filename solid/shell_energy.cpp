#include <algorithm>

#include "core/parallel.h"
#include "solid/bending.h"
#include "solid/membrane.h"

namespace wick::solid {

namespace {

Triple<double> triple(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// ½ A t cᵀ C c with C the inverse of the compliance.
double stretching(const ShellMesh& mesh, const MembraneLaw& law, const ShellInputs& inputs,
                  const std::vector<Vec3>& x, std::size_t t) {
  const Int3& v = mesh.triangles[t];
  const double scale = inputs.rest_scale[t];
  const Mat2 B = mesh.inverse_rest_edges[t] / scale;
  const RestEdges<double> b = {B(0, 0), B(0, 1), B(1, 0), B(1, 1)};
  const Strain<double> c = green_strain(deformation(b, triple(x[v[1]] - x[v[0]]), triple(x[v[2]] - x[v[0]])));
  const double det = law.warp * law.weft - law.poisson * law.poisson;
  const double density =
      0.5 * ((law.weft * c.g00 * c.g00 - 2.0 * law.poisson * c.g00 * c.g11 + law.warp * c.g11 * c.g11) / det +
             c.g01_twice * c.g01_twice / law.shear);
  return mesh.rest_area[t] * scale * scale * inputs.stiffness_scale[t] * inputs.membrane_factor * density;
}

double bending(const ShellMesh& mesh, double stiffness, const ShellInputs& inputs, const std::vector<Vec3>& x,
               std::size_t h) {
  const auto& v = mesh.hinges[h].vertex;
  const auto& t = mesh.hinges[h].triangle;
  const double k =
      1.5 * stiffness * 0.5 * (inputs.stiffness_scale[t[0]] + inputs.stiffness_scale[t[1]]) / hinge_area(mesh, h);
  if (inputs.rest_angle[h] == 0.0) {
    const auto K = isometric_weights(mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]], mesh.rest[v[3]]);
    const double scale = 0.5 * (inputs.rest_scale[t[0]] + inputs.rest_scale[t[1]]);
    Vec3 c = Vec3::Zero();
    for (int i = 1; i < 4; ++i) c += K[i] * (x[v[i]] - x[v[0]]);
    return k * c.squaredNorm() / (scale * scale);
  }
  const double angle = dihedral_angle(x[v[0]], x[v[1]], x[v[2]], x[v[3]]);
  const double c = std::remainder(angle - inputs.rest_angle[h], 6.283185307179586);
  return k * (mesh.rest[v[1]] - mesh.rest[v[0]]).squaredNorm() * c * c;
}

}  // namespace

ShellEnergy elastic_energy(const ShellMesh& mesh, const ShellParams& params, const ShellInputs& inputs,
                           const std::vector<Vec3>& x) {
  constexpr std::size_t grain = 1024;
  const MembraneLaw law = membrane_law(params);
  const std::vector<double> stiffness = hinge_stiffness(mesh, flexural_rigidity(params));
  ShellEnergy energy;
  energy.stretching = parallel_sum(mesh.triangle_count(), grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t t = begin; t < end; ++t) sum += stretching(mesh, law, inputs, x, t);
    return sum;
  });
  energy.bending = parallel_sum(mesh.hinges.size(), grain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t h = begin; h < end; ++h) sum += bending(mesh, stiffness[h], inputs, x, h);
    return sum;
  });
  return energy;
}

}  // namespace wick::solid
