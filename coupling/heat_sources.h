#pragma once
/// Heat sources of the scene: what they give to the gas and to the sheets, where they are during a step.
#include <string>
#include <vector>

#include "coupling/sheet.h"
#include "coupling/world.h"

namespace wick::coupling {

/// Smoke and heat that the heat sources give to the gas during [time, time + dt], spread evenly over their way
/// through the box, and there over the cells of each region that are not inside an obstacle. A cell may be listed
/// many times.
fluid::SmokeSources gas_sources(const WorldParams& params, const fluid::Grid& grid, const fluid::Walls& walls,
                                double time, double dt);

/// One line for each source that is to give smoke or heat to the gas and cannot: outside the box as long as it is
/// on, or all in obstacles (told where nothing moves).
std::vector<std::string> sources_without_gas(const WorldParams& params, const std::vector<Obstacle>& obstacles,
                                             const fluid::Grid& grid);

/// Implicit supply and loss of one sheet, per vertex, in the units of DiffusionInput: a vertex that a moving source
/// passes is supplied for the share of the step in which it lies in the source.
struct SheetSupply {
  std::vector<double> rate, value, loss;
  bool any = false;  ///< a source reaches the sheet now
};
SheetSupply sheet_supply(const WorldParams& params, const Sheet& sheet, double ambient, double kelvin, double time,
                         double dt);

}  // namespace wick::coupling
