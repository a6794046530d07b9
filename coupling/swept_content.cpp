/// What happens to the content of cells that a sheet or an obstacle has passed, and of those that walls squeeze.
#include <algorithm>
#include <cmath>
#include <set>

#include "core/float_sum.h"
#include "core/parallel.h"
#include "coupling/exchange.h"

namespace wick::coupling {

namespace {

/// Layers of swept cells that are looked across, and of cells through which excess heat is passed on; what a sheet
/// sweeps beyond it in one step has no taker and is booked.
constexpr int kReach = 6;

/// Unswept cells along the six grid directions: across the sheet or before the obstacle, where the old content
/// belongs, and on the side where the cell is now.
struct Neighbours {
  std::vector<std::int64_t> across, same;
};

Int3 place_of(const fluid::Grid& grid, std::int64_t cell) {
  const std::int64_t row = cell / grid.nx;
  return {static_cast<int>(cell % grid.nx), static_cast<int>(row % grid.ny), static_cast<int>(row / grid.ny)};
}

/// Looks from cell `at` along one direction for the first cell that was not swept. An odd number of crossings on
/// the way there means that it lies across the sheet; an even one that a fold lies between: no neighbour of either
/// kind.
void look_along(const Raster& raster, const std::vector<std::int64_t>& swept, Int3 at, int axis, int step,
                Neighbours& found) {
  const fluid::Grid& grid = raster.grid();
  int crossings = 0;
  for (int reach = 0; reach < kReach; ++reach) {
    Int3 face = at;
    if (step > 0) ++face[axis];
    crossings += raster.crossings(axis, grid.face(axis, face[0], face[1], face[2]));
    at[axis] += step;
    if (at[axis] < 0 || at[axis] >= grid.size(axis)) return;
    const auto cell = static_cast<std::int64_t>(grid.cell(at[0], at[1], at[2]));
    if (raster.walls().solid[cell]) return;
    if (std::binary_search(swept.begin(), swept.end(), cell)) continue;
    if (crossings % 2 == 1)
      found.across.push_back(cell);
    else if (crossings == 0)
      found.same.push_back(cell);
    return;
  }
}

Neighbours neighbours_of(const Raster& raster, const std::vector<std::int64_t>& swept, std::int64_t cell) {
  const Int3 at = place_of(raster.grid(), cell);
  Neighbours found;
  for (int axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1}) look_along(raster, swept, at, axis, step, found);
  return found;
}

/// An obstacle among all that has just moved.
struct Mover {
  const std::vector<Obstacle>& obstacles;
  std::size_t number;
  Vec3 shift;

