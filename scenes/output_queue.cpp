#include "scenes/output_queue.h"

#include <memory>

namespace wick::scenes {

void OutputQueue::submit(FrameOutput output) {
  writer_.submit([this, frame = std::make_shared<FrameOutput>(std::move(output))] { write(*frame); });
}

void OutputQueue::write(const FrameOutput& output) {
  const auto start = std::chrono::steady_clock::now();
  const double checkpoint = write_outputs(output, params_, folder_, manifest);
  const std::lock_guard lock(mutex_);
  seconds_[output.frame] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!output.checkpoint.empty()) checkpoint_seconds_ = output.checkpoint_seconds + checkpoint;
}

void OutputQueue::note_times(Metrics& metrics) {
  const std::lock_guard lock(mutex_);
  for (const auto& [frame, seconds] : seconds_) metrics.set(frame, background_timing, seconds);
}

double OutputQueue::background_seconds() const {
  const std::lock_guard lock(mutex_);
  double sum = 0.0;
  for (const auto& [frame, seconds] : seconds_) sum += seconds;
  return sum;
}

double OutputQueue::checkpoint_seconds() const {
  const std::lock_guard lock(mutex_);
  return checkpoint_seconds_;
}

}  // namespace wick::scenes
