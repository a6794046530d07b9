#pragma once
/// run.json: what became of a run. It says "running", and how far it is at every checkpoint, until the run has
/// ended of itself; found so without a process, the run was killed.
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/atomic_file.h"
#include "scenes/run_folder.h"

namespace wick::scenes {

struct RunRecord {
  std::string scene;  ///< its name
  std::vector<std::string> models;
  int threads = 0;
  double wall_s = 0.0;              ///< of this process [s]
  int frames = 0;                   ///< computed so far, the initial state included
  std::string outcome = "running";  ///< running, done, checkpointed, failed
  std::string reason;               ///< of a failure
  std::string state_hash;           ///< of the last frame
  std::string scene_sha256;
  std::string scene_file_sha256;  ///< of scene.json as the run wrote it
  std::string metrics_sha256;     ///< of metrics.h5 at the end of the run; empty until then
  double checkpoint_s = 0.0;      ///< to make and write the last checkpoint [s], for the notice a farm should give
  long long unconverged_solves = 0;
  std::vector<std::string> damaged_outputs;  ///< of earlier frames, below the folder; see manifest.json
  std::vector<std::string> warnings;
};

std::string run_record_text(const RunRecord& record);

/// What a later run needs of a record.
struct RecordedRun {
  std::string scene, scene_sha256, scene_file_sha256, metrics_sha256, outcome;
};
/// Reads a run.json; nothing where there is none, or it is no record of a run.
std::optional<RecordedRun> read_run_record(const std::filesystem::path& file);

/// The metrics.h5 that the folder's record vouches for; empty where it has changed, or no run has ended there.
Bytes recorded_metrics(const RunFolder& folder);

/// Keeps run.json up to date, with space set aside so that the last word is written to a full disk too.
class RecordKeeper {
 public:
  explicit RecordKeeper(const RunFolder& folder) : folder_(folder) {}
  ~RecordKeeper();
  RecordKeeper(const RecordKeeper&) = delete;
  RecordKeeper& operator=(const RecordKeeper&) = delete;

  /// Says that the run goes on, and sets the space aside.
  void begin(RunRecord& record);
  void write(RunRecord& record, const std::string& outcome);
  /// Leaves the reason behind, as far as the disk takes it; throws nothing.
  void fail(RunRecord& record, const std::string& reason);
  [[nodiscard]] double seconds() const;  ///< since the run began

 private:
  const RunFolder& folder_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace wick::scenes
