#include "fluid/advection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/require.h"
#include "fluid/advection_walls.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

namespace {

constexpr std::size_t row_grain = 16;

/// Padding of the lattice of component `axis`: a layer of ghosts across it, none along it.
Int3 lattice_pad(int axis) {
  return {axis != 0, axis != 1, axis != 2};
}

}  // namespace

GhostRules velocity_ghosts(const Sides& sides, int axis, const SideMotion& motion, double factor) {
  GhostRules rules;
  for (int s = 0; s < 6; ++s) {
    if (sides[s] == Side::periodic) rules[s].kind = Ghost::wrap;
    if (sides[s] == Side::closed && motion.no_slip && s / 2 != axis) {
      rules[s] = {Ghost::mirror, static_cast<float>(factor * motion.velocity[s][axis])};
    }
  }
  return rules;
}

GhostRules carried_velocity_ghosts(const Sides& sides, int axis, const SideMotion& motion) {
  GhostRules rules = velocity_ghosts(sides, axis, motion, 1.0);
  for (int s = 0; s < 6; ++s) {
    if (sides[s] == Side::open && s / 2 != axis) rules[s].kind = Ghost::zero;
  }
  return rules;
}

void join_periodic_faces(const Grid& grid, const Sides& sides, FaceField& velocity) {
  for (int a = 0; a < 3; ++a) {
    if (sides[2 * a] != Side::periodic) continue;
    Int3 size = lattice_size(grid, a);
    size[a] = 1;
    const Int3 last = {a == 0 ? grid.nx : 0, a == 1 ? grid.ny : 0, a == 2 ? grid.nz : 0};
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          velocity[a][grid.face(a, i + last[0], j + last[1], k + last[2])] = velocity[a][grid.face(a, i, j, k)];
        }
      }
    }
  }
}

/// One pass over a lattice: everything that the row loops share.
struct Transport::Kernel {
  const Transport& t;
  FlowView flow;
  WallTransport at_walls;

  Kernel(const Transport& transport, int lattice)
      : t(transport), at_walls{t.grid_, t.sides_, *t.walls_, t.map_, t.flow_, flow.range, t.short_paths_} {
    for (int a = 0; a < 3; ++a) {
      flow.data[a] = t.flow_[a].data.data();
      flow.sy[a] = t.flow_[a].stride(1);
      flow.sz[a] = t.flow_[a].stride(2);
      flow.range[a] = axis_range(a, lattice);
    }
  }

  /// Ambient air comes into scalars, and into velocity along an open side, half a cell before the side; the
  /// velocity through the side lies on it.
  [[nodiscard]] AxisRange axis_range(int axis, int lattice) const {
    AxisRange r;
    r.n = static_cast<float>(t.grid_.size(axis));
    r.periodic = t.sides_[2 * axis] == Side::periodic;
    const bool open_low = t.sides_[2 * axis] == Side::open, open_high = t.sides_[2 * axis + 1] == Side::open;
    r.low = r.periodic || open_low ? -0.5F : 0.0F;
    r.high = r.n + (r.periodic || open_high ? 0.5F : 0.0F);
    const float ambient = lattice != axis ? 0.5F : 0.0F;
    r.inside_low = open_low ? ambient : 0.0F;
    r.inside_high = r.n - (open_high ? ambient : 0.0F);
    if (r.periodic) {
      r.inside_low = -std::numeric_limits<float>::infinity();
      r.inside_high = std::numeric_limits<float>::infinity();
    }
    return r;
  }

  template <int A>
  void first_pass(std::span<const Padded> source, std::span<Padded> first, std::span<Padded> low,
                  std::span<Padded> high, std::span<float* const> result) const;
  template <int A>
  void second_pass(std::span<const Padded> source, std::span<const Padded> first, std::span<const Padded> low,
                   std::span<const Padded> high, std::span<float* const> result) const;
};

