#include "scenes/preview_gas.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/parallel.h"

namespace wick::scenes {

namespace {

using Index3 = Eigen::Vector3i;

const Vec3 kSmokeColor(0.75, 0.73, 0.70);

/// Which blocks of 8^3 cells, or their neighbours, hold anything to see: rays leap over the others.
class Occupancy {
 public:
  static constexpr int kBlock = 8;

  Occupancy(const fluid::Grid& g, const fluid::SmokeState& gas, double least_density)
      : blocks_((Index3(g.nx, g.ny, g.nz) + Index3::Constant(kBlock - 1)) / kBlock),
        seen_(std::size_t(blocks_[0]) * blocks_[1] * blocks_[2], 0) {
    for (int k = 0; k < g.nz; ++k)
      for (int j = 0; j < g.ny; ++j)
        for (int i = 0; i < g.nx; ++i) {
          const std::size_t c = g.cell(i, j, k);
          // A sample mixes neighbouring cells, so a cell shows up to one cell beyond its own block.
          if (gas.density[c] > least_density || gas.flame[c] > 1e-3F) mark(Index3(i, j, k));
        }
  }
  /// The block of a place in cells.
  [[nodiscard]] Index3 block(const Vec3& q) const {
    return (q.cwiseMax(0.0) / kBlock).cast<int>().cwiseMin(blocks_ - Index3::Ones());
  }
  [[nodiscard]] bool at(const Index3& block) const { return seen_[index(block)] != 0; }
  /// First block and one past the last that hold anything; empty where nothing does.
  [[nodiscard]] std::pair<Index3, Index3> bounds() const { return {low_, high_}; }

 private:
  [[nodiscard]] std::size_t index(const Index3& b) const {
    return b[0] + std::size_t(blocks_[0]) * (b[1] + std::size_t(blocks_[1]) * b[2]);
  }
  void mark(const Index3& cell) {
    const Index3 first = (cell - Index3::Ones()).cwiseMax(0) / kBlock;
    const Index3 last = ((cell + Index3::Ones()) / kBlock).cwiseMin(blocks_ - Index3::Ones());
    low_ = low_.cwiseMin(first), high_ = high_.cwiseMax(last + Index3::Ones());
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) seen_[index({x, y, z})] = 1;
  }
  Index3 blocks_;
  Index3 low_ = blocks_, high_ = Index3::Zero();
  std::vector<std::uint8_t> seen_;
};

/// Optical depth from every cell straight up to the top of the box: how much light the smoke above leaves.
fluid::CellField shadow_depth(const fluid::Grid& g, const fluid::CellField& density, double extinction) {
  fluid::CellField shadow(g.cells(), 0.0F);
  parallel_for(static_cast<std::size_t>(g.ny), 4, [&](std::size_t j) {
    for (int k = g.nz - 2; k >= 0; --k)
      for (int i = 0; i < g.nx; ++i) {
        const std::size_t c = g.cell(i, static_cast<int>(j), k), above = g.cell(i, static_cast<int>(j), k + 1);
        shadow[c] = shadow[above] + static_cast<float>(extinction * g.h) * density[above];
      }
  });
  return shadow;
}

/// Density, flame and light of a cell, side by side: one corner of a sample is one load.
using Seen = Eigen::Array4f;

/// What rays see of the gas around the blocks that hold any, one cell beyond them on the high sides.
class SeenGas {
 public:
  SeenGas(const fluid::Grid& g, const fluid::SmokeState& gas, double extinction, const Occupancy& occupancy) {
    const auto [first, last] = occupancy.bounds();
    const Index3 top = Index3(g.nx, g.ny, g.nz) - Index3::Ones();
    low_ = first * Occupancy::kBlock;
    size_ = (last - first).cwiseMax(0) * Occupancy::kBlock + Index3::Ones();
    if (((last - first).array() <= 0).any()) return;
    const fluid::CellField shadow = shadow_depth(g, gas.density, extinction);
    cells_.resize(std::size_t(size_[0]) * size_[1] * size_[2]);
    parallel_for(static_cast<std::size_t>(size_[2]), 1, [&](std::size_t k) {
      for (int j = 0; j < size_[1]; ++j)
        for (int i = 0; i < size_[0]; ++i) {
          const Index3 from = (low_ + Index3(i, j, static_cast<int>(k))).cwiseMin(top);
          const std::size_t c = g.cell(from[0], from[1], from[2]);
          const float light = 0.35F + 0.65F * std::exp(-0.5F * shadow[c]);
          cells_[index(Index3(i, j, static_cast<int>(k)))] = Seen(gas.density[c], gas.flame[c], light, 0.0F);
        }
    });
  }

