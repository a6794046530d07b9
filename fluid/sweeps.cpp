#include "fluid/sweeps.h"

#include <algorithm>
#include <cstdint>

#include "fluid/simd.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

namespace {

/// What would cross a face and is less than this stays where it is: nothing that anyone measures, but it would
/// fill the box with numbers too small to be stored to full precision, which are slow and lose their sign.
constexpr float least_flux = 1e-30F;

WICK_INLINE F8 load_some(const float* p, int count) {
  if (count >= lanes) return load8(p);
  F8 v = splat(0.0F);
  std::memcpy(&v, p, sizeof(float) * static_cast<std::size_t>(count));
  return v;
}

/// Half the limited slope of a cell. Across a face of zero flow the slope is taken as zero: behind a wall there
/// is nothing to take it from.
WICK_INLINE F8 half_slope(F8 behind, F8 here, F8 ahead, F8 c_low, F8 c_high) {
  const F8 zero = splat(0.0F);
  const F8 a = c_low != zero ? here - behind : zero, b = c_high != zero ? ahead - here : zero;
  return a * b > zero ? a * (b / (a + b)) : zero;
}

/// What the air c takes across a face from the cell that it leaves, `low` or `high`.
struct Side8 {
  F8 ratio, slope, air;
};
WICK_INLINE F8 face_flux(F8 c, const Side8& low, const Side8& high) {
  const I8 up = c > splat(0.0F);
  const F8 ratio = up ? low.ratio : high.ratio, slope = up ? low.slope : -high.slope, air = up ? low.air : high.air;
  const F8 flux = c * (ratio + (1.0F - abs8(c) * air) * slope);
  return abs8(flux) < splat(least_flux) ? splat(0.0F) : flux;
}

/// Multiplies a row by another; false if it holds nothing but zeros.
bool multiply_row(const float* q, const float* air, float* ratio, int n) {
  F8 any = splat(0.0F);
  for (int i = 0; i < n; i += lanes) {
    const F8 v = load_some(q + i, n - i);
    any = max8(any, abs8(v));
    store8(ratio + i, v * load8(air + i));
  }
  float most = 0.0F;
  for (const float lane : lanes_of(any)) most = std::max(most, lane);
  return most > 0.0F;
}

bool empty_row(const float* q, int n) {
  std::uint32_t bits = 0;
  for (int i = 0; i < n; ++i) {
    std::uint32_t b;
    std::memcpy(&b, q + i, sizeof b);
    bits |= b << 1;  // zero of either sign
  }
  return bits == 0;
}

void add_difference(float* __restrict q, const float* in, const float* out, int n) {
  for (int i = 0; i < n; ++i) q[i] += in[i] - out[i];
}

}  // namespace

/// Rows of cells one behind the other along y or z.
struct Sweeper::Line {
  int axis, n;
  float* q;
  std::ptrdiff_t stride;
  const float* courant;  ///< of the lower face of the first row
  std::ptrdiff_t face_stride;
  int across;  ///< index along the other of y and z
  unsigned swept;
  bool periodic, open_low, open_high;

  [[nodiscard]] int j(int p) const { return axis == 1 ? p : across; }
  [[nodiscard]] int k(int p) const { return axis == 1 ? across : p; }
  [[nodiscard]] int wrapped(int p) const { return ((p % n) + n) % n; }
};

Sweeper::Sweeper(const Grid& grid, const Sides& sides, const Courant& courant)
    : grid_(grid), sides_(sides), courant_(courant) {
  const std::size_t width = (std::size_t(grid.nx) + 1 + lanes - 1) / lanes * lanes, size = width + 2 * slack;
  for (auto* rows : {&ratio_, &air_})
    for (auto& row : *rows) row.assign(size, 0.0F);
  for (auto* rows : {&slope_, &flux_})
    for (auto& row : *rows) row.assign(size, 0.0F);
  first_ratio_.assign(size, 0.0F), first_flux_.assign(size, 0.0F);
}

