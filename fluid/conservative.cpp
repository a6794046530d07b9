/// Transport in flux form on the present grid, for audits: what leaves one cell enters the next.
///
///   dq_c/dt = -sum_f sign_f u_f q_f / h,   q_f = q_up + s/2,   s = 2ab/(a+b) if ab > 0 else 0   [van Leer 1979]
///
/// with a, b the differences behind and ahead of the upwind cell. With no divergence each Euler stage is a mean
/// of neighbours with weights >= 0 as long as no more than half of a cell flows out, hence no new extrema and no
/// negative values; Heun's two stages are means of such stages [Shu 1988].
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fluid/advection.h"
#include "fluid/simd.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

namespace {

constexpr std::size_t row_grain = 16;
/// Part of a cell that may flow out in a stage: above it the weight of the cell itself could be negative.
constexpr double most_out = 0.5;
/// More parts than this mean a step hundreds of times beyond any sensible CFL number; the flow is then slowed
/// for this transport, which keeps every property but the speed.
constexpr int most_substeps = 256;

/// Half the limited slope of the upwind cell.
WICK_INLINE F8 half_slope(F8 a, F8 b) {
  return a * b > splat(0.0F) ? a * (b / (a + b)) : splat(0.0F);
}

/// Two ghosts a side, so that slopes exist in the first ghost.
constexpr Int3 two_ghosts = {2, 2, 2};

/// Fluxes of one row of faces. Behind a face of zero flow the slope is taken as zero: behind a wall there is
/// nothing to take it from.
void flux_row(const float* courant, const float* behind, const float* ahead, const float* q, std::ptrdiff_t s,
              float* flux, int count) {
  for (int i = 0; i < count; i += lanes) {
    const int part = std::min(lanes, count - i);
    F8 c = splat(0.0F), cb = splat(0.0F), ca = splat(0.0F);
    std::memcpy(&c, courant + i, sizeof(float) * part);
    std::memcpy(&cb, behind + i, sizeof(float) * part);
    std::memcpy(&ca, ahead + i, sizeof(float) * part);
    const F8 q0 = load8(q + i - 2 * s), q1 = load8(q + i - s), q2 = load8(q + i), q3 = load8(q + i + s);
    const F8 zero = splat(0.0F);
    const F8 low = cb != zero ? q1 - q0 : zero, high = ca != zero ? q2 - q3 : zero;
    const F8 from_low = q1 + half_slope(low, q2 - q1), from_high = q2 + half_slope(high, q1 - q2);
    store_some(flux + i, c > zero ? c * from_low : c * from_high, part);
  }
}

}  // namespace

TransportReport Transport::carry_conservative(std::span<CellField* const> fields) {
  // Courant numbers of the faces; nothing crosses a closed one, whatever its wall does.
  const Grid& g = grid_;
  for (int a = 0; a < 3; ++a) {
    const Int3 size = lattice_size(g, a);
    courant_[a].resize(g.faces(a)), flux_[a].resize(g.faces(a));
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      float* c = courant_[a].data() + row * size[0];
      const float* u = flow_[a].data.data() + flow_[a].index(0, j, k);
      const std::uint8_t* closed = walls_->any ? walls_->closed[a].data() + row * size[0] : nullptr;
      const int along = a == 1 ? j : k;
      const bool whole_row = a != 0 && ((along == 0 && sides_[2 * a] == Side::closed) ||
                                        (along == g.size(a) && sides_[2 * a + 1] == Side::closed));
      for (int i = 0; i < size[0]; ++i) c[i] = whole_row || (closed && closed[i]) ? 0.0F : u[i];
      if (a == 0 && sides_[0] == Side::closed) c[0] = 0.0F;
      if (a == 0 && sides_[1] == Side::closed) c[g.nx] = 0.0F;
    });
  }
  join_periodic_faces(g, sides_, courant_);

  // Cut the step until no cell gives away more than half of what it holds.
  const double outflow =
      parallel_max(std::size_t(g.ny) * g.nz, row_grain, 0.0, [&](std::size_t begin, std::size_t end) {
        double most = 0.0;
        for (std::size_t row = begin; row < end; ++row) {
          const int j = int(row % g.ny), k = int(row / g.ny);
          for (int i = 0; i < g.nx; ++i) {
            const float out = std::max(courant_[0][g.face(0, i + 1, j, k)], 0.0F) +
                              std::max(courant_[1][g.face(1, i, j + 1, k)], 0.0F) +
                              std::max(courant_[2][g.face(2, i, j, k + 1)], 0.0F) -
                              std::min(courant_[0][g.face(0, i, j, k)], 0.0F) -
                              std::min(courant_[1][g.face(1, i, j, k)], 0.0F) -
                              std::min(courant_[2][g.face(2, i, j, k)], 0.0F);
            most = std::max(most, double(out));
          }
        }
        return most;
      });
  TransportReport report;
  const double wanted = std::ceil(outflow / most_out);
  report.substeps = static_cast<int>(std::clamp(wanted, 1.0, double(most_substeps)));
  const double part = std::min(1.0 / report.substeps, outflow > 0.0 ? most_out / outflow : 1.0);
  for (auto& c : courant_) {
    parallel_for(c.size(), 65536, [&](std::size_t f) { c[f] *= static_cast<float>(part); });
  }

  source_.resize(std::max<std::size_t>(source_.size(), 1));
  for (CellField* field : fields) {
    double out = 0.0;
    source_[0].reshape(lattice_size(g, 3), two_ghosts);
    for (int substep = 0; substep < report.substeps; ++substep) out += heun_stage_pair(*field);
    report.out.push_back(out);
  }
  return report;
}

