#pragma once
/// Smoke as OpenVDB, one file a frame, built in memory (the library does not notice a full disk).
///
/// Grids, all at cell centres of a linear transform with voxel h, origin at the lower corner + h/2, class fog
/// volume, Blosc + active mask, values half where they fit (|q| <= 65504):
///   density      [kg/m3]                              background 0
///   temperature  absolute: T_amb + excess [K]         background T_amb
///   flame        reaction coordinate in [0, 1]        background 0
///   vel          face velocities averaged [m/s]       background 0, contravariant-relative
/// Voxels within the clip threshold of the background are inactive and not stored. The temperature's background
/// is ambient and not 0: a filter at the rim of the stored region then sees warm air, not a gap of 300 K, and a
/// value read outside is true; a black body at ambient emits no visible light, so renderers show no difference.
/// Active voxels are always stored in leaves: a grid made of tiles alone renders as nothing in Cycles 3.4.
#include <memory>
#include <string>

#include "fluid/smoke.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// What one volume file shows: a copy of the state, so that the file can be made while the next step runs.
struct VolumeFrame {
  fluid::SmokeState state;
  fluid::Grid grid;
  double ambient_temperature = 293.15;  ///< [K]
  int frame = 1;                        ///< as in the file name
  double time = 0.0;                    ///< [s]
  double fps = 24.0;
  std::string scene_sha256;
};

/// The bytes of the .vdb file.
std::string smoke_vdb(const VolumeFrame& frame, const VolumeParams& params, UpAxis up_axis);

}  // namespace wick::scenes
