#pragma once
/// Sums and maxima over smoke fields; the same bits at any number of threads.
#include "fluid/smoke.h"

namespace wick::fluid {

double sum(const CellField& field);
/// Largest |component| of velocity, whatever its sign [m/s].
double fastest(const FaceField& velocity);
double cell_volume(const SmokeParams& params);    ///< [m3]
double heat_capacity(const SmokeParams& params);  ///< of the air in one cell [J/K]

}  // namespace wick::fluid
