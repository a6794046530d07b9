#pragma once
/// The term of masses behind closed faces in the pressure equation [Chentanez 2006], with lumped masses M:
///
///   T = ρ h³ D N M⁻¹ Nᵀ Dᵀ         (in the units in which an open face has coefficient 1)
///
/// q_r = p_low - p_high pushes face r along its axis, Nᵀ spreads it to the masses, M⁻¹ makes velocities of them, N
/// brings those back to the faces, D to the cells. The preconditioner knows T as faces of coefficient
///   w_r = ρ h³ sum_k weight_rk / m_k  sum_s weight_sk      (row sums of N M⁻¹ Nᵀ: T is at most that)
/// that is, a sheet of mass m an area is a layer of gas of density m/h [after the added-mass argument of
/// Chentanez 2006, section 4]. Solved is E = T - W on top of the matrix with faces W.
#include "fluid/multigrid_graph.h"
#include "fluid/multigrid_layout.h"
#include "fluid/walls.h"

namespace wick::fluid {

class MovableTerm {
 public:
  /// Rows on open faces, on closed sides of the box, or beside a solid cell do not take part; of several rows
  /// on one face only the first does.
  MovableTerm(const Grid& grid, const Sides& sides, const Walls& walls, const MovableWalls& movable,
              double density);

  [[nodiscard]] const std::vector<Graph::WeakFace>& weak_faces() const { return weak_; }
  /// p·E p.
  [[nodiscard]] double quadratic(const Coloured<float>& p) const;
  /// out += factor E p.
  template <class T>
  void add_product(const Coloured<T>& p, double factor, Coloured<double>& out) const;
  /// Impulse on the masses [N s] of pressure `p` over `dt`; 3 a dof.
  void add_impulse(const std::vector<double>& p, double dt, std::vector<Vec3>& impulse) const;
  /// Adds to the velocity of the wall faces what their masses gained.
  void move_faces(const std::vector<Vec3>& impulse, FaceField& velocity) const;

 private:
  struct Row {
    std::uint8_t axis;
    std::int64_t face, twin;  ///< twin: second copy of a periodic face, or -1
    std::int64_t low, high;   ///< cells, -1: outside an open side
    std::uint32_t low_at, high_at;
    std::uint8_t low_colour, high_colour;
    std::array<std::int32_t, 3> dof;
    std::array<double, 3> weight;
  };

  template <class T>
  void spread_jumps(const Coloured<T>& p) const;

  Grid grid_;
  double coefficient_;  ///< ρ h³
  std::vector<Row> rows_;
  std::vector<Graph::WeakFace> weak_;
  std::vector<double> inverse_mass_;
  mutable std::vector<double> jump_;  ///< per row
  mutable std::vector<Vec3> push_;    ///< per dof
};

}  // namespace wick::fluid
