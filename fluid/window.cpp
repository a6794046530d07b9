#include "fluid/window.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fluid/padded.h"
#include "fluid/smoke_state.h"

namespace wick::fluid {

namespace {

/// Windows begin and end at multiples of this, so that their solvers are rebuilt seldom.
constexpr int block = 16;
/// Cells kept around what matters, besides those that it can cross in a step: room for the air that it pushes.
constexpr int margin = 8;
/// Parts of the largest value below which a value does not matter: smoke and heat that nobody sees, and speeds
/// of the far field of a vortex, which the margin then continues outward.
constexpr float least_scalar = 1e-4F;
constexpr float least_speed = 0.005F;
/// Above this part of the box, stepping all of it costs no more.
constexpr double most_of_box = 0.8;

/// Bounds of cells; empty until something is added.
struct Bounds {
  Int3 low = {1 << 30, 1 << 30, 1 << 30}, high = {0, 0, 0};

  void add(const Int3& from, const Int3& to) {
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], from[a]), high[a] = std::max(high[a], to[a]);
  }
  [[nodiscard]] bool empty() const { return high[0] == 0; }
};

/// Bounds of the values of a lattice with |value| > least, found plane by plane.
void add_values(const std::vector<float>& values, const Int3& size, float least, Bounds& bounds) {
  std::vector<Bounds> planes(size[2]);
  parallel_for(planes.size(), 1, [&](std::size_t k) {
    for (int j = 0; j < size[1]; ++j) {
      const float* row = values.data() + (k * size[1] + j) * size[0];
      float most = 0.0F;
      for (int i = 0; i < size[0]; ++i) most = std::max(most, std::abs(row[i]));
      if (!(most > least)) continue;
      int first = 0, last = size[0] - 1;
      while (!(std::abs(row[first]) > least)) ++first;
      while (!(std::abs(row[last]) > least)) --last;
      planes[k].add({first, j, int(k)}, {last + 1, j + 1, int(k) + 1});
    }
  });
  for (const Bounds& plane : planes) {
    if (!plane.empty()) bounds.add(plane.low, plane.high);
  }
}

float largest(const std::vector<float>& values) {
  return static_cast<float>(parallel_max(values.size(), 65536, 0.0, [&](std::size_t begin, std::size_t end) {
    float most = 0.0F;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(values[i]));
    return double(most);
  }));
}

/// Everything that moves, shows or pushes.
Bounds what_matters(const SmokeState& state, const Grid& grid, const SmokeSources& sources, const Walls& walls) {
  Bounds bounds;
  for (const CellField* field : {&state.density, &state.temperature, &state.flame}) {
    add_values(*field, lattice_size(grid, 3), least_scalar * largest(*field), bounds);
  }
  const auto least = static_cast<float>(least_speed * fastest(state.velocity));
  for (int a = 0; a < 3; ++a) add_values(state.velocity[a], lattice_size(grid, a), least, bounds);
  for (const std::int64_t c : sources.cell) {
    const Int3 at = {int(c % grid.nx), int(c / grid.nx % grid.ny), int(c / grid.nx / grid.ny)};
    bounds.add(at, {at[0] + 1, at[1] + 1, at[2] + 1});
  }
  for (int a = 0; walls.any && a < 3; ++a) {
    const Int3 size = lattice_size(grid, a);
    for (std::size_t f = 0; f < walls.closed[a].size(); ++f) {
      if (!walls.closed[a][f]) continue;
      const Int3 at = {int(f % size[0]), int(f / size[0] % size[1]), int(f / size[0] / size[1])};
      bounds.add(at, {at[0] + 1, at[1] + 1, at[2] + 1});
    }
  }
  return bounds;
}

/// Bounds widened by `cells` and to whole blocks, inside the box; a periodic axis is always taken whole.
Window widen(const Bounds& bounds, int cells, const Grid& grid, const Sides& sides) {
  Window w;
  for (int a = 0; a < 3; ++a) {
    const int n = grid.size(a);
    w.low[a] = std::clamp((bounds.low[a] - cells) / block * block, 0, n);
    w.high[a] = std::clamp((bounds.high[a] + cells + block - 1) / block * block, 0, n);
    if (sides[2 * a] == Side::periodic || n - w.high[a] < block / 2) w.high[a] = n;
    if (sides[2 * a] == Side::periodic || bounds.low[a] - cells <= 0) w.low[a] = 0;
  }
  return w;
}

bool contains(const Window& outer, const Window& inner) {
  for (int a = 0; a < 3; ++a) {
    if (inner.low[a] < outer.low[a] || inner.high[a] > outer.high[a]) return false;
  }
  return true;
}

/// Copies the rows of a window of a lattice of `size`; `extra` is 1 along the axis of a face lattice.
template <class T, class Copy>
void copy_rows(const Int3& size, const Window& w, const Int3& extra, T* whole, const Copy& copy) {
  const int ny = w.size(1) + extra[1], nz = w.size(2) + extra[2], nx = w.size(0) + extra[0];
  parallel_for(std::size_t(ny) * nz, 64, [&](std::size_t row) {
    const int j = w.low[1] + int(row % ny), k = w.low[2] + int(row / ny);
    copy(whole + w.low[0] + std::size_t(size[0]) * (j + std::size_t(size[1]) * k), row * nx, std::size_t(nx));
  });
}

