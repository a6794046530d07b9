#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace wick {

void parallel_chunks(std::size_t count, std::size_t grain, FunctionRef<void(std::size_t, std::size_t)> body) {
  if (count == 0) return;
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) return body(0, count);
  tbb::parallel_for(std::size_t{0}, chunks,
                    [&](std::size_t chunk) { body(chunk * grain, std::min(count, (chunk + 1) * grain)); });
}

namespace {

/// One value a chunk, each computed by whichever thread, then folded in chunk order.
template <class Fold>
double fold_chunks(std::size_t count, std::size_t grain, double start,
                   FunctionRef<double(std::size_t, std::size_t)> body, Fold fold) {
  grain = std::max<std::size_t>(grain, 1);
  std::vector<double> partial((count + grain - 1) / grain, start);
  parallel_chunks(count, grain,
                  [&](std::size_t begin, std::size_t end) { partial[begin / grain] = body(begin, end); });
  double result = start;
  for (const double value : partial) result = fold(result, value);
  return result;
}

}  // namespace

double parallel_sum(std::size_t count, std::size_t grain, FunctionRef<double(std::size_t, std::size_t)> body) {
  return fold_chunks(count, grain, 0.0, body, [](double a, double b) { return a + b; });
}

double parallel_max(std::size_t count, std::size_t grain, double lowest,
                    FunctionRef<double(std::size_t, std::size_t)> body) {
  return fold_chunks(count, grain, lowest, body, [](double a, double b) { return std::max(a, b); });
}

ThreadLimit::ThreadLimit(int threads)
    : control_(new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                       static_cast<std::size_t>(std::max(threads, 1)))) {}

ThreadLimit::~ThreadLimit() {
  delete static_cast<tbb::global_control*>(control_);
}

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace wick
