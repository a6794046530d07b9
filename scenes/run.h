#pragma once
/// Running a scene: from its file to its frames, over interruptions.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/require.h"
#include "scenes/scene.h"

namespace wick::scenes {

struct RunOptions {
  std::filesystem::path scene;
  std::string out;               ///< empty: out/<scene name>
  std::optional<int> frames;     ///< overrides the scene's
  std::vector<std::string> set;  ///< /pointer=value
  int threads = 0;               ///< 0: all that the machine has
  bool quiet = false;
  bool restart = false;  ///< forget what the folder holds
};

/// Where a run of the scene writes.
std::filesystem::path output_folder(const RunOptions& options, const Scene& scene);

/// The scene that the options name, with their changes applied.
Scene load_scene(const RunOptions& options);

/// Computes the frames that the output folder does not have yet. Throws Refusal; returns done or checkpointed.
ExitCode run_scene(const RunOptions& options);

/// Checks all that a run would check, writes nothing, prints what the run would be.
void check_scene(const RunOptions& options);

/// Throws Refusal (refused) when the machine has not the memory that the scene needs.
void require_memory(const Scene& scene);

}  // namespace wick::scenes
