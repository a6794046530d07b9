#include "diffusion/perlin.h"

#include <cmath>

#include "core/noise.h"

namespace wick::diffusion {

namespace {

/// Directions from the middle of a cube to its twelve edges [Perlin 2002], the first four a second time: 16 need no
/// modulo.
constexpr int gradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                  {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                  {1, 1, 0},  {-1, 1, 0},  {0, -1, 1}, {0, -1, -1}};

/// 6 t⁵ - 15 t⁴ + 10 t³: first and second derivative vanish at both ends.
double fade(double t) {
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

std::uint64_t lattice_key(std::int64_t i, std::int64_t j, std::int64_t k) {
  return (static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ULL) ^
         (static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fULL) ^
         (static_cast<std::uint64_t>(k) * 0x165667b19e3779f9ULL);
}

}  // namespace

double perlin(const Vec3& p, std::uint64_t seed) {
  const Vec3 cell(std::floor(p.x()), std::floor(p.y()), std::floor(p.z()));
  const Vec3 f = p - cell;
  const Vec3 w(fade(f.x()), fade(f.y()), fade(f.z()));
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const std::uint64_t key =
        lattice_key(static_cast<std::int64_t>(cell.x()) + i, static_cast<std::int64_t>(cell.y()) + j,
                    static_cast<std::int64_t>(cell.z()) + k);
    const int* g = gradients[hash_index(seed, key) & 15];
    const double slope = g[0] * (f.x() - i) + g[1] * (f.y() - j) + g[2] * (f.z() - k);
    sum += slope * (i != 0 ? w.x() : 1.0 - w.x()) * (j != 0 ? w.y() : 1.0 - w.y()) * (k != 0 ? w.z() : 1.0 - w.z());
  }
  return sum;
}

}  // namespace wick::diffusion
