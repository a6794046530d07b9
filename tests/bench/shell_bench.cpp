/// Cloth of 140 x 140 vertices, 20 substeps a frame of 1/60 s: milliseconds a frame, and nanoseconds a constraint.
#include <benchmark/benchmark.h>

#include "core/parallel.h"
#include "solid/constraints.h"
#include "solid/primitives.h"

namespace wick::solid {
namespace {

ShellMesh cloth() {
  return build_mesh(rectangle(140, 140, {1.0, std::sqrt(0.75)}));
}

/// A frame of cloth held by its upper edge. Arguments: threads, 0 free / 1 held, share of bent hinges in per cent.
void frame(benchmark::State& bench) {
  ThreadLimit limit(static_cast<int>(bench.range(0)));
  const ShellMesh mesh = cloth();
  ShellParams params;
  params.substeps = 20;
  ShellInputs inputs = make_shell_inputs(mesh, params);
  for (std::size_t h = 0; h < inputs.rest_angle.size(); ++h)
    if (h % 100 < static_cast<std::size_t>(bench.range(2))) inputs.rest_angle[h] = 0.1;
  ShellState state{mesh.rest, std::vector<Vec3>(mesh.vertex_count(), Vec3::Zero())};
  Pins pins;
  for (std::int32_t i = 139 * 140; i < 140 * 140 && bench.range(1) == 1; ++i) {
    pins.vertex.push_back(i);
    pins.target.push_back(mesh.rest[i]);
  }
  ShellSolver solver(mesh, params);
  const std::vector<Obstacle> nothing;
  const std::vector<Vec3> none;
  const ShellLoads loads{inputs, pins, nothing, none, none, Vec3(0, 0, -9.81)};
  for (auto _ : bench) solver.step(state, mesh, loads, 1.0 / 60.0);
}
BENCHMARK(frame)
    ->Args({1, 1, 0})
    ->Args({2, 1, 0})
    ->Args({2, 0, 0})
    ->Args({2, 1, 100})
    ->ArgNames({"threads", "held", "bent"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

std::vector<Row> rows_of(const ShellMesh& mesh) {
  std::vector<Row> rows;
  for (const Vec3& x : mesh.rest) rows.push_back({1.01 * x.x(), x.y(), 0.01 * x.x() * x.y(), 1e5});
  rows.push_back({0, 0, 0, 0});
  return rows;
}

/// One sweep over the constraints; the counter is constraints a second.
void sweep(benchmark::State& bench, bool triangles, bool bent) {
  ThreadLimit limit(static_cast<int>(bench.range(0)));
  const ShellMesh mesh = cloth();
  const ShellParams params;
  ShellInputs inputs = make_shell_inputs(mesh, params);
  if (bent) inputs.rest_angle.assign(mesh.hinges.size(), 0.1);
  ConstraintSet set(mesh, params);
  set.update(inputs, 1.0 / 1200.0);
  std::vector<Row> x = rows_of(mesh);
  const std::vector<Row> previous = x;
  for (auto _ : bench)
    if (triangles)
      set.project_bent_hinges_and_triangles(x, previous, 0.24);
    else
      set.project_flat_hinges(x, 0.24);
  const double count = triangles ? double(mesh.triangle_count()) + (bent ? double(mesh.hinges.size()) : 0.0)
                                 : double(mesh.hinges.size());
  bench.counters["per_constraint"] =
      benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void membrane(benchmark::State& bench) {
  sweep(bench, true, false);
}
void flat_bending(benchmark::State& bench) {
  sweep(bench, false, false);
}
void bent_hinges_and_membrane(benchmark::State& bench) {
  sweep(bench, true, true);
}
BENCHMARK(membrane)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK(flat_bending)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK(bent_hinges_and_membrane)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond)->UseRealTime();

void construction(benchmark::State& bench) {
  const ShellMesh mesh = build_mesh(rectangle(100, 100, {1.0, std::sqrt(0.75)}));
  const ShellParams params;
  for (auto _ : bench) benchmark::DoNotOptimize(ShellSolver(mesh, params));
}
BENCHMARK(construction)->Unit(benchmark::kMillisecond);

void cutting(benchmark::State& bench) {
  const ShellMesh mesh = build_mesh(rectangle(100, 100, {1.0, std::sqrt(0.75)}));
  std::vector<std::uint8_t> keep(mesh.triangle_count(), 1);
  keep[5000] = 0;
  for (auto _ : bench) benchmark::DoNotOptimize(without_triangles(mesh, keep));
}
BENCHMARK(cutting)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace wick::solid
