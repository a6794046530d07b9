/// Figs 1 and 9: a sheet burns with each method on the same deformation.
#include <fmt/format.h>

#include "scenes/experiments/catalogue.h"
#include "scenes/experiments/front_numbers.h"

namespace wick::scenes {

namespace {

struct Method {
  const char* label;
  const char* model;
};

const FrontQuestion burnt_band = {FrontOf::char_, 0.4, true};

/// Numbers of every method over the seeds, and panels of the first seed. The first method is the isotropic one that
/// the others are measured against.
struct Comparison {
  std::vector<MethodNumbers> numbers;
  std::vector<SheetHistory> first;  ///< of seed 1, for the panels
};

Comparison compare(const Surroundings& s, const std::string& scene_name, const std::vector<Method>& methods,
                   const FrontQuestion& question) {
  Comparison result;
  for (const Method& m : methods) result.numbers.push_back({m.label, {}});
  for (int seed = 1; seed <= s.seeds(); ++seed) {
    std::vector<SheetHistory> runs;
    std::vector<std::vector<double>> c;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      s.say(fmt::format("{}: {}, seed {}", scene_name, methods[m].label, seed));
      const Scene scene = s.scene(scene_name, {fmt::format("/diffusion/model={}", methods[m].model),
                                               fmt::format("/shells/0/motion/seed={}", seed)});
      runs.push_back(replay(scene));
      if (c.empty()) c.push_back(strain_density(scene, runs[0].mesh, runs[0].frames.back().x));
      result.numbers[m].seeds.push_back(measure_front(runs[m], runs[0], c, question));
    }
    if (seed == 1) result.first = std::move(runs);
  }
  return result;
}

std::vector<SheetPanel> panels_of(const Comparison& comparison, const FrontQuestion& question, ColorScale scale) {
  std::vector<SheetPanel> panels;
  for (std::size_t m = 0; m < comparison.first.size(); ++m)
    panels.push_back(front_panel(comparison.numbers[m].label, comparison.first[m], question, scale));
  return panels;
}

/// Quotient seed by seed.
std::vector<double> over(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> q;
  for (std::size_t i = 0; i < a.size(); ++i) q.push_back(a[i] / b[i]);
  return q;
}

ExperimentReport burning_methods(const Surroundings& s) {
  const std::vector<Method> methods = {{"isotropic", "isotropic"},
                                       {"ours", "strain_constrained"},
                                       {"Eq 7", "strain_unconstrained"},
                                       {"tensor", "tensor"}};
  const Comparison all = compare(s, "crumple_burning", methods, burnt_band);
  const MethodNumbers &isotropic = all.numbers[0], &ours = all.numbers[1];
  const double h = mean_edge(all.first[0].mesh);
  const auto in_edges = [&](const MethodNumbers& m) {
    std::vector<double> values = m.of(&FrontNumbers::fine_roughness);
    for (double& value : values) value /= h;
    return values;
  };
  ExperimentReport report;
  report.checks = {
      at_least("P(ours)/P(isotropic)",
               over(ours.of(&FrontNumbers::tortuosity), isotropic.of(&FrontNumbers::tortuosity)), 1.15),
      at_least("rG(ours)", ours.of(&FrontNumbers::displacement), 0.5),
      at_least("Rq4(ours) [edges]", in_edges(ours), 0.4),
      at_most("Rq4(isotropic) [edges]", in_edges(isotropic), 0.1),
      reported("Df(ours)", ours.of(&FrontNumbers::dimension)),
      reported("Df(isotropic)", isotropic.of(&FrontNumbers::dimension)),
      reported("r_s(ours)", ours.of(&FrontNumbers::advance))};
  for (std::size_t m = 2; m < all.numbers.size(); ++m)
    report.checks.push_back(
        reported(fmt::format("Rq4({}) [edges]", all.numbers[m].label), in_edges(all.numbers[m])));
  report.tables.push_back(numbers_table("numbers", all.numbers));
  report.pictures.push_back({"fronts",
                             "char when 0.4 of the sheet is burnt, on the same crumpled sheet; line: half burnt",
                             draw_sheets(panels_of(all, burnt_band, ColorScale::fire), 4)});
  return report;
}

}  // namespace

void add_fire(std::vector<Experiment>& list) {
  list.push_back({"fig01", "Fig 1: a sheet burns with several methods", "ours ragged, the others smooth", "",
                  burning_methods});
}

}  // namespace wick::scenes
