#pragma once
/// What a run writes, before it is written.
#include <cstdint>
#include <filesystem>
#include <string>

#include "coupling/world.h"
#include "scenes/scene.h"

namespace wick::scenes {

struct DiskEstimate {
  std::uint64_t frame = 0;       ///< largest size of the volumes, meshes and previews of one frame [bytes]
  std::uint64_t joined = 0;      ///< what one frame adds to the files that are made at the end [bytes]
  std::uint64_t checkpoint = 0;  ///< of one checkpoint [bytes]
  std::uint64_t all = 0;         ///< largest size of the whole run: every frame, and the checkpoints that are kept
};

/// Volumes are counted as if every cell were stored and nothing compressed: smoke that fills little takes less.
DiskEstimate estimate_disk(coupling::World& world, const Scene& scene);

/// Bytes that may still be written where `folder` is or will be.
std::uint64_t free_disk(const std::filesystem::path& folder);

/// A warning where the frames after `done` may not fit beside what is there already; empty where they do.
std::string disk_shortage(const DiskEstimate& estimate, const Scene& scene, int done,
                          const std::filesystem::path& folder);

/// Throws Refusal (refused) when not even one frame and its checkpoint fit.
void require_disk(const DiskEstimate& estimate, const std::filesystem::path& folder);

}  // namespace wick::scenes
