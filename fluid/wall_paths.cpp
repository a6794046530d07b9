#include "fluid/wall_paths.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace wick::fluid {

void WallPaths::wrap_cell(Int3& cell) const {
  for (int b = 0; b < 3; ++b) {
    const int n = grid_.size(b);
    if (sides_[2 * b] == Side::periodic) cell[b] = ((cell[b] % n) + n) % n;
  }
}

bool WallPaths::closed_face(int axis, const Int3& face) const {
  Int3 cell = face;
  const int n = grid_.size(axis);
  if (sides_[2 * axis] == Side::periodic) cell[axis] = ((face[axis] % n) + n) % n;
  for (int b = 0; b < 3; ++b) {
    if (b == axis) continue;
    const int m = grid_.size(b);
    if (sides_[2 * b] == Side::periodic) cell[b] = ((cell[b] % m) + m) % m;
    if (cell[b] < 0 || cell[b] >= m) return false;  // between ghosts of an open side there is only air
  }
  if (cell[axis] < 0 || cell[axis] > n) return true;
  if (cell[axis] == 0 && sides_[2 * axis] == Side::closed) return true;
  if (cell[axis] == n && sides_[2 * axis + 1] == Side::closed) return true;
  return walls_.any && walls_.closed[axis][grid_.face(axis, cell[0], cell[1], cell[2])] != 0;
}

bool WallPaths::passable(const Int3& cell, int axis, int upper) const {
  Int3 face = cell;
  face[axis] += upper;
  // Nothing goes sideways out of the layer of ghosts, whose outer sides are at infinity for what is near a wall.
  for (int b = 0; b < 3; ++b) {
    if (b == axis || sides_[2 * b] == Side::periodic) continue;
    if (cell[b] < -1 || cell[b] > grid_.size(b)) return false;
  }
  const int n = grid_.size(axis);
  if (sides_[2 * axis] != Side::periodic && (face[axis] < 0 || face[axis] > n)) return false;
  for (int b = 0; b < 3; ++b) {
    if (b == axis) continue;
    const bool ghost = cell[b] < 0 || cell[b] >= grid_.size(b);
    if (ghost && sides_[2 * b + (cell[b] >= 0)] == Side::closed) return false;
  }
  return !closed_face(axis, face);
}

WallPoint WallPaths::walk(const WallPoint& start, const std::array<float, 3>& displacement) const {
  WallPoint at = start;
  std::array<float, 3> d = displacement;
  for (int a = 0; a < 3; ++a) {
    // A value that is not a number, or one larger than the box, must not walk for ever.
    const float longest = 4.0F * static_cast<float>(grid_.size(a) + 1);
    d[a] = std::isfinite(d[a]) ? std::clamp(d[a], -longest, longest) : 0.0F;
    if (sides_[2 * a] == Side::periodic) continue;
    const float low = sides_[2 * a] == Side::open ? -0.5F : 0.0F;
    const float high = static_cast<float>(grid_.size(a)) + (sides_[2 * a + 1] == Side::open ? 0.5F : 0.0F);
    const float end = std::clamp(start.x[a] + d[a], low, high);
    at.clipped = at.clipped || end != start.x[a] + d[a];
    d[a] = end - start.x[a];
  }
  // Cross faces in the order in which the line meets them; `travelled` is the part of it done.
  float travelled = 0.0F;
  while (true) {
    int axis = -1;
    float next = 1.0F;
    for (int a = 0; a < 3; ++a) {
      if (d[a] == 0.0F) continue;
      const float face = static_cast<float>(at.cell[a] + (d[a] > 0.0F));
      const float when = (face - start.x[a]) / d[a];
      if (when < next) next = when, axis = a;
    }
    if (axis < 0) break;
    travelled = std::max(travelled, next);
    if (!passable(at.cell, axis, d[axis] > 0.0F)) {
      at.clipped = true;
      for (int a = 0; a < 3; ++a) d[a] *= travelled;
      break;
    }
    at.cell[axis] += d[axis] > 0.0F ? 1 : -1;
  }
  for (int a = 0; a < 3; ++a) {
    const auto low = static_cast<float>(at.cell[a]);
    at.x[a] = std::clamp(start.x[a] + d[a], low, low + 1.0F);
  }
  return at;
}

