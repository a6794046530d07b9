#include "fluid/forces.h"

#include <algorithm>
#include <cmath>

#include "core/float_sum.h"
#include "core/parallel.h"
#include "fluid/smoke_state.h"

namespace wick::fluid {

namespace {

constexpr std::size_t row_grain = 16;
constexpr std::size_t cell_grain = 32768;

/// Multiplies a field and returns by how much its sum fell.
double shrink(CellField& field, double factor) {
  if (factor == 1.0) return 0.0;
  const auto f = static_cast<float>(factor);
  return parallel_sum(field.size(), cell_grain, [&](std::size_t begin, std::size_t end) {
    double lost = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const float left = f * field[i];
      lost += double(field[i]) - double(left);
      field[i] = left;
    }
    return lost;
  });
}

}  // namespace

Faded fade(SmokeState& state, const SmokeParams& params, double dt) {
  const double volume = cell_volume(params);
  Faded faded;
  faded.smoke = volume * shrink(state.density, std::exp(-params.dissipation * dt));
  faded.heat = heat_capacity(params) * shrink(state.temperature, std::exp(-params.cooling * dt));
  shrink(state.flame, std::exp(-dt / params.flame_life));
  return faded;
}

void add_sources(SmokeState& state, const SmokeSources& sources, const SmokeParams& params) {
  const double volume = cell_volume(params);
  const double capacity = heat_capacity(params);
  FloatSum smoke, heat;
  for (std::size_t s = 0; s < sources.cell.size(); ++s) {
    const auto c = static_cast<std::size_t>(sources.cell[s]);
    if (!sources.smoke.empty()) smoke.add(state.density[c], sources.smoke[s] / volume);
    if (!sources.heat.empty()) heat.add(state.temperature[c], sources.heat[s] / capacity);
    if (!sources.flame.empty()) state.flame[c] = std::max(state.flame[c], static_cast<float>(sources.flame[s]));
  }
}

void lift(const SmokeState& state, const SmokeParams& params, Padded& result) {
  const Int3& n = result.count;
  const auto ambient = static_cast<float>(params.ambient_temperature), b = static_cast<float>(params.buoyancy_heat);
  const auto weight = static_cast<float>(params.buoyancy_smoke / params.air_density);
  parallel_for(std::size_t(n[1]) * n[2], row_grain, [&](std::size_t row) {
    const float* t = state.temperature.data() + row * n[0];
    const float* d = state.density.data() + row * n[0];
    float* l = result.data.data() + result.index(0, int(row % n[1]), int(row / n[1]));
    // Gas colder than 1 K is an error of the scheme, and only the pole at 0 K is kept away.
    for (int i = 0; i < n[0]; ++i) l[i] = b * t[i] / std::max(ambient + t[i], 1.0F) - weight * d[i];
  });
}

void add_buoyancy(FaceField& velocity, const Padded& lift, const SmokeSources& sources, const Grid& grid,
                  const Walls& walls, double dt) {
  for (int a = 0; a < 3; ++a) {
    const auto half_pull = static_cast<float>(-0.5 * dt * sources.gravity[a]);
    const float* body = sources.body_force ? (*sources.body_force)[a].data() : nullptr;
    if (half_pull == 0.0F && !body) continue;
    const auto step = static_cast<float>(dt);
    const Int3 size = lattice_size(grid, a);
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      float* u = velocity[a].data() + row * size[0];
      const float* above = lift.data.data() + lift.index(0, j, k);
      const float* below = above - lift.stride(a);
      for (int i = 0; i < size[0]; ++i) u[i] += half_pull * (below[i] + above[i]);
      if (!body) return;
      for (int i = 0; i < size[0]; ++i) u[i] += step * body[row * size[0] + i];
    });
    move_with_walls(walls, a, velocity[a]);
  }
}

void add_half_pressure(FaceField& velocity, const std::vector<double>& pressure, Padded& work, const Grid& grid,
                       const Sides& sides, double density, double dt) {
  const Int3& n = work.count;
  parallel_for(std::size_t(n[1]) * n[2], row_grain, [&](std::size_t row) {
    const double* p = pressure.data() + row * n[0];
    std::copy_n(p, n[0], work.data.data() + work.index(0, int(row % n[1]), int(row / n[1])));
  });
  // No gradient across closed sides; p = 0 on open ones.
  GhostRules rules = scalar_ghosts(sides);
  for (GhostRule& rule : rules) {
    if (rule.kind == Ghost::zero) rule.kind = Ghost::mirror;
  }
  work.fill_ghosts(rules);
  const auto scale = static_cast<float>(0.5 * dt / (density * grid.h));
  for (int a = 0; a < 3; ++a) {
    const Int3 size = lattice_size(grid, a);
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const float* above = work.data.data() + work.index(0, int(row % size[1]), int(row / size[1]));
      const float* below = above - work.stride(a);
      float* u = velocity[a].data() + row * size[0];
      for (int i = 0; i < size[0]; ++i) u[i] -= scale * (above[i] - below[i]);
    });
  }
}

