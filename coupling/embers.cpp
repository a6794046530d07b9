#include "coupling/embers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "coupling/remesh.h"

namespace wick::coupling {

double EmberState::total_mass() const {
  return std::accumulate(mass.begin(), mass.end(), 0.0);
}

double EmberState::total_heat() const {
  double sum = 0.0;
  for (std::size_t n = 0; n < size(); ++n) sum += heat_capacity[n] * theta[n];
  return sum;
}

void visit(StateVisitor& visitor, EmberState& state) {
  visitor.array("x", state.x);
  visitor.array("v", state.v);
  visitor.array("mass", state.mass);
  visitor.array("area", state.area);
  visitor.array("heat_capacity", state.heat_capacity);
  visitor.array("theta", state.theta);
  visitor.array("age", state.age);
  visitor.array("id", state.id);
  visitor.value("next_id", state.next_id);
}

namespace {

/// What one part of a sheet adds up to.
struct Part {
  double area = 0.0, mass = 0.0, heat_capacity = 0.0, heat = 0.0;
  Vec3 moment = Vec3::Zero(), momentum = Vec3::Zero();
  bool pinned = false;
};

std::vector<Part> parts_of(const Sheet& sheet) {
  std::int32_t last = -1;
  for (const std::int32_t c : sheet.mesh.component) last = std::max(last, c);
  std::vector<Part> parts(last + 1);
  for (std::size_t i = 0; i < sheet.mesh.vertex_count(); ++i) {
    if (sheet.mesh.component[i] < 0) continue;
    Part& part = parts[sheet.mesh.component[i]];
    const double mass = sheet.areal_mass * sheet.mesh.vertex_area[i] * sheet.burning.fraction_left[i];
    part.area += sheet.mesh.vertex_area[i];
    part.mass += mass;
    part.heat_capacity += sheet.heat_capacity[i];
    part.heat += sheet.heat_capacity[i] * sheet.theta[i];
    part.moment += mass * sheet.state.x[i];
    part.momentum += mass * sheet.state.v[i];
  }
  for (const PinSet& pin : sheet.pins)
    for (const std::int32_t i : pin.vertices)
      if (sheet.mesh.component[i] >= 0) parts[sheet.mesh.component[i]].pinned = true;
  return parts;
}

void add_ember(EmberState& embers, const Part& part) {
  embers.x.emplace_back(part.moment / part.mass);
  embers.v.emplace_back(part.momentum / part.mass);
  embers.mass.push_back(part.mass);
  embers.area.push_back(part.area);
  embers.heat_capacity.push_back(part.heat_capacity);
  embers.theta.push_back(part.heat / part.heat_capacity);
  embers.age.push_back(0.0);
  embers.id.push_back(embers.next_id++);
}

template <class T>
void keep_only(std::vector<T>& values, const std::vector<std::uint8_t>& keep) {
  std::size_t kept = 0;
  for (std::size_t n = 0; n < values.size(); ++n)
    if (keep[n]) values[kept++] = values[n];
  values.resize(kept);
}

/// Velocity after dt of drag k |v| v, implicit: v = relative - dt k |v| v.
Vec3 dragged(const Vec3& relative, double k, double dt) {
  return 2.0 * relative / (1.0 + std::sqrt(1.0 + 4.0 * k * dt * relative.norm()));
}

bool inside(const fluid::Grid& grid, const Vec3& x) {
  const Vec3 high = grid.origin + grid.h * Vec3(grid.nx, grid.ny, grid.nz);
  return (x.array() >= grid.origin.array()).all() && (x.array() <= high.array()).all();
}

}  // namespace

bool sheds_embers(const WorldParams& world) {
  const auto can_fall = [](const ShellSection& s) { return s.moves && s.motion.kind == MotionKind::none; };
  return world.burning && world.burning->ember_size > 0.0 && world.burning->removal > world.burning->ash &&
         std::any_of(world.shells.begin(), world.shells.end(), can_fall);
}

std::size_t shed_embers(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push, EmberState& embers) {
  const double size = world.burning->ember_size;
  if (size <= 0.0 || !sheet.free()) return 0;
  const std::vector<Part> parts = parts_of(sheet);
  std::vector<std::uint8_t> gone(parts.size(), 0);
  std::size_t count = 0;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    gone[n] = !parts[n].pinned && parts[n].area < size * size && parts[n].mass > 0.0;
    if (!gone[n]) continue;
    add_ember(embers, parts[n]);
    ++count;
  }
  if (count == 0) return 0;
  std::vector<std::uint8_t> keep(sheet.mesh.triangle_count());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = !gone[sheet.mesh.component[sheet.mesh.triangles[t][0]]];
  drop_triangles(sheet, world, keep, push);
  return count;
}

