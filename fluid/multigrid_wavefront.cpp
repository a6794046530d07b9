#include "fluid/multigrid_wavefront.h"

#include <algorithm>

#include "core/parallel.h"

namespace wick::fluid {

namespace {

/// All stages over planes [begin, end), each stage a plane behind the one before. At an inner end the range
/// shrinks by a plane a stage.
void trapezoid(int begin, int end, bool inner_begin, bool inner_end, int stages, FunctionRef<void(int, int)> body) {
  for (int front = begin; front < end + stages - 1; ++front)
    for (int stage = 0; stage < stages; ++stage) {
      const int plane = front - stage;
      const int first = begin + (inner_begin ? stage : 0), last = end - (inner_end ? stage : 0);
      if (plane >= first && plane < last) body(stage, plane);
    }
}

}  // namespace

void wavefront(int planes, int stages, bool parallel, FunctionRef<void(int, int)> body) {
  // A few trapezoids a thread balance the load; each must be wide enough to keep its top.
  const int widest = parallel ? 2 * thread_count() : 1;
  const int pieces = thread_count() == 1 ? 1 : std::clamp(planes / (2 * stages + 2), 1, widest);
  // Ends are even, so that pairs of planes are never torn apart.
  const auto cut = [&](int piece) { return piece == pieces ? planes : planes * piece / pieces / 2 * 2; };
  parallel_chunks(pieces, 1, [&](std::size_t first, std::size_t last) {
    for (int piece = static_cast<int>(first); piece < static_cast<int>(last); ++piece)
      trapezoid(cut(piece), cut(piece + 1), piece > 0, piece + 1 < pieces, stages, body);
  });
  parallel_chunks(pieces - 1, 1, [&](std::size_t first, std::size_t last) {
    for (int piece = static_cast<int>(first); piece < static_cast<int>(last); ++piece)
      for (int stage = 1; stage < stages; ++stage)
        for (int plane = cut(piece + 1) - stage; plane < cut(piece + 1) + stage; ++plane) body(stage, plane);
  });
}

}  // namespace wick::fluid
