/// A half line held wet at its end, and a travelling wave: problems with a front.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/experiments/accuracy.h"

namespace wick::scenes {

namespace {

using Values = std::vector<double>;

/// A strip of 1 m, a tenth as wide, held at u = 1 at x = 0: u = erfc(x/(2 √(α t))), uptake 2 √(α t/π) per width.
struct HalfLine {
  double error, uptake_error, milliseconds;
};

constexpr double strip_alpha = 0.01, strip_time = 0.5;

HalfLine wet_strip(MeshKind kind, int along, const NamedOperator& op, int steps, double tolerance) {
  const Vec2 size(1.0, 0.1);
  const TestSheet strip(make_sheet(kind, along, size));
  const std::size_t n = strip.mesh.vertex_count();
  Values rate(n, 0.0), u(n, 0.0);
  const Values value(n, 1.0);
  for (std::size_t i = 0; i < n; ++i)
    if (strip.mesh.rest[i].x() == 0.0) rate[i] = 1e9 * strip.mesh.vertex_area[i];
  diffusion::DiffusionInput input = strip.input();
  input.supply_rate = &rate;
  input.supply_value = &value;
  HalfLine result{};
  result.milliseconds = march(input, plain_diffusion(op, strip_alpha, tolerance), strip_time / steps, steps, u);
  const double reach = std::sqrt(strip_alpha * strip_time);
  result.error =
      relative_error(strip, u, strip.field([&](const Vec3& p) { return std::erfc(p.x() / (2.0 * reach)); }));
  result.uptake_error = std::abs(strip.total(u) / size.y() / (2.0 * reach / std::sqrt(M_PI)) - 1.0);
  return result;
}

WorkPrecision empty_curve(std::string label) {
  return {.label = std::move(label), .resolution = {}, .error = {}, .milliseconds = {}};
}

/// u = 0 is unstable: what the solves leave ahead of the front would ignite by itself after ln(1/tolerance)/κ.
/// Below this nothing reacts; it slows the front by π²/(2 ln² cutoff), about 1 % [Brunet 1997].
constexpr double cutoff = 1e-9;

/// u_t = α u_xx + κ u (1 - u) from a step: runs at 2 √(α κ), behind which it lags by 3/2 √(α/κ) ln(κ t) [Bramson
/// 1983].
struct Wave {
  double speed, lag, milliseconds;  ///< over 2 √(α κ) and 3/2 √(α/κ)
};

Wave run_wave(const NamedOperator& op, MeshKind kind, double cells_across, double dt, double tolerance,
              double end) {
  // Width √(α/κ) = 1 and κ = 1, so the speed is 2.
  const double h = 1.0 / cells_across, length = 2.0 * end + 15.0;
  const int along = static_cast<int>(std::lround(length / h)) + 1;
  const TestSheet strip(make_sheet(kind, along, Vec2(length, 3.0 * h * std::sqrt(0.75))));
  const double width = strip.total(Values(strip.mesh.vertex_count(), 1.0)) / length;
  Values u = strip.field([](const Vec3& p) { return p.x() <= 5.0 ? 1.0 : 0.0; });
  Values amount(u.size());
  diffusion::DiffusionInput input = strip.input();
  input.amount = &amount;
  const int steps = static_cast<int>(std::lround(end / dt));
  std::vector<Vec3> basis;
  Values position;
  const auto react = [&](int step, const Values& v) {
    for (std::size_t i = 0; i < v.size(); ++i)
      amount[i] = v[i] > cutoff ? dt * strip.mesh.vertex_area[i] * v[i] * (1.0 - v[i]) : 0.0;
    const double t = step * dt;
    if (t < end / 3.0) return;
    basis.emplace_back(t, std::log(t), 1.0);
    position.push_back(strip.total(v) / width);
  };
  Wave wave{};
  wave.milliseconds = march(input, plain_diffusion(op, 1.0, tolerance), dt, steps, u, react);
  Eigen::MatrixXd a(basis.size(), 3);
  for (std::size_t k = 0; k < basis.size(); ++k) a.row(static_cast<Eigen::Index>(k)) = basis[k];
  const Eigen::Map<const Eigen::VectorXd> x(position.data(), static_cast<Eigen::Index>(position.size()));
  // Three unknowns over a third of a decade: the normal equations lose some six of sixteen digits.
  const Mat3 normal = a.transpose() * a;
  const Vec3 fit = normal.inverse() * Vec3(a.transpose() * x);
  wave.speed = fit[0] / 2.0;
  wave.lag = -fit[1] / 1.5;
  return wave;
}

}  // namespace

void measure_half_line(const Surroundings& s, ExperimentReport& report, Table& table) {
  s.say("accuracy: half line");
  std::vector<WorkPrecision> by_mesh, by_step;
  const NamedOperator& standard = operators_compared()[1];
  const HalfLine usual = wet_strip(MeshKind::staggered, 93, standard, 60, 1e-8);
  report.checks.push_back(
      at_most("half line: rms error of u, cotan clamped, h = 1/92, 60 steps", {usual.error}, 0.01));
  report.checks.push_back(at_most("half line: error of the uptake there", {usual.uptake_error}, 0.01));
  for (const NamedOperator& op : operators_compared())
    for (const MeshKind kind : {MeshKind::staggered, MeshKind::jittered, MeshKind::graded}) {
      by_mesh.push_back(empty_curve(fmt::format("{}, {}", op.name, name_of(kind))));
      for (int level = 0; level < (s.quick ? 3 : 4); ++level) {
        const int cells = 23 << level;
        const HalfLine r = wet_strip(kind, cells + 1, op, 10 << (2 * level), 1e-8);
        by_mesh.back().add(1.0 / cells, r.error, r.milliseconds);
      }
      tabulate(table, "half line", "h (dt ~ h²)", by_mesh.back());
    }
  by_step.push_back(empty_curve("u"));
  by_step.push_back(empty_curve("uptake"));
  for (const int steps : {5, 10, 20, 40, 80, 160}) {
    const HalfLine r = wet_strip(MeshKind::staggered, 369, standard, steps, 1e-8);
    by_step[0].add(strip_time / steps, r.error, r.milliseconds);
    by_step[1].add(strip_time / steps, r.uptake_error, r.milliseconds);
  }
  tabulate(table, "half line: u", "dt [s]", by_step[0]);
  tabulate(table, "half line: uptake", "dt [s]", by_step[1]);
  report.checks.push_back(at_least("half line: order in h, cotan, staggered", {by_mesh[0].order()}, 1.8));
  report.checks.push_back(at_least("half line: order in dt of the uptake", {by_step[1].order()}, 0.9));
  const std::vector<WorkPrecision> shown = {by_mesh[0], by_mesh[2], by_mesh[3], by_mesh[5], by_mesh[6], by_mesh[8]};
  report.pictures.push_back(
      {"half-line", "a strip held wet at one end: error of u, dt ~ h²", chart("half line, mesh", "h [m]", shown)});
  report.pictures.push_back({"half-line-step", "a strip held wet at one end: error of u and of the uptake",
                             chart("half line, time step", "dt [s]", by_step)});
}

void measure_wave(const Surroundings& s, ExperimentReport& report, Table& table) {
  const double end = s.quick ? 30.0 : 60.0;
  s.say("accuracy: travelling wave");
  const NamedOperator& standard = operators_compared()[1];
  const Wave usual = run_wave(standard, MeshKind::staggered, 8.0, 0.05, 1e-12, end);
  report.checks.push_back(
      at_most("wave: error of the speed, front over 8 edges, cotan clamped", {std::abs(usual.speed - 1.0)}, 0.05));
  report.checks.push_back(reported("wave: fitted lag over 3/2 √(α/κ) ln(κ t)", {usual.lag}));
  std::vector<WorkPrecision> by_mesh, by_step, by_tolerance;
  for (const NamedOperator& op : operators_compared())
    for (const MeshKind kind : {MeshKind::staggered, MeshKind::jittered, MeshKind::graded}) {
      by_mesh.push_back(empty_curve(fmt::format("{}, {}", op.name, name_of(kind))));
      for (const double cells : {1.0, 2.0, 4.0, 8.0}) {
        const Wave w = run_wave(op, kind, cells, 0.05, 1e-12, end);
        by_mesh.back().add(1.0 / cells, std::abs(w.speed - 1.0), w.milliseconds);
      }
      tabulate(table, "wave", "h over front width", by_mesh.back());
    }
  by_step.push_back(empty_curve(standard.name));
  for (const double dt : {0.8, 0.4, 0.2, 0.1, 0.05}) {
    const Wave w = run_wave(standard, MeshKind::staggered, 8.0, dt, 1e-12, end);
    by_step.back().add(dt, std::abs(w.speed - 1.0), w.milliseconds);
  }
  tabulate(table, "wave", "kappa dt", by_step.back());
  by_tolerance.push_back(empty_curve(standard.name));
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const Wave w = run_wave(standard, MeshKind::staggered, 8.0, 0.05, tolerance, end);
    by_tolerance.back().add(tolerance, std::abs(w.speed - 1.0), w.milliseconds);
  }
  tabulate(table, "wave", "tolerance", by_tolerance.back());
  report.pictures.push_back({"wave",
                             "relative error of the speed of a travelling wave against the resolution of its front",
                             chart("travelling wave, mesh", "h over front width", by_mesh)});
  report.pictures.push_back(
      {"wave-step", "the same against the time step and against the tolerance",
       draw_charts({{.title = "travelling wave, step",
                     .x_label = "kappa dt",
                     .y_label = "relative error of the speed",
                     .log_x = true,
                     .log_y = true,
                     .series = {{"cotan clamped", by_step[0].resolution, by_step[0].error}}},
                    {.title = "travelling wave, tolerance",
                     .x_label = "tolerance",
                     .y_label = "relative error of the speed",
                     .log_x = true,
                     .log_y = true,
                     .series = {{"cotan clamped", by_tolerance[0].resolution, by_tolerance[0].error}}}})});
}

}  // namespace wick::scenes
