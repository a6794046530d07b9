#pragma once
/// What a person sees of a run: a bar on a terminal, plain lines elsewhere, a table of stages at the end.
#include <cstdio>
#include <string>

#include "coupling/world.h"

namespace wick::scenes {

/// Prints a text where somebody may read it. A run outlives its terminal: that it cannot be printed is no error.
void say(std::FILE* stream, const std::string& text);

class Progress {
 public:
  Progress(int first, int last, bool quiet);
  /// Tells of one computed frame that took `seconds`.
  void frame(const coupling::FrameReport& report, double seconds);
  /// A line of its own, above the bar.
  void note(const std::string& text);
  /// Stage, seconds, share, and what the writer's thread spent meanwhile; nothing when quiet.
  void summary(double wall_seconds, double background_seconds);

 private:
  void clear_bar();

  int first_, last_;
  bool quiet_, bar_, bar_shown_ = false;
  double mean_seconds_ = 0.0;  ///< of the recent frames, for the time left
  double step_seconds_ = 0.0;
  int frames_ = 0;
  StageSeconds stages_;
};

}  // namespace wick::scenes
