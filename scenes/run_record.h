#pragma once
/// run.json: what became of a run. It says "running" until the run has ended of itself; found so without a
/// process, the run was killed.
#include <string>
#include <vector>

namespace wick::scenes {

struct RunRecord {
  std::vector<std::string> models;
  int threads = 0;
  double wall_s = 0.0;              ///< of this process [s]
  int frames = 0;                   ///< computed so far, the initial state included
  std::string outcome = "running";  ///< running, done, checkpointed, failed
  std::string reason;               ///< of a failure
  std::string state_hash;           ///< of the last frame
  std::string scene_sha256;
  double checkpoint_s = 0.0;  ///< to make and write the last checkpoint [s], for the notice a farm should give
  long long unconverged_solves = 0;
  std::vector<std::string> damaged_outputs;  ///< of earlier frames, below the folder; see manifest.json
  std::vector<std::string> warnings;
};

std::string run_record_text(const RunRecord& record);

}  // namespace wick::scenes
