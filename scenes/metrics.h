#pragma once
/// metrics.h5: one row a frame. The table lives in memory and goes into every checkpoint; the file is built
/// anew each frame and replaced whole, so a crash never costs an earlier frame.
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "coupling/world.h"
#include "scenes/atomic_file.h"

namespace wick::scenes {

/// Seconds that the simulation waited for the outputs of a frame, and seconds that the writer's thread spent on
/// them meanwhile. The row of a frame is made before its files are written, so it says what is known by then; later
/// rows, and the file at the end of the run, complete it.
inline constexpr const char* output_timing = "/timing/output";
inline constexpr const char* background_timing = "/timing/output_background";

class Metrics {
 public:
  using Row = std::map<std::string, double>;  ///< by path in the file, as in /timing/smoke

  /// Adds the row of one frame. A path seen for the first time is filled backwards, one that is missing is
  /// filled: amounts, times, counts and residuals by 0, anything else by NaN.
  void add(const Row& row, std::uint64_t state_hash);

  /// Replaces one value of the row of `frame`.
  void set(int frame, const std::string& path, double value);

  /// Takes what outputs cost from `file`, a metrics.h5, for the first rows of which it tells the same states.
  /// Throws std::runtime_error where it is no such file; to be asked of verified bytes only.
  void recall_output_times(std::string_view file);

  [[nodiscard]] std::size_t rows() const { return state_hash_.size(); }
  [[nodiscard]] std::uint64_t last_hash() const { return state_hash_.empty() ? 0 : state_hash_.back(); }
  /// All values of one path; null where there is none.
  [[nodiscard]] const std::vector<double>* column(const std::string& path) const;
  [[nodiscard]] const std::map<std::string, std::vector<double>>& columns() const { return columns_; }

  /// The bytes of metrics.h5.
  [[nodiscard]] Bytes file() const;
  void visit(StateVisitor& visitor);

 private:
  std::map<std::string, std::vector<double>> columns_;
  std::vector<std::uint64_t> state_hash_;
};

/// The row of the frame that `world` has just reached.
Metrics::Row metrics_row(const coupling::World& world, const coupling::FrameReport& report);

}  // namespace wick::scenes
