#pragma once
/// Small records that every stage hands back, gathered by the world into metrics.
#include <chrono>
#include <map>
#include <string>

namespace wick {

/// What an iterative solve did. Residuals are true ones (recomputed from the solution), relative to
/// the right-hand side in the 2-norm.
struct SolveReport {
  int iterations = 0;
  double residual_before = 0.0;
  double residual_after = 0.0;
  double rhs_sum = 0.0;  ///< compatibility of a closed box: 0 up to rounding when solvable
  bool converged = true;
  double seconds = 0.0;
};

/// Seconds by stage, added up over the substeps of a frame.
using StageSeconds = std::map<std::string, double>;

/// Adds the time it lives to one stage.
class StageTimer {
 public:
  StageTimer(StageSeconds& stages, const std::string& stage)
      : seconds_(stages[stage]), start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace wick
