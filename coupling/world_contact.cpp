/// The part of the world that keeps sheets from passing through themselves and each other.
#include "core/require.h"
#include "coupling/world_impl.h"
#include "solid/sheet_group.h"

namespace wick::coupling {

namespace {

std::unique_ptr<solid::SheetContact> make_contact(const std::vector<Sheet>& sheets,
                                                  const solid::SheetContactParams& params) {
  std::vector<const solid::ShellMesh*> meshes;
  std::vector<double> half_thickness;
  for (const Sheet& sheet : sheets) {
    meshes.push_back(&sheet.mesh);
    half_thickness.push_back(0.5 * (params.thickness > 0.0 ? params.thickness : sheet.params.material.thickness));
  }
  return std::make_unique<solid::SheetContact>(meshes, half_thickness, params);
}

}  // namespace

/// Sheets that cross at the start are refused where contact is to keep them apart, and told of elsewhere.
void World::Impl::look_for_crossings() {
  std::vector<std::string> lines = crossing_sheets(sheets);
  if (params.contact && !params.contact->allow_crossings && !lines.empty()) {
    const std::size_t colon = lines.front().find(':');
    throw Refusal(ExitCode::scene_invalid, lines.front().substr(0, colon),
                  lines.front().substr(colon + 2) + "; move it, or set /contact/allow_crossings");
  }
  for (std::string& line : lines) warnings.push_back(std::move(line));
  if (!params.contact) return;
  contact = make_contact(sheets, params.contact->sheets);
  if (const std::size_t lowered = contact->lowered(); lowered > 0)
    warnings.push_back("/contact/thickness: is more than the edges of the meshes bear at " +
                       std::to_string(lowered) + " vertices, where it is lowered to 0.6 of the shortest edge");
}

/// All sheets side by side, those that are held or driven as what the others meet.
void World::Impl::move_sheets_together(double end, double dt, FrameReport& report) {
  if (!contact) contact = make_contact(sheets, params.contact->sheets);
  const std::size_t count = sheets.size();
  std::vector<std::vector<Vec3>> from(count), air(count);
  std::vector<solid::Pins> pins(count);
  std::vector<solid::ShellLoads> loads;
  std::vector<solid::GroupedSheet> grouped;
  loads.reserve(count);
  for (std::size_t s = 0; s < count; ++s) {
    Sheet& sheet = sheets[s];
    from[s] = sheet.state.x;
    if (sheet.driven()) follow_motion(sheet, end, dt);
    refresh_inputs(sheet, params);
    if (!gas && sheet.shell) air[s] = wind_at(params, sheet.state.x, end - dt);
    pins[s] = pins_at(sheet, end);
    loads.push_back({sheet.inputs, pins[s], obstacles, push[s], air[s], params.gravity});
    grouped.push_back({&sheet.mesh, &sheet.state, sheet.shell.get(), &sheet.params.material, &loads[s], &from[s]});
  }
  const std::vector<solid::ShellStepReport> reports = solid::step_together(grouped, *contact, dt);
  for (std::size_t s = 0; s < count; ++s) sheets[s].report.shell = reports[s];
  report.forced_contacts += static_cast<int>(contact->report().impossible);
}

}  // namespace wick::coupling
