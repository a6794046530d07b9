/// Figures that are arithmetic: edge vectors (3), the rescaling of eight numbers (7, Table 1), and the rigid limit.
#include <Eigen/Geometry>
#include <cmath>

#include "diffusion/redistribution.h"
#include "diffusion/strain.h"
#include "scenes/experiments/catalogue.h"
#include "scenes/experiments/replay.h"
#include "solid/primitives.h"

namespace wick::scenes {

namespace {

/// Golden numbers of one right triangle: S of a stretch, a shear and the null direction of Eq (5).
ExperimentReport edge_vectors(const Surroundings&) {
  const solid::ShellMesh mesh = solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)},
                                                  {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}, {{0, 1, 2}});
  const auto measure = [&](const Vec3& x1, const Vec3& x2, diffusion::Measure m) {
    return diffusion::strain_measure(diffusion::green_strain(mesh, {Vec3::Zero(), x1, x2}, 0), m, false);
  };
  const Vec3 e1(1, 0, 0), e2(0, 1, 0);
  const double q = std::sqrt(1.2), r = std::sqrt(0.8);
  constexpr auto literal = diffusion::Measure::orthotropic;
  constexpr auto invariant = diffusion::Measure::invariant;
  ExperimentReport report;
  report.checks = {
      at_most("|S - 0.0484| of a stretch of 1.2", {std::abs(measure(1.2 * e1, e2, literal) - 0.0484)}, 1e-12),
      at_most("|S - 0.024525| of a shear of 0.3", {std::abs(measure(e1, Vec3(0.3, 1, 0), literal) - 0.024525)},
              1e-12),
      at_most("|S| along the null direction of Eq 5", {std::abs(measure(q * e1, r * e2, literal))}, 1e-12),
      at_most("|S - 0.005| there, invariant", {std::abs(measure(q * e1, r * e2, invariant) - 0.005)}, 1e-12),
      at_most("|S - 0.1296| of a shrinkage to 0.8", {std::abs(measure(0.8 * e1, 0.8 * e2, literal) - 0.1296)},
              1e-12)};
  return report;
}

/// Table 1: eight values u* + C rescaled to the target 4.3 of Fig 7.
ExperimentReport rescaling(const Surroundings&) {
  const std::vector<double> before = {5.7, 12.0, 2.0, 4.5, 9.3, 6.7, 4.1, 1.5};
  const std::vector<double> expected = {0.535153, 1.126638, 0.187773, 0.422489,
                                        0.873144, 0.629039, 0.384934, 0.140830};
  std::vector<double> v = before;
  const std::vector<double> weight(v.size(), 1.0);
  const std::vector<std::int32_t> members = {0, 1, 2, 3, 4, 5, 6, 7};
  diffusion::project_total(members, weight, 4.3, 0.0, v);
  ExperimentReport report;
  Table table{.name = "table1", .columns = {"vertex", "u*+C", "scale", "target"}, .rows = {}};
  double worst = 0.0, scales = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    worst = std::max(worst, std::abs(v[i] - expected[i]));
    scales += before[i] / 12.0;
    table.add({std::to_string(i)}, {before[i], before[i] / 12.0, v[i]});
  }
  report.tables.push_back(table);
  report.checks = {at_most("largest error of the eight targets", {worst}, 5e-7),
                   at_most("|sum of scales - 3.816667|", {std::abs(scales - 3.816667)}, 5e-7)};
  return report;
}

/// A sheet that only turns and moves has no strain: Eq (8) is then plain diffusion.
ExperimentReport rigid_limit(const Surroundings& s) {
  const std::vector<std::string> still = {"/shells/0/motion/kind=none"};
  Scene ours = s.scene("crumple_wetting", still);
  Scene isotropic = s.scene("crumple_wetting", {still[0], "/diffusion/model=isotropic"});
  for (Scene* scene : {&ours, &isotropic}) {
    scene->world.shells[0].moves = false;
    scene->world.shells[0].mesh.rotation = Vec3(20, 30, 40);
    scene->world.heat_sources[0].kind = coupling::SourceKind::ball;
    scene->world.heat_sources[0].center = scene->world.shells[0].mesh.position;
    scene->world.heat_sources[0].radius = 0.2;
  }
  const SheetHistory a = replay(ours), b = replay(isotropic);
  double worst = 0.0;
  for (std::size_t n = 0; n < a.frames.size(); ++n)
    for (std::size_t i = 0; i < a.frames[n].u.size(); ++i)
      worst = std::max(worst, std::abs(a.frames[n].u[i] - b.frames[n].u[i]));
  ExperimentReport report;
  report.checks = {at_most("largest |u(ours) - u(isotropic)|", {worst}, 1e-13)};
  return report;
}

}  // namespace

void add_arithmetic(std::vector<Experiment>& list) {
  list.push_back({"fig03", "Fig 3: strain from edge vectors", "golden numbers of one triangle", "", edge_vectors});
  list.push_back(
      {"fig07", "Fig 7 and Table 1: rescaling to the target", "the eight numbers of the table", "", rescaling});
  list.push_back({"rigid", "rigid limit (text)", "a rigid sheet diffuses isotropically", "", rigid_limit});
}

}  // namespace wick::scenes
