#include "coupling/ablation.h"

#include "coupling/remesh.h"

namespace wick::coupling {

namespace {

/// Integrals over the sheet of what is linear on each triangle: mass [kg] and heat [J].
struct Content {
  double mass = 0.0, heat = 0.0;
};

Content content(const Sheet& sheet, const WorldParams& world) {
  const double per_theta = world.heat.heat_capacity * world.temperature_scale();
  Content sum;
  for (std::size_t t = 0; t < sheet.mesh.triangle_count(); ++t) {
    const double third = sheet.areal_mass * sheet.mesh.rest_area[t] / 3.0;
    for (const std::int32_t i : sheet.mesh.triangles[t]) {
      sum.mass += third * sheet.burning.fraction_left[i];
      sum.heat += third * per_theta * sheet.theta[i];
    }
  }
  return sum;
}

/// Cuts the sheet's mesh along the contour. Returns whether that changed anything.
bool cut_along_rim(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push) {
  std::vector<double> level = sheet.burning.fraction_left;
  for (double& l : level) l -= world.burning->removal;
  solid::CutSurface surface{sheet.mesh.rest,
                            sheet.mesh.triangles,
                            sheet.snapping,
                            {sheet.burning.fraction_left, sheet.theta},
                            {world.burning->ash, 0.0}};
  const solid::MeshCut cut = solid::cut_below(surface, std::move(level));
  if (!cut.any()) return false;
  sheet.mesh.rest = std::move(surface.rest);
  sheet.mesh.triangles = std::move(surface.triangles);
  sheet.snapping = std::move(surface.snapping);
  sheet.burning.fraction_left = std::move(surface.density[0]);
  sheet.theta = std::move(surface.density[1]);
  follow_mesh(sheet, world, cut.blends, push);
  return true;
}

}  // namespace

Ablated ablate(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push) {
  const BurningParams& burning = *world.burning;
  bool any_burnt = false;
  for (std::size_t i = 0; i < sheet.burning.fraction_left.size() && !any_burnt; ++i)
    any_burnt = sheet.mesh.vertex_area[i] > 0.0 && sheet.burning.fraction_left[i] < burning.removal;
  if (!any_burnt) return {};
  const Content before = content(sheet, world);
  const bool whole = burning.rim == BurntRim::whole || sheet.driven();
  const bool any = whole ? drop_triangles(sheet, world, unburnt_triangles(sheet.mesh, sheet.burning, burning), push)
                         : cut_along_rim(sheet, world, push);
  if (!any) return {};
  const Content after = content(sheet, world);
  return {true, before.mass - after.mass, before.heat - after.heat};
}

}  // namespace wick::coupling
