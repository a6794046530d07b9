#pragma once
/// Conjugate gradients in double, preconditioned by a float multigrid V-cycle [Tatebe 1993; McAdams 2010], for
///
///   sum over the open faces of a cell of (p_c - p_nb)  [+ E p]  = f_c
///
/// with p = 0 on open sides. E is the optional term of masses that move behind closed faces.
#include <optional>

#include "core/report.h"
#include "fluid/multigrid_install.h"
#include "fluid/pressure_layer.h"
#include "fluid/pressure_movable.h"

namespace wick::fluid {

class Multigrid {
 public:
  Multigrid(const Grid& grid, const Sides& sides);

  /// Rebuilds the levels near the walls: what no old or new wall touches stays. `weak`: see Graph::WeakFace.
  void set_walls(const Walls& walls, const std::vector<Graph::WeakFace>& weak);

  /// Solves to |f - A p| <= tolerance |f|. `p` is the first guess on entry. `f` must be 0 in solid cells; parts
  /// of the fluid without an open side get their mean taken out of f, and mean 0 in p. With a report that has not
  /// converged, p is the best that was reached; when f is not finite p is left alone.
  SolveReport solve(std::vector<double>& f, std::vector<double>& p, const MovableTerm* extra, double tolerance,
                    int max_iterations);

 private:
  void subtract_part_means(std::vector<double>& field, double* removed) const;
  void load(const std::vector<double>& field, double scale, Coloured<double>& out) const;
  void store(const Coloured<double>& in, double scale, std::vector<double>& field) const;
  void subtract_part_means(Coloured<double>& field) const;
  double update_residual(const std::vector<double>& f, double scale, const MovableTerm* extra);
  void add_term(const MovableTerm& extra, double factor, const std::vector<double>& at_cells);
  double turn_direction(double beta, const MovableTerm* extra);
  double advance(double alpha, const MovableTerm* extra);
  void precondition();
  double preconditioned_product() const;
  int iterate(const std::vector<double>& f, double scale, const MovableTerm* extra, double target,
              int max_iterations, double& residual);

  std::vector<Graph> graphs_;
  std::vector<Level> levels_;
  std::vector<Installed> installed_;
  std::vector<std::int32_t> part_;  ///< closed part of each cell, -1: none; empty: no closed part
  int parts_ = 0;
  Coloured<double> x_, r_;
  Coloured<double> best_;  ///< x of the least true residual, once there was a fresh start
  Coloured<float> direction_;
  std::optional<WallLayer> layer_;  ///< beside light masses, for the solve under way
};

}  // namespace wick::fluid
