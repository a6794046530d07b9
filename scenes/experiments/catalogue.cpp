#include "scenes/experiments/catalogue.h"

namespace wick::scenes {

namespace {

std::vector<Experiment> build_list() {
  std::vector<Experiment> list;
  add_fire(list);
  add_arithmetic(list);
  add_strain(list);
  add_wetting(list);
  add_earlier_fire(list);
  add_rates(list);
  add_flag(list);
  add_ablation(list);
  add_convergence(list);
  add_cost(list);
  add_accuracy(list);
  list.push_back({"fig02", "Fig 2: photographs of burnt and wet sheets", "reference only", "measured data", {}});
  list.push_back({"fig08", "Fig 8: a sheet of paper is shredded by fire", "tongues and shreds", "tearing", {}});
  list.push_back({"fig10", "Fig 10: sheet and smoke", "turbulent smoke at torn rims", "tearing", {}});
  list.push_back({"fig11", "Fig 11: a bunny absorbs water", "patches follow the deformation", "water", {}});
  list.push_back({"fig12", "Fig 12: Fig 11 with earlier methods", "round patches", "water", {}});
  list.push_back({"fig13", "Fig 13: a pumpkin absorbs water", "never above capacity", "water", {}});
  list.push_back({"fig14", "Fig 14: a wet cloth droops", "fronts meet in the stretched middle", "water", {}});
  list.push_back({"fig15", "Fig 15: Fig 14 with earlier methods", "fronts ignore the stretch", "water", {}});
  list.push_back({"fig16", "Fig 16: a ball of water hits a stretched cloth", "a star", "water", {}});
  return list;
}

}  // namespace

std::span<const Experiment> experiments() {
  static const std::vector<Experiment> list = build_list();
  return list;
}

}  // namespace wick::scenes
