/// What happens to the content of cells that a sheet or an obstacle has passed, and of those that walls squeeze.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/float_sum.h"
#include "core/parallel.h"
#include "coupling/exchange.h"

namespace wick::coupling {

namespace {

/// Layers of cells across which a taker is looked for before farther ones count, and through which excess heat is
/// passed on.
constexpr int kReach = 6;
/// The taker beyond an open side of the box.
constexpr std::int64_t kOutside = -1;

/// Unswept cells along the six grid directions: where the old content belongs, and those on the side where the cell
/// is now.
struct Neighbours {
  std::vector<std::int64_t> across, same;
};

Int3 place_of(const fluid::Grid& grid, std::int64_t cell) {
  const std::int64_t row = cell / grid.nx;
  return {static_cast<int>(cell % grid.nx), static_cast<int>(row % grid.ny), static_cast<int>(row / grid.ny)};
}

/// Cells whose centre was in the obstacle at some time of its `move` to where it is now, but not all the time.
void add_swept_by(const Obstacle& obstacle, const Pose& move, const fluid::Grid& grid,
                  std::vector<std::uint8_t>& passes, std::uint8_t mark) {
  parallel_for(static_cast<std::size_t>(grid.nz), 1, [&](std::size_t k) {
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const Vec3 now = probe(grid, {i, j, static_cast<int>(k)});
        const Vec3 before = move.place(now);
        const double distance = sample_distance(obstacle, now).distance;
        if (std::abs(distance) > 2.0 * (before - now).norm()) continue;
        const bool stayed = distance < 0.0 && sample_distance(obstacle, before).distance < 0.0;
        if (!stayed && segment_meets(obstacle, before, now)) passes[grid.cell(i, j, static_cast<int>(k))] |= mark;
      }
  });
}

/// All cells that walls have passed, and what lies beside them.
class SweptCells {
 public:
  SweptCells(const Raster& raster, const fluid::Sides& sides, const Sweep& sweep)
      : raster_(raster), sides_(sides), sweep_(sweep) {
    const bool moved =
        std::any_of(sweep.moves.begin(), sweep.moves.end(), [](const Pose& move) { return move != Pose{}; });
    const bool passed =
        std::any_of(sweep.by_sheet.begin(), sweep.by_sheet.end(), [](const auto& c) { return !c.empty(); });
    if (!moved && !passed) return;
    passes_.assign(raster.grid().cells(), 0);
    for (std::size_t n = 0; n < sweep.moves.size(); ++n)
      if (sweep.moves[n] != Pose{})
        add_swept_by((*sweep.obstacles)[n], sweep.moves[n], raster.grid(), passes_, kByObstacle);
    for (const std::vector<std::int64_t>& cells : sweep.by_sheet)
      for (const std::int64_t c : cells)
        if ((passes_[c] & kSheets) < kSheets) ++passes_[c];
    for (std::size_t c = 0; c < passes_.size(); ++c)
      if (passes_[c] != 0) cells_.push_back(static_cast<std::int64_t>(c));
  }

  /// Ascending.
  [[nodiscard]] const std::vector<std::int64_t>& cells() const { return cells_; }

  /// Of all cells, in their order.
  [[nodiscard]] std::vector<Neighbours> neighbours() const {
    std::vector<Neighbours> all(cells_.size());
    parallel_for(all.size(), 256, [&](std::size_t s) { all[s] = neighbours_of(cells_[s]); });
    find_ways_out(all);
    return all;
  }

 private:
  static constexpr std::uint8_t kByObstacle = 0x80, kSheets = 0x7f;
  struct Found {
    std::int64_t cell;
    int distance;
  };

  const Raster& raster_;
  const fluid::Sides& sides_;
  const Sweep& sweep_;
  std::vector<std::uint8_t> passes_;  ///< per cell: sheets that passed it, and whether an obstacle did
  std::vector<std::int64_t> cells_;

  /// Farther cells count only where there are none within reach.
  static std::vector<std::int64_t> nearest(const std::vector<Found>& all) {
    int least = std::numeric_limits<int>::max();
    for (const Found& found : all) least = std::min(least, found.distance);
    std::vector<std::int64_t> cells;
    for (const Found& found : all)
      if (found.distance <= std::max(kReach, least)) cells.push_back(found.cell);
    return cells;
  }

  /// Whether what was at `from` before the move can be at `to` now: seen from each obstacle it does not lie
  /// between.
  [[nodiscard]] bool leaves_way(const Vec3& from, const Vec3& to) const {
    for (std::size_t n = 0; sweep_.obstacles != nullptr && n < sweep_.obstacles->size(); ++n)
      if (segment_meets((*sweep_.obstacles)[n], n < sweep_.moves.size() ? sweep_.moves[n].place(from) : from, to))
        return false;
    return true;
  }

  [[nodiscard]] Neighbours neighbours_of(std::int64_t cell) const {
    std::vector<Found> across, same;
    for (int side = 0; side < 6; ++side) look_along(cell, side / 2, side % 2 == 0 ? -1 : 1, across, same);
    return {nearest(across), nearest(same)};
  }