  [[nodiscard]] const Obstacle& obstacle() const { return obstacles[number]; }
  /// Whether what was at `from` before the move can be at `to` now: seen from the mover it does not lie between the
  /// two, and no other obstacle does.
  [[nodiscard]] bool leaves_way(const Vec3& from, const Vec3& to) const {
    for (std::size_t n = 0; n < obstacles.size(); ++n)
      if (segment_meets(obstacles[n], n == number ? Vec3(from + shift) : from, to)) return false;
    return true;
  }
};

/// Looks from cell `at`, which an obstacle has just entered, left or passed, for the first cell that it did not:
/// where the cell's old content belongs, or what fills it now.
void look_beside(const Raster& raster, const Mover& mover, const std::vector<std::int64_t>& swept, Int3 at,
                 int axis, int step, Neighbours& found) {
  const fluid::Grid& grid = raster.grid();
  const Vec3 place = probe(grid, at);
  bool open = !raster.walls().solid[grid.cell(at[0], at[1], at[2])];
  for (int reach = 0; reach < kReach; ++reach) {
    Int3 face = at;
    if (step > 0) ++face[axis];
    const std::size_t between = grid.face(axis, face[0], face[1], face[2]);
    if (raster.crossings(axis, between) > 0) return;
    open = open && raster.walls().closed[axis][between] == 0;
    at[axis] += step;
    if (at[axis] < 0 || at[axis] >= grid.size(axis)) return;
    const auto cell = static_cast<std::int64_t>(grid.cell(at[0], at[1], at[2]));
    if (std::binary_search(swept.begin(), swept.end(), cell)) continue;
    if (raster.walls().solid[cell]) return;
    if (mover.leaves_way(place, probe(grid, at))) found.across.push_back(cell);
    if (open) found.same.push_back(cell);
    return;
  }
}

/// Cells whose centre was in the obstacle at some time of its move, but not all the time.
std::vector<std::int64_t> cells_swept_by(const Mover& mover, const fluid::Grid& grid) {
  const Obstacle& obstacle = mover.obstacle();
  const double reach = 2.0 * mover.shift.norm();
  std::vector<std::vector<std::int64_t>> found(static_cast<std::size_t>(grid.nz));
  parallel_for(found.size(), 1, [&](std::size_t k) {
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const Vec3 now = probe(grid, {i, j, static_cast<int>(k)});
        const double distance = sample_distance(obstacle, now).distance;
        if (std::abs(distance) > reach) continue;
        const Vec3 before = now + mover.shift;
        const bool stayed = distance < 0.0 && sample_distance(obstacle, before).distance < 0.0;
        if (!stayed && segment_meets(obstacle, before, now))
          found[k].push_back(static_cast<std::int64_t>(grid.cell(i, j, static_cast<int>(k))));
      }
  });
  std::vector<std::int64_t> swept;
  for (const auto& part : found) swept.insert(swept.end(), part.begin(), part.end());
  return swept;
}

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

/// What had no taker, and what was rounded away.
struct Loss {
  double without_taker = 0.0, rounded = 0.0;
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
    for (const std::int64_t cell : across) set(field[cell], field[cell] + old / static_cast<double>(across.size()));
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

namespace {

SweptLoss hand_over_all(const Raster& raster, const std::vector<std::int64_t>& swept,
                        const std::vector<Neighbours>& neighbours, const fluid::SmokeParams& params,
                        fluid::SmokeState& gas) {
  const std::vector<Share> shares = plan_shares(neighbours);
  const double volume = std::pow(raster.grid().h, 3);
  const double capacity = params.air_density * params.air_heat_capacity * volume;
  const Loss smoke = hand_over(gas.density, swept, neighbours, shares);
  const Loss heat = hand_over(gas.temperature, swept, neighbours, shares);
  hand_over(gas.flame, swept, neighbours, shares);
  // Flame is an indicator, not a stuff: handed over it may not add up to more than 1.
  for (const Neighbours& found : neighbours)
    for (const std::int64_t cell : found.across) gas.flame[cell] = std::min(gas.flame[cell], 1.0F);
  return {volume * smoke.without_taker, capacity * heat.without_taker, volume * smoke.rounded,
          capacity * heat.rounded};
}

}  // namespace

SweptLoss hand_over_swept(const Raster& raster, const std::vector<std::int64_t>& swept,
                          const fluid::SmokeParams& params, fluid::SmokeState& gas) {
  if (swept.empty()) return {};
  std::vector<Neighbours> neighbours;
  for (const std::int64_t cell : swept) neighbours.push_back(neighbours_of(raster, swept, cell));
  return hand_over_all(raster, swept, neighbours, params, gas);
}

SweptLoss hand_over_displaced(const Raster& raster, const std::vector<Obstacle>& obstacles, std::size_t number,
                              const Vec3& shift, const fluid::SmokeParams& params, fluid::SmokeState& gas) {
  const Mover mover{obstacles, number, shift};
  const std::vector<std::int64_t> swept = cells_swept_by(mover, raster.grid());
  if (swept.empty()) return {};
  std::vector<Neighbours> neighbours(swept.size());
  for (std::size_t s = 0; s < swept.size(); ++s)
    for (int side = 0; side < 6; ++side)
      look_beside(raster, mover, swept, place_of(raster.grid(), swept[s]), side / 2, side % 2 == 0 ? -1 : 1,
                  neighbours[s]);
  return hand_over_all(raster, swept, neighbours, params, gas);
}

}  // namespace wick::coupling
