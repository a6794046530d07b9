/// Milliseconds of one implicit diffusion step on a sheet, against refactoring with Eigen's SimplicialLDLT in the
/// same run. soft: the diffusion length is about an edge; stiff: ten times that.
#include <benchmark/benchmark.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <map>

#include "diffusion/linear_solver.h"
#include "diffusion/operators.h"
#include "diffusion/strain_diffusion.h"
#include "solid/primitives.h"

namespace wick::diffusion {
namespace {

struct Case {
  solid::ShellMesh mesh;
  std::vector<Vec3> x;
  std::vector<double> u;
  double diffusion;  ///< dt α
};

/// Sheets of 20,000 and 200,000 vertices, bent a little, with a front across the middle.
const Case& make_case(bool large, bool stiff) {
  static std::map<std::pair<bool, bool>, Case> cases;
  Case& c = cases[{large, stiff}];
  if (!c.u.empty()) return c;
  const int n = large ? 447 : 141;
  c.mesh = solid::build_mesh(solid::rectangle(n, n, Vec2(1.0, 1.0)));
  c.x = c.mesh.rest;
  for (Vec3& p : c.x) p.z() += 0.02 * std::sin(12.0 * p.x() + 7.0 * p.y());
  for (const Vec3& p : c.mesh.rest)
    c.u.push_back(0.5 - 0.5 * std::tanh((p.x() - 0.5 + 0.05 * std::sin(20.0 * p.y())) / 0.05));
  const double length = (large ? 2.6 : 0.8) * (stiff ? 10.0 : 1.0) / (n - 1);
  c.diffusion = length * length;
  return c;
}

void run_step(benchmark::State& state, DiffusionParams p) {
  const Case& c = make_case(state.range(0) != 0, state.range(1) != 0);
  p.alpha = c.diffusion * 60.0;
  DiffusionSolver solver(p);
  const DiffusionInput in{.mesh = &c.mesh, .x = &c.x, .mass = &c.mesh.vertex_area};
  std::vector<double> u = c.u;
  solver.step(u, in, 1.0 / 60.0);
  double strain = 0.0, total = 0.0;
  DiffusionReport r;
  for (auto _ : state) {
    u = c.u;
    r = solver.step(u, in, 1.0 / 60.0);
    strain += r.seconds_strain;
    total += r.seconds_strain + r.seconds_solve;
  }
  state.counters["iterations"] = r.solve.iterations;
  state.counters["strain_share"] = strain / total;
  state.counters["residual"] = r.solve.residual_after;
}

/// Eq (8a) alone.
void isotropic(benchmark::State& state) {
  DiffusionParams p;
  p.model = Model::isotropic;
  p.tolerance = 1e-6;
  run_step(state, p);
}
/// The same with edge lengths of the moving sheet, so that all values are assembled anew.
void isotropic_current_metric(benchmark::State& state) {
  DiffusionParams p;
  p.model = Model::isotropic;
  p.metric = Metric::current;
  p.tolerance = 1e-6;
  run_step(state, p);
}
void strain_after(benchmark::State& state) {
  DiffusionParams p;
  p.order = Order::after;
  p.tolerance = 1e-6;
  run_step(state, p);
}
void burning_preset(benchmark::State& state) {
  run_step(state, make_preset(Preset::burning));
}
void wetting_preset(benchmark::State& state) {
  run_step(state, make_preset(Preset::wetting));
}

/// Assembly, numeric factorisation and solve of the same system, symbolic analysis kept.
void eigen_ldlt(benchmark::State& state) {
  const Case& c = make_case(state.range(0) != 0, state.range(1) != 0);
  const SheetGraph graph = build_graph(c.mesh);
  SheetOperator op;
  build_operator(c.mesh, graph, {}, c.mesh.rest, corner_cotangents(c.mesh, c.mesh.rest), c.mesh.vertex_area, op);
  SheetMatrix matrix;
  const int n = static_cast<int>(c.u.size());
  Eigen::SparseMatrix<double> a(n, n);
  Eigen::VectorXd rhs(n), u(n);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
  const auto fill = [&](bool first) {
    assemble(graph, op, c.diffusion, {}, {}, matrix);
    for (int j = 0; j < n; ++j) {
      if (first) {
        a.startVec(j);
        a.insertBack(j, j) = 0.0;
        for (int k = graph.offset[j]; k < graph.offset[j + 1]; ++k)
          if (graph.column[k] > j) a.insertBack(graph.column[k], j) = 0.0;
      }
    }
    if (first) a.finalize();
    double* value = a.valuePtr();
    for (int j = 0; j < n; ++j) {
      *value++ = matrix.diagonal[j];
      for (int k = graph.offset[j]; k < graph.offset[j + 1]; ++k)
        if (graph.column[k] > j) *value++ = matrix.entry[k];
    }
  };
  fill(true);
  factor.analyzePattern(a);
  for (auto _ : state) {
    fill(false);
    factor.factorize(a);
    for (int i = 0; i < n; ++i) rhs[i] = matrix.storage[i] * c.u[i];
    u = factor.solve(rhs);
    benchmark::DoNotOptimize(u.data());
  }
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"large", "stiff"})->Args({0, 0})->Args({0, 1})->Args({1, 0})->Args({1, 1});
  b->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.3);
}

BENCHMARK(isotropic)->Apply(sizes);
BENCHMARK(isotropic_current_metric)->Apply(sizes);
BENCHMARK(strain_after)->Apply(sizes);
BENCHMARK(burning_preset)->Apply(sizes);
BENCHMARK(wetting_preset)->Apply(sizes);
BENCHMARK(eigen_ldlt)->Apply(sizes);

}  // namespace
}  // namespace wick::diffusion