template <class T>
std::vector<T> crop_values(const std::vector<T>& whole, const Grid& grid, int lattice, const Window& w) {
  const Int3 extra = {lattice == 0, lattice == 1, lattice == 2};
  std::vector<T> part(std::size_t(w.size(0) + extra[0]) * (w.size(1) + extra[1]) * (w.size(2) + extra[2]));
  copy_rows(lattice_size(grid, lattice), w, extra, whole.data(),
            [&](const T* from, std::size_t at, std::size_t n) { std::copy_n(from, n, part.data() + at); });
  return part;
}

template <class T>
void paste_values(const std::vector<T>& part, const Grid& grid, int lattice, const Window& w,
                  std::vector<T>& whole) {
  const Int3 extra = {lattice == 0, lattice == 1, lattice == 2};
  copy_rows(lattice_size(grid, lattice), w, extra, whole.data(),
            [&](T* to, std::size_t at, std::size_t n) { std::copy_n(part.data() + at, n, to); });
}

}  // namespace

std::optional<Window> choose_window(const SmokeState& state, const SmokeParams& params, const SmokeSources& sources,
                                    const Walls& walls) {
  // A force everywhere moves air everywhere, and air that sticks to sides would stick to those of the window.
  if (!params.active_window || sources.body_force || params.no_slip) return std::nullopt;
  const Grid grid = smoke_grid(params);
  const Bounds bounds = what_matters(state, grid, sources, walls);
  if (bounds.empty()) return std::nullopt;
  const int reach = margin + static_cast<int>(std::ceil(std::min(params.cfl, 64.0)));
  Window wanted = widen(bounds, reach, grid, params.sides);
  if (state.window.size() == 6) {
    // Keep the last window unless it is too small, or would be too large by a whole block even with one to spare.
    const auto& s = state.window;
    const Window last = {{s[0], s[1], s[2]}, {s[3], s[4], s[5]}};
    const Window spare = widen(bounds, reach + block, grid, params.sides);
    if (contains(last, wanted) && contains(spare, last))
      wanted = last;
    else if (!contains(last, wanted))
      wanted = widen(bounds, reach + block / 2, grid, params.sides);
  }
  if (double(wanted.cells()) > most_of_box * double(grid.cells())) return std::nullopt;
  return wanted;
}

SmokeParams window_params(const SmokeParams& params, const Window& window) {
  const Grid grid = smoke_grid(params);
  SmokeParams p = params;
  for (int a = 0; a < 3; ++a) {
    p.resolution[a] = window.size(a);
    p.lower[a] += grid.h * window.low[a];
    if (window.low[a] > 0) p.sides[2 * a] = Side::open;
    if (window.high[a] < grid.size(a)) p.sides[2 * a + 1] = Side::open;
  }
  p.width = grid.h * window.size(0);
  return p;
}

SmokeState crop(const SmokeState& state, const Grid& grid, const Window& w) {
  SmokeState part;
  for (int a = 0; a < 3; ++a) part.velocity[a] = crop_values(state.velocity[a], grid, a, w);
  part.pressure = crop_values(state.pressure, grid, 3, w);
  part.density = crop_values(state.density, grid, 3, w);
  part.temperature = crop_values(state.temperature, grid, 3, w);
  part.flame = crop_values(state.flame, grid, 3, w);
  return part;
}

void paste(const SmokeState& part, const Grid& grid, const Window& w, SmokeState& state) {
  for (int a = 0; a < 3; ++a) {
    auto& u = state.velocity[a];
    parallel_for(u.size(), 65536, [&](std::size_t f) { u[f] = 0.0F; });
    paste_values(part.velocity[a], grid, a, w, u);
  }
  paste_values(part.pressure, grid, 3, w, state.pressure);
  paste_values(part.density, grid, 3, w, state.density);
  paste_values(part.temperature, grid, 3, w, state.temperature);
  paste_values(part.flame, grid, 3, w, state.flame);
}

Walls crop(const Walls& walls, const Grid& grid, const Window& w) {
  Walls part;
  part.any = walls.any;
  if (!walls.any) return part;
  part.solid = crop_values(walls.solid, grid, 3, w);
  part.near = crop_values(walls.near, grid, 3, w);
  for (int a = 0; a < 3; ++a) {
    part.closed[a] = crop_values(walls.closed[a], grid, a, w);
    part.velocity[a] = crop_values(walls.velocity[a], grid, a, w);
  }
  return part;
}

SmokeSources crop(const SmokeSources& sources, const Grid& grid, const Window& w) {
  SmokeSources part = sources;
  for (std::int64_t& c : part.cell) {
    const Int3 at = {int(c % grid.nx), int(c / grid.nx % grid.ny), int(c / grid.nx / grid.ny)};
    c = (at[0] - w.low[0]) +
        std::int64_t(w.size(0)) * ((at[1] - w.low[1]) + std::int64_t(w.size(1)) * (at[2] - w.low[2]));
  }
  return part;
}

MovableWalls crop(const MovableWalls& movable, const Grid& grid, const Window& w) {
  MovableWalls part = movable;
  for (std::size_t r = 0; r < part.face.size(); ++r) {
    const int a = part.axis[r];
    const Int3 size = lattice_size(grid, a);
    const std::int64_t f = part.face[r];
    const Int3 at = {int(f % size[0]), int(f / size[0] % size[1]), int(f / size[0] / size[1])};
    part.face[r] =
        (at[0] - w.low[0]) + std::int64_t(w.size(0) + (a == 0)) *
                                 ((at[1] - w.low[1]) + std::int64_t(w.size(1) + (a == 1)) * (at[2] - w.low[2]));
  }
  return part;
}

}  // namespace wick::fluid