/// One over the air density of a row: 1 less what the sweeps so far have carried away.
void Sweeper::inverse_density(int j, int k, unsigned swept, float* out) const {
  if (swept == swept_none) return std::fill_n(out, grid_.nx, 1.0F), void();
  const float* x = courant_[0].data() + grid_.face(0, 0, j, k);
  const float* y = courant_[1].data() + grid_.face(1, 0, j, k);
  const float* z = courant_[2].data() + grid_.face(2, 0, j, k);
  const std::ptrdiff_t up_y = grid_.nx, up_z = std::ptrdiff_t(grid_.nx) * grid_.ny;
  for (int i = 0; i < grid_.nx; i += lanes) {
    F8 rho = splat(1.0F);
    if (swept & swept_x) rho -= load8(x + i + 1) - load8(x + i);
    if (swept & swept_y) rho -= load8(y + i + up_y) - load8(y + i);
    if (swept & swept_z) rho -= load8(z + i + up_z) - load8(z + i);
    store8(out + i, 1.0F / rho);
  }
}

/// Brings row p of the line into the place `ahead`.
void Sweeper::enter(const Line& line, int p) {
  const bool outside = p < 0 || p >= line.n;
  if (outside && !line.periodic) {
    std::fill(ratio_[2].begin(), ratio_[2].end(), 0.0F);
    std::fill(air_[2].begin(), air_[2].end(), 1.0F);
    live_[2] = false;
    return;
  }
  const int w = line.wrapped(p);
  inverse_density(line.j(w), line.k(w), line.swept, air_[2].data() + slack);
  // The first rows have been swept when the last ones ask for them.
  if (p == line.n) {
    ratio_[2] = first_ratio_;
    live_[2] = first_live_;
    return;
  }
  live_[2] = multiply_row(line.q + w * line.stride, air_[2].data() + slack, ratio_[2].data() + slack, grid_.nx);
}

/// Slope of row p, the present one, and the fluxes of its lower face.
void Sweeper::pass(const Line& line, int p, const float* low) {
  const int n = grid_.nx;
  live_flux_[1] = live_[0] || live_[1];
  if (!live_flux_[1]) {
    std::fill(slope_[1].begin(), slope_[1].end(), 0.0F);
    std::fill(flux_[1].begin(), flux_[1].end(), 0.0F);
    return;
  }
  const float* high = line.courant + (p < line.n ? p + 1 : p) * line.face_stride;
  const float *q0 = ratio_[0].data() + slack, *q1 = ratio_[1].data() + slack, *q2 = ratio_[2].data() + slack;
  const float *r0 = air_[0].data() + slack, *r1 = air_[1].data() + slack, *s0 = slope_[0].data() + slack;
  float* __restrict s1 = slope_[1].data() + slack;
  float* __restrict f1 = flux_[1].data() + slack;
  for (int i = 0; i < n; i += lanes) {
    const F8 c = load8(low + i), behind = load8(q0 + i), here = load8(q1 + i);
    const F8 slope = half_slope(behind, here, load8(q2 + i), c, load8(high + i));
    store8(s1 + i, slope);
    store8(f1 + i, face_flux(c, {behind, load8(s0 + i), load8(r0 + i)}, {here, slope, load8(r1 + i)}));
  }
}

double Sweeper::out_of_row(const std::vector<float>& flux, double sign) const {
  double sum = 0.0;
  for (int i = 0; i < grid_.nx; ++i) sum += flux[slack + i];
  return sign * sum;
}

double Sweeper::along(const Line& line) {
  const int n = line.n;
  const auto advance = [&] {
    for (auto* rows : {&ratio_, &air_}) std::swap((*rows)[0], (*rows)[1]), std::swap((*rows)[1], (*rows)[2]);
    live_[0] = live_[1], live_[1] = live_[2];
    std::swap(slope_[0], slope_[1]);
    std::swap(flux_[0], flux_[1]);
    live_flux_[0] = live_flux_[1];
  };
  // The row before the first: that at the other end, or ambient air.
  const auto face = [&](int p) { return line.courant + p * line.face_stride; };
  enter(line, line.periodic ? -2 : -1), advance();
  enter(line, -1), advance();
  enter(line, 0);
  if (line.periodic) {
    first_ratio_ = ratio_[2], first_live_ = live_[2];
    // Its slope has the faces n - 1 and n beside it; the flux is not used.
    Line before = line;
    before.courant = face(n - 1);
    pass(before, 0, face(n - 1));
  } else {
    std::fill(slope_[1].begin(), slope_[1].end(), 0.0F);
  }
  advance();

  double out = 0.0;
  for (int p = 0; p <= n; ++p) {
    if (p < n) {
      enter(line, p + 1);
      pass(line, p, face(p));
    } else if (line.periodic) {
      flux_[1] = first_flux_;
    } else {
      std::fill(ratio_[2].begin(), ratio_[2].end(), 0.0F);
      pass(line, p, face(p));
    }
    if (p == 0) {
      if (line.periodic) first_flux_ = flux_[1];
      if (line.open_low) out += out_of_row(flux_[1], -1.0);
    } else if (live_flux_[0] || live_flux_[1] || line.periodic) {
      add_difference(line.q + (p - 1) * line.stride, flux_[0].data() + slack, flux_[1].data() + slack, grid_.nx);
    }
    if (p == n && line.open_high) out += out_of_row(flux_[1], 1.0);
    advance();
  }
  return out;
}

