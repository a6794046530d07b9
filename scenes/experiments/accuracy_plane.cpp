/// A Gaussian that spreads on a plane, and spherical harmonics that decay on an icosphere.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/experiments/accuracy.h"

namespace wick::scenes {

namespace {

using Values = std::vector<double>;

constexpr double alpha = 0.01, end_time = 0.1, start_variance = 0.003;
const Vec2 unit_square(1.0, 1.0);

/// u = s0²/(s0² + 2 α t) exp(-r²/(2 (s0² + 2 α t))): the heat kernel of a point at t = -s0²/(2 α). The border is
/// seven standard deviations away at the end.
Values heat_kernel(const TestSheet& sheet, double t) {
  const double variance = start_variance + 2.0 * alpha * t;
  return sheet.field([&](const Vec3& p) {
    const double r2 = (p.head<2>() - 0.5 * unit_square).squaredNorm();
    return start_variance / variance * std::exp(-r2 / (2.0 * variance));
  });
}

struct Run {
  double error, milliseconds;
  Values u;
};

Run spread_gaussian(const TestSheet& sheet, const NamedOperator& op, int steps, double tolerance) {
  Run run{0.0, 0.0, heat_kernel(sheet, 0.0)};
  run.milliseconds = march(sheet.input(), plain_diffusion(op, alpha, tolerance), end_time / steps, steps, run.u);
  run.error = relative_error(sheet, run.u, heat_kernel(sheet, end_time));
  return run;
}

/// Second moments of u about its centre: xx, yy, xy.
Vec3 second_moments(const TestSheet& s, const Values& u) {
  const double total = s.total(u);
  Vec2 center = Vec2::Zero();
  for (std::size_t i = 0; i < u.size(); ++i)
    center += s.mesh.vertex_area[i] * u[i] / total * s.mesh.rest[i].head<2>();
  Vec3 m = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec2 d = s.mesh.rest[i].head<2>() - center;
    m += s.mesh.vertex_area[i] * u[i] / total * Vec3(d.x() * d.x(), d.y() * d.y(), d.x() * d.y());
  }
  return m;
}

/// Growth of the second moments, [xx, yy, xy].
Vec3 growth(const TestSheet& sheet, const NamedOperator& op) {
  const Run run = spread_gaussian(sheet, op, 10, 1e-12);
  return second_moments(sheet, run.u) - second_moments(sheet, heat_kernel(sheet, 0.0));
}

/// Backward Euler lets <r²> grow by 4 α dt a step on any lattice without drift: the slope needs no small step.
void check_slopes(const Surroundings& s, ExperimentReport& report) {
  const int along = s.quick ? 47 : 93;
  double cotan = 0.0;
  for (const MeshKind kind : {MeshKind::staggered, MeshKind::jittered, MeshKind::graded}) {
    const TestSheet sheet(make_sheet(kind, along, unit_square));
    for (const NamedOperator& op : operators_compared()) {
      const Vec3 g = growth(sheet, op) / (2.0 * alpha * end_time);
      const double error = std::max(std::abs(g[0] - 1.0), std::abs(g[1] - 1.0));
      if (op.kind == diffusion::Operator::cotan && !op.clamp) cotan = std::max(cotan, error);
      if (op.kind != diffusion::Operator::cotan || op.clamp)
        report.checks.push_back(
            reported(fmt::format("Gaussian: error of the slope of <x²>, {}, {}", op.name, name_of(kind)), {error}));
    }
  }
  report.checks.push_back(
      at_most("Gaussian: error of the slope of <x²>, cotan, worst of three meshes", {cotan}, 0.01));

  const NamedOperator umbrella = {"umbrella 2", diffusion::Operator::umbrella, 2.0, true};
  const NamedOperator literal = {"umbrella as printed", diffusion::Operator::umbrella, 1.0, true};
  const TestSheet jack(make_sheet(MeshKind::union_jack, along, unit_square));
  const Vec3 g = growth(jack, umbrella) / (2.0 * alpha * end_time);
  report.checks.push_back(at_most("Gaussian: error of the slope of <x²>, umbrella 2, union jack",
                                  {std::max(std::abs(g[0] - 1.0), std::abs(g[1] - 1.0))}, 0.01));
  const TestSheet diagonal(make_sheet(MeshKind::single_diagonal, along, unit_square));
  const Vec3 m = growth(diagonal, literal);
  const double mean = 0.5 * (m[0] + m[1]), half = std::hypot(0.5 * (m[0] - m[1]), m[2]);
  const double aspect = std::sqrt((mean + half) / (mean - half));
  report.checks.push_back(reported("Gaussian: aspect of the printed umbrella, single diagonal", {aspect}));
  report.checks.push_back(
      at_most("Gaussian: its relative deviation from 1.554", {std::abs(aspect / 1.554 - 1.0)}, 0.02));
}

/// h is halved, dt quartered: the whole error falls fourfold where the operator is of second order.
void refine_mesh(const Surroundings& s, ExperimentReport& report, Table& table) {
  const int levels = s.quick ? 3 : 4;
  double least_cotan = INFINITY;
  for (const MeshKind kind : {MeshKind::staggered, MeshKind::jittered, MeshKind::graded}) {
    std::vector<WorkPrecision> curves;
    for (const NamedOperator& op : operators_compared()) {
      s.say(fmt::format("accuracy: Gaussian, {}, {}", name_of(kind), op.name));
      curves.push_back({.label = op.name, .resolution = {}, .error = {}, .milliseconds = {}});
      for (int level = 0; level < levels; ++level) {
        const int cells = 23 << level;
        const TestSheet sheet(make_sheet(kind, cells + 1, unit_square));
        const Run run = spread_gaussian(sheet, op, 5 << (2 * level), 1e-8);
        curves.back().add(1.0 / cells, run.error, run.milliseconds);
      }
      const std::string what = fmt::format("Gaussian: order in h, {}, {}", op.name, name_of(kind));
      report.checks.push_back(reported(what, {curves.back().order()}));
      if (op.kind == diffusion::Operator::cotan && !op.clamp)
        least_cotan = std::min(least_cotan, curves.back().order());
      tabulate(table, fmt::format("Gaussian {}", name_of(kind)), "h (dt ~ h²)", curves.back());
    }
    report.pictures.push_back({fmt::format("gaussian-{}", name_of(kind)),
                               fmt::format("error of a spreading Gaussian on {} meshes, dt ~ h²", name_of(kind)),
                               chart(fmt::format("Gaussian, {}", name_of(kind)), "h [m]", curves)});
  }
  report.checks.push_back(at_least("Gaussian: order in h, cotan, least of three meshes", {least_cotan}, 1.8));
}

void refine_step_and_tolerance(const Surroundings& s, ExperimentReport& report, Table& table) {
  const TestSheet sheet(make_sheet(MeshKind::staggered, s.quick ? 93 : 185, unit_square));
  s.say("accuracy: Gaussian, step and tolerance");
  std::vector<WorkPrecision> by_step, by_tolerance;
  for (const NamedOperator& op : operators_compared()) {
    by_step.push_back({.label = op.name, .resolution = {}, .error = {}, .milliseconds = {}});
    for (const int steps : {2, 4, 8, 16, 32}) {
      const Run run = spread_gaussian(sheet, op, steps, 1e-8);
      by_step.back().add(end_time / steps, run.error, run.milliseconds);
    }
    tabulate(table, "Gaussian staggered", "dt [s]", by_step.back());
  }
  // The step alone, against a run of the same mesh with sixteen times as many.
  const Values fine = spread_gaussian(sheet, operators_compared()[1], 512, 1e-10).u;
  by_step.push_back({.label = "step alone", .resolution = {}, .error = {}, .milliseconds = {}});
  for (const int steps : {2, 4, 8, 16, 32}) {
    const Run run = spread_gaussian(sheet, operators_compared()[1], steps, 1e-10);
    by_step.back().add(end_time / steps, relative_error(sheet, run.u, fine), run.milliseconds);
  }
  tabulate(table, "Gaussian staggered", "dt [s]", by_step.back());
  report.checks.push_back(at_least("Gaussian: order in dt, cotan clamped", {by_step.back().order()}, 0.9));
  report.pictures.push_back({"gaussian-step", "error of a spreading Gaussian against the time step",
                             chart("Gaussian, time step", "dt [s]", by_step)});

  // Against the tightest solve, so that only the tolerance is seen; and the time that it takes.
  const NamedOperator& op = operators_compared()[1];
  const Run tight = spread_gaussian(sheet, op, 16, 1e-13);
  by_tolerance.push_back({.label = "of the solve alone", .resolution = {}, .error = {}, .milliseconds = {}});
  by_tolerance.push_back({.label = "whole error", .resolution = {}, .error = {}, .milliseconds = {}});
  double at_default = 0.0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10}) {
    const Run run = spread_gaussian(sheet, op, 16, tolerance);
    const double alone = relative_error(sheet, run.u, tight.u);
    by_tolerance[0].add(tolerance, alone, run.milliseconds);
    by_tolerance[1].add(tolerance, run.error, run.milliseconds);
    if (tolerance == 1e-6) at_default = alone / tight.error;
  }
  tabulate(table, "Gaussian staggered: solve alone", "tolerance", by_tolerance[0]);
  tabulate(table, "Gaussian staggered: whole", "tolerance", by_tolerance[1]);
  report.checks.push_back(
      at_most("Gaussian: error of solves at 1e-6 over that of step and mesh", {at_default}, 0.01));
  report.pictures.push_back({"gaussian-tolerance", "error of a spreading Gaussian against the solver's tolerance",
                             chart("Gaussian, tolerance", "tolerance", by_tolerance)});
}