/// One Euler stage, q += (blend) of the flux balance of `q`; returns the outflow of the stage.
double Transport::flux_stage(const CellField& before, CellField& q, bool second) {
  const Grid& g = grid_;
  Padded& padded = source_[0];
  padded.assign(q, 1.0F);
  padded.fill_ghosts(scalar_ghosts(sides_));
  for (int a = 0; a < 3; ++a) {
    const Int3 size = lattice_size(g, a);
    const std::ptrdiff_t line = a == 0 ? 1 : a == 1 ? size[0] : std::ptrdiff_t(size[0]) * size[1];
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      const int n = g.size(a), along = a == 1 ? j : k;
      const float* c = courant_[a].data() + row * size[0];
      const float* values = padded.data.data() + padded.index(0, j, k);
      float* flux = flux_[a].data() + row * size[0];
      // Outside the box the flow goes on as it crosses the side; across periodic sides, as at the other end.
      const bool periodic = sides_[2 * a] == Side::periodic;
      if (a != 0) {
        const float* behind = along > 0 ? c - line : periodic ? c + (n - 1) * line : c;
        const float* ahead = along < n ? c + line : periodic ? c - (n - 1) * line : c;
        return flux_row(c, behind, ahead, values, padded.stride(a), flux, size[0]);
      }
      flux_row(c, periodic ? c + n - 1 : c, n > 0 ? c + 1 : c, values, 1, flux, 1);
      flux_row(c + 1, c, c + 2, values + 1, 1, flux + 1, n - 1);
      flux_row(c + n, c + n - 1, periodic ? c + 1 : c + n, values + n, 1, flux + n, 1);
    });
  }
  join_periodic_faces(g, sides_, flux_);
  parallel_for(std::size_t(g.ny) * g.nz, row_grain, [&](std::size_t row) {
    const int j = int(row % g.ny), k = int(row / g.ny);
    const float* fx = flux_[0].data() + g.face(0, 0, j, k);
    const float* fy = flux_[1].data() + g.face(1, 0, j, k);
    const float* fz = flux_[2].data() + g.face(2, 0, j, k);
    const std::size_t up_y = g.nx, up_z = std::size_t(g.nx) * g.ny;
    float* now = q.data() + row * g.nx;
    const float* old = before.data() + row * g.nx;
    for (int i = 0; i < g.nx; ++i) {
      const float change = (fx[i] - fx[i + 1]) + (fy[i] - fy[i + up_y]) + (fz[i] - fz[i + up_z]);
      now[i] = second ? 0.5F * (old[i] + (now[i] + change)) : now[i] + change;
    }
  });
  return side_flux_sum();
}

double Transport::heun_stage_pair(CellField& field) {
  before_ = field;
  const double first = flux_stage(before_, field, false);
  return 0.5 * (first + flux_stage(before_, field, true));
}

double Transport::side_flux_sum() const {
  double out = 0.0;
  for (int s = 0; s < 6; ++s) {
    if (sides_[s] != Side::open) continue;
    const int a = s / 2;
    Int3 low = {0, 0, 0}, high = lattice_size(grid_, a);
    low[a] = s % 2 ? grid_.size(a) : 0;
    high[a] = low[a] + 1;
    for (int k = low[2]; k < high[2]; ++k) {
      for (int j = low[1]; j < high[1]; ++j) {
        for (int i = low[0]; i < high[0]; ++i) {
          out += (s % 2 ? 1.0 : -1.0) * flux_[a][grid_.face(a, i, j, k)];
        }
      }
    }
  }
  return out;
}

}  // namespace wick::fluid
