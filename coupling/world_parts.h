#pragma once
/// The pieces that World strings together: rules of scenes, what sheets lose, what outputs show.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "coupling/sheet.h"
#include "coupling/world.h"

namespace wick::coupling {

/// Rules that join sections; throws Refusal with the pointer at fault.
void check_world(const WorldParams& params);

/// Vertices that a sheet will have, before it is built: those of a file from its size.
double estimated_vertices(const ShellSection& shell, const WorldParams& params);

/// See World::estimate_memory.
std::vector<MemoryShare> world_memory(const WorldParams& params);

/// Velocity of the air around the given places without a gas grid (same count), empty in still air.
std::vector<Vec3> wind_at(const WorldParams& params, const std::vector<Vec3>& x, double time);

/// One line for each sheet that passes through itself, and for each pair that pass through each other, with how
/// often and where first.
std::vector<std::string> crossing_sheets(const std::vector<Sheet>& sheets);

/// One line for each sheet that reaches out of the grid's box at the start: what it gives off there is lost.
std::vector<std::string> sheets_outside(const std::vector<Sheet>& sheets, const fluid::Grid& grid);

/// Largest speed of the vertices that are in the grid's box, or would be within a cell of it [m/s].
double fastest_in_box(const std::vector<Sheet>& sheets, const fluid::Grid& grid);

/// Largest speed of the obstacles that are in the grid's box or may enter it within dt [m/s].
double fastest_in_box(const std::vector<Obstacle>& obstacles, const fluid::Grid& grid, double dt);

/// 1/m of every vertex of every sheet, 0 where a pin holds it at time t, or the sheet is held.
std::vector<double> inverse_masses(const std::vector<Sheet>& sheets, double t);

/// Adds a solve to the frame's record: iterations summed, worst residual kept.
void note_solve(FrameReport& report, const std::string& solver, const SolveReport& solve);

void add_shown_values(ShellView& view, const Sheet& sheet, double ambient, double kelvin);
std::map<std::string, double> sheet_metrics(const Sheet& sheet);

}  // namespace wick::coupling
