#pragma once
/// Sheets that part where they are stretched beyond their strength, which falls as they char.
#include "coupling/sheet.h"

namespace wick::coupling {

/// Strain at which every vertex parts (V): the sheet's own, scattered by seeded flaws, times what char has left of
/// it.
std::vector<double> tearing_strength(const Sheet& sheet, const WorldParams& world);

/// Parts the sheet where it is overstrained, each place once; its mesh, solvers and inputs follow. `push` as in
/// ablate(). Returns the number of vertices that were split.
std::size_t tear_sheet(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push);

/// How often the sheets of a scene are looked at for tears in a step of dt; 1 where none tears.
int tearing_checks(const std::vector<Sheet>& sheets, double dt);

}  // namespace wick::coupling
