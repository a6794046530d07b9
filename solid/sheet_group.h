#pragma once
/// Sheets that touch each other advance side by side, substep by substep.
#include <span>
#include <vector>

#include "solid/sheet_contact.h"
#include "solid/shell.h"

namespace wick::solid {

/// One sheet of the group for one step. All of it must live through the step.
struct GroupedSheet {
  const ShellMesh* mesh;
  ShellState* state;
  ShellSolver* solver;  ///< null: held or driven, from `from` to where the state is [m]
  const ShellParams* params;
  const ShellLoads* loads;  ///< null without a solver
  const std::vector<Vec3>* from;
};

/// Advances the sheets by dt, in the largest number of substeps that one of them asks for; sheets in the order in
/// which `contact` was made for them. Reports in that order too, empty for sheets without a solver.
std::vector<ShellStepReport> step_together(std::span<GroupedSheet> sheets, SheetContact& contact, double dt);

}  // namespace wick::solid
