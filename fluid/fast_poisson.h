#pragma once
/// Exact solution of the discrete Poisson equation in an empty box by fast transforms [Swarztrauber 1977].
///
///   sum over the six neighbours of (p_c - p_nb) = f_c
///
/// The side of the box holds: closed, p_nb = p_c; open, p = 0 on the face (p_nb = -p_c); periodic, p_nb is
/// the cell on the other end. x and y are transformed to the eigenvectors of the second difference; along z
/// a tridiagonal system a mode is left, or, when z is periodic, a third transform.
#include <memory>
#include <vector>

#include "fluid/grid.h"

namespace wick::fluid {

class FastPoisson {
 public:
  FastPoisson(const Int3& cells, const Sides& sides);
  ~FastPoisson();
  FastPoisson(FastPoisson&&) noexcept;
  FastPoisson& operator=(FastPoisson&&) noexcept;

  /// True when no side is open: the solution is then defined up to a constant.
  [[nodiscard]] bool singular() const;

  /// Replaces `f` by the solution. When singular, f must sum to 0 and the solution has mean 0.
  void solve(std::vector<double>& f);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::fluid