unsigned WallPaths::reach(const Int3& cell, const Int3& toward) const {
  // Grow the set over the twelve inner faces of the block until it stays the same.
  unsigned reached = 1;
  for (unsigned before = 0; before != reached;) {
    before = reached;
    for (int corner = 0; corner < 8; ++corner) {
      if (!(reached >> corner & 1U)) continue;
      Int3 c = cell;
      for (int a = 0; a < 3; ++a) c[a] += (corner >> a & 1) * toward[a];
      for (int a = 0; a < 3; ++a) {
        const int other = corner ^ (1 << a);
        if (reached >> other & 1U) continue;
        const bool outward = !(corner >> a & 1);
        const bool up = outward == (toward[a] > 0);
        if (passable(c, a, up)) reached |= 1U << other;
      }
    }
  }
  return reached;
}

namespace {

struct Block {
  Int3 toward{};
  std::array<float, 3> weight{};  ///< of the far side, along each axis
};

Block block_around(const WallPoint& at) {
  Block block;
  for (int a = 0; a < 3; ++a) {
    const float f = at.x[a] - (static_cast<float>(at.cell[a]) + 0.5F);
    block.toward[a] = f >= 0.0F ? 1 : -1;
    block.weight[a] = std::min(std::abs(f), 0.5F);
  }
  return block;
}

/// Weighted mean that also keeps the range and tells what was left out.
struct Mean {
  float sum = 0.0F, weight = 0.0F, low = 0.0F, high = 0.0F;
  bool thinned = false;

  void add(float value, float w) {
    low = weight == 0.0F ? value : std::min(low, value);
    high = weight == 0.0F ? value : std::max(high, value);
    sum += w * value;
    weight += w;
  }
  [[nodiscard]] WallSample result() const { return {std::clamp(sum / weight, low, high), low, high, thinned}; }
};

}  // namespace

WallSample WallPaths::sample_scalar(const Padded& field, const WallPoint& at) const {
  WallPoint here = at;
  wrap_cell(here.cell);
  const Block block = block_around(at);
  const unsigned reached = reach(here.cell, block.toward);
  Mean mean;
  for (int corner = 0; corner < 8; ++corner) {
    float w = 1.0F;
    Int3 c = here.cell;
    for (int a = 0; a < 3; ++a) {
      const bool far = corner >> a & 1;
      w *= far ? block.weight[a] : 1.0F - block.weight[a];
      if (far) c[a] += block.toward[a];
    }
    if (w == 0.0F) continue;
    if (reached >> corner & 1U)
      mean.add(field.at(c[0], c[1], c[2]), w);
    else
      mean.thinned = true;
  }
  return mean.result();
}

WallSample WallPaths::sample_velocity(const Padded& component, int axis, const WallPoint& at) const {
  WallPoint here = at;
  wrap_cell(here.cell);
  const Block block = block_around(at);
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const int n = grid_.size(axis);
  const float along = std::clamp(at.x[axis] - static_cast<float>(at.cell[axis]), 0.0F, 1.0F);

  // Of the four cells side by side, those are seen to which a path of open faces leads within the four.
  std::array<Int3, 4> cells;
  for (int corner = 0; corner < 4; ++corner) {
    cells[corner] = here.cell;
    cells[corner][b] += (corner & 1) * block.toward[b];
    cells[corner][c] += (corner >> 1) * block.toward[c];
  }
  const int up_b = block.toward[b] > 0, up_c = block.toward[c] > 0;
  const bool b0 = passable(cells[0], b, up_b), c0 = passable(cells[0], c, up_c);
  const bool b1 = passable(cells[2], b, up_b), c1 = passable(cells[1], c, up_c);
  const std::array<bool, 4> seen = {true, b0 || (c0 && b1 && c1), c0 || (b0 && c1 && b1), (b0 && c1) || (c0 && b1)};
  Mean mean;
  for (int corner = 0; corner < 4; ++corner) {
    const float w = (corner & 1 ? block.weight[b] : 1.0F - block.weight[b]) *
                    (corner >> 1 ? block.weight[c] : 1.0F - block.weight[c]);
    if (w == 0.0F) continue;
    if (!seen[corner]) {
      mean.thinned = true;
      continue;
    }
    Int3 face = cells[corner];
    for (int upper = 0; upper < 2; ++upper) {
      Int3 f = face;
      f[axis] = std::clamp(face[axis] + upper, 0, n);
      const float share = upper ? along : 1.0F - along;
      if (share > 0.0F) mean.add(component.at(f[0], f[1], f[2]), w * share);
    }
  }
  return mean.result();
}

