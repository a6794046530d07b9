#include "coupling/exchange.h"

#include <algorithm>
#include <cmath>

#include "core/float_sum.h"

namespace wick::coupling {

namespace {

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
  const double gas_capacity = params.air_density * params.air_heat_capacity * h * h * h;  // J/K of a cell

  // Share each cell's heat among the vertex faces that see it, so that together they cannot take more than it has.
  std::vector<float> seen(gas.temperature.size(), 0.0F);
  for (const VertexStencil& stencil : stencils)
    for (const auto& face : stencil.face)
      for (int n = 0; n < face.count; ++n) seen[face.cell[n]] += face.weight[n];

  double total = 0.0;
  std::vector<std::pair<std::int64_t, double>> given;  // heat taken from cells, applied after all have been read
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
  FloatSum taken;
  for (const auto& [cell, heat] : given) taken.add(gas.temperature[cell], -heat / gas_capacity);
  return total;
}

Deposited deposit(const std::vector<VertexStencil>& stencils, const std::vector<double>& smoke,
                  const std::vector<double>& heat, const std::vector<double>& flame, double hottest,
                  const fluid::SmokeParams& params, fluid::SmokeState& gas) {
  const double h = params.width / params.resolution[0];
  const double volume = h * h * h;
  const double gas_capacity = params.air_density * params.air_heat_capacity * volume;
  Deposited sum;
  FloatSum density, kelvin;
  for (std::size_t i = 0; i < stencils.size(); ++i) {
    if (smoke[i] == 0.0 && heat[i] == 0.0 && flame[i] == 0.0) continue;
    const int faces = (stencils[i].face[0].count > 0 ? 1 : 0) + (stencils[i].face[1].count > 0 ? 1 : 0);
    if (faces == 0) {
      sum.escaped_smoke += smoke[i];
      sum.escaped_heat += heat[i];
      continue;
    }
    double unburnt = 0.0;
    for (const auto& face : stencils[i].face) {
      // The weights are floats, and their sum is 1 but for rounding.
      double weights = 0.0;
      for (int n = 0; n < face.count; ++n) weights += face.weight[n];
      for (int n = 0; n < face.count; ++n) {
        const double share = face.weight[n] / (weights * faces);
        const std::int64_t c = face.cell[n];
        density.add(gas.density[c], share * smoke[i] / volume);
        const double wanted = share * heat[i];
        const double room = gas_capacity * std::max(0.0, hottest - static_cast<double>(gas.temperature[c]));
        kelvin.add(gas.temperature[c], std::min(wanted, room) / gas_capacity);
        unburnt += std::max(wanted - room, 0.0);
        gas.flame[c] = std::max(gas.flame[c], static_cast<float>(flame[i]));
      }
    }
    sum.smoke += smoke[i];
    sum.heat += heat[i] - unburnt;
    sum.unburnt_heat += unburnt;
  }
  return sum;
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
