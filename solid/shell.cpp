#include "solid/shell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "solid/constraints.h"
#include "solid/contact.h"
#include "solid/spin.h"
#include "solid/triangle_contact.h"

namespace wick::solid {

namespace {

/// Vertices that one thread takes at a time.
constexpr std::size_t kGrain = 2048;
/// Nothing in a fire moves at 100 km/s: only overflowing numbers meet this limit, and are counted.
constexpr double kLargestSpeed = 1e5;

Vec3 vector(const Row& r) {
  return {r.x, r.y, r.z};
}
Row row(const Vec3& v, double w) {
  return {v.x(), v.y(), v.z(), w};
}

/// What the last pass of a substep counts; one a chunk, so that adding them up needs no locks.
struct Tally {
  std::size_t contacts = 0, limited = 0;
};

/// Cuts v to the largest speed, and what is not a number to rest. True if it did.
bool limit_speed(Vec3& v) {
  const double speed = v.norm();
  if (speed <= kLargestSpeed) return false;
  v = std::isfinite(speed) ? Vec3(v * (kLargestSpeed / speed)) : Vec3::Zero();
  return true;
}

}  // namespace

/// The state of a step lives in rows of four doubles, so that a vertex is one aligned load.
struct ShellSolver::Impl {
  Impl(const ShellMesh& mesh, const ShellParams& p)
      : params(p),
        constraints(mesh, p),
        spin(mesh),
        triangle_contact(mesh, 0.5 * p.thickness),
        vertex_count(mesh.vertex_count()),
        position(vertex_count + 1),
        previous(vertex_count + 1),
        bent(vertex_count + 1),
        velocity(vertex_count),
        push(vertex_count),
        clearance(vertex_count),
        touched(vertex_count),
        tally((vertex_count + kGrain - 1) / kGrain) {
    // The vertex beyond the last serves idle lanes.
    position.back() = previous.back() = bent.back() = {0.0, 0.0, 0.0, 0.0};
  }

  void load(const ShellState& state, const ShellInputs& inputs, const Pins& pins);
  void prepare_push(const std::vector<Vec3>& force, const std::vector<Vec3>& wind, const Vec3& gravity);
  void move_pins(double share);
  void predict();
  void unbend();
  void finish(const std::vector<Obstacle>& obstacles, double start);
  double touch(const std::vector<Obstacle>& obstacles, double start, Vec3& x, Vec3& origin) const;
  void store(const ShellMesh& mesh, ShellState& state, ShellStepReport& report) const;

  ShellParams params;
  ConstraintSet constraints;
  SpinKeeper spin;
  TriangleContact triangle_contact;
  std::size_t vertex_count;
  std::vector<Row> position;        ///< x and inverse mass
  std::vector<Row> previous;        ///< x at the start of the substep
  std::vector<Row> bent;            ///< y = x + γ (x − xⁿ) and inverse mass, during the sweep over flat hinges
  std::vector<Row> velocity, push;  ///< v, and what a substep adds to it
  std::vector<double> clearance;    ///< a distance to all obstacles that is certainly there [m]
  std::vector<std::uint8_t> touched;  ///< by an obstacle in this substep, or cut to the speed limit
  std::vector<Tally> tally;
  std::size_t between_vertices = 0;  ///< vertices moved by contacts of triangles in the last substep
  double h = 0.0;                    ///< substep [s]
  double gamma = 0.0;                ///< Rayleigh damping b/h
  double keep = 1.0;                 ///< share of the velocity that air drag leaves a substep

  // Of the step that is under way.
  const ShellLoads* loads = nullptr;
  std::vector<Vec3> pinned_from;  ///< where the pinned vertices were when it began [m]
  int substeps = 1;
};

void ShellSolver::Impl::load(const ShellState& state, const ShellInputs& inputs, const Pins& pins) {
  parallel_for(vertex_count, kGrain, [&](std::size_t i) {
    position[i] = row(state.x[i], inputs.mass[i] > 0.0 ? 1.0 / inputs.mass[i] : 0.0);
    velocity[i] = row(state.v[i], 0.0);
    clearance[i] = 0.0;
  });
  for (const std::int32_t i : pins.vertex) position[i].w = 0.0;
}

/// v += h (g + f/m), and the exact solution of v̇ = −k (v − wind) over a substep: v ← wind + (v − wind) e^{−kh}.
void ShellSolver::Impl::prepare_push(const std::vector<Vec3>& force, const std::vector<Vec3>& wind,
                                     const Vec3& gravity) {
  keep = std::exp(-params.air_drag * h);
  std::fill(tally.begin(), tally.end(), Tally{});
  parallel_chunks(vertex_count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 dv = Vec3::Zero();
      const double w = position[i].w;
      if (w > 0.0) {
        dv = h * gravity;
        if (!force.empty()) dv += h * w * force[i];
        if (!wind.empty()) dv += (1.0 - keep) * wind[i];
        if (limit_speed(dv)) ++tally[begin / kGrain].limited;
      }
      push[i] = row(dv, 0.0);
    }
  });
}

