#include "fluid/smoke_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "fluid/advection.h"

namespace wick::fluid {

namespace {

constexpr std::size_t cell_grain = 32768;

/// Largest |value|, whatever its sign.
double largest(const std::vector<float>& field) {
  return parallel_max(field.size(), cell_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    float most = 0.0F;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(field[i]));
    return double(most);
  });
}

}  // namespace

double sum(const CellField& field) {
  return parallel_sum(field.size(), cell_grain, [&](std::size_t begin, std::size_t end) {
    double total = 0.0;
    for (std::size_t i = begin; i < end; ++i) total += field[i];
    return total;
  });
}

double fastest(const FaceField& velocity) {
  return std::max({largest(velocity[0]), largest(velocity[1]), largest(velocity[2])});
}

double cell_volume(const SmokeParams& p) {
  const double h = smoke_grid(p).h;
  return h * h * h;
}
double heat_capacity(const SmokeParams& p) {
  return p.air_density * p.air_heat_capacity * cell_volume(p);
}

void visit(StateVisitor& visitor, SmokeState& state) {
  visitor.array("velocity_x", state.velocity[0]);
  visitor.array("velocity_y", state.velocity[1]);
  visitor.array("velocity_z", state.velocity[2]);
  visitor.array("pressure", state.pressure);
  visitor.array("density", state.density);
  visitor.array("temperature", state.temperature);
  visitor.array("flame", state.flame);
  visitor.array("window", state.window);
}

Grid smoke_grid(const SmokeParams& p) {
  return {p.resolution[0], p.resolution[1], p.resolution[2], p.width / p.resolution[0], p.lower};
}

SmokeState make_smoke_state(const SmokeParams& params) {
  const Grid grid = smoke_grid(params);
  SmokeState state;
  state.velocity = make_face_field(grid);
  state.pressure.assign(grid.cells(), 0.0);
  for (CellField* field : {&state.density, &state.temperature, &state.flame}) field->assign(grid.cells(), 0.0F);
  return state;
}

double stable_dt(const SmokeState& state, const SmokeParams& params, const Vec3& gravity) {
  // The speed at the end of the step is v + a dt: solve (v + a dt) dt = cfl h.
  const double v = fastest(state.velocity), path = params.cfl * smoke_grid(params).h;
  const double lift = parallel_max(state.density.size(), cell_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    double most = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double t = state.temperature[i];
      const double pull = params.buoyancy_heat * t / std::max(params.ambient_temperature + t, 1.0) -
                          params.buoyancy_smoke * state.density[i] / params.air_density;
      most = std::max(most, std::abs(pull));
    }
    return most;
  });
  // The curl of a flow of speed v is at most about 4 v/h, so confinement pushes with at most 4 ε v.
  const double a = lift * gravity.cwiseAbs().maxCoeff() + 4.0 * params.vorticity * v;
  if (v == 0.0 && a == 0.0) return std::numeric_limits<double>::infinity();
  return 2.0 * path / (v + std::sqrt(v * v + 4.0 * a * path));
}

double total_smoke(const SmokeState& state, const SmokeParams& params) {
  return cell_volume(params) * sum(state.density);
}

double total_heat(const SmokeState& state, const SmokeParams& params) {
  return heat_capacity(params) * sum(state.temperature);
}

void impose_walls(const Grid& grid, const Sides& sides, const Walls& walls, FaceField& velocity) {
  for (int s = 0; s < 6; ++s) {
    if (sides[s] != Side::closed) continue;
    const int a = s / 2;
    Int3 low = {0, 0, 0}, high = lattice_size(grid, a);
    low[a] = s % 2 ? grid.size(a) : 0;
    high[a] = low[a] + 1;
    for (int k = low[2]; k < high[2]; ++k) {
      for (int j = low[1]; j < high[1]; ++j) {
        for (int i = low[0]; i < high[0]; ++i) velocity[a][grid.face(a, i, j, k)] = 0.0F;
      }
    }
  }
  for (int a = 0; a < 3; ++a) move_with_walls(walls, a, velocity[a]);
  join_periodic_faces(grid, sides, velocity);
}

}  // namespace wick::fluid
