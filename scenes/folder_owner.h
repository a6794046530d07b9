#pragma once
/// Whose an output folder is: a run replaces what a run wrote, never what somebody else put there.
#include <string>

#include "scenes/checkpoint.h"
#include "scenes/run_folder.h"
#include "scenes/run_record.h"

namespace wick::scenes {

struct FolderClaim {
  const Scene& scene;
  std::filesystem::path scene_path;  ///< of the scene file that is being run
  std::string scene_text;            ///< the effective scene, as scene.json is going to be
};

/// Throws Refusal (output_cannot_be_made) where the run would replace a file that no run wrote, the scene file
/// itself, or a file that the scene reads.
void require_own_files(const RunFolder& folder, const FolderClaim& claim);

/// Throws Refusal (output_cannot_be_made) naming the scene whose run the folder's record tells of, where it is
/// another one than `identity_sha256`.
void require_no_other_run(const RunFolder& folder, const std::string& identity_sha256);

/// Throws Refusal (output_cannot_be_made) where a checkpoint of the folder is of another scene than `identity`, or
/// of another version of the program.
void require_same_run(const RunFolder& folder, const CheckpointHeader& header, const std::string& identity);

}  // namespace wick::scenes
