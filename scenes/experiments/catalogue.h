#pragma once
/// The experiments by file: each function adds its own to the list.
#include <vector>

#include "scenes/experiments/experiment.h"

namespace wick::scenes {

void add_arithmetic(std::vector<Experiment>& list);   ///< Figs 3, 7, Table 1, rigid limit
void add_wetting(std::vector<Experiment>& list);      ///< Fig 6
void add_convergence(std::vector<Experiment>& list);  ///< dt and mesh refinement
void add_fire(std::vector<Experiment>& list);         ///< Figs 1, 9
void add_cost(std::vector<Experiment>& list);         ///< Fig 20
void add_accuracy(std::vector<Experiment>& list);     ///< work and precision against closed forms

}  // namespace wick::scenes
