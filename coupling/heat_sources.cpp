#include "coupling/heat_sources.h"

#include <algorithm>
#include <cmath>

#include "coupling/rasterize.h"

namespace wick::coupling {

namespace {

/// What a source heats at one time.
struct SourceRegion {
  SourceKind kind;
  Vec3 center, lower, upper;
  double radius;

  [[nodiscard]] bool contains(const Vec3& p) const {
    if (kind == SourceKind::ball) return (p - center).norm() <= radius;
    return (p.array() >= lower.array()).all() && (p.array() <= upper.array()).all();
  }
  [[nodiscard]] Vec3 half() const { return 0.5 * (upper - lower); }
};

SourceRegion region_at(const HeatSourceParams& source, double time) {
  const Vec3 moved = time * source.velocity;
  if (source.kind == SourceKind::box)
    return {source.kind, 0.5 * (source.lower + source.upper) + moved, source.lower + moved, source.upper + moved,
            0.0};
  const Vec3 center = source.center + moved, reach = Vec3::Constant(source.radius);
  return {source.kind, center, center - reach, center + reach, source.radius};
}

/// Where a source is for some seconds of a step.
struct Stay {
  SourceRegion region;
  double seconds;
};

struct Interval {
  double begin, end;
};

/// The part of `time` in which the source, as it moves, meets the box [low, high].
Interval meeting(const HeatSourceParams& source, Interval time, const Vec3& low, const Vec3& high) {
  const SourceRegion start = region_at(source, 0.0);
  for (int a = 0; a < 3; ++a) {
    const double speed = source.velocity[a];
    if (speed == 0.0) continue;
    const double first = (low[a] - start.upper[a]) / speed;
    const double second = (high[a] - start.lower[a]) / speed;
    time.begin = std::max(time.begin, std::min(first, second));
    time.end = std::min(time.end, std::max(first, second));
  }
  return time;
}

/// The stays of a source during [time, time + dt] that matter to the box [low, high]: the middles of equal parts of
/// its way through the box, each at most half of `resolved`, or of the source's own half length along the way, if
/// that is longer. None while it is off.
std::vector<Stay> stays_of(const HeatSourceParams& source, double time, double dt, const Vec3& low,
                           const Vec3& high, double resolved) {
  Interval on{std::max(time, source.start), std::min(time + dt, source.stop)};
  const double speed = source.velocity.norm();
  if (speed > 0.0) on = meeting(source, on, low, high);
  if (!(on.end > on.begin)) return {};
  const double seconds = std::min(on.end - on.begin, dt);
  int count = 1;
  if (speed > 0.0) {
    const Vec3 half = region_at(source, 0.0).half();
    const double half_length = (half.array() * speed / source.velocity.array().abs()).minCoeff();
    count = std::max(1, static_cast<int>(std::ceil(2.0 * speed * seconds / std::max(resolved, half_length))));
  }
  std::vector<Stay> stays;
  for (int n = 0; n < count; ++n)
    stays.push_back({region_at(source, on.begin + (n + 0.5) / count * seconds), seconds / count});
  return stays;
}

/// Calls body(i, j, k) for the cells of the grid whose centre lies in the region. Along an axis on which a box
/// holds no centre, those are the cells that its middle lies in; so is the cell of a ball that holds none.
template <class Body>
void for_cells_in(const SourceRegion& region, const fluid::Grid& grid, Body&& body) {
  const Vec3 low = (region.lower - grid.origin) / grid.h;
  const Vec3 high = (region.upper - grid.origin) / grid.h;
  Int3 first, last;
  bool thin = false;
  for (int a = 0; a < 3; ++a) {
    double from = std::ceil(low[a] - 0.5), to = std::floor(high[a] - 0.5);
    if (from > to) {
      from = to = std::floor(0.5 * (low[a] + high[a]));
      thin = true;
    }
    first[a] = static_cast<int>(std::clamp(from, 0.0, double(grid.size(a))));
    last[a] = static_cast<int>(std::clamp(to, -1.0, double(grid.size(a) - 1)));
  }
  const bool box = region.kind == SourceKind::box;
  bool any = false;
  if (box || !thin)
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          if (box || region.contains(grid.cell_center(i, j, k))) {
            any = true;
            body(i, j, k);
          }
  const Vec3 q = (region.center - grid.origin) / grid.h;
  const bool inside = (q.array() >= 0.0).all() && q.x() < grid.nx && q.y() < grid.ny && q.z() < grid.nz;
  if (!box && !any && inside) body(static_cast<int>(q.x()), static_cast<int>(q.y()), static_cast<int>(q.z()));
}

Vec3 top_of(const fluid::Grid& grid) {
  return grid.origin + grid.h * Vec3(grid.nx, grid.ny, grid.nz);
}

bool meets_box(const SourceRegion& region, const fluid::Grid& grid) {
  return (region.lower.array() <= top_of(grid).array()).all() &&
         (region.upper.array() >= grid.origin.array()).all();
}

/// Lists each cell once, so that many sources, or many stays of one, take no more memory than the grid.
void merge_cells(fluid::SmokeSources& sources, std::size_t cells) {
  if (sources.cell.size() <= cells) return;
  std::vector<double> smoke(cells, 0.0), heat(cells, 0.0), flame(cells, -1.0);
  for (std::size_t s = 0; s < sources.cell.size(); ++s) {
    const auto c = static_cast<std::size_t>(sources.cell[s]);
    smoke[c] += sources.smoke[s];
    heat[c] += sources.heat[s];
    flame[c] = std::max(flame[c], sources.flame[s]);
  }
  std::size_t kept = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    if (flame[c] < 0.0) continue;
    sources.cell[kept] = static_cast<std::int64_t>(c);
    sources.smoke[kept] = smoke[c];
    sources.heat[kept] = heat[c];
    sources.flame[kept] = flame[c];
    ++kept;
  }
  sources.cell.resize(kept);
  sources.smoke.resize(kept);
  sources.heat.resize(kept);
  sources.flame.resize(kept);
}

}  // namespace

