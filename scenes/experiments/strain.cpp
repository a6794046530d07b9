/// Figs 4 and 5: C on a sheet under load, and what the weakening delta does to it.
#include "diffusion/strain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diffusion/front.h"
#include "scenes/experiments/catalogue.h"
#include "scenes/experiments/replay.h"
#include "solid/primitives.h"

namespace wick::scenes {

namespace {

/// Σ C_t = Σ A S/2 over the sheet [m²].
double total_strain(const Scene& scene, const solid::ShellMesh& mesh, const std::vector<Vec3>& x) {
  std::vector<double> strain;
  diffusion::triangle_strain(*scene.world.diffusion, mesh, x, nullptr, strain);
  double sum = 0.0;
  for (std::size_t t = 0; t < strain.size(); ++t) sum += 0.5 * mesh.rest_area[t] * strain[t];
  return sum;
}

/// Relative error of Σ C_t of a uniform stretch q along x against its closed form A S/2, S = (E² + E²/8) with the
/// Green strain E = (q² - 1)/2.
double uniform_error(const Scene& scene) {
  const solid::ShellMesh mesh = solid::build_mesh(solid::rectangle(47, 54, Vec2(1.0, 1.0)));
  std::vector<Vec3> x = mesh.rest;
  const double q = 1.1, e = 0.5 * (q * q - 1.0);
  for (Vec3& p : x) p.x() *= q;
  return std::abs(total_strain(scene, mesh, x) / (0.5 * (e * e + e * e / 8.0)) - 1.0);
}

ExperimentReport strain_under_load(const Surroundings& s) {
  s.say("fig04: a corner is pulled");
  const Scene scene = s.scene("pulled_sheet");
  const SheetHistory h = replay(scene);
  std::vector<double> time, total;
  for (const SheetFrame& frame : h.frames) {
    time.push_back(frame.time);
    total.push_back(total_strain(scene, h.mesh, frame.x));
  }
  // The load grows evenly; ten stations of it.
  bool rises = true;
  for (std::size_t n = 6; n < total.size(); n += 6) rises = rises && total[n] > total[n - 6];
  ExperimentReport report;
  report.checks = {at_most("C at rest", {total[0]}, 1e-14),
                   at_most("error of sum C of a uniform stretch of 1.1", {uniform_error(scene)}, 1e-10),
                   holds("sum C rises with the load", rises, "at ten stations")};
  std::vector<SheetPanel> panels;
  for (const std::size_t n : {std::size_t{0}, std::size_t{20}, std::size_t{40}, std::size_t{60}}) {
    std::vector<double> c = strain_density(scene, h.mesh, h.frames[n].x);
    for (double& value : c) value = std::sqrt(value);
    panels.push_back(
        {fmt::format("{:.2f} s", h.frames[n].time), &h.mesh, h.frames[n].x, c, 0.0, 0.15, ColorScale::strain, {}});
  }
  report.pictures.push_back(
      {"strain", "the pulled sheet from above; colour: √c, dark 0.15", draw_sheets(panels, 4)});
  report.pictures.push_back({"load", "total strain while the corner is pulled at constant speed",
                             draw_charts({{.title = "sum of C",
                                           .x_label = "t [s]",
                                           .y_label = "sum A S/2 [m2]",
                                           .series = {{"", time, total}}}})});
  return report;
}

ExperimentReport weakening(const Surroundings& s) {
  ExperimentReport report;
  std::vector<double> imposed, loaded;
  std::vector<SheetHistory> strips;
  strips.reserve(3);
  std::vector<SheetPanel> panels;
  Table table{.name = "weakening", .columns = {"delta", "imposed", "loaded"}, .rows = {}};
  for (const double delta : {0.0, 1.0, 10.0}) {
    s.say(fmt::format("fig05: delta {}", delta));
    const std::string change = fmt::format("/diffusion/delta={}", delta);
    const Scene held = s.scene("crumple_wetting", {change, "/frames=2"});
    const SheetHistory a = replay(held);
    imposed.push_back(total_strain(held, a.mesh, a.frames.back().x));
    const Scene hung = s.scene("hanging_strip", {change});
    const SheetHistory b = replay(hung);
    loaded.push_back(total_strain(hung, b.mesh, b.frames.back().x));
    strips.push_back(b);
    std::vector<double> c = strain_density(hung, strips.back().mesh, strips.back().frames.back().x);
    for (double& value : c) value = std::sqrt(value);
    panels.push_back({fmt::format("delta {}", delta),
                      &strips.back().mesh,
                      diffusion::front_coordinates(strips.back().mesh),
                      c,
                      0.0,
                      1.0,
                      ColorScale::strain,
                      {}});
    table.add({fmt::format("{}", delta)}, {imposed.back(), loaded.back()});
  }
  const double error =
      std::max(std::abs(imposed[1] * 2.0 / imposed[0] - 1.0), std::abs(imposed[2] * 11.0 / imposed[0] - 1.0));
  report.checks = {at_most("imposed shape: error of sum C ~ 1/(1 + delta)", {error}, 1e-12),
                   holds("under load, weakened cloth: sum C rises with delta",
                         loaded[0] < loaded[1] && loaded[1] < loaded[2], "strictly"),
                   reported("sum C at delta 10 over delta 0, under load", {loaded[2] / loaded[0]})};
  report.tables.push_back(table);
  double darkest = 0.0;
  for (const SheetPanel& p : panels)
    darkest = std::max(darkest, *std::max_element(p.values.begin(), p.values.end()));
  for (SheetPanel& p : panels) p.high = darkest;
  report.pictures.push_back({"pattern",
                             "a strip that hangs in its own weight, weakened by delta; colour: √c, the same scale",
                             draw_sheets(panels, 3)});
  report.analysis =
      "The paper says both that a larger delta weakens the influence of stretching and that it strengthens the "
      "pattern. Both "
      "are right: S is multiplied by 1/(1 + delta), so an imposed shape gives less; but where the cloth itself is "
      "softened by "
      "the same factor, a given load stretches it (1 + delta) times as far, and S, which is quadratic, grows.";
  return report;
}

}  // namespace

void add_strain(std::vector<Experiment>& list) {
  list.push_back({"fig04", "Fig 4: C under an external force",
                  "zero at rest, rises with the load, local at the pins", "", strain_under_load});
  list.push_back({"fig05", "Fig 5: a small and a large delta", "the pattern differs with delta", "", weakening});
}

}  // namespace wick::scenes
