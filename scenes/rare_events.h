#pragma once
/// What should not happen often in a run: counted frame by frame, told once at its end.
#include <string>
#include <vector>

#include "coupling/world.h"

namespace wick::scenes {

class RareEvents {
 public:
  void add(const coupling::FrameReport& report);
  /// Replaces the count of unconverged solves by that of the frames so far, of earlier processes too.
  void set_unconverged(long long solves) { unconverged_solves_ = solves; }
  [[nodiscard]] long long unconverged_solves() const { return unconverged_solves_; }
  /// One sentence for each kind that has happened.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  long long unconverged_solves_ = 0;
  long long lengthened_steps_ = 0;
  long long squeezed_steps_ = 0;
};

}  // namespace wick::scenes
