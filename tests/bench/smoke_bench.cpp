/// Speed of the smoke step: a plume with and without a sphere and a sheet, at one and two threads.
///   bench_smoke [--large]                    --large adds 256^3
///   bench_smoke CELLS SCENE THREADS          one plume alone, for profiles
///
/// For each stage: ns a cell, and the bytes a cell that the arrays it must read and write come to once each
/// (modelled, without caches), as a share of the bandwidth of a triad measured in the same run.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/smoke.h"

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

enum class Scene { empty, sphere, sheet };
const char* name_of(Scene scene) {
  return scene == Scene::empty ? "empty" : scene == Scene::sphere ? "sphere" : "sheet";
}

template <class Body>
void for_each_cell(const Grid& g, const Body& body) {
  for (int k = 0; k < g.nz; ++k) {
    for (int j = 0; j < g.ny; ++j) {
      for (int i = 0; i < g.nx; ++i) body(i, j, k);
    }
  }
}

/// A sphere of solid cells, or a square plate of closed faces with nothing inside.
Walls make_walls(const Grid& g, const Sides& sides, Scene scene) {
  Walls w;
  if (scene == Scene::empty) return w;
  w.any = true;
  w.solid.assign(g.cells(), 0);
  w.velocity = make_face_field(g);
  for (int a = 0; a < 3; ++a) w.closed[a].assign(g.faces(a), 0);
  for_each_cell(g, [&](int i, int j, int k) {
    const Vec3 x = g.cell_center(i, j, k);
    if (scene == Scene::sheet) {
      const bool in = std::abs(x.x() - 0.5) < 0.3 && std::abs(x.y() - 0.5) < 0.3 && k == g.nz / 2 + 1;
      if (in) w.closed[2][g.face(2, i, j, k)] = 1;
      return;
    }
    if ((x - Vec3(0.5, 0.5, 0.55)).norm() >= 0.15) return;
    w.solid[g.cell(i, j, k)] = 1;
    w.closed[0][g.face(0, i, j, k)] = w.closed[0][g.face(0, i + 1, j, k)] = 1;
    w.closed[1][g.face(1, i, j, k)] = w.closed[1][g.face(1, i, j + 1, k)] = 1;
    w.closed[2][g.face(2, i, j, k)] = w.closed[2][g.face(2, i, j, k + 1)] = 1;
  });
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

/// Bytes a cell that each stage has to move at least, arrays in and out counted once: floats, 3 components of
/// velocity, 3 scalars; MacCormack also writes and reads the first-order value and its range.
double modelled_bytes(const std::string& stage) {
  if (stage == "forces") return 4.0 * (3 * 2 + 2 + 1 + 6 + 3 * 2 + 7);
  if (stage == "advect_velocity") return 4.0 * 3 * (2 + 3 + 3 + 4 + 3 + 1);
  if (stage == "advect_scalars") return 4.0 * 3 * (2 + 1 + 3 + 4 + 1) + 4.0 * 6;
  return 0.0;
}

void plume(int n, Scene scene, int threads) {
  ThreadLimit limit(threads);
  SmokeParams p;
  p.resolution = {n, n, n};
  p.active_window = false;
  p.buoyancy_smoke = 0.5;
  const Grid g = smoke_grid(p);
  const Walls walls = make_walls(g, p.sides, scene);
  SmokeState s = make_smoke_state(p);
  SmokeSolver solver(p);
  const double bandwidth = triad();
  const int warm = 24, timed = 6;
  StageSeconds stages;
  double total = 0.0, iterations = 0.0;
  for (int step = 0; step < warm + timed; ++step) {
    const double dt = std::min(0.02, stable_dt(s, p, Vec3(0, 0, -9.81)));
    const SmokeSources sources = burner(g, dt);
    const auto start = std::chrono::steady_clock::now();
    const SmokeStepReport report = solver.step(s, sources, walls, dt);
    if (step < warm) continue;
    total += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / timed;
    iterations += double(report.pressure.iterations) / timed;
    for (const auto& [stage, t] : report.seconds) stages[stage] += t / timed;
  }
  const double cells = double(g.cells());
  std::printf("%4d^3 %-6s %dT  step %7.1f ns/cell  pressure iterations %4.1f  triad %.1f GB/s\n", n, name_of(scene),
              threads, total * 1e9 / cells, iterations, bandwidth);
  for (const auto& [stage, t] : stages) {
    std::printf("      %-16s %7.2f ns/cell", stage.c_str(), t * 1e9 / cells);
    const double bytes = modelled_bytes(stage);
    if (bytes > 0)
      std::printf("  %5.0f B/cell modelled, %.0f %% of triad", bytes, 100 * bytes * cells / t * 1e-9 / bandwidth);
    std::printf("\n");
  }
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
  if (argc == 4) {
    const Scene scenes[] = {Scene::empty, Scene::sphere, Scene::sheet};
    for (const Scene scene : scenes) {
      if (!std::strcmp(argv[2], name_of(scene))) plume(std::atoi(argv[1]), scene, std::atoi(argv[3]));
    }
    return 0;
  }
  const bool large = argc > 1 && !std::strcmp(argv[1], "--large");
  for (const int n : {64, 128, 256}) {
    if (n == 256 && !large) continue;
    for (const int threads : {1, 2}) scalar(n, threads);
    for (const Scene scene : {Scene::empty, Scene::sphere, Scene::sheet}) {
      for (const int threads : {1, 2}) plume(n, scene, threads);
    }
  }
}
