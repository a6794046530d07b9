#pragma once
/// Recorded motion of one sheet, as an HDF5 file:
///   /time       F          seconds, ascending
///   /x          F x V x 3  places of the vertices [m]
///   /frame      F          number of the simulated frame, 1 for the initial state
///   /rest       V x 3      rest shape of the sheet, where the scene places it [m]
///   /triangles  T x 3      vertex numbers
///   /checksum   1          of all above, so that a damaged copy is refused
///   /units, /version       "m,s", and the program that wrote it
/// Reals are 64-bit, whole numbers 32-bit (the checksum 64-bit unsigned). A reader needs /time and /x only.
#include <filesystem>

#include "core/function_ref.h"
#include "coupling/motion.h"
#include "scenes/atomic_file.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// What goes into a motion file besides the places.
struct MotionHeader {
  std::vector<std::int32_t> frame;  ///< F
  std::vector<double> time;         ///< F [s]
  const solid::ShellMesh* mesh = nullptr;
};

/// The bytes of a motion file; `places(n)` is called once for each n < F in ascending order and gives V places.
Bytes motion_file(const MotionHeader& header, FunctionRef<const std::vector<Vec3>&(std::size_t)> places);

/// Reads a motion file. Throws Refusal with `pointer` where it is missing, damaged, or no motion.
coupling::MotionTrack read_motion(const std::filesystem::path& path, const std::string& pointer);

/// Reads the tracks of all sheets of the scene whose motion is recorded.
void read_motions(Scene& scene);

}  // namespace wick::scenes
