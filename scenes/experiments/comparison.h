#pragma once
/// Several methods on the same deformation, over seeds.
#include <string>
#include <vector>

#include "scenes/experiments/front_numbers.h"

namespace wick::scenes {

/// One method: what it changes in the scene.
struct Method {
  std::string label;
  std::vector<std::string> assignments;
};

/// A method that differs by its model alone.
Method model(const std::string& label, const std::string& name);

/// Numbers of every method over the seeds, and the runs of the first seed for pictures. The first method is the
/// isotropic one that the others are measured against.
struct Comparison {
  std::vector<MethodNumbers> numbers;
  std::vector<SheetHistory> first;
  double edge = 0.0;  ///< mean length of the edges [m]

  [[nodiscard]] std::vector<double> of(std::size_t method, double FrontNumbers::*number) const {
    return numbers[method].of(number);
  }
  /// Rq4 in edges.
  [[nodiscard]] std::vector<double> roughness(std::size_t method) const;
  /// |r_s| seed by seed.
  [[nodiscard]] std::vector<double> advance_size(std::size_t method) const;
};

/// Runs every method on `scene` with /shells/0/motion/seed = 1, 2, ...; or, where the sheet is moved by the shell
/// solver, on the motion recorded once a seed under gusts of that seed.
Comparison compare(const Surroundings& s, const std::string& scene, const std::vector<Method>& methods,
                   const FrontQuestion& question);

std::vector<SheetPanel> panels_of(const Comparison& comparison, const FrontQuestion& question, ColorScale scale);

/// Quotient seed by seed.
std::vector<double> over(const std::vector<double>& a, const std::vector<double>& b);

/// The thresholds of an earlier method beside ours: rG <= 0.2, Rq4 at most half of ours, |r_s| <= 0.15.
void add_earlier_method(const Comparison& all, std::size_t method, std::size_t ours, ExperimentReport& report);

}  // namespace wick::scenes