  /// Whether what two neighbouring swept cells held was on the same side of all sheets and obstacles.
  [[nodiscard]] bool were_joined(const Int3& a, const Int3& b, int axis, const Int3& face) const {
    const fluid::Grid& grid = raster_.grid();
    const auto sheets = [&](const Int3& at) { return passes_[grid.cell(at[0], at[1], at[2])] & kSheets; };
    if (sheets(a) != sheets(b) || raster_.crossings(axis, grid.face(axis, face[0], face[1], face[2])) > 0)
      return false;
    for (std::size_t n = 0; n < sweep_.moves.size(); ++n)
      if (segment_meets((*sweep_.obstacles)[n], sweep_.moves[n].place(probe(grid, a)),
                        sweep_.moves[n].place(probe(grid, b))))
        return false;
    return true;
  }

  /// What has no taker of its own is squeezed out along the swept cells beside it, to the takers of the nearest
  /// that has some.
  void find_ways_out(std::vector<Neighbours>& all) const {
    const fluid::Grid& grid = raster_.grid();
    std::vector<std::size_t> ring;
    for (std::size_t s = 0; s < all.size(); ++s)
      if (!all[s].across.empty()) ring.push_back(s);
    if (ring.size() == all.size()) return;
    while (!ring.empty()) {
      std::vector<std::size_t> next;
      for (const std::size_t s : ring)
        for (int side = 0; side < 6; ++side) {
          const int axis = side / 2;
          const Int3 at = place_of(grid, cells_[s]);
          Int3 face = at, other = at;
          face[axis] += side % 2;
          other[axis] += side % 2 == 0 ? -1 : 1;
          if (other[axis] < 0 || other[axis] >= grid.size(axis)) continue;
          const auto cell = static_cast<std::int64_t>(grid.cell(other[0], other[1], other[2]));
          if (passes_[cell] == 0 || !were_joined(at, other, axis, face)) continue;
          const auto index =
              static_cast<std::size_t>(std::lower_bound(cells_.begin(), cells_.end(), cell) - cells_.begin());
          if (!all[index].across.empty()) continue;
          all[index].across = all[s].across;
          next.push_back(index);
        }
      ring = std::move(next);
    }
  }

  /// Looks from `cell` along one direction for the first cell that was not swept, or for the open side of the box.
  /// What the cell held belongs there if as many sheets lie between as have passed it (one, or an odd number; an
  /// even one where they meet a fold is no way), and no obstacle does.
  void look_along(std::int64_t cell, int axis, int step, std::vector<Found>& across,
                  std::vector<Found>& same) const {
    const fluid::Grid& grid = raster_.grid();
    const fluid::Side side = sides_[2 * axis + (step > 0 ? 1 : 0)];
    Int3 at = place_of(grid, cell), unwrapped = at;
    const Vec3 place = probe(grid, at);
    const int passed = passes_[cell] & kSheets;
    int crossings = 0;
    bool open = raster_.walls().solid[cell] == 0;
    const auto takes = [&](const Vec3& where) {
      const bool sheets_between = passed == 0 ? crossings == 0 : crossings > 0 && crossings % 2 == passed % 2;
      return sheets_between && leaves_way(place, where);
    };
    for (int distance = 1; distance <= grid.size(axis); ++distance) {
      Int3 face = at;
      if (step > 0) ++face[axis];
      const std::size_t between = grid.face(axis, face[0], face[1], face[2]);
      crossings += raster_.crossings(axis, between);
      open = open && raster_.walls().closed[axis][between] == 0;
      at[axis] += step;
      unwrapped[axis] += step;
      if (at[axis] < 0 || at[axis] >= grid.size(axis)) {
        if (side == fluid::Side::open && takes(probe(grid, unwrapped))) across.push_back({kOutside, distance});
        if (side != fluid::Side::periodic) return;
        at[axis] = step > 0 ? 0 : grid.size(axis) - 1;
      }
      const auto other = static_cast<std::int64_t>(grid.cell(at[0], at[1], at[2]));
      if (passes_[other] != 0) continue;
      if (raster_.walls().solid[other]) return;
      if (takes(probe(grid, unwrapped))) across.push_back({other, distance});
      if (open) same.push_back({other, distance});
      return;
    }
  }
};

/// One swept cell that a giver fills, and its weight in the giver's split.
struct Share {
  std::int64_t giver;
  std::size_t receiver;  ///< index among the swept cells
  double weight;
};

/// Who fills whom: a giver splits its content among itself (weight 1) and its receivers (1/(their givers)).
std::vector<Share> plan_shares(const std::vector<Neighbours>& neighbours) {
  std::vector<Share> shares;
  for (std::size_t s = 0; s < neighbours.size(); ++s)
    for (const std::int64_t giver : neighbours[s].same)
      shares.push_back({giver, s, 1.0 / static_cast<double>(neighbours[s].same.size())});
  std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
    return a.giver != b.giver ? a.giver < b.giver : a.receiver < b.receiver;
  });
  return shares;
}

