/// Transport in flux form: what leaves one cell enters the next.
///
/// A step is an even number of parts, swept in the orders x y z and z y x in turn [Strang 1968], each sweep with
/// limited slopes [van Leer 1974]. Within a part the air that the sweeps have moved is followed too: they carry the
/// mixing ratio q/rho, where rho = 1 less the divergence so far. So a flow without divergence leaves what is
/// uniform uniform, and makes no new extrema and no negative values [Easter 1993].
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fluid/advection.h"

namespace wick::fluid {

namespace {

constexpr std::size_t row_grain = 16;
/// Part of its air that may leave a cell in a sweep. All of it would do but for rounding.
constexpr double most_out = 0.99;
/// More parts than this mean a step hundreds of times beyond any sensible CFL number; the flow is then slowed
/// for this transport, which keeps every property but the speed.
constexpr int most_parts = 256;

/// The number of parts of a step in which no sweep in either order takes more than `most_out` of the air that a
/// cell then has: out/parts <= most_out (1 - swept/parts), `swept` the divergence along the axes before.
double parts_needed(const Grid& g, const Courant& courant) {
  const float inverse = static_cast<float>(1.0 / most_out);
  const std::size_t nx = g.nx, up_y = nx, up_z = nx * g.ny;
  return parallel_max(std::size_t(g.ny) * g.nz, row_grain, 0.0, [&](std::size_t begin, std::size_t end) {
    float most = 0.0F;
    for (std::size_t row = begin; row < end; ++row) {
      const int j = int(row % g.ny), k = int(row / g.ny);
      const float* x = courant[0].data() + g.face(0, 0, j, k);
      const float* y = courant[1].data() + g.face(1, 0, j, k);
      const float* z = courant[2].data() + g.face(2, 0, j, k);
      const auto out = [&](float low, float high) {
        return inverse * (std::max(high, 0.0F) - std::min(low, 0.0F));
      };
      for (std::size_t i = 0; i < nx; ++i) {
        const float out_x = out(x[i], x[i + 1]), out_y = out(y[i], y[i + up_y]), out_z = out(z[i], z[i + up_z]);
        const float dx = x[i + 1] - x[i], dy = y[i + up_y] - y[i], dz = z[i + up_z] - z[i];
        const float forward = std::max(out_x, std::max(out_y + dx, out_z + dx + dy));
        const float backward = std::max(out_z, std::max(out_y + dz, out_x + dz + dy));
        most = std::max(most, std::max(forward, backward));
      }
    }
    return double(most);
  });
}

/// Planes or slabs that one task takes, and what went out of each field in them.
struct Outflow {
  std::size_t fields;
  std::vector<double> in_plane, in_slab;

  [[nodiscard]] double total(std::size_t f) const {
    double sum = 0.0;
    for (const auto* part : {&in_plane, &in_slab}) {
      for (std::size_t at = f; at < part->size(); at += fields) sum += (*part)[at];
    }
    return sum;
  }
};

/// Ends a part with y and x, begins the next with x and y, or both, plane by plane.
void sweep_planes(const Grid& g, const Sides& sides, const Courant& courant, std::span<CellField* const> fields,
                  bool end_part, bool begin_part, Outflow& outflow) {
  const std::size_t grain = std::max(1, int(2 * row_grain) / g.ny);
  parallel_chunks(g.nz, grain, [&](std::size_t first, std::size_t last) {
    Sweeper sweeper(g, sides, courant);
    for (std::size_t plane = first; plane < last; ++plane) {
      const int k = static_cast<int>(plane);
      for (std::size_t f = 0; f < fields.size(); ++f) {
        float* q = fields[f]->data();
        if (sweeper.empty_plane(q, k)) continue;
        double& out = outflow.in_plane[plane * fields.size() + f];
        if (end_part) {
          out += sweeper.along_y(q, k, swept_z);
          out += sweeper.along_x(q, k, swept_z | swept_y);
        }
        if (begin_part) {
          out += sweeper.along_x(q, k, swept_none);
          out += sweeper.along_y(q, k, swept_x);
        }
      }
    }
  });
}

/// Ends one part with z and begins the next, slab by slab.
void sweep_slabs(const Grid& g, const Sides& sides, const Courant& courant, std::span<CellField* const> fields,
                 Outflow& outflow) {
  const std::size_t grain = std::max(1, int(2 * row_grain) / g.nz);
  parallel_chunks(g.ny, grain, [&](std::size_t first, std::size_t last) {
    Sweeper sweeper(g, sides, courant);
    for (std::size_t slab = first; slab < last; ++slab) {
      const int j = static_cast<int>(slab);
      for (std::size_t f = 0; f < fields.size(); ++f) {
        float* q = fields[f]->data();
        if (sweeper.empty_slab(q, j)) continue;
        double& out = outflow.in_slab[slab * fields.size() + f];
        out += sweeper.along_z(q, j, swept_x | swept_y);
        out += sweeper.along_z(q, j, swept_none);
      }
    }
  });
}

}  // namespace

/// Courant numbers of the faces; nothing crosses a closed one, whatever its wall does.
void Transport::take_courant_numbers() {
  const Grid& g = grid_;
  for (int a = 0; a < 3; ++a) {
    const Int3 size = lattice_size(g, a);
    courant_[a].resize(g.faces(a) + sweep_slack);
    parallel_for(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      float* __restrict c = courant_[a].data() + row * size[0];
      const float* u = flow_[a].data.data() + flow_[a].index(0, j, k);
      const std::uint8_t* closed = walls_->any ? walls_->closed[a].data() + row * size[0] : nullptr;
      const int along = a == 1 ? j : k;
      const bool whole_row = a != 0 && ((along == 0 && sides_[2 * a] == Side::closed) ||
                                        (along == g.size(a) && sides_[2 * a + 1] == Side::closed));
      if (whole_row)
        std::fill_n(c, size[0], 0.0F);
      else if (closed)
        for (int i = 0; i < size[0]; ++i) c[i] = closed[i] ? 0.0F : u[i];
      else
        std::copy_n(u, size[0], c);
      if (a == 0 && sides_[0] == Side::closed) c[0] = 0.0F;
      if (a == 0 && sides_[1] == Side::closed) c[g.nx] = 0.0F;
    });
  }
  join_periodic_faces(g, sides_, courant_);
}

TransportReport Transport::carry_conservative(std::span<CellField* const> fields) {
  const Grid& g = grid_;
  take_courant_numbers();
  const double needed = parts_needed(g, courant_);
  const int pairs = static_cast<int>(std::clamp(std::ceil(0.5 * needed), 1.0, 0.5 * most_parts));
  const auto part = static_cast<float>(std::min(0.5 / pairs, needed > 0.0 ? 1.0 / needed : 1.0));
  for (auto& c : courant_) parallel_for(c.size(), 65536, [&](std::size_t f) { c[f] *= part; });

  Outflow outflow{fields.size(), {}, {}};
  outflow.in_plane.assign(fields.size() * g.nz, 0.0);
  outflow.in_slab.assign(fields.size() * g.ny, 0.0);
  for (int pair = 0; pair <= pairs; ++pair) {
    sweep_planes(g, sides_, courant_, fields, pair > 0, pair < pairs, outflow);
    if (pair < pairs) sweep_slabs(g, sides_, courant_, fields, outflow);
  }
  TransportReport report;
  report.substeps = 2 * pairs;
  for (std::size_t f = 0; f < fields.size(); ++f) report.out.push_back(outflow.total(f));
  return report;
}

}  // namespace wick::fluid
