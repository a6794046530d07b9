#pragma once
/// Everything that one frame writes, gathered so that the world can move on while it is written.
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "coupling/world.h"
#include "scenes/atomic_file.h"
#include "scenes/manifest.h"
#include "scenes/preview.h"
#include "scenes/run_folder.h"
#include "scenes/volume_output.h"

namespace wick::scenes {

struct FrameOutput {
  int frame = 0;
  std::filesystem::path volume_path;
  std::optional<VolumeFrame> volume;
  std::vector<std::pair<std::filesystem::path, Bytes>> files;  ///< complete: meshes, motion
  std::filesystem::path preview_path;
  std::optional<Picture> preview;
  Bytes metrics;                    ///< empty: between frames
  Bytes checkpoint;                 ///< empty: none in this frame
  double checkpoint_seconds = 0.0;  ///< that making it took
};

/// Copies of the fields and the finished meshes of the world's present frame.
FrameOutput gather_outputs(const coupling::World& world, const Scene& scene, const RunFolder& folder,
                           const std::string& scene_sha256);

/// Writes them and notes them in the manifest: volume, files, metrics, manifest, then the checkpoint, which thus
/// vouches for all before it. Returns the seconds that writing the checkpoint took.
double write_outputs(const FrameOutput& output, const OutputParams& params, const RunFolder& folder,
                     Manifest& manifest);

}  // namespace wick::scenes
