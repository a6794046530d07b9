/// Cloth of 140 x 140 vertices that touches itself, 20 substeps a frame of 1/60 s: milliseconds a frame, beside the
/// same frame without contact; and what a vertex costs from 5 to 200 thousand of them.
#include <benchmark/benchmark.h>

#include <memory>

#include "core/parallel.h"
#include "tests/solid/sheet_group.h"

namespace wick::solid {
namespace {

constexpr double kFrame = 1.0 / 60.0;

/// One sheet of cotton under gravity.
struct Cloth {
  explicit Cloth(TriangleSoup soup) : sheet(group.add(std::move(soup), cotton())) {
    sheet.gravity = Vec3(0, 0, -9.81);
  }
  void frame(bool touches) {
    if (touches)
      group.step(kFrame);
    else
      sheet.step(kFrame);
  }

  Group group;
  Sheet& sheet;
};

const Obstacle kFloor{"floor", PlaneShape{Vec3::Zero(), Vec3::UnitZ()}, 0.5};

/// Lying flat on a floor.
std::unique_ptr<Cloth> flat(int n) {
  auto cloth = std::make_unique<Cloth>(rectangle(n, n, {n / 140.0, n / 140.0 * std::sqrt(0.75)}));
  for (Vec3& x : cloth->sheet.state.x) x.z() = 0.5 * cloth->sheet.params.thickness;
  cloth->sheet.obstacles.push_back(kFloor);
  return cloth;
}

/// Hung up, dropped on the floor and come to lie there in folds.
std::unique_ptr<Cloth> crumpled(int n, int frames) {
  TriangleSoup soup = rectangle(n, n, {n / 140.0, n / 140.0 * std::sqrt(0.75)});
  for (Vec3& x : soup.positions)
    x = Vec3(x.x(), 0.01 * std::sin(9 * x.y()) * std::sin(7 * x.x() + 1), x.y() + 0.02);
  auto cloth = std::make_unique<Cloth>(std::move(soup));
  cloth->sheet.obstacles.push_back(kFloor);
  for (int k = 0; k < frames; ++k) cloth->frame(true);
  return cloth;
}

void report(benchmark::State& bench, const Cloth& cloth) {
  const SheetContactReport last = cloth.group.contact ? cloth.group.contact->report() : SheetContactReport{};
  bench.counters["pairs"] = static_cast<double>(last.pairs);
  bench.counters["contacts"] = static_cast<double>(last.contacts);
  bench.counters["per_vertex"] =
      benchmark::Counter(static_cast<double>(cloth.sheet.mesh.vertex_count()),
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
  static const ShellState lying = crumpled(140, 150)->sheet.state;
  auto cloth = crumpled(140, 0);
  cloth->sheet.state = lying;
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