/// x̂ = x + h v; y for the flat hinges.
void ShellSolver::Impl::predict() {
  const bool flat = constraints.has_flat_hinges();
  parallel_for(vertex_count, kGrain, [&](std::size_t i) {
    Row& p = position[i];
    previous[i] = p;
    if (p.w > 0.0) {
      const Row &v = velocity[i], &dv = push[i];
      p.x += h * (keep * v.x + dv.x);
      p.y += h * (keep * v.y + dv.y);
      p.z += h * (keep * v.z + dv.z);
    }
    if (!flat) return;
    const Row& q = previous[i];
    bent[i] = {p.x + gamma * (p.x - q.x), p.y + gamma * (p.y - q.y), p.z + gamma * (p.z - q.z), p.w};
  });
}

/// Puts the pinned vertices `share` of the way to their targets. Their position moves within the substep,
/// so this follows predict().
void ShellSolver::Impl::move_pins(double share) {
  const Pins& pins = loads->pins;
  for (std::size_t k = 0; k < pins.vertex.size(); ++k) {
    const std::int32_t i = pins.vertex[k];
    const Vec3 x = share >= 1.0 ? pins.target[k] : Vec3(pinned_from[k] + share * (pins.target[k] - pinned_from[k]));
    position[i] = row(x, 0.0);
    bent[i] = row(x + gamma * (x - vector(previous[i])), 0.0);
  }
}

/// x = xⁿ + (y − xⁿ)/(1+γ).
void ShellSolver::Impl::unbend() {
  if (!constraints.has_flat_hinges()) return;
  const double share = 1.0 / (1.0 + gamma);
  parallel_for(vertex_count, kGrain, [&](std::size_t i) {
    Row& p = position[i];
    if (!(p.w > 0.0)) return;
    const Row &q = previous[i], &y = bent[i];
    p.x = q.x + share * (y.x - q.x);
    p.y = q.y + share * (y.y - q.y);
    p.z = q.z + share * (y.z - q.z);
  });
}

/// Contact, then v = (x − xⁿ)/h. `start` is the time since the step began at which the substep does.
void ShellSolver::Impl::finish(const std::vector<Obstacle>& obstacles, double start) {
  parallel_chunks(vertex_count, kGrain, [&](std::size_t begin, std::size_t end) {
    Tally& counts = tally[begin / kGrain];
    counts.contacts = 0;
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 x = vector(position[i]), origin = vector(previous[i]);
      const bool free = position[i].w > 0.0;
      if (free && !obstacles.empty()) {
        // A distance shrinks by no more than the way gone; twice that allows for the slope of sampled distances.
        double fastest = 0.0;
        for (const Obstacle& o : obstacles) fastest = std::max(fastest, o.speed_at(x));
        clearance[i] -= 2.0 * ((x - origin).norm() + h * fastest);
        if (!(clearance[i] > 0.0)) {
          clearance[i] = touch(obstacles, start, x, origin);
          counts.contacts += clearance[i] <= 0.0;
        }
      }
      touched[i] = free && !obstacles.empty() && clearance[i] <= 0.0;
      Vec3 v = (x - origin) / h;
      if (free && limit_speed(v)) {
        x = origin + h * v;
        ++counts.limited;
        touched[i] = 1;
      }
      position[i] = row(x, position[i].w);
      previous[i] = row(origin, position[i].w);
      velocity[i] = row(v, 0.0);
    }
  });
  between_vertices = triangle_contact.resolve(start, h, position, previous, velocity, touched);
}

double ShellSolver::Impl::touch(const std::vector<Obstacle>& obstacles, double start, Vec3& x, Vec3& origin) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Obstacle& o : obstacles)
    nearest = std::min(nearest, resolve_contact(o, start, h, 0.5 * params.thickness, x, origin));
  return nearest;
}

