#include "coupling/exchange.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace wick::coupling {

namespace {

constexpr std::size_t kGrain = 1024;

double cell_volume(const Raster& raster) { return std::pow(raster.grid().h, 3); }

/// First degree of freedom of each sheet.
std::vector<std::int32_t> dof_offsets(const std::vector<SheetSurface>& sheets) {
  std::vector<std::int32_t> offset(sheets.size() + 1, 0);
  for (std::size_t s = 0; s < sheets.size(); ++s)
    offset[s + 1] = offset[s] + static_cast<std::int32_t>(sheets[s].mesh->vertex_count());
  return offset;
}

}  // namespace

double exchange_heat(const std::vector<VertexStencil>& stencils, const std::vector<double>& areas,
                     const std::vector<double>& theta, const std::vector<double>& capacity, const HeatScale& scale,
                     double convection, double dt, const fluid::SmokeParams& params, fluid::SmokeState& gas,
                     std::vector<double>& sheet_heat, std::vector<double>& hotter_side) {
  const double h = params.width / params.resolution[0];
  const double gas_capacity = params.air_density * params.air_heat_capacity * h * h * h;   // J/K of a cell

  // Share each cell's heat among the vertex faces that see it, so that together they cannot take more than it has.
  std::vector<float> seen(gas.temperature.size(), 0.0F);
  for (const VertexStencil& stencil : stencils)
    for (const auto& face : stencil.face)
      for (int n = 0; n < face.count; ++n) seen[face.cell[n]] += face.weight[n];

  double total = 0.0;
  std::vector<std::pair<std::int64_t, double>> given;   // heat taken from cells, applied after all have been read
  for (std::size_t i = 0; i < stencils.size(); ++i) {
    double gas_kelvin[2] = {0.0, 0.0};
    if (capacity[i] <= 0.0) continue;
    const double sheet_kelvin = theta[i] * scale.kelvin;
    for (int side = 0; side < 2; ++side) {
      const auto& face = stencils[i].face[side];
      for (int n = 0; n < face.count; ++n) {
        const double kelvin = gas.temperature[face.cell[n]];
        gas_kelvin[side] += face.weight[n] * kelvin;
        // Two bodies that relax towards each other: exp(-G dt (1/C1 + 1/C2)) of their difference is left.
        const double share = face.weight[n] / seen[face.cell[n]];
        const double cs = capacity[i] / scale.kelvin * face.weight[n] * 0.5, cg = gas_capacity * share;
        const double conductance = convection * areas[i] * face.weight[n];
        const double both = 1.0 / cs + 1.0 / cg;
        const double heat = (kelvin - sheet_kelvin) * -std::expm1(-conductance * dt * both) / both;
        sheet_heat[i] += heat;
        total += heat;
        given.emplace_back(face.cell[n], heat);
      }
    }
    // One kelvin of difference already tells a side; the scale only keeps noise from deciding.
    const double difference = gas_kelvin[1] - gas_kelvin[0];
    hotter_side[i] = difference / (std::abs(difference) + 1.0);
  }
  for (const auto& [cell, heat] : given) gas.temperature[cell] -= static_cast<float>(heat / gas_capacity);
  return total;
}

Deposited deposit(const std::vector<VertexStencil>& stencils, const std::vector<double>& smoke,
                  const std::vector<double>& heat, const std::vector<double>& flame, const fluid::SmokeParams& params,
                  fluid::SmokeState& gas) {
  const double h = params.width / params.resolution[0];
  const double volume = h * h * h;
  const double gas_capacity = params.air_density * params.air_heat_capacity * volume;
  Deposited sum;
  for (std::size_t i = 0; i < stencils.size(); ++i) {
    if (smoke[i] == 0.0 && heat[i] == 0.0 && flame[i] == 0.0) continue;
    const int faces = (stencils[i].face[0].count > 0 ? 1 : 0) + (stencils[i].face[1].count > 0 ? 1 : 0);
    if (faces == 0) {
      sum.escaped_smoke += smoke[i];
      sum.escaped_heat += heat[i];
      continue;
    }
    sum.smoke += smoke[i];
    sum.heat += heat[i];
    for (const auto& face : stencils[i].face)
      for (int n = 0; n < face.count; ++n) {
        const double share = face.weight[n] / faces;
        const std::int64_t c = face.cell[n];
        gas.density[c] += static_cast<float>(share * smoke[i] / volume);
        gas.temperature[c] += static_cast<float>(share * heat[i] / gas_capacity);
        gas.flame[c] = std::max(gas.flame[c], static_cast<float>(flame[i]));
      }
  }
  return sum;
}

