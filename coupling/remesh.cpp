#include "coupling/remesh.h"

#include <algorithm>

namespace wick::coupling {

namespace {

/// Blends forces by what they are on an area, so that a smaller piece gets less.
class ForceDensity {
 public:
  ForceDensity(std::vector<Vec3>& force, const solid::ShellMesh& before, const std::vector<solid::Blend>& blends)
      : force_(force) {
    if (force_.empty()) return;
    for (std::size_t i = 0; i < force_.size(); ++i)
      if (before.vertex_area[i] > 0.0) force_[i] /= before.vertex_area[i];
    solid::apply(blends, force_);
  }
  void spread(const solid::ShellMesh& after) {
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] *= after.vertex_area[i];
  }

 private:
  std::vector<Vec3>& force_;
};

/// Everything that the sheet keeps per vertex, but for forces, what is rebuilt, and mass and heat, which have been
/// kept as integrals.
void blend_values(Sheet& sheet, const std::vector<solid::Blend>& blends) {
  const auto blend = [&](auto& values) {
    if (!values.empty()) solid::apply(blends, values);
  };
  blend(sheet.mesh.material);
  blend(sheet.state.x);
  blend(sheet.state.v);
  blend(sheet.strain_added);
  blend(sheet.burning.curl);
  blend(sheet.seen_x);
}

/// Copies of a vertex start a hair apart, each towards the triangles that are its own: contact keeps apart what is
/// apart, and what touches in a point has no side.
void part_twins(Sheet& sheet, const std::vector<solid::Blend>& blends) {
  constexpr double kHair = 1e-3;
  const std::vector<Vec3> x = sheet.state.x;
  const auto draw_in = [&](std::int32_t i) {
    Vec3 middle = Vec3::Zero();
    const std::int32_t first = sheet.mesh.incident_offset[i], end = sheet.mesh.incident_offset[i + 1];
    for (std::int32_t k = first; k < end; ++k)
      for (const std::int32_t j : sheet.mesh.triangles[sheet.mesh.incident[k]])
        middle += x[j] / (3.0 * (end - first));
    if (end > first) sheet.state.x[i] = x[i] + kHair * (middle - x[i]);
  };
  for (const solid::Blend& twin : blends)
    if (twin.a == twin.b) draw_in(twin.vertex), draw_in(twin.a);
}

/// A pin holds a place of the material: where that has burnt it lets go.
void release_burnt_pins(Sheet& sheet, const std::vector<solid::Blend>& blends) {
  std::vector<std::uint8_t> gone(sheet.mesh.vertex_count(), 0);
  for (std::size_t i = 0; i < gone.size(); ++i)
    gone[i] = sheet.mesh.incident_offset[i] == sheet.mesh.incident_offset[i + 1];
  for (const solid::Blend& blend : blends)
    if (blend.vertex == blend.a) gone[blend.vertex] = 1;
  for (PinSet& pin : sheet.pins) {
    std::size_t kept = 0;
    for (std::size_t n = 0; n < pin.vertices.size(); ++n) {
      if (gone[pin.vertices[n]]) continue;
      pin.vertices[kept] = pin.vertices[n];
      pin.start[kept++] = pin.start[n];
    }
    pin.vertices.resize(kept);
    pin.start.resize(kept);
  }
}

}  // namespace

void follow_mesh(Sheet& sheet, const WorldParams& world, const std::vector<solid::Blend>& blends,
                 std::vector<Vec3>& push) {
  ForceDensity pushed(push, sheet.mesh, blends), relaxed(sheet.gas_force, sheet.mesh, blends);
  blend_values(sheet, blends);
  rebuild_topology(sheet, world);
  release_burnt_pins(sheet, blends);
  part_twins(sheet, blends);
  pushed.spread(sheet.mesh);
  relaxed.spread(sheet.mesh);
}

bool drop_triangles(Sheet& sheet, const WorldParams& world, const std::vector<std::uint8_t>& keep,
                    std::vector<Vec3>& push) {
  std::vector<Int3>& triangles = sheet.mesh.triangles;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < keep.size(); ++t)
    if (keep[t]) triangles[kept++] = triangles[t];
  if (kept == keep.size()) return false;
  triangles.resize(kept);
  follow_mesh(sheet, world, {}, push);
  return true;
}

}  // namespace wick::coupling
