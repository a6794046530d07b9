/// Figs 1 and 9: a sheet burns with each method on the same deformation.
#include <fmt/format.h>

#include "scenes/experiments/catalogue.h"
#include "scenes/experiments/comparison.h"

namespace wick::scenes {

namespace {

const FrontQuestion burnt_band = {FrontOf::charred, 0.4, true};

ExperimentReport burning_methods(const Surroundings& s) {
  const Comparison all = compare(s, "crumple_burning",
                                 {model("isotropic", "isotropic"),
                                  model("ours", "strain_constrained"),
                                  model("Eq 7", "strain_unconstrained"),
                                  model("tensor", "tensor"),
                                  {"ours, gain x 3", {"/diffusion/gain=1500"}},
                                  {"ours, local_front", {"/diffusion/scope=local_front"}}},
                                 burnt_band);
  ExperimentReport report;
  report.checks = {at_least("P(ours)/P(isotropic)",
                            over(all.of(1, &FrontNumbers::tortuosity), all.of(0, &FrontNumbers::tortuosity)), 1.15),
                   at_least("rG(ours)", all.of(1, &FrontNumbers::displacement), 0.5),
                   at_least("Rq4(ours) [edges]", all.roughness(1), 0.4),
                   at_most("Rq4(isotropic) [edges]", all.roughness(0), 0.1),
                   reported("rG(ours), unburnt places", all.of(1, &FrontNumbers::ahead)),
                   reported("rG(ours), of the char", all.of(1, &FrontNumbers::front_displacement)),
                   reported("rG(ours, three times the gain)", all.of(4, &FrontNumbers::displacement)),
                   reported("rG(ours, scope local_front)", all.of(5, &FrontNumbers::displacement)),
                   reported("Df(ours)", all.of(1, &FrontNumbers::dimension)),
                   reported("Df(isotropic)", all.of(0, &FrontNumbers::dimension)),
                   reported("r_s(ours)", all.of(1, &FrontNumbers::advance)),
                   reported("Rq4(Eq 7) [edges]", all.roughness(2)),
                   reported("Rq4(tensor) [edges]", all.roughness(3))};
  report.analysis =
      "rG compares u with isotropic u where the latter lies between 0.15 and 0.85. In a fire that is ahead of the "
      "front and behind it: strained places take fire earlier and have therefore cooled more behind it, which "
      "turns the sign there. The char, which only grows, has no such other side. It hangs on no resolution of C: "
      "three times the strength (Pi = 9 instead of 3) brings rG to zero, the narrower scope (`/diffusion/scope`) "
      "leaves it, since both heat strained places earlier, and behind the fire those are cold earlier too.";
  report.tables.push_back(numbers_table("numbers", all.numbers));
  report.pictures.push_back({"fronts",
                             "char when 0.4 of the sheet is burnt, on the same crumpled sheet; line: half burnt",
                             draw_sheets(panels_of(all, burnt_band, ColorScale::fire), 3)});
  return report;
}

/// Lenaerts' and Patkar's models in the loop of burning. Their rates are matched to the isotropic advance; gravity
/// acts across the sheet's plane, as it lies. Beside them Patkar's with the numbers of Table 2, of unknown units,
/// read per second.
ExperimentReport earlier_methods(const Surroundings& s) {
  const Comparison all = compare(
      s, "crumple_burning",
      {model("isotropic", "isotropic"),
       model("ours", "strain_constrained"),
       {"porous", {"/diffusion/model=porous", "/diffusion/porous/permeability=5e-9", "/diffusion/porous/full=4"}},
       {"diffuse_gravity",
        {"/diffusion/model=diffuse_gravity", "/diffusion/gravity_transport/diffusion_rate=86",
         "/diffusion/gravity_transport/gravity_rate=17", "/diffusion/gravity_transport/transport_threshold=0.05"}},
       model("diffuse_gravity, as given", "diffuse_gravity")},
      burnt_band);
  ExperimentReport report;
  for (const std::size_t m : {2, 3}) {
    add_earlier_method(all, m, 1, report);
    report.checks.push_back(reported("A(" + all.numbers[m].label + ")", all.of(m, &FrontNumbers::covered)));
  }
  report.checks.push_back(reported("A(" + all.numbers[4].label + ")", all.of(4, &FrontNumbers::covered)));
  report.checks.push_back(reported("rG(ours)", all.of(1, &FrontNumbers::displacement)));
  report.analysis =
      "Table 2 prints Patkar's coefficients (0.005, 0.001, threshold 0.424) without units. Read per second they "
      "carry "
      "so little heat that the fire does not leave its source (last panel); they are scaled here until the front "
      "keeps up with the isotropic one. Lenaerts' pressures are those of Table 2; the permeability, which it does "
      "not print, is scaled in the same way.";
  report.tables.push_back(numbers_table("numbers", all.numbers));
  report.pictures.push_back({"fronts", "char when 0.4 of the sheet is burnt (or at the end); line: half burnt",
                             draw_sheets(panels_of(all, burnt_band, ColorScale::fire), 5, 220)});
  return report;
}

}  // namespace

void add_fire(std::vector<Experiment>& list) {
  list.push_back({"fig01", "Fig 1: a sheet burns with several methods", "ours ragged, the others smooth", "",
                  burning_methods});
}

void add_earlier_fire(std::vector<Experiment>& list) {
  list.push_back({"fig09", "Fig 9: the same with earlier methods", "smooth fronts", "", earlier_methods});
}

}  // namespace wick::scenes