SweptLoss hand_over_swept(const Raster& raster, const std::vector<std::int64_t>& swept, const fluid::SmokeParams& params,
                          fluid::SmokeState& gas) {
  const fluid::Grid& grid = raster.grid();
  const fluid::Walls& walls = raster.walls();
  const auto is_swept = [&](std::int64_t c) { return std::binary_search(swept.begin(), swept.end(), c); };

  // For each swept cell, look along the six grid directions for the first cell that was not swept: an odd number of
  // closed faces on the way there means that it lies across the sheet, where the old content belongs.
  struct Links {
    std::vector<std::int64_t> across, same;
  };
  std::vector<Links> links(swept.size());
  std::vector<std::int64_t> giver;                   // cells on the new side, with how much they share out
  constexpr int kReach = 6;                          // layers; a sheet that crosses more in one step leaves the rest
  for (std::size_t s = 0; s < swept.size(); ++s) {
    const std::int64_t c = swept[s];
    const Int3 at = {static_cast<int>(c % grid.nx), static_cast<int>(c / grid.nx % grid.ny),
                     static_cast<int>(c / (std::int64_t(grid.nx) * grid.ny))};
    for (int axis = 0; axis < 3; ++axis)
      for (int step : {-1, 1}) {
        Int3 q = at;
        int closed = 0;
        for (int reach = 0; reach < kReach; ++reach) {
          Int3 face = q;
          if (step > 0) ++face[axis];
          closed += walls.closed[axis][grid.face(axis, face[0], face[1], face[2])];
          q[axis] += step;
          if (q[axis] < 0 || q[axis] >= grid.size(axis)) break;
          const auto d = static_cast<std::int64_t>(grid.cell(q[0], q[1], q[2]));
          if (walls.solid[d]) break;
          if (is_swept(d)) continue;
          (closed % 2 == 1 ? links[s].across : links[s].same).push_back(d);
          break;
        }
      }
  }

  // A giver with receivers c splits its content among itself and them: weight 1 for itself, 1/(givers of c) for c.
  std::vector<std::pair<std::int64_t, std::pair<std::size_t, double>>> shares;   // giver -> (swept index, weight)
  for (std::size_t s = 0; s < swept.size(); ++s)
    for (const std::int64_t d : links[s].same) shares.push_back({d, {s, 1.0 / static_cast<double>(links[s].same.size())}});
  std::sort(shares.begin(), shares.end());

  const double volume = cell_volume(raster);
  SweptLoss lost;
  const auto hand_over = [&](fluid::CellField& field, double unit, double* loss) {
    std::vector<double> fresh(swept.size(), 0.0);
    for (std::size_t begin = 0, end = 0; begin < shares.size(); begin = end) {
      const std::int64_t d = shares[begin].first;
      double weights = 1.0;
      for (; end < shares.size() && shares[end].first == d; ++end) weights += shares[end].second.second;
      const double content = field[d];
      for (std::size_t n = begin; n < end; ++n) fresh[shares[n].second.first] += content * shares[n].second.second / weights;
      field[d] = static_cast<float>(content / weights);
    }
    for (std::size_t s = 0; s < swept.size(); ++s) {
      const double old = field[swept[s]];
      const auto& across = links[s].across;
      for (const std::int64_t d : across) field[d] += static_cast<float>(old / static_cast<double>(across.size()));
      if (across.empty() && loss) *loss += old * unit;
      field[swept[s]] = static_cast<float>(fresh[s]);
    }
  };
  hand_over(gas.density, volume, &lost.smoke);
  hand_over(gas.temperature, params.air_density * params.air_heat_capacity * volume, &lost.heat);
  hand_over(gas.flame, 0.0, nullptr);
  return lost;
}

fluid::MovableWalls movable_walls(const Raster& raster, const std::vector<SheetSurface>& sheets,
                                  std::vector<double> inverse_mass) {
  const std::vector<std::int32_t> offset = dof_offsets(sheets);
  fluid::MovableWalls movable;
  movable.inverse_mass = std::move(inverse_mass);
  for (const WallHit& hit : raster.hits()) {
    const Int3& t = sheets[hit.sheet].mesh->triangles[hit.triangle];
    movable.axis.push_back(static_cast<std::uint8_t>(hit.axis));
    movable.face.push_back(hit.face);
    movable.dof.push_back({offset[hit.sheet] + t[0], offset[hit.sheet] + t[1], offset[hit.sheet] + t[2]});
    movable.weight.push_back(hit.weight);
  }
  return movable;
}

std::vector<Vec3> pressure_impulse(const Raster& raster, const std::vector<SheetSurface>& sheets,
                                   const std::vector<double>& pressure, double dt) {
  const fluid::Grid& grid = raster.grid();
  const std::vector<std::int32_t> offset = dof_offsets(sheets);
  std::vector<Vec3> impulse(offset.back(), Vec3::Zero());
  for (const WallHit& hit : raster.hits()) {
    const auto at = [&](int shift) {
      Int3 cell = hit.cell;
      cell[hit.axis] += shift;
      const bool outside = cell[hit.axis] < 0 || cell[hit.axis] >= grid.size(hit.axis);
      return outside ? 0.0 : pressure[grid.cell(cell[0], cell[1], cell[2])];
    };
    const double push = (at(-1) - at(0)) * grid.h * grid.h * dt;
    const Int3& t = sheets[hit.sheet].mesh->triangles[hit.triangle];
    for (int k = 0; k < 3; ++k) impulse[offset[hit.sheet] + t[k]][hit.axis] += hit.weight[k] * push;
  }
  return impulse;
}

}  // namespace wick::coupling
