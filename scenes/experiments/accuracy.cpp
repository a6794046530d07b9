/// Work and precision of the diffusion against closed forms: which operator, tolerance, step and mesh a run needs.
#include "scenes/experiments/accuracy.h"

#include <chrono>
#include <cmath>

#include "core/noise.h"
#include "diffusion/sums.h"
#include "scenes/experiments/catalogue.h"

namespace wick::scenes {

const char* name_of(MeshKind kind) {
  constexpr const char* names[] = {"staggered", "jittered", "graded", "single diagonal", "union jack"};
  return names[static_cast<int>(kind)];
}

solid::ShellMesh make_sheet(MeshKind kind, int along, const Vec2& size) {
  const bool squares = kind == MeshKind::single_diagonal || kind == MeshKind::union_jack;
  const double h = size.x() / (along - 1);
  const double rows = size.y() / h * (squares ? 1.0 : 2.0 / std::sqrt(3.0));
  const int up = std::max(1, static_cast<int>(std::lround(rows))) + 1;
  const solid::Lattice lattice = kind == MeshKind::single_diagonal ? solid::Lattice::grid
                                 : kind == MeshKind::union_jack    ? solid::Lattice::union_jack
                                                                   : solid::Lattice::staggered;
  solid::TriangleSoup soup = solid::rectangle(along, up, size, lattice);
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < along; ++i) {
      const int v = j * along + i;
      Vec2 at = soup.material[v];
      const bool inner = i > 0 && i < along - 1 && j > 0 && j < up - 1;
      if (kind == MeshKind::jittered && inner)
        at += 0.25 * h * Vec2(hash_signed(7, 2 * v), hash_signed(7, 2 * v + 1));
      // dx/dξ runs from 0.5 to 1.5.
      if (kind == MeshKind::graded) {
        const double xi = at.x() / size.x();
        at.x() = size.x() * (xi + 0.5 * std::sin(2.0 * M_PI * xi) / (2.0 * M_PI));
      }
      soup.material[v] = at;
      soup.positions[v].head<2>() = at;
    }
  return solid::build_mesh(std::move(soup));
}

const std::vector<NamedOperator>& operators_compared() {
  static const std::vector<NamedOperator> list = {{"cotan", diffusion::Operator::cotan, 2.0, false},
                                                  {"cotan clamped", diffusion::Operator::cotan, 2.0, true},
                                                  {"umbrella 2", diffusion::Operator::umbrella, 2.0, true}};
  return list;
}

diffusion::DiffusionParams plain_diffusion(const NamedOperator& op, double alpha, double tolerance) {
  diffusion::DiffusionParams p;
  p.model = diffusion::Model::isotropic;
  p.discretisation = op.kind;
  p.umbrella_factor = op.umbrella_factor;
  p.clamp_weights = op.clamp;
  p.alpha = alpha;
  p.tolerance = tolerance;
  return p;
}

std::vector<double> TestSheet::field(const std::function<double(const Vec3&)>& f) const {
  std::vector<double> u;
  for (const Vec3& p : mesh.rest) u.push_back(f(p));
  return u;
}

double TestSheet::total(const std::vector<double>& u) const {
  return diffusion::sum_of(u.size(), [&](std::size_t i) { return mesh.vertex_area[i] * u[i]; });
}

