#pragma once
/// The part of advection near walls: which points of a row must be carried with care, and how.
#include <algorithm>
#include <span>

#include "fluid/advection_kernel.h"
#include "fluid/wall_paths.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

/// Carries single points, one at a time, through open faces only. All state belongs to the caller.
struct WallTransport {
  const Grid& grid;
  const Sides& sides;
  const Walls& walls;
  const WallMap& map;
  const std::array<Padded, 3>& flow;  ///< [cells a step]
  const std::array<AxisRange, 3>& range;
  bool short_paths;  ///< no path is longer than the map has looked for
  WallPaths paths{grid, sides, map};

  /// Lanes of a row of lattice A, from (i,j,k) on, whose path or stencil meets a closed face that is no side of
  /// the box.
  template <int A>
  [[nodiscard]] unsigned near(const Paths& path, int i, int j, int k, int count) const {
    if (!walls.any) return 0;
    if (nothing_near<A>(i, j, k)) return 0;
    unsigned near = within_clearance<A>(path, i, j, k);
    if (count < lanes) near &= (1U << count) - 1U;
    if (near == 0) return 0;

    // All cells that the path and its stencils see lie between these, with room for rounding.
    std::array<std::array<std::int32_t, lanes>, 3> low, high;
    for (int a = 0; a < 3; ++a) {
      const F8 from = min8(path.start[a], min8(path.middle[a], path.x[a])) - (0.5F + rounding);
      const F8 to = max8(path.start[a], max8(path.middle[a], path.x[a])) + (0.5F + rounding);
      // Whatever lies farther outside is as good as just outside.
      const auto end = static_cast<float>(grid.size(a)) + 4.0F;
      low[a] = lanes_of(__builtin_convertvector(floor8(clamp8(from, -4.0F, end)), I8));
      high[a] = lanes_of(__builtin_convertvector(floor8(clamp8(to, -4.0F, end)), I8));
    }
    for (unsigned left = near; left; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const Int3 from = {low[0][lane], low[1][lane], low[2][lane]},
                 to = {high[0][lane], high[1][lane], high[2][lane]};
      if (map.all_open(from, to)) near &= ~(1U << lane);
    }
    return near;
  }

  /// First pass at one point. Where the path was cut or the stencil thinned, the range is narrowed to the value
  /// itself, so that the second pass leaves it alone.
  template <int A>
  void first(int i, int j, int k, std::span<const Padded> source, std::span<WallSample> out) const {
    if (held<A>(i, j, k)) {
      for (std::size_t f = 0; f < out.size(); ++f) {
        const float q = source[f].at(i, j, k);
        out[f] = {q, q, q, true};
      }
      return;
    }
    const WallPoint end = paths.trace(flow, lattice_point<A>(i, j, k, -1.0F), -1.0F);
    for (std::size_t f = 0; f < out.size(); ++f) {
      out[f] = sample<A>(source[f], end);
      if (!sound(end) || out[f].thinned) out[f].low = out[f].high = out[f].value;
    }
  }

  /// Second pass at one point: the value carried back; not usable where that is not sound.
  template <int A>
  void second(int i, int j, int k, std::span<const Padded> first, std::span<float> back,
              std::span<bool> usable) const {
    std::fill(usable.begin(), usable.end(), false);
    if (held<A>(i, j, k)) return;
    const WallPoint end = paths.trace(flow, lattice_point<A>(i, j, k, 1.0F), 1.0F);
    for (std::size_t f = 0; f < back.size(); ++f) {
      const WallSample s = sample<A>(first[f], end);
      back[f] = s.value;
      usable[f] = sound(end) && !s.thinned;
    }
  }

 private:
  /// More than the rounding of positions up to thousands of cells.
  static constexpr float rounding = 1e-3F;

  /// Clearances of eight cells of a row from cell (i,j,k) on, the last row standing in for those behind it. Lanes
  /// past the ends of a row read its neighbours, which can only make a point careful without need.
  [[nodiscard]] const std::uint8_t* clearance(int i, int j, int k) const {
    return map.clearance() + i +
           (std::ptrdiff_t(std::clamp(j, 0, grid.ny - 1)) +
            std::ptrdiff_t(grid.ny) * std::clamp(k, 0, grid.nz - 1)) *
               grid.nx;
  }
  /// True for nearly all of the box: no wall within reach of any path from the eight points.
  template <int A>
  [[nodiscard]] bool nothing_near(int i, int j, int k) const {
    if (!short_paths) return false;
    const auto far = [&](const std::uint8_t* at) {
      std::uint64_t bytes;
      std::memcpy(&bytes, at, sizeof bytes);
      return bytes == 0x0101010101010101U * map.far();
    };
    if (!far(clearance(i, j, k))) return false;
    return A == 3 || far(clearance(i - (A == 0), j - (A == 1), k - (A == 2)));
  }

  /// A quick test that lets no near point go: those stretching further than the clearance of their cell, less
  /// one cell for the stencil and half a cell (a whole one for points on faces) to the edge.
  template <int A>
  [[nodiscard]] unsigned within_clearance(const Paths& path, int i, int j, int k) const {
    F8 stretch = splat(0.0F);
    for (int a = 0; a < 3; ++a) {
      stretch = max8(stretch, max8(abs8(path.middle[a] - path.start[a]), abs8(path.x[a] - path.start[a])));
    }
    // Of a face, the cells on both sides count.
    F8 clear = load_bytes(clearance(i, j, k));
    if constexpr (A < 3) clear = min8(clear, load_bytes(clearance(i - (A == 0), j - (A == 1), k - (A == 2))));
    const I8 within = stretch + (A < 3 ? 2.0F : 1.5F) + rounding < clear;
    const auto far = lanes_of(within);
    unsigned near = 0;
    for (int lane = 0; lane < lanes; ++lane) near |= (far[lane] ? 0U : 1U) << lane;
    return near;
  }

  /// The point (i,j,k) of lattice A; a face counts to the cell from which (or to which) the path goes.
  template <int A>
  [[nodiscard]] WallPoint lattice_point(int i, int j, int k, float sign) const {
    WallPoint p{{float(i) + 0.5F, float(j) + 0.5F, float(k) + 0.5F}, {i, j, k}, false};
    if constexpr (A < 3) {
      p.x[A] -= 0.5F;
      const bool lower = sign * flow[A].at(i, j, k) < 0.0F;
      const int n = grid.size(A);
      if (lower) --p.cell[A];
      if (sides[2 * A] != Side::periodic) p.cell[A] = std::clamp(p.cell[A], 0, n - 1);
    }
    return p;
  }
  template <int A>
  [[nodiscard]] WallSample sample(const Padded& field, const WallPoint& at) const {
    if constexpr (A < 3)
      return paths.sample_velocity(field, A, at);
    else
      return paths.sample_scalar(field, at);
  }
  /// Values that nothing flows through or out of: inside obstacles, and on closed faces.
  template <int A>
  [[nodiscard]] bool held(int i, int j, int k) const {
    if constexpr (A < 3)
      return map.closed_face(A, {i, j, k});
    else
      return !walls.solid.empty() && walls.solid[grid.cell(i, j, k)];
  }
  /// True where a path that nothing cut ended inside the box, by the same limits as stayed_inside.
  [[nodiscard]] bool sound(const WallPoint& end) const {
    bool inside = !end.clipped;
    for (int a = 0; a < 3; ++a)
      inside = inside && end.x[a] >= range[a].inside_low && end.x[a] <= range[a].inside_high;
    return inside;
  }
};

}  // namespace wick::fluid

#pragma GCC diagnostic pop
