#include "diffusion/strain_diffusion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "core/require.h"
#include "diffusion/input_check.h"
#include "diffusion/strain_diffusion_impl.h"

namespace wick::diffusion {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double>(end - start).count();
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Models with a transport of their own in place of Eq (8a).
bool moves_along_edges(Model model) {
  return model == Model::porous || model == Model::diffuse_gravity;
}

}  // namespace

/// Rebuilds what depends on the triangles or on the rest shape, only when they have changed.
void DiffusionSolver::Impl::follow_topology(const solid::ShellMesh& mesh) {
  if (same_bytes(triangles, mesh.triangles) && same_bytes(rest, mesh.rest) && !graph.offset.empty()) return;
  triangles = mesh.triangles;
  rest = mesh.rest;
  graph = build_graph(mesh);
  rest_corner = corner_cotangents(mesh, mesh.rest);
  build_operator(mesh, graph, choice(true), mesh.rest, rest_corner, mesh.vertex_area, reference);
  solver.reset();
  neighbourhood.reset();
}
/// Supply, loss and spreading of one step; u_star enters as u.
void DiffusionSolver::Impl::spread(const Values& u, const DiffusionInput& in, double dt, Values& u_star,
                                   DiffusionReport& report) {
  if (moves_along_edges(params.model))
    transfer(in, dt, u_star, report);
  else
    diffuse(u, in, dt, u_star, report);
}

DiffusionSolver::DiffusionSolver(const DiffusionParams& params) : impl_(std::make_unique<Impl>(params)) {
  require(params.u_min > 0.0 && params.u_min < params.u_max, "/diffusion/u_min",
          "u_min must lie between 0 and u_max (at 0 dry vertices would count as front) raise it or u_max");
}
DiffusionSolver::~DiffusionSolver() = default;
DiffusionSolver::DiffusionSolver(DiffusionSolver&&) noexcept = default;
DiffusionSolver& DiffusionSolver::operator=(DiffusionSolver&&) noexcept = default;

DiffusionReport DiffusionSolver::step(std::vector<double>& u, const DiffusionInput& input, double dt) {
  require_input(u, input, dt);
  Impl& s = *impl_;
  const Values& mass = *input.mass;
  const auto amount_of = [&](const Values& w) {
    return sum_of(w.size(), [&](std::size_t i) { return mass[i] * w[i]; });
  };
  DiffusionReport report;
  for (double& value : u) value = std::max(value, 0.0);
  s.follow_topology(*input.mesh);
  Values& u_star = s.spread_u;
  int iterations = 0;
  const auto spread = [&] {
    iterations += report.solve.iterations;
    report = {};
    report.before = amount_of(u);
    s.book_external(u, input, dt, report);
    s.exchanging = s.exchanging && s.plan_exchange(input, u);
    u_star = u;
    s.spread(u, input, dt, u_star, report);
  };

  // (8a) supply and diffusion, with C and what pays for it where they are rates.
  const auto start = Clock::now();
  s.strained = s.find_strain(input, dt);
  s.exchanging = s.strained && s.params.order == Order::inside;
  s.misjudged.clear();
  const auto strained = Clock::now();
  spread();
  auto diffused = Clock::now();

  // (8b)-(8g) strain on the front, rescaled to the total.
  if (s.exchanging && !s.settle_exchange(input, dt, u_star, u, report)) {
    // A piece of which the step leaves too little for the exchange is taken as printed.
    spread();
    diffused = Clock::now();
    s.settle_exchange(input, dt, u_star, u, report);
  } else if (!s.exchanging) {
    if (!moves_along_edges(s.params.model) && s.params.discretisation != Operator::cotan)
      report.drift = amount_of(u_star) - (report.before + report.supplied - report.excess - report.lost);
    report.sigma_source = report.drift;
    s.redistribute(input, dt, u_star, u, report);
  }
  report.solve.iterations += iterations;
  report.misjudged = static_cast<std::size_t>(std::count(s.misjudged.begin(), s.misjudged.end(), 1));
  report.seconds_solve = seconds_between(strained, diffused);
  report.seconds_strain = seconds_between(start, strained) + seconds_between(diffused, Clock::now());
  report.front_vertices = s.count_front(input);

  // Cut what no projection has seen: Eq (7), and vertices of no triangle.
  if (input.capacity > 0.0)
    for (std::size_t i = 0; i < u.size(); ++i)
      if (u[i] > input.capacity) report.excess += mass[i] * (u[i] - input.capacity), u[i] = input.capacity;
  report.after = amount_of(u);
  if (!std::isfinite(report.after))
    throw Refusal(ExitCode::numerical_failure, "/diffusion/sigma",
                  "the total of u overflowed (sigma creates too much) reduce sigma or the run");
  return report;
}

const std::vector<double>& DiffusionSolver::strain_vertex() const {
  return impl_->c;
}
const std::vector<double>& DiffusionSolver::strain_triangle() const {
  return impl_->strain;
}
const std::vector<double>& DiffusionSolver::supplied_vertex() const {
  return impl_->given;
}

}  // namespace wick::diffusion