/// Zonal harmonic P_l(z) of the unit sphere.
double legendre(int l, double z) {
  double a = 1.0, b = z;
  if (l == 0) return a;
  for (int k = 2; k <= l; ++k) {
    const double next = ((2 * k - 1) * z * b - (k - 1) * a) / k;
    a = b;
    b = next;
  }
  return b;
}

struct Decay {
  double rate, milliseconds, mean_error;  ///< rate over l(l+1)
};

/// One backward Euler step divides P_l by 1 + dt l(l+1): undone exactly, so that only the space error is seen.
Decay decay(const TestSheet& sphere, int l, const NamedOperator& op) {
  const Vec3 axis = Vec3(1, 2, 3).normalized();
  const Values y = sphere.field([&](const Vec3& x) { return legendre(l, x.normalized().dot(axis)); });
  Values u;
  for (const double value : y) u.push_back(2.0 + value);  // u stays positive; the constant does not decay
  const double before = sphere.total(u), dt = 0.5 / (l * (l + 1));
  Decay result{};
  result.milliseconds = march(sphere.input(), plain_diffusion(op, 1.0, 1e-12), dt, 1, u);
  result.mean_error = std::abs(sphere.total(u) / before - 1.0);
  double yy = 0.0, uy = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    yy += sphere.mesh.vertex_area[i] * y[i] * y[i];
    uy += sphere.mesh.vertex_area[i] * y[i] * (u[i] - 2.0);
  }
  result.rate = (yy / uy - 1.0) / (dt * l * (l + 1));
  return result;
}

}  // namespace

