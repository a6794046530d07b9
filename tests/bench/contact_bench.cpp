/// Cloth of 140 x 140 vertices that touches itself, 20 substeps a frame of 1/60 s: milliseconds a frame, beside the
/// same frame without contact; and what a vertex costs from 5 to 200 thousand of them.
#include <benchmark/benchmark.h>

#include <memory>

#include "core/parallel.h"
#include "solid/primitives.h"
#include "solid/sheet_group.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0;

ShellParams cotton() {
  ShellParams p;
  p.thickness = 1e-3;
  p.density = 160.0;
  p.young_warp = p.young_weft = 2e6;
  p.bending = 1e-5;
  p.air_drag = 1.0;
  p.substeps = 20;
  return p;
}

/// One sheet with all that a step needs.
struct Cloth {
  explicit Cloth(TriangleSoup soup)
      : mesh(build_mesh(std::move(soup))),
        params(cotton()),
        inputs(make_shell_inputs(mesh, params)),
        solver(mesh, params),
        state{mesh.rest, std::vector<Vec3>(mesh.vertex_count(), Vec3::Zero())},
        contact(std::vector<const ShellMesh*>{&mesh}, std::vector<double>{0.5 * params.thickness}, {}) {}

  void frame(bool touches) {
    const std::vector<Vec3> none;
    const ShellLoads loads{inputs, pins, obstacles, none, none, Vec3(0, 0, -9.81)};
    if (!touches) {
      solver.step(state, mesh, loads, kFrame);
      return;
    }
    GroupedSheet sheet{&mesh, &state, &solver, &params, &loads, nullptr};
    step_together({&sheet, 1}, contact, kFrame);
  }

  ShellMesh mesh;
  ShellParams params;
  ShellInputs inputs;
  ShellSolver solver;
  ShellState state;
  SheetContact contact;
  Pins pins;
  std::vector<Obstacle> obstacles;
};

const Obstacle kFloor{"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5};

/// Lying flat on a floor.
std::unique_ptr<Cloth> flat(int n) {
  auto cloth = std::make_unique<Cloth>(rectangle(n, n, {n / 140.0, n / 140.0 * std::sqrt(0.75)}));
  for (Vec3& x : cloth->state.x) x.z() = 0.5 * cloth->params.thickness;
  cloth->obstacles.push_back(kFloor);
  return cloth;
}

/// Hung up, dropped on the floor and come to lie there in folds.
std::unique_ptr<Cloth> crumpled(int n, int frames) {
  TriangleSoup soup = rectangle(n, n, {n / 140.0, n / 140.0 * std::sqrt(0.75)});
  for (Vec3& x : soup.positions)
    x = Vec3(x.x(), 0.01 * std::sin(9 * x.y()) * std::sin(7 * x.x() + 1), x.y() + 0.02);
  auto cloth = std::make_unique<Cloth>(std::move(soup));
  cloth->obstacles.push_back(kFloor);
  for (int k = 0; k < frames; ++k) cloth->frame(true);
  return cloth;
}

void report(benchmark::State& bench, const Cloth& cloth) {
  bench.counters["pairs"] = static_cast<double>(cloth.contact.report().pairs);
  bench.counters["contacts"] = static_cast<double>(cloth.contact.report().contacts);
  bench.counters["per_vertex"] =
      benchmark::Counter(static_cast<double>(cloth.mesh.vertex_count()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Arguments: threads, with contact.
void flat_frame(benchmark::State& bench) {
  const ThreadLimit limit(static_cast<int>(bench.range(0)));
  const auto cloth = flat(140);
  for (auto _ : bench) cloth->frame(bench.range(1) == 1);
  report(bench, *cloth);
}
BENCHMARK(flat_frame)
    ->ArgsProduct({{1, 2}, {0, 1}})
    ->ArgNames({"threads", "contact"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void crumpled_frame(benchmark::State& bench) {
  const ThreadLimit limit(static_cast<int>(bench.range(0)));
  static const ShellState lying = crumpled(140, 150)->state;
  auto cloth = crumpled(140, 0);
  cloth->state = lying;
  for (auto _ : bench) cloth->frame(bench.range(1) == 1);
  report(bench, *cloth);
}
BENCHMARK(crumpled_frame)
    ->ArgsProduct({{1, 2}, {1}})
    ->ArgNames({"threads", "contact"})
    ->Iterations(10)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Vertices a side; all edges have the same length.
void flat_size(benchmark::State& bench) {
  const ThreadLimit limit(2);
  const auto cloth = flat(static_cast<int>(bench.range(0)));
  for (auto _ : bench) cloth->frame(true);
  report(bench, *cloth);
}
BENCHMARK(flat_size)->Arg(71)->Arg(141)->Arg(283)->Arg(447)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The same while it falls in folds.
void falling_size(benchmark::State& bench) {
  const ThreadLimit limit(2);
  const auto cloth = crumpled(static_cast<int>(bench.range(0)), 16);
  for (auto _ : bench) cloth->frame(true);
  report(bench, *cloth);
}
BENCHMARK(falling_size)->Arg(71)->Arg(141)->Arg(283)->Iterations(1)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace wick::solid
