#pragma once
/// What should not happen often in a run: counted frame by frame, told once at its end.
#include <map>
#include <string>
#include <vector>

#include "coupling/world.h"

namespace wick::scenes {

class RareEvents {
 public:
  void add(const coupling::FrameReport& report);
  /// What the sheets (by name, as metrics) and the books show at the end of a frame.
  void look_at(int frame, const std::map<std::string, std::map<std::string, double>>& shells,
               const std::map<std::string, Ledger>& ledgers);
  /// Replaces the count of unconverged solves by that of the frames so far, of earlier processes too.
  void set_unconverged(long long solves) { unconverged_solves_ = solves; }
  [[nodiscard]] long long unconverged_solves() const { return unconverged_solves_; }
  /// One sentence for each kind that has happened.
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  long long unconverged_solves_ = 0;
  long long lengthened_steps_ = 0;
  long long squeezed_steps_ = 0;
  struct Stretch {
    double strain = 0.0;
    int frame = 0;
  };
  std::map<std::string, Stretch> stretched_;  ///< most of each shell that ever was beyond what cloth and paper do
  std::map<std::string, double> walled_in_;   ///< by quantity: share that sealed pockets took out, where not small
};

}  // namespace wick::scenes
