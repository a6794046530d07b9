#include "scenes/experiments/replay.h"

#include <algorithm>
#include <cmath>

#include "coupling/world.h"
#include "diffusion/front.h"
#include "diffusion/strain.h"

namespace wick::scenes {

namespace {

SheetFrame frame_of(const coupling::World& world) {
  SheetFrame frame;
  frame.time = world.time();
  const coupling::ShellView view = world.shells().front();
  frame.x = *view.x;
  for (const auto& [name, values] : view.values) {
    if (name == "u") frame.u.assign(values.begin(), values.end());
    if (name == "char")
      for (const float value : values) frame.left.push_back(1.0 - static_cast<double>(value));
  }
  const auto heat = world.ledgers().find("heat");
  if (heat != world.ledgers().end()) {
    frame.heat = heat->second.flows();
    frame.heat["stock"] = heat->second.total_stock();
  }
  return frame;
}

}  // namespace

SheetHistory replay(const Scene& scene, const std::function<bool(const SheetFrame&)>& enough) {
  coupling::World world(scene.world);
  SheetHistory history;
  history.mesh = *world.shells().front().mesh;
  history.frames.push_back(frame_of(world));
  while (world.frame() < scene.frames && !(enough && enough(history.frames.back()))) {
    const coupling::FrameReport report = world.step(1.0 / scene.fps);
    for (const auto& [stage, seconds] : report.seconds) history.seconds[stage] += seconds;
    const auto heat = world.ledgers().find("heat");
    if (heat != world.ledgers().end())
      history.total_error = std::max(history.total_error, std::abs(heat->second.relative_error()));
    history.frames.push_back(frame_of(world));
  }
  return history;
}

std::vector<double> strain_density(const Scene& scene, const solid::ShellMesh& mesh, const std::vector<Vec3>& x) {
  diffusion::DiffusionParams params = *scene.world.diffusion;
  params.gain_form = diffusion::Gain::density;
  params.gain = 1.0;
  std::vector<double> strain, c;
  diffusion::triangle_strain(params, mesh, x, nullptr, strain);
  diffusion::vertex_strain(params, mesh, strain, 1.0, c);
  return c;
}

std::vector<std::vector<double>> strain_densities(const Scene& scene, const SheetHistory& history) {
  const coupling::MotionParams& motion = scene.world.shells[0].motion;
  const bool moves = motion.kind == coupling::MotionKind::recorded || motion.ramp > 0.0 ||
                     (motion.kind == coupling::MotionKind::wave && motion.period > 0.0);
  std::vector<std::vector<double>> c;
  for (std::size_t n = 0; n < (moves ? history.frames.size() : 1); ++n)
    c.push_back(strain_density(scene, history.mesh, history.frames[n].x));
  return c;
}

std::shared_ptr<const coupling::MotionTrack> record_track(Scene scene) {
  scene.world.diffusion.reset();
  scene.world.burning.reset();
  scene.world.heat_sources.clear();
  const SheetHistory history = replay(scene);
  auto track = std::make_shared<coupling::MotionTrack>();
  for (const SheetFrame& frame : history.frames) {
    track->time.push_back(frame.time);
    track->x.push_back(frame.x);
  }
  return track;
}

std::vector<double> front_field(const SheetFrame& frame, FrontOf of) {
  if (of == FrontOf::u) return frame.u;
  std::vector<double> charred;
  for (const double left : frame.left) charred.push_back(1.0 - left);
  return charred;
}

std::size_t frame_at_coverage(const SheetHistory& history, FrontOf of, double coverage) {
  const std::vector<Vec3> x = diffusion::front_coordinates(history.mesh);
  for (std::size_t n = 0; n < history.frames.size(); ++n)
    if (diffusion::find_front(history.mesh, x, front_field(history.frames[n], of), 0.5).covered() >= coverage)
      return n;
  return history.frames.size() - 1;
}

}  // namespace wick::scenes