double Sweeper::along_y(float* q, int k, unsigned swept) {
  const std::ptrdiff_t nx = grid_.nx;
  return along({1, grid_.ny, q + grid_.cell(0, 0, k), nx, courant_[1].data() + grid_.face(1, 0, 0, k), nx, k, swept,
                sides_[2] == Side::periodic, sides_[2] == Side::open, sides_[3] == Side::open});
}

double Sweeper::along_z(float* q, int j, unsigned swept) {
  const std::ptrdiff_t plane = std::ptrdiff_t(grid_.nx) * grid_.ny;
  return along({2, grid_.nz, q + grid_.cell(0, j, 0), plane, courant_[2].data() + grid_.face(2, 0, j, 0), plane, j,
                swept, sides_[4] == Side::periodic, sides_[4] == Side::open, sides_[5] == Side::open});
}

/// One row along x, the inverse of its air density in air_[1].
double Sweeper::sweep_row(float* q, const float* c) {
  const int n = grid_.nx;
  float *ratio = ratio_[1].data() + slack, *air = air_[1].data() + slack, *slope = slope_[1].data() + slack;
  float* flux = flux_[1].data() + slack;
  multiply_row(q, air, ratio, n);
  const bool periodic = sides_[0] == Side::periodic;
  ratio[-1] = periodic ? ratio[n - 1] : 0.0F, ratio[n] = periodic ? ratio[0] : 0.0F;
  air[-1] = periodic ? air[n - 1] : 1.0F, air[n] = periodic ? air[0] : 1.0F;
  for (int i = 0; i < n; i += lanes) {
    store8(slope + i, half_slope(load8(ratio + i - 1), load8(ratio + i), load8(ratio + i + 1), load8(c + i),
                                 load8(c + i + 1)));
  }
  slope[-1] = periodic ? slope[n - 1] : 0.0F, slope[n] = periodic ? slope[0] : 0.0F;
  for (int i = 0; i <= n; i += lanes) {
    store8(flux + i, face_flux(load8(c + i), {load8(ratio + i - 1), load8(slope + i - 1), load8(air + i - 1)},
                               {load8(ratio + i), load8(slope + i), load8(air + i)}));
  }
  add_difference(q, flux, flux + 1, n);
  return (sides_[1] == Side::open ? double(flux[n]) : 0.0) - (sides_[0] == Side::open ? double(flux[0]) : 0.0);
}

double Sweeper::along_x(float* q, int k, unsigned swept) {
  double out = 0.0;
  for (int j = 0; j < grid_.ny; ++j) {
    float* row = q + grid_.cell(0, j, k);
    if (empty_row(row, grid_.nx)) continue;
    inverse_density(j, k, swept, air_[1].data() + slack);
    out += sweep_row(row, courant_[0].data() + grid_.face(0, 0, j, k));
  }
  return out;
}

bool Sweeper::empty_plane(const float* q, int k) const {
  for (int j = 0; j < grid_.ny; ++j) {
    if (!empty_row(q + grid_.cell(0, j, k), grid_.nx)) return false;
  }
  return true;
}

bool Sweeper::empty_slab(const float* q, int j) const {
  for (int k = 0; k < grid_.nz; ++k) {
    if (!empty_row(q + grid_.cell(0, j, k), grid_.nx)) return false;
  }
  return true;
}

}  // namespace wick::fluid
