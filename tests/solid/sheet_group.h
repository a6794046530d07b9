#pragma once
/// Sheets that advance together and touch each other, for the tests of this folder.
#include <memory>

#include "solid/crossings.h"
#include "solid/sheet_group.h"
#include "tests/solid/sheet.h"

namespace wick::solid {

/// Sheets that advance together; those without `free` are moved by their velocities alone.
struct Group {
  std::vector<std::unique_ptr<Sheet>> sheets;
  std::vector<std::uint8_t> free;
  SheetContactParams params;
  std::unique_ptr<SheetContact> contact;

  Sheet& add(TriangleSoup soup, const ShellParams& p, bool is_free = true) {
    sheets.push_back(std::make_unique<Sheet>(std::move(soup), p));
    free.push_back(is_free ? 1 : 0);
    return *sheets.back();
  }
  std::vector<ShellStepReport> step(double dt) {
    if (!contact) make_contact();
    std::vector<ShellLoads> loads;
    std::vector<std::vector<Vec3>> from;
    for (std::size_t s = 0; s < sheets.size(); ++s) {
      loads.push_back(sheets[s]->loads());
      from.push_back(sheets[s]->state.x);
      if (!free[s])
        for (std::size_t i = 0; i < from[s].size(); ++i) sheets[s]->state.x[i] += dt * sheets[s]->state.v[i];
    }
    std::vector<GroupedSheet> grouped;
    for (std::size_t s = 0; s < sheets.size(); ++s) {
      Sheet& sheet = *sheets[s];
      grouped.push_back(
          {&sheet.mesh, &sheet.state, free[s] ? &sheet.solver : nullptr, &sheet.params, &loads[s], &from[s]});
    }
    return step_together(grouped, *contact, dt);
  }
  [[nodiscard]] std::size_t crossings() const {
    std::vector<PosedSheet> posed;
    for (const auto& sheet : sheets) posed.push_back({&sheet->mesh, &sheet->state.x});
    return find_crossings(posed).size();
  }
  [[nodiscard]] bool finite() const {
    for (const auto& sheet : sheets)
      if (!sheet->finite()) return false;
    return true;
  }

 private:
  void make_contact() {
    std::vector<const ShellMesh*> meshes;
    std::vector<double> half;
    for (const auto& sheet : sheets) {
      meshes.push_back(&sheet->mesh);
      half.push_back(0.5 * (params.thickness > 0.0 ? params.thickness : sheet->params.thickness));
    }
    contact = std::make_unique<SheetContact>(meshes, half, params);
  }
};

inline ShellParams cotton() {
  ShellParams p;
  p.thickness = 1e-3;
  p.density = 160.0;
  p.young_warp = p.young_weft = 2e6;
  p.bending = 1e-5;
  p.air_drag = 1.0;
  p.substeps = 20;
  return p;
}

inline TriangleSoup moved(TriangleSoup soup, const Mat3& turn, const Vec3& by) {
  for (Vec3& x : soup.positions) x = turn * x + by;
  return soup;
}
inline Mat3 turn_about(const Vec3& axis, double degrees) {
  return Eigen::AngleAxisd(degrees * M_PI / 180.0, axis.normalized()).toRotationMatrix();
}
inline double energy_of_motion(const Sheet& sheet) {
  double sum = 0.0;
  for (std::size_t i = 0; i < sheet.state.v.size(); ++i)
    sum += 0.5 * sheet.inputs.mass[i] * sheet.state.v[i].squaredNorm();
  return sum;
}
inline double mass(const Sheet& sheet) {
  double sum = 0.0;
  for (const double m : sheet.inputs.mass) sum += m;
  return sum;
}

}  // namespace wick::solid
