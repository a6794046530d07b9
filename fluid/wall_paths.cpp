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
  std::array<float, 3> inverse;
  for (int a = 0; a < 3; ++a) inverse[a] = 1.0F / d[a];
  while (true) {
    int axis = -1;
    float next = 1.0F;
    for (int a = 0; a < 3; ++a) {
      if (d[a] == 0.0F) continue;
      const float face = static_cast<float>(at.cell[a] + (d[a] > 0.0F));
      // Where the inverse is too large to be stored the end comes before any face, unless the start is on it.
      const float to_face = face - start.x[a];
      const float when = to_face == 0.0F ? 0.0F : to_face * inverse[a];
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

/// The 2x2x2 cells around a point.
struct WallPaths::Block {
  Int3 cell{};                    ///< that of the point, within the box or its ghosts
  Int3 toward{};                  ///< where the others lie
  std::array<float, 3> weight{};  ///< of the far side, along each axis
  std::array<std::uint8_t, 8> doors{};
};

WallPaths::Block WallPaths::block_around(const WallPoint& at) const {
  Block block;
  block.cell = at.cell;
  wrap_cell(block.cell);
  for (int a = 0; a < 3; ++a) {
    const float f = at.x[a] - (static_cast<float>(at.cell[a]) + 0.5F);
    block.toward[a] = f >= 0.0F ? 1 : -1;
    block.weight[a] = std::min(std::abs(f), 0.5F);
  }
  block.doors = map_.block_doors(block.cell, block.toward);
  return block;
}

unsigned WallPaths::reach(const Block& block) const {
  // Most blocks have no wall in them.
  unsigned all = 0x3F;
  for (const std::uint8_t doors : block.doors) all &= doors;
  if (all == 0x3F) return 0xFF;

  // Grow the set over the twelve inner faces of the block until it stays the same.
  unsigned reached = 1;
  for (unsigned before = 0; before != reached;) {
    before = reached;
    for (int corner = 0; corner < 8; ++corner) {
      if (!(reached >> corner & 1U)) continue;
      for (int a = 0; a < 3; ++a) {
        const bool outward = !(corner >> a & 1);
        const bool up = outward == (block.toward[a] > 0);
        if (block.doors[corner] >> (2 * a + up) & 1U) reached |= 1U << (corner ^ (1 << a));
      }
    }
  }
  return reached;
}

namespace {

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
  const Block block = block_around(at);
  const unsigned reached = reach(block);
  Mean mean;
  for (int corner = 0; corner < 8; ++corner) {
    float w = 1.0F;
    Int3 c = block.cell;
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

template <int A>
WallSample WallPaths::sample_component(const Padded& component, const WallPoint& at, const Block& block) const {
  constexpr int b = (A + 1) % 3, c = (A + 2) % 3;
  const int n = size_[A];
  const float along = std::clamp(at.x[A] - static_cast<float>(at.cell[A]), 0.0F, 1.0F);

  // Of the four cells side by side, those are seen to which a path of open faces leads within the four.
  const int up_b = block.toward[b] > 0, up_c = block.toward[c] > 0;
  const auto door = [&](unsigned corner, int axis, int up) { return block.doors[corner] >> (2 * axis + up) & 1U; };
  const bool b0 = door(0, b, up_b), c0 = door(0, c, up_c), b1 = door(1U << c, b, up_b), c1 = door(1U << b, c, up_c);
  const std::array<bool, 4> seen = {true, b0 || (c0 && b1 && c1), c0 || (b0 && c1 && b1), (b0 && c1) || (c0 && b1)};
  const std::ptrdiff_t step_b = block.toward[b] * component.stride(b),
                       step_c = block.toward[c] * component.stride(c);
  const std::ptrdiff_t step_a = component.stride(A);
  const float* values =
      component.data.data() +
      component.index(A == 0 ? 0 : block.cell[0], A == 1 ? 0 : block.cell[1], A == 2 ? 0 : block.cell[2]);
  const std::ptrdiff_t low = std::clamp(block.cell[A], 0, n) * step_a;
  const std::ptrdiff_t high = std::clamp(block.cell[A] + 1, 0, n) * step_a;
  Mean mean;
  for (int corner = 0; corner < 4; ++corner) {
    const float w = (corner & 1 ? block.weight[b] : 1.0F - block.weight[b]) *
                    (corner >> 1 ? block.weight[c] : 1.0F - block.weight[c]);
    if (w == 0.0F) continue;
    if (!seen[corner]) {
      mean.thinned = true;
      continue;
    }
    const float* of_cell = values + (corner & 1) * step_b + (corner >> 1) * step_c;
    if (1.0F - along > 0.0F) mean.add(of_cell[low], w * (1.0F - along));
    if (along > 0.0F) mean.add(of_cell[high], w * along);
  }
  return mean.result();
}

WallSample WallPaths::sample_velocity(const Padded& component, int axis, const WallPoint& at) const {
  const Block block = block_around(at);
  if (axis == 0) return sample_component<0>(component, at, block);
  if (axis == 1) return sample_component<1>(component, at, block);
  return sample_component<2>(component, at, block);
}

std::array<float, 3> WallPaths::velocity(const std::array<Padded, 3>& field, const WallPoint& at) const {
  const Block block = block_around(at);
  return {sample_component<0>(field[0], at, block).value, sample_component<1>(field[1], at, block).value,
          sample_component<2>(field[2], at, block).value};
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