double relative_error(const TestSheet& sheet, const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += sheet.mesh.vertex_area[i] * (a[i] - b[i]) * (a[i] - b[i]);
    size += sheet.mesh.vertex_area[i] * b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

double march(diffusion::DiffusionInput input, const diffusion::DiffusionParams& params, double dt, int steps,
             std::vector<double>& u, const std::function<void(int, const std::vector<double>&)>& prepare) {
  using Clock = std::chrono::steady_clock;
  diffusion::DiffusionSolver solver(params);
  std::vector<double> scratch = u;
  if (prepare) prepare(0, u);
  solver.step(scratch, input, dt);
  double milliseconds = 0.0;
  for (int k = 0; k < steps; ++k) {
    if (prepare) prepare(k, u);
    const Clock::time_point start = Clock::now();
    solver.step(u, input, dt);
    milliseconds += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  }
  return milliseconds;
}

void WorkPrecision::add(double at, double err, double ms) {
  resolution.push_back(at);
  error.push_back(err);
  milliseconds.push_back(ms);
}

double WorkPrecision::order() const {
  const std::size_t n = error.size();
  return std::log(error[n - 1] / error[n - 2]) / std::log(resolution[n - 1] / resolution[n - 2]);
}

void tabulate(Table& table, const std::string& problem, const std::string& varied, const WorkPrecision& w) {
  for (std::size_t k = 0; k < w.error.size(); ++k) {
    const double order =
        k == 0 ? 0.0 : std::log(w.error[k] / w.error[k - 1]) / std::log(w.resolution[k] / w.resolution[k - 1]);
    table.add({problem, w.label, varied}, {w.resolution[k], w.error[k], w.milliseconds[k], order});
  }
}

Picture chart(const std::string& title, const std::string& varied, const std::vector<WorkPrecision>& curves) {
  Chart left{
      .title = title, .x_label = varied, .y_label = "relative error", .log_x = true, .log_y = true, .series = {}};
  Chart right = left;
  right.x_label = "milliseconds";
  right.title = "work and precision";
  for (const WorkPrecision& w : curves) {
    std::vector<double> size;
    for (const double e : w.error) size.push_back(std::abs(e));
    left.series.push_back({w.label, w.resolution, size});
    right.series.push_back({w.label, w.milliseconds, size});
  }
  return draw_charts({left, right});
}

namespace {

constexpr const char* analysis =
    "**Operator.** Cotan weights are of second order on every mesh and in every problem, at the same cost as the "
    "umbrella. The umbrella is right where the directions of the edges cancel (equilateral triangles, union jack); "
    "elsewhere refining does not help it: a Gaussian on the graded mesh keeps an error of 7 %, its second moments "
    "grow "
    "35 % wrong, and as the rows along the border of a sheet are one-sided even a staggered strip takes up water "
    "with "
    "an error of some per cent. So `cotan` is the default, and the umbrella remains for the method as printed.\n\n"
    "**Clamping.** Setting negative cotan weights to 0 (`clamp_weights`, on by default) changes nothing that "
    "matters "
    "on staggered and jittered meshes. On the graded one, whose widest triangles are obtuse, it costs: 2 % instead "
    "of "
    "0.04 % at the finest level of the half line. What it buys is that no value leaves the range of its "
    "neighbours. "
    "It is the right default for meshes that burn and tear; on an obtuse mesh whose numbers matter, switch it "
    "off.\n\n"
    "**Tolerance.** The whole error does not change from 1e-4 on; 1e-6 leaves less than a thousandth of it to the "
    "solver, and the default of 1e-8 costs a twentieth more time than that. One problem needs more: ahead of a "
    "travelling wave u = 0 is unstable, and what a solve leaves there ignites. Without a threshold below which "
    "nothing "
    "reacts (burning has one: the ignition temperature) no tolerance is tight enough for long; with one at 1e-9 "
    "solves "
    "at 1e-10 are.\n\n"
    "**Step.** First order in dt, as backward Euler must be. The errors of step and mesh are equal near "
    "dt = h²/(6 alpha), so that halving h asks for a quarter of dt; in wetting scenes the step is far beyond that "
    "and is what decides. An impulsive start costs no order: after n steps the uptake is wrong by about 1/(8 "
    "n).\n\n"
    "**Mesh.** With cotan weights the three kinds differ by less than a third at equal work: choose the mesh for "
    "what "
    "it shows.";

ExperimentReport accuracy(const Surroundings& s) {
  ExperimentReport report;
  Table table{.name = "work_precision",
              .columns = {"problem", "method", "varied", "value", "relative_error", "milliseconds", "order"},
              .rows = {},
              .on_page = true};
  measure_gaussian(s, report, table);
  measure_harmonics(s, report, table);
  measure_half_line(s, report, table);
  measure_wave(s, report, table);
  report.tables.push_back(std::move(table));
  report.analysis = analysis;
  return report;
}

}  // namespace

void add_accuracy(std::vector<Experiment>& list) {
  list.push_back({"accuracy", "work and precision (ours)",
                  "second order in h and first in dt with cotan weights; the umbrella stalls on irregular meshes",
                  "", accuracy});
}

}  // namespace wick::scenes
