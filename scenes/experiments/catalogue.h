#pragma once
/// The experiments by file: each function adds its own to the list.
#include <vector>

#include "scenes/experiments/experiment.h"

namespace wick::scenes {

void add_fire(std::vector<Experiment>& list);          ///< Fig 1
void add_arithmetic(std::vector<Experiment>& list);    ///< Figs 3, 7, Table 1, rigid limit
void add_strain(std::vector<Experiment>& list);        ///< Figs 4, 5
void add_wetting(std::vector<Experiment>& list);       ///< Fig 6
void add_earlier_fire(std::vector<Experiment>& list);  ///< Fig 9
void add_rates(std::vector<Experiment>& list);         ///< Figs 17, 18
void add_flag(std::vector<Experiment>& list);          ///< Fig 19
void add_ablation(std::vector<Experiment>& list);      ///< what each part of the method does
void add_convergence(std::vector<Experiment>& list);   ///< dt and mesh refinement
void add_cost(std::vector<Experiment>& list);          ///< Fig 20
void add_accuracy(std::vector<Experiment>& list);      ///< work and precision against closed forms

}  // namespace wick::scenes
