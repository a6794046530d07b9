#pragma once
/// What the experiments measure on the front of a run, against an isotropic run on the same deformation.
#include <string>
#include <vector>

#include "scenes/experiments/experiment.h"
#include "scenes/experiments/replay.h"

namespace wick::scenes {

struct FrontNumbers {
  double covered = 0.0;             ///< A, fraction of the sheet
  double tortuosity = 0.0;          ///< P: over the width of a band, or over the circle of the same area
  double fine_roughness = 0.0;      ///< Rq4 [m]
  double relative_roughness = 0.0;  ///< Rq
  double departure = 0.0;           ///< Rd: distance from the isotropic front at the same coverage, over √area
  double dimension = 0.0;           ///< Df
  double pieces = 0.0;              ///< nc: longer than six edges
  double displacement = 0.0;  ///< rG: Spearman of u above its mean at equal isotropic u with c smoothed over 4 cm
  double front_displacement = 0.0;  ///< rG of the field that the front is found in: u, or the char
  double ahead = 0.0;               ///< rG over the vertices that are unburnt in both runs
  double advance = 0.0;             ///< r_s: Spearman of the front's normal advance with c, mean over frames
  double advance_partial = 0.0;     ///< r_s with distance from the source and the front's curvature partialled out
  double curvature_power = 0.0;  ///< of the front's curvature at wavelengths below a sixteenth of the width [1/m2]
  double covered_at_end = 0.0;   ///< A of the last frame
  double anisotropy = 0.0;       ///< AI4: fourth harmonic of the front's radius about the middle of the sheet
};

struct FrontQuestion {
  FrontOf of = FrontOf::u;
  double coverage = 0.35;  ///< at which the shape is measured
  bool band = true;        ///< the front crosses the sheet; false: it surrounds the middle
};

/// Width of a band: the extent of the sheet along its first material axis [m].
double sheet_width(const solid::ShellMesh& mesh);

/// Mean length of the edges [m].
double mean_edge(const solid::ShellMesh& mesh);

/// `c` is the strain density of the scene's deformation in each frame, or in one for all (V).
FrontNumbers measure_front(const SheetHistory& run, const SheetHistory& isotropic,
                           const std::vector<std::vector<double>>& c, const FrontQuestion& question);

/// The front of a run at the coverage asked, as a panel.
SheetPanel front_panel(const std::string& title, const SheetHistory& run, const FrontQuestion& question,
                       ColorScale scale);

/// One method over several seeds: a column for each number.
struct MethodNumbers {
  std::string label;
  std::vector<FrontNumbers> seeds;
  /// One number of every seed.
  [[nodiscard]] std::vector<double> of(double FrontNumbers::*number) const;
};

/// All numbers of all methods and seeds.
Table numbers_table(const std::string& name, const std::vector<MethodNumbers>& methods);

}  // namespace wick::scenes