Confinement::Confinement(const Grid& grid, const Sides& sides) : grid_(grid), sides_(sides) {
  const Int3 size = {grid.nx, grid.ny, grid.nz};
  for (auto* field : {&curl_, &push_}) {
    for (Padded& p : *field) p.reshape(size, {1, 1, 1});
  }
  strength_.reshape(size, {1, 1, 1});
}

void Confinement::add(FaceField& velocity, const std::array<Padded, 3>& flow, const Walls& walls, double epsilon,
                      double dt) {
  if (epsilon == 0.0) return;
  const int nx = grid_.nx, ny = grid_.ny;
  const std::size_t rows = std::size_t(ny) * grid_.nz;
  GhostRules copies = scalar_ghosts(sides_);
  for (GhostRule& rule : copies) rule.kind = rule.kind == Ghost::wrap ? Ghost::wrap : Ghost::copy;

  // Take the curl at cell centres from the mean of the two faces on each side; [1/s].
  const auto quarter = static_cast<float>(0.25 / dt);
  parallel_for(rows, row_grain, [&](std::size_t row) {
    const int j = int(row % ny), k = int(row / ny);
    // Twice the difference of component b along axis a at cell i.
    const auto slope = [&](int b, int a, int i) {
      const Padded& f = flow[b];
      const float* at = f.data.data() + f.index(0, j, k) + i;
      const std::ptrdiff_t s = f.stride(a), up = f.stride(b);
      return (at[s] + at[s + up]) - (at[-s] + at[up - s]);
    };
    const std::size_t here = strength_.index(0, j, k);
    for (int i = 0; i < nx; ++i) {
      const float x = quarter * (slope(2, 1, i) - slope(1, 2, i));
      const float y = quarter * (slope(0, 2, i) - slope(2, 0, i));
      const float z = quarter * (slope(1, 0, i) - slope(0, 1, i));
      curl_[0].data[here + i] = x, curl_[1].data[here + i] = y, curl_[2].data[here + i] = z;
      strength_.data[here + i] = std::sqrt(x * x + y * y + z * z);
    }
  });
  strength_.fill_ghosts(copies);

  // Push toward the vortex core. The floor under |grad|ω|| makes the direction fade out where the curl is
  // constant to rounding, instead of pointing anywhere.
  const auto scale = static_cast<float>(0.5 * dt * epsilon * grid_.h);
  parallel_for(rows, row_grain, [&](std::size_t row) {
    const int j = int(row % ny), k = int(row / ny);
    const std::size_t here = strength_.index(0, j, k);
    const float* m = strength_.data.data() + here;
    const std::ptrdiff_t sy = strength_.stride(1), sz = strength_.stride(2);
    const std::uint8_t* near = walls.any ? walls.near.data() + row * nx : nullptr;
    for (int i = 0; i < nx; ++i) {
      const float gx = m[i + 1] - m[i - 1], gy = m[i + sy] - m[i - sy], gz = m[i + sz] - m[i - sz];
      const float floor = 1e-5F * m[i] + 1e-20F;
      const float s = (near && near[i] ? 0.0F : scale) / (std::sqrt(gx * gx + gy * gy + gz * gz) + floor);
      const float x = curl_[0].data[here + i], y = curl_[1].data[here + i], z = curl_[2].data[here + i];
      push_[0].data[here + i] = s * (gy * z - gz * y);
      push_[1].data[here + i] = s * (gz * x - gx * z);
      push_[2].data[here + i] = s * (gx * y - gy * x);
    }
  });
  for (int a = 0; a < 3; ++a) {
    push_[a].fill_ghosts(copies);
    const Int3 size = lattice_size(grid_, a);
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const float* above = push_[a].data.data() + push_[a].index(0, int(row % size[1]), int(row / size[1]));
      const float* below = above - push_[a].stride(a);
      float* u = velocity[a].data() + row * size[0];
      for (int i = 0; i < size[0]; ++i) u[i] += below[i] + above[i];
    });
  }
}

}  // namespace wick::fluid
