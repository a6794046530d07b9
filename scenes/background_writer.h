#pragma once
/// Makes files on a thread of its own while the next frame is computed. Jobs run in the order they were given,
/// so a checkpoint on the disk means that every earlier output is there too.
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace wick::scenes {

class BackgroundWriter {
 public:
  /// At most `room` jobs wait; further ones hold the caller up, so that memory stays bounded.
  explicit BackgroundWriter(std::size_t room = 8);
  /// Waits for the jobs; an error nobody asked for is lost.
  ~BackgroundWriter();
  BackgroundWriter(const BackgroundWriter&) = delete;
  BackgroundWriter& operator=(const BackgroundWriter&) = delete;

  /// Queues a job. Rethrows the error of an earlier one; after an error no further job runs.
  void submit(std::function<void()> job);
  /// Waits until all jobs are done and rethrows the first error.
  void finish();

 private:
  void work();
  void rethrow();

  std::size_t room_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> jobs_;
  bool busy_ = false;
  bool closing_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace wick::scenes