fluid::SmokeSources gas_sources(const WorldParams& p, const fluid::Grid& grid, const fluid::Walls& walls,
                                double time, double dt) {
  fluid::SmokeSources sources;
  sources.gravity = p.gravity;
  for (const HeatSourceParams& source : p.heat_sources) {
    if (source.gas_power == 0.0 && source.gas_smoke == 0.0) continue;
    for (const Stay& stay : stays_of(source, time, dt, grid.origin, top_of(grid), grid.h)) {
      const std::size_t first = sources.cell.size();
      for_cells_in(stay.region, grid, [&](int i, int j, int k) {
        const std::size_t c = grid.cell(i, j, k);
        if (walls.any && walls.solid[c]) return;
        sources.cell.push_back(static_cast<std::int64_t>(c));
      });
      const auto cells = static_cast<double>(sources.cell.size() - first);
      sources.smoke.resize(sources.cell.size(), source.gas_smoke * stay.seconds / cells);
      sources.heat.resize(sources.cell.size(), source.gas_power * stay.seconds / cells);
      sources.flame.resize(sources.cell.size(), source.gas_power > 0.0 ? 1.0 : 0.0);
      merge_cells(sources, grid.cells());
    }
  }
  return sources;
}

std::vector<std::string> sources_without_gas(const WorldParams& p, const std::vector<Obstacle>& obstacles,
                                             const fluid::Grid& grid) {
  std::vector<std::string> found;
  const bool still = std::all_of(obstacles.begin(), obstacles.end(),
                                 [](const Obstacle& o) { return o.velocity.isZero() && o.spin.isZero(); });
  for (std::size_t n = 0; n < p.heat_sources.size(); ++n) {
    const HeatSourceParams& source = p.heat_sources[n];
    if (source.gas_power == 0.0 && source.gas_smoke == 0.0) continue;
    const std::string pointer =
        "/heat_sources/" + std::to_string(n) + (source.gas_power != 0.0 ? "/gas_power" : "/gas_smoke");
    const std::vector<Stay> stays =
        stays_of(source, source.start, source.stop - source.start, grid.origin, top_of(grid), grid.h);
    bool inside = false, gas = false;
    for (std::size_t s = 0; s < stays.size() && !gas; ++s) {
      inside = inside || meets_box(stays[s].region, grid);
      for_cells_in(stays[s].region, grid, [&](int i, int j, int k) {
        gas = gas || !still || std::all_of(obstacles.begin(), obstacles.end(), [&](const Obstacle& obstacle) {
                return sample_distance(obstacle, probe(grid, {i, j, k})).distance >= 0.0;
              });
      });
    }
    if (!inside)
      found.push_back(pointer + ": has no effect (the source is outside the box of the gas all the time)");
    else if (!gas)
      found.push_back(pointer + ": has no effect (no cell of gas lies in the source)");
  }
  return found;
}

namespace {

/// Seconds of [begin, end] for which a source that is on and moves holds the point p, which rests.
double seconds_inside(const HeatSourceParams& source, Interval on, const Vec3& p) {
  if (!(on.end > on.begin)) return 0.0;
  if (source.velocity.isZero()) return region_at(source, 0.0).contains(p) ? on.end - on.begin : 0.0;
  if (source.kind == SourceKind::ball) {
    // |p - c - t V|² = R²
    const Vec3 from = p - source.center;
    const double speed2 = source.velocity.squaredNorm(), middle = from.dot(source.velocity) / speed2;
    const double miss2 = (from - middle * source.velocity).squaredNorm(), radius2 = source.radius * source.radius;
    if (!(miss2 <= radius2)) return 0.0;
    const double half = std::sqrt((radius2 - miss2) / speed2);
    return std::max(0.0, std::min(on.end, middle + half) - std::max(on.begin, middle - half));
  }
  for (int a = 0; a < 3; ++a)
    if (source.velocity[a] == 0.0 && (p[a] < source.lower[a] || p[a] > source.upper[a])) return 0.0;
  on = meeting(source, on, p, p);
  return std::max(0.0, on.end - on.begin);
}

}  // namespace

SheetSupply sheet_supply(const WorldParams& p, const Sheet& sheet, double ambient, double kelvin, double time,
                         double dt) {
  SheetSupply supply;
  const std::vector<Vec3>& x = sheet.state.x;
  supply.loss.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) supply.loss[i] = p.heat.loss * sheet.heat_capacity[i];
  for (const HeatSourceParams& source : p.heat_sources) {
    const Interval on{std::max(time, source.start), std::min(time + dt, source.stop)};
    if (source.rate == 0.0 || !(on.end > on.begin)) continue;
    if (!supply.any) {
      supply.rate.assign(x.size(), 0.0);
      supply.value.assign(x.size(), 0.0);
      supply.any = true;
    }
    const double value = std::max(0.0, (source.temperature - ambient) / kelvin);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double share = std::min(1.0, seconds_inside(source, on, x[i]) / dt);
      if (share == 0.0) continue;
      // Where sources overlap, the sheet is drawn to the mean of their temperatures, weighted by rate.
      const double add = source.rate * share * sheet.heat_capacity[i], sum = supply.rate[i] + add;
      if (sum > 0.0) supply.value[i] = (supply.value[i] * supply.rate[i] + value * add) / sum;
      supply.rate[i] = sum;
    }
  }
  return supply;
}

}  // namespace wick::coupling
