#include "scenes/experiments/comparison.h"

#include <fmt/format.h>

#include <cmath>

namespace wick::scenes {

Method model(const std::string& label, const std::string& name) {
  return {label, {"/diffusion/model=" + name}};
}

std::vector<double> Comparison::roughness(std::size_t method) const {
  std::vector<double> values = of(method, &FrontNumbers::fine_roughness);
  for (double& value : values) value /= edge;
  return values;
}

std::vector<double> Comparison::advance_size(std::size_t method) const {
  std::vector<double> values = of(method, &FrontNumbers::advance);
  for (double& value : values) value = std::abs(value);
  return values;
}

Comparison compare(const Surroundings& s, const std::string& scene_name, const std::vector<Method>& methods,
                   const FrontQuestion& question) {
  Comparison result;
  for (const Method& m : methods) result.numbers.push_back({m.label, {}});
  for (int seed = 1; seed <= s.seeds(); ++seed) {
    std::vector<SheetHistory> runs;
    std::vector<std::vector<double>> c;
    std::shared_ptr<const coupling::MotionTrack> track;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      s.say(fmt::format("{}: {}, seed {}", scene_name, methods[m].label, seed));
      Scene scene = s.scene(scene_name, methods[m].assignments);
      coupling::MotionParams& motion = scene.world.shells[0].motion;
      if (motion.kind == coupling::MotionKind::none) {
        if (scene.world.wind) scene.world.wind->seed = seed;
        if (!track) track = record_track(scene);
        motion.kind = coupling::MotionKind::recorded;
        motion.track = track;
        scene.world.shells[0].pins.clear();
        scene.world.wind.reset();
      }
      motion.seed = seed;
      runs.push_back(replay(scene));
      if (c.empty()) c = strain_densities(scene, runs[0]);
      result.numbers[m].seeds.push_back(measure_front(runs[m], runs[0], c, question));
    }
    result.edge = mean_edge(runs[0].mesh);
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

std::vector<double> over(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> q;
  for (std::size_t i = 0; i < a.size(); ++i) q.push_back(a[i] / b[i]);
  return q;
}

void add_earlier_method(const Comparison& all, std::size_t method, std::size_t ours, ExperimentReport& report) {
  const std::string& label = all.numbers[method].label;
  report.checks.push_back(at_most("rG(" + label + ")", all.of(method, &FrontNumbers::displacement), 0.2));
  report.checks.push_back(
      at_most("Rq4(" + label + ")/Rq4(ours)", over(all.roughness(method), all.roughness(ours)), 0.5));
  report.checks.push_back(at_most("|r_s(" + label + ")|", all.advance_size(method), 0.15));
  report.checks.push_back(reported("r_s partial(" + label + ")", all.of(method, &FrontNumbers::advance_partial)));
}

}  // namespace wick::scenes