void ShellSolver::Impl::store(const ShellMesh& mesh, ShellState& state, ShellStepReport& report) const {
  parallel_for(vertex_count, kGrain, [&](std::size_t i) {
    state.x[i] = vector(position[i]);
    state.v[i] = vector(velocity[i]);
  });
  report.contacts = between_vertices;
  for (const Tally& counts : tally) {
    report.contacts += counts.contacts;
    report.limited += counts.limited;
  }
  report.max_speed = parallel_max(vertex_count, kGrain, 0.0, [&](std::size_t begin, std::size_t end) {
    double largest2 = 0.0;
    for (std::size_t i = begin; i < end; ++i) largest2 = std::max(largest2, state.v[i].squaredNorm());
    return std::sqrt(largest2);
  });
  report.max_stretch = parallel_max(mesh.edges.size(), kGrain, -1.0, [&](std::size_t begin, std::size_t end) {
    double largest2 = 0.0;
    for (std::size_t e = begin; e < end; ++e) {
      const double l2 = (state.x[mesh.edges[e][1]] - state.x[mesh.edges[e][0]]).squaredNorm();
      largest2 = std::max(largest2, l2 / (mesh.rest_length[e] * mesh.rest_length[e]));
    }
    return std::sqrt(largest2) - 1.0;
  });
}

ShellSolver::ShellSolver(const ShellMesh& mesh, const ShellParams& params)
    : impl_(std::make_unique<Impl>(mesh, params)) {}
ShellSolver::~ShellSolver() = default;
ShellSolver::ShellSolver(ShellSolver&&) noexcept = default;
ShellSolver& ShellSolver::operator=(ShellSolver&&) noexcept = default;

int substep_count(const ShellParams& params, double dt) {
  // A frame of 1/60 s must not get one more because 60 dt is a rounding error above 1.
  const double wanted = std::ceil(params.substeps * dt * 60.0 * (1.0 - 1e-9));
  return static_cast<int>(std::clamp(wanted, 1.0, 1e8));
}

void ShellSolver::begin(const ShellState& state, const ShellLoads& loads, double dt, int substeps) {
  Impl& s = *impl_;
  assert(state.x.size() == s.vertex_count && state.v.size() == s.vertex_count);
  s.loads = &loads;
  s.substeps = substeps;
  s.h = dt / substeps;
  s.gamma = s.params.damping / s.h;
  s.constraints.update(loads.inputs, s.h);
  s.load(state, loads.inputs, loads.pins);
  s.prepare_push(loads.force, loads.wind, loads.gravity);
  s.spin.choose_free(loads.pins, loads.inputs);
  s.triangle_contact.begin_step(loads.obstacles);
  s.pinned_from.clear();
  for (const std::int32_t i : loads.pins.vertex) s.pinned_from.push_back(state.x[i]);
}

void ShellSolver::deform(int substep) {
  Impl& s = *impl_;
  s.spin.remember(s.position, s.velocity, s.push, s.keep);
  s.predict();
  s.move_pins((substep + 1.0) / s.substeps);
  s.constraints.project_flat_hinges(s.bent, s.gamma);
  s.unbend();
  s.constraints.project_bent_hinges_and_triangles(s.position, s.previous, s.gamma);
}

void ShellSolver::meet_obstacles(int substep) {
  impl_->finish(impl_->loads->obstacles, substep * impl_->h);
}

void ShellSolver::end_substep() {
  Impl& s = *impl_;
  s.spin.restore(s.position, s.velocity, s.touched, s.h);
}

ShellStepReport ShellSolver::end(ShellState& state, const ShellMesh& mesh) {
  ShellStepReport report;
  report.substeps = impl_->substeps;
  impl_->store(mesh, state, report);
  impl_->loads = nullptr;
  return report;
}

std::vector<Row>& ShellSolver::positions() {
  return impl_->position;
}

const std::vector<std::uint8_t>& ShellSolver::touched() const {
  return impl_->touched;
}

void ShellSolver::note_contact(std::size_t i, const Row& start) {
  Impl& s = *impl_;
  s.touched[i] = 1;
  if (!(s.position[i].w > 0.0)) return;
  // An obstacle shifts `previous` along with the overlap that it takes out, so that this makes no speed; where the
  // contact has undone the push, that shift would be a speed. What overlaps has the lesser of the two.
  const Vec3 x = vector(s.position[i]), since_shifted = x - vector(s.previous[i]), since_start = x - vector(start);
  const bool shifted = since_shifted.squaredNorm() < since_start.squaredNorm();
  s.velocity[i] = row((shifted ? since_shifted : since_start) / s.h, 0.0);
}

ShellStepReport ShellSolver::step(ShellState& state, const ShellMesh& mesh, const ShellLoads& loads, double dt) {
  if (!(dt > 0.0)) return {};
  assert(mesh.triangle_count() == loads.inputs.rest_scale.size());
  assert(mesh.hinges.size() == loads.inputs.rest_angle.size());
  const auto clock = std::chrono::steady_clock::now();
  const int substeps = substep_count(impl_->params, dt);
  begin(state, loads, dt, substeps);
  for (int k = 0; k < substeps; ++k) {
    deform(k);
    meet_obstacles(k);
    end_substep();
  }
  ShellStepReport report = end(state, mesh);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock).count();
  return report;
}

}  // namespace wick::solid
