#pragma once
/// Transport along one axis, the building block of transport in flux form: rows of eight cells at a time, in place.
///
/// A cell of air density rho holds the mixing ratio chi = q/rho, linear within the cell with half slope
/// s = ab/(a+b) if ab > 0 else 0 [van Leer 1974], a and b the differences to the cells behind and ahead. In a sweep
/// the air c crosses a face and takes with it the mean of that part of the line,
///   f = c (chi +- (1 - |c|/rho) s)  of the cell that it leaves.
/// Each new value is then a mean of parts of old ones as long as no more air leaves a cell than it has.
#include <array>
#include <span>
#include <vector>

#include "fluid/grid.h"

namespace wick::fluid {

/// Courant numbers of the faces, 0 on closed ones; room for `sweep_slack` more values behind the end.
constexpr std::size_t sweep_slack = 16;
using Courant = std::array<std::vector<float>, 3>;

/// The axes whose sweeps have been made since the air density was 1, a bit each.
enum Swept : unsigned { swept_none = 0, swept_x = 1, swept_y = 2, swept_z = 4 };

/// Rows of scratch of one task. `grid`, `sides` and `courant` must outlive it.
class Sweeper {
 public:
  Sweeper(const Grid& grid, const Sides& sides, const Courant& courant);

  /// Sweeps `q` along x or y through plane k, or along z through the cells of row j of all planes. `swept`: axes
  /// swept before. Returns what went out through open sides.
  double along_x(float* q, int k, unsigned swept);
  double along_y(float* q, int k, unsigned swept);
  double along_z(float* q, int j, unsigned swept);

  /// True if the plane k, or the row j of all planes, holds nothing but zeros: then sweeps within it change
  /// nothing.
  [[nodiscard]] bool empty_plane(const float* q, int k) const;
  [[nodiscard]] bool empty_slab(const float* q, int j) const;

 private:
  struct Line;
  double along(const Line& line);
  void enter(const Line& line, int p);
  void pass(const Line& line, int p, const float* ahead);
  double out_of_row(const std::vector<float>& flux, double sign) const;
  void inverse_density(int j, int k, unsigned swept, float* out) const;
  double sweep_row(float* q, const float* c);

  const Grid& grid_;
  const Sides& sides_;
  const Courant& courant_;
  // Rows of the cell behind, the present one and the one ahead of it; each row has `slack` ghosts at both ends.
  static constexpr int slack = 8;
  std::array<std::vector<float>, 3> ratio_, air_;
  std::array<std::vector<float>, 2> slope_, flux_;
  std::array<bool, 3> live_{};  ///< the row holds anything but zeros
  std::array<bool, 2> live_flux_{};
  std::vector<float> first_ratio_, first_flux_;
  bool first_live_ = false;
};

}  // namespace wick::fluid
