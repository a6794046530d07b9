#pragma once
/// Sheets as binary little-endian PLY, one file a frame: what every renderer and ParaView read without a library.
#include "coupling/world.h"
#include "scenes/atomic_file.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// Vertices with x y z, nx ny nz, vx vy vz [m/s], s t (material coordinates [m], where the sheet has them),
/// red green blue alpha (sRGB, glow included), and every named value of the view as a float; then the triangles.
/// Those that a triangle names are written, with the number that they keep from frame to frame as the int `id`.
Bytes shell_ply(const coupling::ShellView& view, UpAxis up_axis);

/// Pieces that have burnt off, as points: x y z, vx vy vz, radius [m], temperature [K], red green blue alpha, id.
Bytes ember_ply(const coupling::EmberView& view, UpAxis up_axis);

/// A vector of the simulation (z up) as the output's axes see it.
inline Vec3 to_axes(const Vec3& v, UpAxis up_axis) {
  return up_axis == UpAxis::z ? v : Vec3(v.x(), v.z(), -v.y());
}

}  // namespace wick::scenes
