/// Cost of the pressure projection to 1e-6 from a zero guess: iterations, nanoseconds a cell, the share of the
/// hierarchy, and the memory traffic of a simple model against a triad measured in the same run.
#include <benchmark/benchmark.h>

#include <chrono>

#include "core/parallel.h"
#include "fluid/multigrid.h"
#include "fluid/pressure.h"
#include "tests/fluid/wall_shapes.h"

namespace wick::fluid {
namespace {

enum Shape { none, sphere, flat, tilted, wrinkled, rolled };
const char* const shape_names[] = {"none", "sphere", "flat", "tilted", "wrinkled", "rolled"};

Walls make_walls(const Grid& grid, int shape) {
  Walls walls = no_walls(grid);
  if (shape == none) walls.any = false;
  if (shape == sphere) add_sphere_obstacle(grid, walls, Vec3(0.5, 0.5, 0.3), 0.15);
  if (shape == flat) add_flat_sheet(grid, walls);
  if (shape == tilted) add_tilted_sheet(grid, walls);
  if (shape == wrinkled) add_wrinkled_sheet(grid, walls);
  if (shape == rolled) add_rolled_sheet(grid, walls);
  return walls;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Bytes a second of a = b + q c over arrays far larger than the cache.
double triad_bandwidth(int threads) {
  static std::array<double, 3> known{};
  if (known[threads] > 0.0) return known[threads];
  const ThreadLimit limit(threads);
  const std::size_t count = 1U << 25;
  std::vector<float> a(count, 0.0F), b(count, 1.0F), c(count, 2.0F);
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    parallel_for(count, count / 16, [&](std::size_t i) { a[i] = b[i] + 3.0F * c[i]; });
    known[threads] = std::max(known[threads], 12.0 * static_cast<double>(count) / seconds_since(start));
  }
  benchmark::DoNotOptimize(a.data());
  return known[threads];
}

/// Seconds of one rebuild of the hierarchy with the walls where they were.
double rebuild_seconds(const Grid& grid, const Walls& walls) {
  Multigrid multigrid(grid, open_top);
  multigrid.set_walls(walls, {});
  const auto start = std::chrono::steady_clock::now();
  multigrid.set_walls(walls, {});
  return seconds_since(start);
}

/// Arguments: cells an axis, shape, threads.
void project(benchmark::State& state) {
  const Grid grid = unit_grid(static_cast<int>(state.range(0)));
  const int shape = static_cast<int>(state.range(1)), threads = static_cast<int>(state.range(2));
  const ThreadLimit limit(threads);
  const Walls walls = make_walls(grid, shape);
  const FaceField stirred = stirred_velocity(grid);
  FaceField velocity = stirred;
  std::vector<double> pressure(grid.cells());
  PressureSolver solver(grid, open_top, {.tolerance = 1e-6});
  const ProjectionInput input{.density = 1.2, .dt = 0.01, .walls = &walls};
  SolveReport report;
  double best = 1e30;
  for ([[maybe_unused]] auto _ : state) {
    velocity = stirred;
    std::fill(pressure.begin(), pressure.end(), 0.0);
    report = solver.project(velocity, pressure, input);
    best = std::min(best, report.seconds);
    state.SetIterationTime(report.seconds);
  }
  // 49 passes over a float a cell an iteration: 35 of the V(2,2)-cycle and single-precision CG, 14 more for
  // double; transforms: six passes over doubles.
  const auto cells = static_cast<double>(grid.cells());
  const double bytes = shape == none ? 6 * 16 * cells : 4 * 49.0 * report.iterations * cells;
  const double bandwidth = triad_bandwidth(threads);
  state.SetLabel(shape_names[shape]);
  state.counters["iterations"] = report.iterations;
  state.counters["ns_per_cell"] = 1e9 * best / cells;
  state.counters["model_GB"] = 1e-9 * bytes;
  state.counters["triad_GBs"] = 1e-9 * bandwidth;
  state.counters["of_triad"] = bytes / best / bandwidth;
  if (shape != none) state.counters["setup_share"] = rebuild_seconds(grid, walls) / best;
}

BENCHMARK(project)
    ->ArgNames({"n", "shape", "threads"})
    ->ArgsProduct({{64, 128, 256}, {none, sphere, flat, tilted, wrinkled, rolled}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(3);

}  // namespace
}  // namespace wick::fluid

BENCHMARK_MAIN();
