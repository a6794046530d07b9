#pragma once
/// Numbers that tell how ragged a front is. Lengths in metres, of the shape in which the front was found.
#include "diffusion/front.h"

namespace wick::diffusion {

/// P of closed fronts: length over the circumference of the disc of the same area; 1 for a circle.
double blob_tortuosity(const Front& front);
/// P of a front that crosses a band of the given width: length over width; 1 for a straight line.
double band_tortuosity(const Front& front, double width);

/// Root mean square distance of the front from its own low-pass, a Gaussian of `sigma` along arc length (open
/// pieces go on beyond their ends by point reflection, so a straight piece stays as it is). Over pieces at least
/// `least_length` long, weighted by length; 0 when there are none. [m]
double roughness(const Front& front, double sigma, double least_length);

/// Rq: roughness at sigma = L/8 of each piece, over √area; a circle has (1 - exp(-π²/32))/√π = 0.1497.
double relative_roughness(const Front& front, double least_length);

/// Rq4: roughness at a fixed 4 cm [m].
inline double fine_roughness(const Front& front, double least_length) {
  return roughness(front, 0.04, least_length);
}

/// Root mean square distance of the front from another one [m]; infinite when one of them is empty.
double departure(const Front& front, const Front& other);

/// Box-counting dimension between box sizes `finest` and `coarsest` in eight geometric steps; counts are the least
/// over shifted lattices. `fit` is R² of the regression.
struct BoxDimension {
  double dimension = 0.0;
  double fit = 0.0;
};
BoxDimension box_dimension(const Front& front, double finest, double coarsest);

/// Mean square curvature of the front at wavelengths below `wavelength`: its spectral power there, absolute [1/m²].
/// Samples are `spacing` apart; over pieces at least `least_length` long.
double fine_curvature_power(const Front& front, double wavelength, double spacing, double least_length);

/// AI_m: amplitude of the m-th harmonic of the front's radius about `center`, over the mean radius.
double radial_harmonic(const Front& front, const Vec3& center, int m);

/// AI: 1 - √(smallest/largest) of the second moments of u about its centroid, in the two directions of the sheet in
/// which they are largest; 0 for a round spot.
double second_moment_anisotropy(const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                                const std::vector<double>& u);

}  // namespace wick::diffusion