/// q^ = A q. With `first` empty the values go straight to `result`; otherwise they, and the range of what they
/// were made of, are kept for the second pass.
template <int A>
void Transport::Kernel::first_pass(std::span<const Padded> source, std::span<Padded> first, std::span<Padded> low,
                                   std::span<Padded> high, std::span<float* const> result) const {
  const Int3 size = lattice_size(t.grid_, A);
  const std::size_t fields = source.size();
  parallel_chunks(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t begin, std::size_t end) {
    std::vector<WallSample> sampled(fields);
    for (std::size_t row = begin; row < end; ++row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      for (int i = 0; i < size[0]; i += lanes) {
        const int count = size[0] - i;
        const Paths paths = trace_paths<A>(flow, i, j, k, -1.0F);
        const Brackets at = bracket_lattice<A>(flow, paths.x);
        const I8 inside = stayed_inside(flow, paths.x);
        for (std::size_t f = 0; f < fields; ++f) {
          const Corners corners(source[f].data.data(), source[f].stride(1), source[f].stride(2), at);
          const F8 q = corners.interpolate(at);
          if (first.empty()) {
            store_some(result[f] + row * size[0] + i, q, count);
            continue;
          }
          const std::size_t here = source[f].index(i, j, k);
          store_some(first[f].data.data() + here, q, count);
          store_some(low[f].data.data() + here, inside ? corners.lowest() : q, count);
          store_some(high[f].data.data() + here, inside ? corners.highest() : q, count);
        }
        for (unsigned near = at_walls.near<A>(paths, i, j, k, count); near; near &= near - 1) {
          const int lane = __builtin_ctz(near);
          at_walls.first<A>(i + lane, j, k, source, sampled);
          for (std::size_t f = 0; f < fields; ++f) {
            if (first.empty()) {
              result[f][row * size[0] + i + lane] = sampled[f].value;
              continue;
            }
            const std::size_t here = source[f].index(i + lane, j, k);
            first[f].data[here] = sampled[f].value;
            low[f].data[here] = sampled[f].low;
            high[f].data[here] = sampled[f].high;
          }
        }
      }
    }
  });
}

/// q' = q^ + (q - A⁻¹ q^)/2, held within the range of the first pass.
template <int A>
void Transport::Kernel::second_pass(std::span<const Padded> source, std::span<const Padded> first,
                                    std::span<const Padded> low, std::span<const Padded> high,
                                    std::span<float* const> result) const {
  const Int3 size = lattice_size(t.grid_, A);
  const std::size_t fields = source.size();
  parallel_chunks(std::size_t(size[1]) * size[2], row_grain, [&](std::size_t begin, std::size_t end) {
    std::vector<float> back(fields);
    const auto usable = std::make_unique<bool[]>(fields);
    for (std::size_t row = begin; row < end; ++row) {
      const int j = int(row % size[1]), k = int(row / size[1]);
      for (int i = 0; i < size[0]; i += lanes) {
        const int count = size[0] - i;
        const Paths paths = trace_paths<A>(flow, i, j, k, 1.0F);
        const Brackets at = bracket_lattice<A>(flow, paths.x);
        const I8 inside = stayed_inside(flow, paths.x);
        for (std::size_t f = 0; f < fields; ++f) {
          const std::size_t here = source[f].index(i, j, k);
          const F8 hat = load8(first[f].data.data() + here), q = load8(source[f].data.data() + here);
          const F8 again =
              Corners(first[f].data.data(), first[f].stride(1), first[f].stride(2), at).interpolate(at);
          const F8 better = inside ? hat + 0.5F * (q - again) : hat;
          store_some(result[f] + row * size[0] + i,
                     min8(max8(better, load8(low[f].data.data() + here)), load8(high[f].data.data() + here)),
                     count);
        }
        for (unsigned near = at_walls.near<A>(paths, i, j, k, count); near; near &= near - 1) {
          const int lane = __builtin_ctz(near);
          at_walls.second<A>(i + lane, j, k, first, back, std::span<bool>(usable.get(), fields));
          for (std::size_t f = 0; f < fields; ++f) {
            const std::size_t here = source[f].index(i + lane, j, k);
            const float hat = first[f].data[here];
            const float better = usable[f] ? hat + 0.5F * (source[f].data[here] - back[f]) : hat;
            result[f][row * size[0] + i + lane] = std::min(std::max(better, low[f].data[here]), high[f].data[here]);
          }
        }
      }
    }
  });
}

Transport::Transport(const Grid& grid, const Sides& sides, const SideMotion& motion)
    : grid_(grid), sides_(sides), motion_(motion), map_(grid, sides) {
  for (int a = 0; a < 3; ++a) flow_[a].reshape(lattice_size(grid, a), lattice_pad(a));
}

void Transport::set_flow(const FaceField& velocity, const Walls& walls, double dt) {
  walls_ = &walls;
  scale_ = dt / grid_.h;
  for (int a = 0; a < 3; ++a) {
    flow_[a].assign(velocity[a], static_cast<float>(scale_));
    flow_[a].fill_ghosts(velocity_ghosts(sides_, a, motion_, scale_));
  }
  if (!walls.any) return;

  // Look for walls as far as the fastest path goes; paths longer than the cap are looked at one by one.
  double fastest = 0.0;
  for (int a = 0; a < 3; ++a) {
    const auto& u = velocity[a];
    fastest = std::max(fastest, parallel_max(u.size(), 65536, 0.0, [&](std::size_t begin, std::size_t end) {
                         float most = 0.0F;
                         for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(u[i]));
                         return double(most);
                       }));
  }
  constexpr double farthest = 12.0;
  map_.set(walls, static_cast<int>(std::ceil(std::min(fastest * scale_, farthest) + 2.0)));
  short_paths_ = fastest * scale_ <= farthest;
}

