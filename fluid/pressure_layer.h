#pragma once
/// Exact solve on the layer of cells beside light movable walls, as a second half of the preconditioner.
///
/// Let A = B + E be the pressure matrix (see pressure_movable.h), V the multigrid cycle for B and Z the columns of
/// the identity that belong to the layer. The preconditioner is the adapted deflation A-DEF2 of [Tang 2009],
///
///   z = V r,   z += Z (Zᵀ A Z)⁻¹ Zᵀ (r - A z)
///
/// so that what V does not know, masses that tie the jumps of many faces together, is solved exactly however light
/// they are. Zᵀ A Z is never formed: with the velocities of the masses as unknowns of their own,
///
///   [ L    G          ]            Zᵀ A Z = L + G (ρ h³ M⁻¹) Gᵀ,  G = D N
///   [ Gᵀ  -M/(ρ h³) ]
///
/// is sparse however coarse the mesh is against the grid, and quasi-definite, so that it has a factorisation L D Lᵀ
/// in any order [Vanderbei 1995].
///
/// The layer keeps the directions of conjugate gradients in double at its cells: light masses make of the rounding
/// of a float, 6e-8 of the pressure, a flow ρ h³/m times as large, and the residual would not fall below it.
#include <memory>

#include "fluid/multigrid_level.h"
#include "fluid/pressure_movable.h"

namespace wick::fluid {

class WallLayer {
 public:
  /// Factorises for the cells of `term`, which must live as long. `finest` holds B.
  WallLayer(const Level& finest, const MovableTerm& term);
  ~WallLayer();
  WallLayer(WallLayer&&) noexcept;
  WallLayer& operator=(WallLayer&&) noexcept;

  /// z += Z (Zᵀ A Z)⁻¹ Zᵀ (r - A z).
  void correct(const Coloured<double>& r, Coloured<float>& z);
  /// d = z + beta d, with the z of the last correction.
  void turn(double beta);
  /// d at the cells of the term.
  [[nodiscard]] const std::vector<double>& direction() const;
  /// x += alpha e, r -= alpha B e, with e what `rounded` lacks of the direction.
  void advance(double alpha, const Coloured<float>& rounded, Coloured<double>& x, Coloured<double>& r) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::fluid
