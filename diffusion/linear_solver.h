#pragma once
/// Solves the symmetric positive definite systems of implicit diffusion.
///
/// Conjugate gradients on the deviation from the mean: u = m + v, with m the mean that the row sums of A fix in
/// each component, so that steps far beyond the sheet's own diffusion time lose no digits. The preconditioner is
/// the diagonal while the spectrum of the present matrix promises few iterations; beyond that it is the factor of
/// a reference matrix (rest shape, uniform density, rounded time step). That matrix is a function of the present
/// one alone, so a run continued from a checkpoint takes the same decisions and gives the same bits.
#include <memory>
#include <vector>

#include "core/report.h"
#include "diffusion/operators.h"

namespace wick::diffusion {

/// Iterations above which a factorisation pays: two triangular solves cost about ten products.
inline constexpr double factor_threshold = 100.0;

/// Iterations that diagonal CG will need, from the mean ratio of diagonal to row sum (2 d/s bounds the condition
/// number, √κ/2 ln(2/ε) the iterations; warm starts are measured to save half of those).
double estimated_iterations(const SheetMatrix& matrix, double tolerance);

class LinearSolver {
 public:
  LinearSolver();
  ~LinearSolver();
  LinearSolver(LinearSolver&&) noexcept;
  LinearSolver& operator=(LinearSolver&&) noexcept;

  /// Solves A x = b from the guess in x. Rows are weighted by storage over row sum, so that a stiff supply, whose
  /// rows are large and easily solved, does not hide the residual of the others; without supply the weights are 1.
  SolveReport solve(const SheetMatrix& matrix, const std::vector<double>& rhs, double tolerance,
                    std::vector<double>& x);

  /// Forgets factors: the mesh has changed.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::diffusion