std::array<float, 3> WallPaths::velocity(const std::array<Padded, 3>& field, const WallPoint& at) const {
  std::array<float, 3> u;
  for (int a = 0; a < 3; ++a) u[a] = sample_velocity(field[a], a, at).value;
  return u;
}

WallPoint WallPaths::trace(const std::array<Padded, 3>& flow, const WallPoint& start, float sign) const {
  const auto scaled = [](std::array<float, 3> u, float factor) {
    for (float& v : u) v *= factor;
    return u;
  };
  const WallPoint middle = walk(start, scaled(velocity(flow, start), 0.5F * sign));
  WallPoint end = walk(start, scaled(velocity(flow, middle), sign));
  end.clipped = end.clipped || middle.clipped;
  return end;
}

namespace {

/// Marks a cell 0 where one of its faces that is not a side of the box is closed.
void mark_wall_cells(const Grid& g, const Sides& sides, const Walls& walls, std::vector<std::uint8_t>& clear) {
  for (int a = 0; a < 3; ++a) {
    parallel_for(std::size_t(g.ny) * g.nz, 64, [&](std::size_t row) {
      const int j = int(row % g.ny), k = int(row / g.ny);
      for (int i = 0; i < g.nx; ++i) {
        const Int3 c = {i, j, k};
        Int3 up = c;
        ++up[a];
        const bool low_side = c[a] == 0 && sides[2 * a] == Side::closed;
        const bool high_side = up[a] == g.size(a) && sides[2 * a + 1] == Side::closed;
        const bool low = !low_side && walls.closed[a][g.face(a, i, j, k)];
        const bool high = !high_side && walls.closed[a][g.face(a, up[0], up[1], up[2])];
        if (low || high) clear[g.cell(i, j, k)] = 0;
      }
    });
  }
}

/// out = min over |o| <= reach of max(|o|, value o cells along the axis), rows of bytes at a time.
void spread_rows(const Grid& g, bool periodic, int axis, int reach, const std::vector<std::uint8_t>& in,
                 std::vector<std::uint8_t>& out) {
  const int n = g.size(axis);
  parallel_for(std::size_t(g.ny) * g.nz, 32, [&](std::size_t row) {
    const int j = int(row % g.ny), k = int(row / g.ny);
    std::uint8_t* to = out.data() + g.cell(0, j, k);
    const std::uint8_t* self = in.data() + g.cell(0, j, k);
    std::copy(self, self + g.nx, to);
    for (int o = -reach; o <= reach; ++o) {
      const auto distance = static_cast<std::uint8_t>(std::abs(o));
      if (axis == 0) {
        for (int i = std::max(0, -o); i < std::min(n, n - o); ++i)
          to[i] = std::min(to[i], std::max(distance, self[i + o]));
        if (!periodic) continue;
        for (int i = 0; i < n; ++i) {
          if (i + o >= 0 && i + o < n) continue;
          to[i] = std::min(to[i], std::max(distance, self[((i + o) % n + n) % n]));
        }
        continue;
      }
      int other = (axis == 1 ? j : k) + o;
      if (periodic) other = (other % n + n) % n;
      if (other < 0 || other >= n) continue;
      const std::uint8_t* from = in.data() + (axis == 1 ? g.cell(0, other, k) : g.cell(0, j, other));
      for (int i = 0; i < g.nx; ++i) to[i] = std::min(to[i], std::max(distance, from[i]));
    }
  });
}

}  // namespace

std::vector<std::uint8_t> wall_clearance(const Grid& grid, const Sides& sides, const Walls& walls, int reach) {
  std::vector<std::uint8_t> clear(grid.cells(), static_cast<std::uint8_t>(reach + 1)), other(grid.cells());
  mark_wall_cells(grid, sides, walls, clear);
  for (int a = 0; a < 3; ++a) {
    spread_rows(grid, sides[2 * a] == Side::periodic, a, reach, clear, other);
    std::swap(clear, other);
  }
  return clear;
}

}  // namespace wick::fluid
