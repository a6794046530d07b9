#include "coupling/tearing.h"

#include <algorithm>
#include <cmath>

#include "core/noise.h"
#include "coupling/remesh.h"
#include "solid/tear.h"

namespace wick::coupling {

namespace {

bool tears(const Sheet& sheet) {
  return sheet.free() && sheet.params.tearing.has_value();
}

}  // namespace

std::vector<double> tearing_strength(const Sheet& sheet, const WorldParams& world) {
  const TearingParams& p = *sheet.params.tearing;
  std::vector<double> strength(sheet.mesh.vertex_count(), p.strain);
  for (std::size_t i = 0; i < strength.size(); ++i) {
    strength[i] *= 1.0 + p.scatter * hash_signed(static_cast<std::uint64_t>(p.seed), i);
    if (!world.burning) continue;
    const double left = 1.0 - burnt(sheet.burning.fraction_left[i], *world.burning);
    strength[i] *= p.char_strength + (1.0 - p.char_strength) * left * left;
  }
  return strength;
}

std::size_t tear_sheet(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push) {
  if (!tears(sheet)) return 0;
  const std::vector<solid::VertexStrain> strains =
      solid::vertex_strains(sheet.mesh, sheet.state.x, sheet.inputs.rest_scale);
  const std::vector<double> strength = tearing_strength(sheet, world);
  const solid::MeshCut cut = solid::tear(sheet.mesh, strains, strength, sheet.mesh.triangles);
  if (!cut.any()) return 0;
  solid::apply(cut.blends, sheet.mesh.rest);
  for (std::vector<double>* values : {&sheet.snapping, &sheet.theta, &sheet.burning.fraction_left})
    if (!values->empty()) solid::apply(cut.blends, *values);
  follow_mesh(sheet, world, cut.blends, push);
  return cut.born;
}

int tearing_checks(const std::vector<Sheet>& sheets, double dt) {
  constexpr double kPer = 60.0;
  double checks = 1.0;
  for (const Sheet& sheet : sheets)
    if (tears(sheet)) checks = std::max(checks, std::ceil(sheet.params.tearing->checks * kPer * dt * (1.0 - 1e-9)));
  return static_cast<int>(std::min(checks, 1e6));
}

}  // namespace wick::coupling
