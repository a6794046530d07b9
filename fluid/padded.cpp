#include "fluid/padded.h"

#include <algorithm>

#include "core/parallel.h"
#include "fluid/simd.h"

namespace wick::fluid {

namespace {

/// Rows of a plane that one task takes: enough work to outweigh starting it.
constexpr std::size_t row_grain = 32;

/// Sets a row of `count` ghosts from the inner row nearest to it and the one at the opposite side.
void fill_row(const GhostRule& rule, float* out, const float* inside, const float* opposite, std::size_t count) {
  const float* from = rule.kind == Ghost::wrap ? opposite : inside;
  const float scale = rule.kind == Ghost::mirror ? -1.0F : 1.0F;
  const float shift = rule.kind == Ghost::mirror ? 2.0F * rule.wall : 0.0F;
  if (rule.kind == Ghost::zero) return std::fill_n(out, count, 0.0F), void();
  for (std::size_t i = 0; i < count; ++i) out[i] = shift + scale * from[i];
}

}  // namespace

void Padded::reshape(const Int3& counts, const Int3& pads) {
  count = counts;
  pad = pads;
  const std::size_t size = std::size_t(extent(0)) * extent(1) * extent(2);
  data.resize(size + 2 * lanes);
}

void Padded::assign(const std::vector<float>& source, float factor) {
  const std::size_t nx = count[0], ny = count[1], rows = ny * count[2];
  parallel_for(rows, row_grain, [&](std::size_t row) {
    const float* in = source.data() + row * nx;
    float* out = data.data() + index(0, int(row % ny), int(row / ny));
    for (std::size_t i = 0; i < nx; ++i) out[i] = factor * in[i];
  });
}

void Padded::fill_ghosts(const GhostRules& rules) {
  // Fill axis by axis; later axes copy whole rows and planes, ghosts of earlier axes included.
  for (int axis = 0; axis < 3; ++axis) {
    const std::ptrdiff_t s = stride(axis);
    const int n = count[axis];
    const std::size_t across = axis == 0 ? std::size_t(extent(1)) * extent(2) : axis == 1 ? extent(2) : extent(1);
    parallel_for(across, axis == 0 ? 1024 : 16, [&](std::size_t row) {
      float* base = data.data() + std::ptrdiff_t(row) * (axis == 1 ? stride(2) : stride(1));
      const std::size_t length = axis == 0 ? 1 : extent(0);
      for (int g = 0; g < pad[axis]; ++g) {
        // Ghost g counts outward from the side; wrap takes the g-th value from the other end.
        const int low = pad[axis] - 1 - g, high = pad[axis] + n + g;
        const int w = g % n;
        fill_row(rules[2 * axis], base + low * s, base + pad[axis] * s, base + (pad[axis] + n - 1 - w) * s, length);
        fill_row(rules[2 * axis + 1], base + high * s, base + (pad[axis] + n - 1) * s, base + (pad[axis] + w) * s,
                 length);
      }
    });
  }
}

GhostRules scalar_ghosts(const Sides& sides) {
  GhostRules rules;
  for (int s = 0; s < 6; ++s) {
    rules[s].kind = sides[s] == Side::open ? Ghost::zero : sides[s] == Side::periodic ? Ghost::wrap : Ghost::copy;
  }
  return rules;
}

}  // namespace wick::fluid