void Transport::reshape_work(std::size_t fields, int lattice) {
  for (auto* work : {&source_, &first_, &low_, &high_}) {
    work->resize(std::max(work->size(), fields));
    for (std::size_t f = 0; f < fields; ++f) (*work)[f].reshape(lattice_size(grid_, lattice), lattice_pad(lattice));
  }
}

TransportReport Transport::carry(std::span<CellField* const> fields, Advection method) {
  if (method == Advection::conservative) return carry_conservative(fields);
  const std::size_t count = fields.size();
  const bool two_passes = method == Advection::maccormack;
  TransportReport report;
  std::vector<float*> result;
  reshape_work(count, 3);
  for (std::size_t f = 0; f < count; ++f) {
    report.out.push_back(upwind_outflow(*fields[f]));
    source_[f].assign(*fields[f], 1.0F);
    source_[f].fill_ghosts(scalar_ghosts(sides_));
    result.push_back(fields[f]->data());
  }
  const Kernel kernel(*this, 3);
  const std::span<Padded> source(source_.data(), count), first(first_.data(), two_passes ? count : 0);
  kernel.first_pass<3>(source, first, low_, high_, result);
  if (!two_passes) return report;
  for (Padded& hat : first) hat.fill_ghosts(scalar_ghosts(sides_));
  kernel.second_pass<3>(source, first, low_, high_, result);
  return report;
}

namespace {

template <class Body>
void for_each_axis(const Body& body) {
  body(std::integral_constant<int, 0>{});
  body(std::integral_constant<int, 1>{});
  body(std::integral_constant<int, 2>{});
}

}  // namespace

void Transport::carry(FaceField& velocity, Advection method) {
  require(method != Advection::conservative, "/smoke/velocity_advection",
          "conservative transport is for smoke, heat and flame only (velocity is carried as a property of the air) "
          "choose maccormack or semi_lagrangian");
  const bool two_passes = method == Advection::maccormack;
  for_each_axis([&](auto axis) {
    constexpr int a = axis;
    reshape_work(1, a);
    source_[0].assign(velocity[a], 1.0F);
    const GhostRules ghosts = carried_velocity_ghosts(sides_, a, motion_);
    source_[0].fill_ghosts(ghosts);
    float* const result[] = {velocity[a].data()};
    const Kernel kernel(*this, a);
    const std::span<Padded> source(source_.data(), 1), first(first_.data(), two_passes ? 1 : 0);
    kernel.first_pass<a>(source, first, low_, high_, result);
    if (!two_passes) return;
    first[0].fill_ghosts(ghosts);
    kernel.second_pass<a>(source, first, low_, high_, result);
  });
  spend_head_of_inflow(velocity);
  join_periodic_faces(grid_, sides_, velocity);
}

/// Air outside rests at p = 0, so that by Bernoulli it comes in at p = -ρ s²/2 when it comes at speed s. Between
/// the side and the centre of the cell, h/2 apart, this slows it by ds/dt = -s²/h, which is also what a path does
/// that begins in still air one cell outside; a longer one begins in still air too. Without it every bit of
/// inflow brings energy s²/2 from nowhere, and inflow and the eddies that it feeds grow without bound.
void Transport::spend_head_of_inflow(FaceField& velocity) const {
  for (int s = 0; s < 6; ++s) {
    if (sides_[s] != Side::open) continue;
    const int a = s / 2;
    const float inward = s % 2 ? -1.0F : 1.0F;
    Int3 low = {0, 0, 0}, high = lattice_size(grid_, a);
    low[a] = s % 2 ? grid_.size(a) : 0;
    high[a] = low[a] + 1;
    for (int k = low[2]; k < high[2]; ++k) {
      for (int j = low[1]; j < high[1]; ++j) {
        for (int i = low[0]; i < high[0]; ++i) {
          const std::size_t f = grid_.face(a, i, j, k);
          if (walls_->any && walls_->closed[a][f]) continue;
          velocity[a][f] *= 1.0F - std::clamp(inward * flow_[a].at(i, j, k), 0.0F, 1.0F);
        }
      }
    }
  }
}

double Transport::upwind_outflow(const CellField& field) const {
  double out = 0.0;
  for (int s = 0; s < 6; ++s) {
    if (sides_[s] != Side::open) continue;
    const int a = s / 2, b = (a + 1) % 3, c = (a + 2) % 3, n = grid_.size(a);
    const float outward = s % 2 ? 1.0F : -1.0F;
    for (int p = 0; p < grid_.size(c); ++p) {
      for (int q = 0; q < grid_.size(b); ++q) {
        Int3 cell{}, face{};
        cell[b] = face[b] = q, cell[c] = face[c] = p;
        cell[a] = s % 2 ? n - 1 : 0, face[a] = s % 2 ? n : 0;
        const float u = outward * flow_[a].at(face[0], face[1], face[2]);
        if (u > 0.0F) out += double(u) * field[grid_.cell(cell[0], cell[1], cell[2])];
      }
    }
  }
  return out;
}

}  // namespace wick::fluid
