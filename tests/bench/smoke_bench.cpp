/// Speed of the smoke step: a plume in an empty box, around a sphere and around sheets, at one and two threads,
/// from 64^3 to 256^3, and of the transport of one scalar alone.
///   bench_smoke [--benchmark_filter=REGEX] [--benchmark_list_tests]   those cases whose name holds a match
///
/// For each stage: ns a cell, and the bytes that the arrays it must read and write come to once each (modelled,
/// without caches) against the bandwidth of a triad measured in the same run.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <regex>
#include <string>

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/smoke.h"
#include "tests/fluid/wall_shapes.h"

namespace {

using namespace wick;
using namespace wick::fluid;

double seconds_of(const std::function<void()>& work, int repeats) {
  double best = 1e30;
  for (int r = 0; r < repeats; ++r) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

/// GB/s of a = b + q c on arrays far larger than the caches.
double triad() {
  const std::size_t n = 1 << 24;
  std::vector<float> a(n), b(n, 1.0F), c(n, 2.0F);
  const double s = seconds_of(
      [&] {
        parallel_chunks(n, 1 << 16, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) a[i] = b[i] + 0.5F * c[i];
        });
      },
      5);
  return 12.0 * double(n) / s * 1e-9;
}

enum class Scene { empty, sphere, flat, wrinkled };
const char* name_of(Scene scene) {
  static const char* const names[] = {"empty", "sphere", "flat", "wrinkled"};
  return names[static_cast<int>(scene)];
}

struct Case {
  int cells;
  Scene scene;
  int threads;
  Advection scalars;

  [[nodiscard]] std::string name() const {
    return "plume/n:" + std::to_string(cells) + "/" + name_of(scene) + "/threads:" + std::to_string(threads) + "/" +
           (scalars == Advection::conservative ? "conservative" : "maccormack");
  }
};

template <class Body>
void for_each_cell(const Grid& g, const Body& body) {
  for (int k = 0; k < g.nz; ++k) {
    for (int j = 0; j < g.ny; ++j) {
      for (int i = 0; i < g.nx; ++i) body(i, j, k);
    }
  }
}

/// A sphere of solid cells, or a sheet of closed faces with nothing inside.
Walls make_walls(const Grid& g, const Sides& sides, Scene scene) {
  if (scene == Scene::empty) return {};
  Walls w = no_walls(g);
  if (scene == Scene::sphere) add_sphere_obstacle(g, w, Vec3(0.5, 0.5, 0.55), 0.15);
  if (scene == Scene::flat) add_flat_sheet(g, w);
  if (scene == Scene::wrinkled) add_wrinkled_sheet(g, w);
  mark_near_walls(g, sides, w);
  return w;
}

SmokeSources burner(const Grid& g, double dt) {
  SmokeSources s;
  for_each_cell(g, [&](int i, int j, int k) {
    const Vec3 x = g.cell_center(i, j, k);
    if ((x - Vec3(0.5, 0.5, 0.12)).norm() < 0.08) s.cell.push_back(std::int64_t(g.cell(i, j, k)));
  });
  const auto n = double(s.cell.size());
  s.smoke.assign(s.cell.size(), 1e-3 * dt / n);
  s.heat.assign(s.cell.size(), 2000.0 * dt / n);
  s.flame.assign(s.cell.size(), 1.0);
  return s;
}

/// Bytes a cell that a stage has to move at least, arrays in and out counted once: floats, 3 components of
/// velocity, 3 scalars.
double modelled_bytes(const std::string& stage, const SmokeStepReport& report, Advection scalars) {
  if (stage == "forces") return 4.0 * (3 * 2 + 2 + 1 + 6 + 3 * 2 + 7);
  // MacCormack also writes and reads the first-order value and its range.
  if (stage == "advect_velocity") return 4.0 * 3 * (2 + 3 + 3 + 4 + 3 + 1);
  if (stage == "advect_scalars" && scalars == Advection::maccormack) return 4.0 * 3 * (2 + 1 + 3 + 4 + 1) + 4.0 * 6;
  // Each pass of sweeps reads and writes the scalars and reads the flow, which is copied, looked at and scaled.
  if (stage == "advect_scalars") return 4.0 * ((report.transport_substeps + 1) * (3 * 2 + 3) + 3 * (2 + 1 + 2));
  // Transforms: six passes over doubles. Multigrid: see the benchmark of pressure.
  if (stage == "pressure")
    return report.pressure.iterations == 0 ? 6 * 16.0 : 4 * 49.0 * report.pressure.iterations;
  return 0.0;
}

/// Smoke and a jet in the lower half of the box, so that the first steps are like all others.
void start_plume(const Grid& g, SmokeState& s) {
  s.velocity = stirred_velocity(g, 0.02);
  for_each_cell(g, [&](int i, int j, int k) {
    const Vec3 x = g.cell_center(i, j, k);
    const double r = (x - Vec3(0.5, 0.5, 0.3)).norm();
    if (r > 0.25) return;
    const std::size_t c = g.cell(i, j, k);
    s.density[c] = float(0.01 * (1.0 - 4.0 * r)), s.temperature[c] = float(100.0 * (1.0 - 4.0 * r));
    s.flame[c] = float(1.0 - 4.0 * r);
  });
}

