#pragma once
/// Rank correlation and straight-line fits, for what a front has to do with the strain under it.
#include <span>
#include <vector>

#include "solid/shell_mesh.h"

namespace wick::diffusion {

/// Ranks 1..n; equal values share the mean of their ranks.
std::vector<double> ranks(const std::vector<double>& values);

/// Correlation of two samples of equal size; 0 where one of them is constant.
double pearson(const std::vector<double>& a, const std::vector<double>& b);

/// Spearman's rank correlation; 0 where one sample is constant or shorter than 3.
double spearman(const std::vector<double>& a, const std::vector<double>& b);

/// Spearman's correlation of what remains of a and b after their ranks were regressed on the ranks of the controls.
double partial_spearman(const std::vector<double>& a, const std::vector<double>& b,
                        std::span<const std::vector<double>> controls);

/// y = slope x + offset by least squares.
struct LineFit {
  double slope = 0.0, offset = 0.0, r_squared = 0.0;
};
LineFit fit_line(const std::vector<double>& x, const std::vector<double>& y);

/// Mean and standard deviation over seeds.
struct Spread {
  double mean = 0.0, deviation = 0.0;  ///< of the sample, n - 1
};
Spread spread(const std::vector<double>& values);

/// A vertex field (V) averaged over a Gaussian neighbourhood of `width` (standard deviation, m) of the rest shape:
/// four implicit steps of heat flow, which keep the mean and the range.
std::vector<double> smoothed(const solid::ShellMesh& mesh, const std::vector<double>& field, double width);

/// rG: Spearman's correlation, over the vertices with 0.15 < isotropic < 0.85, of what u is above its mean at equal
/// `isotropic` u with `strain` (V, smoothed by the caller). Follows displacement of the front, where the advance is
/// too small to measure.
double displacement_correlation(const std::vector<double>& u, const std::vector<double>& isotropic,
                                const std::vector<double>& strain);

}  // namespace wick::diffusion