/// The cells behind the open faces of those of `ring` that are not among `seen`; adds them to `seen`.
std::vector<std::int64_t> next_ring(const Raster& raster, const std::vector<std::int64_t>& ring,
                                    std::set<std::int64_t>& seen) {
  const fluid::Grid& grid = raster.grid();
  std::vector<std::int64_t> next;
  for (const std::int64_t cell : ring) {
    const Int3 at = place_of(grid, cell);
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      Int3 face = at, other = at;
      face[axis] += side % 2;
      other[axis] += side % 2 == 0 ? -1 : 1;
      if (other[axis] < 0 || other[axis] >= grid.size(axis)) continue;
      if (raster.walls().closed[axis][grid.face(axis, face[0], face[1], face[2])] != 0) continue;
      const auto neighbour = static_cast<std::int64_t>(grid.cell(other[0], other[1], other[2]));
      if (seen.insert(neighbour).second) next.push_back(neighbour);
    }
  }
  return next;
}

/// What had no taker, what left the box, and what was rounded away.
struct Loss {
  double without_taker = 0.0, outside = 0.0, rounded = 0.0;
};

/// Empties the swept cells across the sheet and fills them from their own side.
Loss hand_over(fluid::CellField& field, const std::vector<std::int64_t>& swept,
               const std::vector<Neighbours>& neighbours, const std::vector<Share>& shares) {
  std::vector<double> fresh(swept.size(), 0.0);
  // What is rounded away is booked: handed on it would end up on the other side of the sheet.
  Loss lost;
  const auto set = [&lost](float& value, double wanted) {
    value = static_cast<float>(wanted);
    lost.rounded += wanted - double(value);
  };
  for (std::size_t begin = 0, end = 0; begin < shares.size(); begin = end) {
    float& content = field[shares[begin].giver];
    double weights = 1.0;
    for (; end < shares.size() && shares[end].giver == shares[begin].giver; ++end) weights += shares[end].weight;
    for (std::size_t n = begin; n < end; ++n) fresh[shares[n].receiver] += content * shares[n].weight / weights;
    set(content, content / weights);
  }
  for (std::size_t s = 0; s < swept.size(); ++s) {
    const double old = field[swept[s]];
    const auto& across = neighbours[s].across;
    for (const std::int64_t cell : across) {
      const double share = old / static_cast<double>(across.size());
      if (cell == kOutside)
        lost.outside += share;
      else
        set(field[cell], field[cell] + share);
    }
    if (across.empty()) lost.without_taker += old;
    set(field[swept[s]], fresh[s]);
  }
  return lost;
}

}  // namespace

double spread_excess_heat(const Raster& raster, double hottest, const fluid::SmokeParams& params,
                          fluid::CellField& temperature) {
  // The largest float that is certainly below.
  const float most = std::nextafter(static_cast<float>(hottest), 0.0F);
  double lost = 0.0;
  for (std::size_t c = 0; c < temperature.size(); ++c) {
    if (!(temperature[c] > most) || raster.walls().near[c] == 0) continue;
    double excess = double(temperature[c]) - double(most);
    FloatSum sum;
    temperature[c] = most;
    std::vector<std::int64_t> ring = {static_cast<std::int64_t>(c)};
    std::set<std::int64_t> seen(ring.begin(), ring.end());
    for (int reach = 0; reach < kReach && excess > 0.0; ++reach) {
      ring = next_ring(raster, ring, seen);
      // Share alike, and what the first have no room for among the others.
      for (std::size_t n = 0; n < ring.size(); ++n) {
        const double room = std::max(0.0, double(most) - double(temperature[ring[n]]));
        const double given = std::min(room, excess / static_cast<double>(ring.size() - n));
        sum.add(temperature[ring[n]], given);
        excess -= given;
      }
    }
    lost += excess + sum.left();
  }
  return params.air_density * params.air_heat_capacity * std::pow(raster.grid().h, 3) * lost;
}

SweptLoss hand_over_swept(const Raster& raster, const Sweep& sweep, const fluid::SmokeParams& params,
                          fluid::SmokeState& gas) {
  const SweptCells all(raster, params.sides, sweep);
  const std::vector<std::int64_t>& swept = all.cells();
  if (swept.empty()) return {};
  const std::vector<Neighbours> neighbours = all.neighbours();
  const std::vector<Share> shares = plan_shares(neighbours);
  const double volume = std::pow(raster.grid().h, 3);
  const double capacity = params.air_density * params.air_heat_capacity * volume;
  const Loss smoke = hand_over(gas.density, swept, neighbours, shares);
  const Loss heat = hand_over(gas.temperature, swept, neighbours, shares);
  hand_over(gas.flame, swept, neighbours, shares);
  // Flame is an indicator, not a stuff: handed over it may not add up to more than 1.
  for (const Neighbours& found : neighbours)
    for (const std::int64_t cell : found.across)
      if (cell != kOutside) gas.flame[cell] = std::min(gas.flame[cell], 1.0F);
  return {.smoke = volume * smoke.without_taker,
          .heat = capacity * heat.without_taker,
          .smoke_out = volume * smoke.outside,
          .heat_out = capacity * heat.outside,
          .rounded_smoke = volume * smoke.rounded,
          .rounded_heat = capacity * heat.rounded};
}

}  // namespace wick::coupling
