#pragma once
/// The inner loops of advection: eight points of a row at a time, no case for sides or walls. Points whose
/// path meets a wall are done again, one at a time, through WallTransport.
#include "fluid/advection.h"
#include "fluid/simd.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

/// How coordinates of one axis are brought into the box.
struct AxisRange {
  float n = 1.0F;
  float low = 0.0F, high = 1.0F;                ///< of positions where ghosts may be sampled
  float inside_low = 0.0F, inside_high = 1.0F;  ///< a path that ends outside these left the box
  bool periodic = false;

  [[nodiscard]] WICK_INLINE F8 wrapped(F8 x) const { return periodic ? x - n * floor8(x * (1.0F / n)) : x; }
};

/// Where a position lies between values: index of the lower one and the weight of the upper.
struct Bracket {
  I8 index;
  F8 weight;
};

/// Between values at whole numbers 0..n (faces along their own axis).
WICK_INLINE Bracket bracket_faces(const AxisRange& r, F8 x) {
  const F8 s = clamp8(r.wrapped(x), 0.0F, r.n);
  const I8 i = min8(__builtin_convertvector(s, I8), splat(static_cast<std::int32_t>(r.n) - 1));
  return {i, s - __builtin_convertvector(i, F8)};
}
/// Between values at halves, the first of them the ghost at -1/2.
WICK_INLINE Bracket bracket_centers(const AxisRange& r, F8 x) {
  const F8 s = clamp8(r.wrapped(x), r.low, r.high) + 0.5F;
  const I8 i = min8(__builtin_convertvector(s, I8), splat(static_cast<std::int32_t>(r.n)));
  return {i, s - __builtin_convertvector(i, F8)};
}

using Brackets = std::array<Bracket, 3>;

/// The eight values around eight points.
struct Corners {
  std::array<F8, 8> q;  ///< x fastest

  WICK_INLINE Corners(const float* data, std::ptrdiff_t sy, std::ptrdiff_t sz, const Brackets& at) {
    alignas(32) std::int32_t index[lanes];
    const I8 base =
        at[0].index + at[1].index * static_cast<std::int32_t>(sy) + at[2].index * static_cast<std::int32_t>(sz);
    std::memcpy(index, &base, sizeof base);
    load_pairs(data, index, q[0], q[1]);
    load_pairs(data + sy, index, q[2], q[3]);
    load_pairs(data + sz, index, q[4], q[5]);
    load_pairs(data + sz + sy, index, q[6], q[7]);
  }
  [[nodiscard]] WICK_INLINE F8 interpolate(const Brackets& at) const {
    const auto mix = [](F8 a, F8 b, F8 t) { return a + t * (b - a); };
    const F8 fx = at[0].weight, fy = at[1].weight, fz = at[2].weight;
    return mix(mix(mix(q[0], q[1], fx), mix(q[2], q[3], fx), fy), mix(mix(q[4], q[5], fx), mix(q[6], q[7], fx), fy),
               fz);
  }
  [[nodiscard]] WICK_INLINE F8 lowest() const {
    return min8(min8(min8(q[0], q[1]), min8(q[2], q[3])), min8(min8(q[4], q[5]), min8(q[6], q[7])));
  }
  [[nodiscard]] WICK_INLINE F8 highest() const {
    return max8(max8(max8(q[0], q[1]), max8(q[2], q[3])), max8(max8(q[4], q[5]), max8(q[6], q[7])));
  }
};

/// The flow, ready for sampling.
struct FlowView {
  std::array<const float*, 3> data;
  std::array<std::ptrdiff_t, 3> sy, sz;
  std::array<AxisRange, 3> range;

  [[nodiscard]] WICK_INLINE std::array<F8, 3> sample(const std::array<F8, 3>& x) const {
    const Brackets face = {bracket_faces(range[0], x[0]), bracket_faces(range[1], x[1]),
                           bracket_faces(range[2], x[2])};
    const Brackets center = {bracket_centers(range[0], x[0]), bracket_centers(range[1], x[1]),
                             bracket_centers(range[2], x[2])};
    std::array<F8, 3> u;
    for (int a = 0; a < 3; ++a) {
      Brackets at = center;
      at[a] = face[a];
      u[a] = Corners(data[a], sy[a], sz[a], at).interpolate(at);
    }
    return u;
  }

  /// Velocity at eight consecutive points of lattice A (component A, or cell centres for 3) from (i,j,k) on.
  template <int A>
  [[nodiscard]] WICK_INLINE std::array<F8, 3> at_points(int i, int j, int k) const {
    const std::ptrdiff_t p[3] = {i, j, k};
    std::array<F8, 3> u;
    for (int b = 0; b < 3; ++b) {
      const std::ptrdiff_t s[3] = {1, sy[b], sz[b]};
      // Skip the ghosts of the axes across component b; it has none along its own.
      const float* d = data[b];
      for (int c = 0; c < 3; ++c) d += (p[c] + (c != b)) * s[c];
      if (A == b) {
        u[b] = load8(d);
      } else if (A == 3) {
        u[b] = 0.5F * (load8(d) + load8(d + s[b]));
      } else {
        const float* e = d - s[A % 3];
        u[b] = 0.25F * (load8(d) + load8(d + s[b]) + load8(e) + load8(e + s[b]));
      }
    }
    return u;
  }
};

/// Eight paths: where they begin, where their velocity is taken, and where they end.
struct Paths {
  std::array<F8, 3> start, middle, x;
};

/// Second-order paths against (sign -1) or along (+1) the flow from eight points of lattice A.
template <int A>
WICK_INLINE Paths trace_paths(const FlowView& flow, int i, int j, int k, float sign) {
  Paths paths;
  paths.start = {lane_index() + (static_cast<float>(i) + (A == 0 ? 0.0F : 0.5F)),
                 splat(static_cast<float>(j) + (A == 1 ? 0.0F : 0.5F)),
                 splat(static_cast<float>(k) + (A == 2 ? 0.0F : 0.5F))};
  const auto u = flow.at_points<A>(i, j, k);
  for (int a = 0; a < 3; ++a) paths.middle[a] = paths.start[a] + (0.5F * sign) * u[a];
  const auto um = flow.sample(paths.middle);
  for (int a = 0; a < 3; ++a) paths.x[a] = paths.start[a] + sign * um[a];
  return paths;
}

/// Brackets of lattice A at positions x.
template <int A>
WICK_INLINE Brackets bracket_lattice(const FlowView& flow, const std::array<F8, 3>& x) {
  Brackets at;
  for (int a = 0; a < 3; ++a)
    at[a] = a == A ? bracket_faces(flow.range[a], x[a]) : bracket_centers(flow.range[a], x[a]);
  return at;
}

/// All bits set in the lanes whose path stayed inside the box.
WICK_INLINE I8 stayed_inside(const FlowView& flow, const std::array<F8, 3>& x) {
  I8 inside = splat(std::int32_t{-1});
  for (int a = 0; a < 3; ++a) inside &= (x[a] >= flow.range[a].inside_low) & (x[a] <= flow.range[a].inside_high);
  return inside;
}

}  // namespace wick::fluid

#pragma GCC diagnostic pop
