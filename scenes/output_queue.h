#pragma once
/// The frames on their way to the disk, and the account of the time that they take.
#include <chrono>
#include <map>
#include <mutex>

#include "scenes/background_writer.h"
#include "scenes/frame_output.h"
#include "scenes/metrics.h"

namespace wick::scenes {

class OutputQueue {
 public:
  OutputQueue(const RunFolder& folder, const OutputParams& params) : folder_(folder), params_(params) {}

  /// What later frames are noted in. Belongs to the writer's thread from the first submit() to finish().
  Manifest manifest;

  /// Queues the files of one frame. Rethrows the error of an earlier one.
  void submit(FrameOutput output);
  /// Waits until all is written; rethrows the first error.
  void finish() { writer_.finish(); }

  /// Brings the rows of written frames up to date.
  void note_times(Metrics& metrics);
  [[nodiscard]] double background_seconds() const;  ///< of all frames so far
  [[nodiscard]] double checkpoint_seconds() const;  ///< that making and writing the last checkpoint took

 private:
  void write(const FrameOutput& output);

  const RunFolder& folder_;
  const OutputParams& params_;
  mutable std::mutex mutex_;
  std::map<int, double> seconds_;  ///< by frame
  double checkpoint_seconds_ = 0.0;
  BackgroundWriter writer_{1};  ///< last: its thread ends before what it uses
};

}  // namespace wick::scenes
