#pragma once
/// What crosses between sheets and gas: smoke and heat, each taken from one side and given to the other in
/// the same call. Everything is one-sided: a vertex talks to the cells on its own two faces only, and cells that a
/// sheet has passed hand their content over to the side where it belongs.
#include <array>
#include <cstdint>
#include <vector>

#include "coupling/rasterize.h"
#include "fluid/smoke.h"

namespace wick::coupling {

/// The cells that the two faces of a vertex see, with weights that sum to 1 a face; a face that sees none (out
/// of the box, or buried in a fold) has count 0. Face 0 is the one that the normal points away from.
struct VertexStencil {
  struct Face {
    std::array<std::int64_t, 8> cell;
    std::array<float, 8> weight;
    int count = 0;
  };
  std::array<Face, 2> face;
};

/// Stencils of all vertices of sheet number `sheet` in `raster` (V).
/// Of the eight cell centres around a vertex, those on the + ends of the closed segments among them belong to
/// face 1, those on the - ends to face 0, and so do cells joined to them by open segments of the same cube. Centres
/// that an obstacle hides from the vertex belong to neither.
std::vector<VertexStencil> vertex_stencils(const Raster& raster, std::int32_t sheet, const SheetSurface& surface,
                                           const std::vector<Obstacle>& obstacles = {});

/// What has moved since the gas last saw it.
struct Sweep {
  std::vector<std::vector<std::int64_t>> by_sheet = {};  ///< cells that each sheet has passed, see swept_cells()
  const std::vector<Obstacle>* obstacles = nullptr;      ///< where they are now; null: none
  std::vector<Pose> moves = {};  ///< of each obstacle since then, as a map of space; empty: none has moved
};
struct SweptLoss {
  double smoke = 0.0, heat = 0.0;                  ///< that had nowhere to go [kg], [J]
  double smoke_out = 0.0, heat_out = 0.0;          ///< pushed out through open sides
  double rounded_smoke = 0.0, rounded_heat = 0.0;  ///< taken out (-: put in) by the rounding of cells to floats
};
/// Moves the content of cells that sheets and obstacles have passed, entered or left to the nearest cells on the
/// side where it was, and fills them from the side they are on now; sums are kept but for what is returned, which
/// has been taken out.
SweptLoss hand_over_swept(const Raster& raster, const Sweep& sweep, const fluid::SmokeParams& params,
                          fluid::SmokeState& gas);

/// Walls that close in push gas out with its heat, which transport on a grid of full cells and the handing over
/// above do not: they pile it up. Cells beside walls that are hotter than `hottest` above ambient [K] pass the
/// excess on through open faces to the nearest cells that have room. Returns the heat [J] that found none within a
/// few cells and was taken out.
double spread_excess_heat(const Raster& raster, double hottest, const fluid::SmokeParams& params,
                          fluid::CellField& temperature);

/// Newton cooling between each face of the sheet and the gas that it sees, integrated exactly for each pair over
/// dt so that no step overshoots. `areas` (V, [m2]), `capacity` M c (V, [J per unit theta]).
/// Adds to `sheet_heat` (V, [J], + into the sheet) and takes the same from the gas. Returns the sum into the
/// sheets. `hotter_side` (V, [-1,1]) is set from the difference of the gas temperatures on the two faces.
struct HeatScale {
  double ambient;  ///< T_amb [K]
  double kelvin;   ///< T_ref - T_amb: kelvin per unit theta
};
double exchange_heat(const std::vector<VertexStencil>& stencils, const std::vector<double>& areas,
                     const std::vector<double>& theta, const std::vector<double>& capacity, const HeatScale& scale,
                     double convection, double dt, const fluid::SmokeParams& params, fluid::SmokeState& gas,
                     std::vector<double>& sheet_heat, std::vector<double>& hotter_side);

/// Puts smoke [kg], heat [J] (V each) and a flame of the given strength (V, 0..1) into the cells that the vertices
/// see, half on each face where both see gas. What no face can take is returned as escaped. Gas is heated to at
/// most `hottest` above ambient [K]: there its oxygen is used up, and the rest of the fuel passes unburnt.
struct Deposited {
  double smoke = 0.0, heat = 0.0;                  ///< now in the gas
  double escaped_smoke = 0.0, escaped_heat = 0.0;  ///< outside the box, or buried
  double unburnt_heat = 0.0;                       ///< never released [J]
};
Deposited deposit(const std::vector<VertexStencil>& stencils, const std::vector<double>& smoke,
                  const std::vector<double>& heat, const std::vector<double>& flame, double hottest,
                  const fluid::SmokeParams& params, fluid::SmokeState& gas);

/// The sheets' masses as the simultaneous pressure solve wants them. Degrees of freedom are the vertices of all
/// sheets one after the other; `inverse_mass` has one entry for each [1/kg].
fluid::MovableWalls movable_walls(const Raster& raster, const std::vector<SheetSurface>& sheets,
                                  std::vector<double> inverse_mass);

/// Impulse of the gas pressure on the vertices of all sheets during dt [N s]: h2 (p- - p+) dt on each closed face.
std::vector<Vec3> pressure_impulse(const Raster& raster, const std::vector<SheetSurface>& sheets,
                                   const std::vector<double>& pressure, double dt);

}  // namespace wick::coupling
