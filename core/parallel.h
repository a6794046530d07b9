#pragma once
/// Parallel loops and sums whose results do not depend on the number of threads: ranges are cut into
/// fixed chunks, and partial sums are added in the order of the chunks.
#include <cstddef>

#include "core/function_ref.h"

namespace wick {

/// Calls body(begin, end) on consecutive chunks of [0, count), `grain` items each (the last may be
/// shorter), on as many threads as the arena has. Chunks must write to disjoint places.
void parallel_chunks(std::size_t count, std::size_t grain,
                     FunctionRef<void(std::size_t begin, std::size_t end)> body);

/// Sum of body(begin, end) over the chunks of [0, count), added in chunk order: the same bits at any
/// number of threads.
double parallel_sum(std::size_t count, std::size_t grain,
                    FunctionRef<double(std::size_t begin, std::size_t end)> body);

/// Maximum of body(begin, end) over the chunks of [0, count); `lowest` when count is 0.
double parallel_max(std::size_t count, std::size_t grain, double lowest,
                    FunctionRef<double(std::size_t begin, std::size_t end)> body);

/// Calls body(i) for each i of [0, count).
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, Body&& body) {
  parallel_chunks(count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Limits every later parallel loop of the process to `threads` (>= 1) while it lives.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  void* control_;
};

/// Threads that a parallel loop uses now.
int thread_count();

}  // namespace wick