void plume(const Case& at) {
  ThreadLimit limit(at.threads);
  SmokeParams p;
  p.resolution = {at.cells, at.cells, at.cells};
  p.active_window = false;
  p.buoyancy_smoke = 0.5;
  p.scalar_advection = at.scalars;
  const Grid g = smoke_grid(p);
  const Walls walls = make_walls(g, p.sides, at.scene);
  SmokeState s = make_smoke_state(p);
  start_plume(g, s);
  SmokeSolver solver(p);
  const double bandwidth = triad();
  const int warm = 3, timed = at.cells > 128 ? 2 : 5;
  StageSeconds stages, bytes;
  double total = 0.0, iterations = 0.0, parts = 0.0;
  const double cells = double(g.cells());
  for (int step = 0; step < warm + timed; ++step) {
    const double dt = std::min(0.02, stable_dt(s, p, Vec3(0, 0, -9.81)));
    const SmokeSources sources = burner(g, dt);
    const auto start = std::chrono::steady_clock::now();
    const SmokeStepReport report = solver.step(s, sources, walls, dt);
    if (step < warm) continue;
    total += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / timed;
    iterations += double(report.pressure.iterations) / timed;
    parts += double(report.transport_substeps) / timed;
    for (const auto& [stage, t] : report.seconds) {
      stages[stage] += t / timed;
      bytes[stage] += modelled_bytes(stage, report, at.scalars) * cells / timed;
    }
  }
  std::printf("%-48s step %6.1f ns/cell  pressure iterations %4.1f  transport parts %.1f  triad %.1f GB/s\n",
              at.name().c_str(), total * 1e9 / cells, iterations, parts, bandwidth);
  for (const auto& [stage, t] : stages) {
    std::printf("      %-16s %7.2f ns/cell", stage.c_str(), t * 1e9 / cells);
    if (bytes[stage] > 0)
      std::printf("  %6.2f GB modelled, %3.0f %% of triad", 1e-9 * bytes[stage],
                  1e-7 * bytes[stage] / t / bandwidth);
    std::printf("\n");
  }
  std::fflush(stdout);
}

/// One scalar alone, flow up to 2.5 cells a step.
void scalar(int n, int threads) {
  ThreadLimit limit(threads);
  const Grid g = {n, n, n, 1.0 / n, Vec3::Zero()};
  const Sides sides = SmokeParams{}.sides;
  FaceField u = make_face_field(g);
  for (int a = 0; a < 3; ++a) {
    const Int3 size = lattice_size(g, a);
    for_each_cell({size[0], size[1], size[2], g.h, g.origin}, [&](int i, int j, int k) {
      const Vec3 x = g.face_center(a, i, j, k);
      u[a][g.face(a, i, j, k)] = float(2.5 * std::sin(3 * x[(a + 1) % 3] + a) * std::cos(5 * x[(a + 2) % 3]) *
                                       std::sin(3.14159265 * x[a]));
    });
  }
  CellField q(g.cells());
  for_each_cell(
      g, [&](int i, int j, int k) { q[g.cell(i, j, k)] = float(std::sin(0.1 * i) * std::cos(0.2 * j + k)); });
  Transport t(g, sides, {});
  const Walls none;
  t.set_flow(u, none, g.h);
  CellField* const fields[] = {&q};
  const auto ns = [&](Advection a) { return 1e9 * seconds_of([&] { t.carry(fields, a); }, 5) / double(g.cells()); };
  std::printf("%4d^3 one scalar %dT  semi-Lagrangian %.1f  MacCormack %.1f  conservative %.1f ns/cell\n", n,
              threads, ns(Advection::semi_lagrangian), ns(Advection::maccormack), ns(Advection::conservative));
}

}  // namespace

int main(int argc, char** argv) {
  std::string filter = ".";
  bool only_list = false;
  const std::string option = "--benchmark_filter=";
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with(option)) {
      filter = argument.substr(option.size());
    } else if (argument == "--benchmark_list_tests") {
      only_list = true;
    } else {
      std::fprintf(stderr, "bench_smoke: unknown option %s (known: %sREGEX, --benchmark_list_tests)\n", argv[i],
                   option.c_str());
      return 64;
    }
  }
  const std::regex wanted(filter);
  const auto run = [&](const std::string& name, const std::function<void()>& measure) {
    if (!std::regex_search(name, wanted)) return;
    if (only_list)
      std::printf("%s\n", name.c_str());
    else
      measure();
  };
  for (const int n : {64, 128, 256}) {
    for (const int threads : {1, 2})
      run("scalar/n:" + std::to_string(n) + "/threads:" + std::to_string(threads), [&] { scalar(n, threads); });
    for (const Scene scene : {Scene::empty, Scene::sphere, Scene::flat, Scene::wrinkled})
      for (const Advection scalars : {Advection::conservative, Advection::maccormack})
        for (const int threads : {1, 2}) {
          const Case at = {n, scene, threads, scalars};
          run(at.name(), [&] { plume(at); });
        }
  }
}