void measure_gaussian(const Surroundings& s, ExperimentReport& report, Table& table) {
  check_slopes(s, report);
  refine_mesh(s, report, table);
  refine_step_and_tolerance(s, report, table);
}

void measure_harmonics(const Surroundings& s, ExperimentReport& report, Table& table) {
  const int finest = s.quick ? 5 : 6;
  const std::vector<int> degrees = {1, 2, 4, 6};
  std::vector<TestSheet> spheres;
  for (int level = 3; level <= finest; ++level)
    spheres.emplace_back(solid::build_mesh(solid::icosphere(level, 1.0)));
  const NamedOperator literal = {"umbrella as printed", diffusion::Operator::umbrella, 1.0, true};
  double worst_rate = 0.0, least_order = INFINITY, worst_mean = 0.0, literal_rate = 0.0;
  std::vector<WorkPrecision> curves;
  for (const NamedOperator& op : {operators_compared()[0], operators_compared()[2], literal})
    for (const int l : degrees) {
      s.say(fmt::format("accuracy: sphere, {}, l = {}", op.name, l));
      const double expected = op.umbrella_factor == 1.0 ? 0.5 : 1.0;
      WorkPrecision w{
          .label = fmt::format("{}, l = {}", op.name, l), .resolution = {}, .error = {}, .milliseconds = {}};
      for (std::size_t k = 0; k < spheres.size(); ++k) {
        const Decay d = decay(spheres[k], l, op);
        const double h = std::sqrt(4.0 * M_PI / static_cast<double>(spheres[k].mesh.vertex_count()));
        w.add(h, std::abs(d.rate / expected - 1.0), d.milliseconds);
        if (op.kind == diffusion::Operator::cotan) worst_mean = std::max(worst_mean, d.mean_error);
        if (op.kind == diffusion::Operator::cotan && k == 2 && l <= 4)
          worst_rate = std::max(worst_rate, w.error.back());
        if (expected == 0.5 && k == 2) literal_rate += d.rate / static_cast<double>(degrees.size());
      }
      if (op.kind == diffusion::Operator::cotan) least_order = std::min(least_order, w.order());
      tabulate(table, "sphere", "h", w);
      if (expected == 1.0 && l != 1) curves.push_back(std::move(w));
    }
  report.checks.push_back(at_most("sphere: error of the rate at level 5, l <= 4, cotan", {worst_rate}, 0.01));
  report.checks.push_back(at_least("sphere: order in h, cotan, least of l", {least_order}, 1.8));
  report.checks.push_back(at_most("sphere: change of the mean, cotan", {worst_mean}, 1e-12));
  report.checks.push_back(at_most("sphere: |rate of the printed umbrella, mean of l - 0.5|/0.5",
                                  {std::abs(2.0 * literal_rate - 1.0)}, 0.03));
  report.pictures.push_back({"sphere", "relative error of the decay rates of spherical harmonics on icospheres",
                             chart("spherical harmonics", "h", curves)});
}

}  // namespace wick::scenes