  /// Trilinear; `q` is in cells, the centre of cell (0,0,0) is 0, and lies in an occupied block.
  [[nodiscard]] Seen sample(const Vec3& q) const {
    const Vec3 inside = (q - low_.cast<double>()).cwiseMax(0.0);
    const Index3 cell = inside.cast<int>().cwiseMin(size_ - Index3::Constant(2));
    const Eigen::Vector3f f = (inside - cell.cast<double>()).cast<float>().cwiseMin(1.0F);
    const Seen* corner = cells_.data() + index(cell);
    const std::size_t row = size_[0], plane = row * size_[1];
    const auto along_x = [&](const Seen* c) -> Seen { return c[0] + f.x() * (c[1] - c[0]); };
    const auto along_y = [&](const Seen* c) -> Seen {
      const Seen near = along_x(c), far = along_x(c + row);
      return near + f.y() * (far - near);
    };
    const Seen below = along_y(corner), above = along_y(corner + plane);
    return below + f.z() * (above - below);
  }

 private:
  [[nodiscard]] std::size_t index(const Index3& c) const {
    return c[0] + std::size_t(size_[0]) * (c[1] + std::size_t(size_[1]) * c[2]);
  }
  Index3 low_, size_;
  std::vector<Seen> cells_;
};

/// Distances at which a ray enters and leaves the box; empty when leave <= enter.
std::pair<double, double> clip_to_box(const fluid::Grid& g, const Vec3& eye, const Vec3& ray) {
  const Vec3 high = g.origin + g.h * Vec3(g.nx, g.ny, g.nz);
  double enter = 0.0, leave = INFINITY;
  for (int a = 0; a < 3; ++a) {
    const double one = (g.origin[a] - eye[a]) / ray[a], two = (high[a] - eye[a]) / ray[a];
    enter = std::max(enter, std::min(one, two));
    leave = std::min(leave, std::max(one, two));
  }
  return {enter, leave};
}

/// Yellow core to red rim.
Vec3 flame_color(double flame) {
  return Vec3(1.0, 0.22 + 0.42 * flame, 0.03 + 0.12 * flame * flame);
}

/// Light that one ray gathers in the gas, and how much of what lies behind shows through.
struct Gathered {
  Vec3 light = Vec3::Zero();
  double clear = 1.0;
};

class GasPainter {
 public:
  GasPainter(const PreviewParams& p, const fluid::SmokeState& gas, const fluid::SmokeParams& params)
      : grid_(fluid::smoke_grid(params)),
        extinction_(p.smoke_extinction),
        // Less than a thousandth of the light over ten cells is not worth a sample.
        occupancy_(grid_, gas, 1e-4 / (std::max(p.smoke_extinction, 1e-9) * grid_.h)),
        seen_(grid_, gas, p.smoke_extinction, occupancy_) {}

  [[nodiscard]] Gathered march(const Vec3& eye, const Vec3& ray, double behind) const {
    Gathered gathered;
    auto [t, leave] = clip_to_box(grid_, eye, ray);
    leave = std::min(leave, behind);
    const double length = 0.8 * grid_.h, step = length / ray.norm();
    const Vec3 start = (eye - grid_.origin) / grid_.h - Vec3::Constant(0.5), way = ray / grid_.h;
    t += 0.5 * step;
    while (t < leave && gathered.clear > 0.005) {
      const Vec3 q = start + t * way;
      const Index3 block = occupancy_.block(q);
      if (occupancy_.at(block)) {
        pass(q, length, gathered);
        t += step;
      } else {
        t += step * steps_out_of(block, q, way * step);
      }
    }
    return gathered;
  }

 private:
  /// The steps until a ray at q has left its block, at least one.
  static double steps_out_of(const Index3& block, const Vec3& q, const Vec3& stride) {
    double steps = INFINITY;
    for (int a = 0; a < 3; ++a) {
      if (stride[a] == 0.0) continue;
      const double wall = Occupancy::kBlock * (stride[a] > 0.0 ? block[a] + 1 : block[a]);
      steps = std::min(steps, (wall - q[a]) / stride[a]);
    }
    return std::max(1.0, std::ceil(steps));
  }

  void pass(const Vec3& q, double length, Gathered& gathered) const {
    constexpr double kFlameGlow = 14.0;  // radiance per metre of full flame
    const Seen seen = seen_.sample(q);
    const double density = seen[0], flame = seen[1], light = seen[2];
    if (density <= 0.0 && flame <= 1e-3) return;
    const double clear = std::exp(static_cast<float>(-extinction_ * std::max(density, 0.0) * length));
    gathered.light +=
        gathered.clear * ((1.0 - clear) * light * kSmokeColor + length * kFlameGlow * flame * flame_color(flame));
    gathered.clear *= clear;
  }

  fluid::Grid grid_;
  double extinction_;
  Occupancy occupancy_;
  SeenGas seen_;
};

}  // namespace

void draw_gas(const PreviewParams& preview, const Camera& camera, Canvas& canvas, const fluid::SmokeState& gas,
              const fluid::SmokeParams& params) {
  const GasPainter painter(preview, gas, params);
  parallel_for(static_cast<std::size_t>(camera.height), 4, [&](std::size_t row) {
    for (int px = 0; px < camera.width; ++px) {
      const std::size_t at = px + std::size_t(camera.width) * row;
      const Gathered gathered = painter.march(camera.eye, camera.ray(px, static_cast<int>(row)), canvas.depth[at]);
      canvas.color[at] = gathered.clear * canvas.color[at] + gathered.light;
    }
  });
}

}  // namespace wick::scenes