EmberLoss step_embers(EmberState& embers, const WorldParams& world, const std::vector<Vec3>& air,
                      const std::vector<Obstacle>& obstacles, const fluid::Grid* grid, double dt) {
  // A flake that tumbles: drag coefficient of a plate, half of it facing the wind in the mean.
  constexpr double kDrag = 1.2, kFacing = 0.5, kStillAir = 1.2;
  const double density = world.smoke ? world.smoke->air_density : kStillAir;
  EmberLoss loss;
  std::vector<std::uint8_t> keep(embers.size(), 1);
  for (std::size_t n = 0; n < embers.size(); ++n) {
    const double k = 0.5 * density * kDrag * kFacing * embers.area[n] / embers.mass[n];
    const Vec3 wind = air.empty() ? Vec3(Vec3::Zero()) : air[n];
    embers.v[n] = wind + dragged(embers.v[n] + dt * world.gravity - wind, k, dt);
    embers.x[n] += dt * embers.v[n];
    embers.age[n] += dt;
    const double cooler = embers.theta[n] * std::exp(-world.heat.loss * dt);
    loss.radiated += embers.heat_capacity[n] * (embers.theta[n] - cooler);
    embers.theta[n] = cooler;
    bool out = embers.age[n] > world.burning->ember_life || (grid && !inside(*grid, embers.x[n]));
    for (const Obstacle& obstacle : obstacles) out = out || sample_distance(obstacle, embers.x[n]).distance < 0.0;
    if (!out) continue;
    keep[n] = 0;
    loss.mass += embers.mass[n];
    loss.heat += embers.heat_capacity[n] * embers.theta[n];
  }
  keep_only(embers.x, keep);
  keep_only(embers.v, keep);
  keep_only(embers.mass, keep);
  keep_only(embers.area, keep);
  keep_only(embers.heat_capacity, keep);
  keep_only(embers.theta, keep);
  keep_only(embers.age, keep);
  keep_only(embers.id, keep);
  return loss;
}

std::vector<Vec3> gas_velocity_at(const fluid::SmokeState& gas, const fluid::Grid& grid,
                                  const std::vector<Vec3>& x) {
  std::vector<Vec3> velocity(x.size());
  for (std::size_t n = 0; n < x.size(); ++n)
    for (int a = 0; a < 3; ++a) {
      Vec3 at = (x[n] - grid.origin) / grid.h - Vec3::Constant(0.5);
      at[a] += 0.5;
      Int3 low;
      Vec3 share;
      for (int b = 0; b < 3; ++b) {
        const int last = grid.size(b) - (a == b ? 0 : 1);
        const double place = std::clamp(at[b], 0.0, double(last));
        low[b] = std::min(static_cast<int>(place), std::max(last - 1, 0));
        share[b] = last > 0 ? place - low[b] : 0.0;
      }
      double sum = 0.0;
      for (int corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        Int3 face = low;
        for (int b = 0; b < 3; ++b) {
          const bool upper = (corner >> b & 1) != 0;
          weight *= upper ? share[b] : 1.0 - share[b];
          face[b] += upper && share[b] > 0.0 ? 1 : 0;
        }
        if (weight > 0.0) sum += weight * double(gas.velocity[a][grid.face(a, face[0], face[1], face[2])]);
      }
      velocity[n][a] = sum;
    }
  return velocity;
}

}  // namespace wick::coupling
