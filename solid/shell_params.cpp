#include <cmath>

#include "core/parameters.h"
#include "solid/bending.h"
#include "solid/membrane.h"

namespace wick::solid {

void describe(ParameterVisitor& v, ShellParams& p) {
  constexpr auto may = OnResume::may_change;
  v.number({"thickness", "m", between(1e-9, 10.0), "t; too large: the sheet is heavy and stays flat like a board"},
           p.thickness);
  v.number({"density", "kg/m3", between(1e-6, 1e7), "mass per volume; areal mass is density * thickness"},
           p.density);
  v.number({"young_warp", "Pa", above(0.0), "Y along material x; too small: the sheet stretches like rubber", may},
           p.young_warp);
  v.number({"young_weft", "Pa", above(0.0), "Y along material y; too small: the sheet stretches like rubber", may},
           p.young_weft);
  v.number({"poisson", "1", between(-0.9, 0.9),
            "nu, in the plane; near +-1 the sheet resists only one kind of strain", may},
           p.poisson);
  v.number(
      {"shear", "Pa", at_least(0.0), "in-plane shear modulus; 0: that of an isotropic sheet, Y/(2(1+nu))", may},
      p.shear);
  v.number(
      {"bending", "N m", at_least(0.0),
       "flexural rigidity B per width; 0: Y t^3/(12(1-nu^2)). Looks softer than it is where B h^2 exceeds some "
       "0.1 density t l^4 (h substep, l edge): then raise substeps",
       may},
      p.bending);
  v.number(
      {"damping", "s", at_least(0.0),
       "Rayleigh b of bending, and of stretching where substeps resolve it [Macklin 2016]; too large: the sheet "
       "creeps and looks softer",
       may},
      p.damping);
  v.number({"air_drag", "1/s", at_least(0.0), "rate at which velocity relative to the wind decays", may},
           p.air_drag);
  v.integer({"substeps", "1", between(1, 10000),
             "per 1/60 s [Macklin 2019]; too few: stretches, and bends more easily than its stiffness says", may},
            p.substeps);
  v.flag({"weaken_with_delta", "", any_value(), "multiply membrane stiffness by 1/(1+delta) of the diffusion"},
         p.weaken_with_delta);
}

void visit(StateVisitor& visitor, ShellState& state) {
  visitor.array("x", state.x);
  visitor.array("v", state.v);
}

MembraneLaw membrane_law(const ShellParams& p) {
  const double mean = std::sqrt(p.young_warp * p.young_weft);
  const double shear = p.shear > 0.0 ? p.shear : mean / (2.0 * (1.0 + p.poisson));
  return {1.0 / (p.thickness * p.young_warp), -p.poisson / (p.thickness * mean), 1.0 / (p.thickness * p.young_weft),
          1.0 / (p.thickness * shear)};
}

ShellInputs make_shell_inputs(const ShellMesh& mesh, const ShellParams& params) {
  ShellInputs inputs;
  inputs.mass.reserve(mesh.vertex_count());
  for (const double area : mesh.vertex_area) inputs.mass.push_back(params.density * params.thickness * area);
  inputs.rest_scale.assign(mesh.triangle_count(), 1.0);
  inputs.stiffness_scale.assign(mesh.triangle_count(), 1.0);
  inputs.rest_angle.reserve(mesh.hinges.size());
  for (const Hinge& hinge : mesh.hinges) {
    const auto& v = hinge.vertex;
    const double angle = dihedral_angle(mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]], mesh.rest[v[3]]);
    // Rounding of the positions (files in single precision) is no curvature.
    constexpr double flat = 1e-5;
    inputs.rest_angle.push_back(std::abs(angle) < flat ? 0.0 : angle);
  }
  return inputs;
}

}  // namespace wick::solid
