#include "fluid/wall_paths.h"

#include <algorithm>
#include <cmath>

namespace wick::fluid {

WallPaths::WallPaths(const Grid& grid, const Sides& sides, const WallMap& map)
    : size_{grid.nx, grid.ny, grid.nz}, map_(map) {
  for (int a = 0; a < 3; ++a) {
    periodic_[a] = sides[2 * a] == Side::periodic;
    low_[a] = sides[2 * a] == Side::open ? -0.5F : 0.0F;
    high_[a] = static_cast<float>(size_[a]) + (sides[2 * a + 1] == Side::open ? 0.5F : 0.0F);
  }
}

void WallPaths::wrap_cell(Int3& cell) const {
  for (int b = 0; b < 3; ++b) {
    const int n = size_[b];
    if (periodic_[b] && (cell[b] < 0 || cell[b] >= n)) cell[b] = ((cell[b] % n) + n) % n;
  }
}

WallPoint WallPaths::walk(const WallPoint& start, const std::array<float, 3>& displacement) const {
  WallPoint at = start;
  std::array<float, 3> d = displacement;
  for (int a = 0; a < 3; ++a) {
    // A value that is not a number, or one larger than the box, must not walk for ever.
    const float longest = 4.0F * static_cast<float>(size_[a] + 1);
    d[a] = std::isfinite(d[a]) ? std::clamp(d[a], -longest, longest) : 0.0F;
    if (periodic_[a]) continue;
    const float end = std::clamp(start.x[a] + d[a], low_[a], high_[a]);
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
    if (!map_.passable(at.cell, axis, d[axis] > 0.0F)) {
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
  // Most blocks have no wall in them.
  Int3 low, high;
  for (int a = 0; a < 3; ++a) low[a] = std::min(cell[a], cell[a] + toward[a]), high[a] = low[a] + 1;
  if (map_.all_open(low, high)) return 0xFF;

  // Grow the set over the twelve inner faces of the block until it stays the same.
  std::array<unsigned, 8> doors;
  for (int corner = 0; corner < 8; ++corner) {
    Int3 c = cell;
    for (int a = 0; a < 3; ++a) c[a] += (corner >> a & 1) * toward[a];
    doors[corner] = map_.doors(c);
  }
  unsigned reached = 1;
  for (unsigned before = 0; before != reached;) {
    before = reached;
    for (int corner = 0; corner < 8; ++corner) {
      if (!(reached >> corner & 1U)) continue;
      for (int a = 0; a < 3; ++a) {
        const bool outward = !(corner >> a & 1);
        const bool up = outward == (toward[a] > 0);
        if (doors[corner] >> (2 * a + up) & 1U) reached |= 1U << (corner ^ (1 << a));
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
  const int n = size_[axis];
  const float along = std::clamp(at.x[axis] - static_cast<float>(at.cell[axis]), 0.0F, 1.0F);

  // Of the four cells side by side, those are seen to which a path of open faces leads within the four.
  std::array<Int3, 4> cells;
  for (int corner = 0; corner < 4; ++corner) {
    cells[corner] = here.cell;
    cells[corner][b] += (corner & 1) * block.toward[b];
    cells[corner][c] += (corner >> 1) * block.toward[c];
  }
  const int up_b = block.toward[b] > 0, up_c = block.toward[c] > 0;
  const unsigned here_doors = map_.doors(cells[0]);
  const bool b0 = here_doors >> (2 * b + up_b) & 1U, c0 = here_doors >> (2 * c + up_c) & 1U;
  const bool b1 = map_.passable(cells[2], b, up_b), c1 = map_.passable(cells[1], c, up_c);
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

}  // namespace wick::fluid
