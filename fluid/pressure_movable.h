#pragma once
/// The term of masses behind closed faces in the pressure equation [Chentanez 2006], with lumped masses M:
///
///   T = ρ h³ D N M⁻¹ Nᵀ Dᵀ         (in the units in which an open face has coefficient 1)
///
/// q_r = p_low - p_high pushes face r along its axis, Nᵀ spreads it to the masses, M⁻¹ makes velocities of them, N
/// brings those back to the faces, D to the cells. The preconditioner knows T as faces of coefficient
///   w_r = ρ h³ sum_k weight_rk / m_k  sum_s weight_sk      (row sums of N M⁻¹ Nᵀ: T is at most that)
/// that is, a sheet of mass m an area is a layer of gas of density m/h. Solved is E = T - W on top of the matrix
/// with faces W. Where masses are light against the gas of a cell, T of jumps that change from face to face is far
/// below W: W is then bounded, and pressure_layer.h makes up for the difference, in more rings of cells the lighter
/// the masses are.
#include "fluid/multigrid_graph.h"
#include "fluid/multigrid_layout.h"
#include "fluid/walls.h"

namespace wick::fluid {

class MovableTerm {
 public:
  /// A cell beside a face that yields to pressure, or in the rings around one that hangs on very light masses.
  struct Cell {
    std::int64_t number;
    std::uint32_t place;  ///< in the arrays of its colour
    std::uint8_t colour;
  };
  /// One such face and the masses that it hangs on.
  struct Row {
    std::uint8_t axis;
    std::int64_t face, twin;           ///< twin: second copy of a periodic face, or -1
    std::int64_t low, high;            ///< cells, -1: outside an open side
    std::int32_t low_slot, high_slot;  ///< the same among cells()
    std::array<std::int32_t, 3> dof;
    std::array<double, 3> weight;
  };

  /// Rows on open faces, on closed sides of the box, or beside a solid cell do not take part; of several rows
  /// on one face only the first does.
  MovableTerm(const Grid& grid, const Sides& sides, const Walls& walls, const MovableWalls& movable,
              double density);

  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }  ///< ascending
  /// Place of a cell among cells(), or -1.
  [[nodiscard]] std::int32_t slot(std::int64_t cell) const;
  /// W, one face a row.
  [[nodiscard]] const std::vector<Graph::WeakFace>& weak_faces() const { return weak_; }
  [[nodiscard]] const std::vector<double>& inverse_mass() const { return inverse_mass_; }
  [[nodiscard]] double coefficient() const { return coefficient_; }  ///< ρ h³ [kg]
  /// True when W alone is no good picture of T: the preconditioner should solve the cells beside the walls exactly.
  [[nodiscard]] bool light() const { return light_; }
  /// p·E p, with p at cells().
  [[nodiscard]] double quadratic(const std::vector<double>& p) const;
  /// out += factor E p, both at cells().
  void add_product(const std::vector<double>& p, double factor, std::vector<double>& out) const;
  /// The values of a field at cells().
  template <class T>
  [[nodiscard]] std::vector<double> gather(const Coloured<T>& p) const;
  /// out += factor E p.
  template <class T>
  void add_product(const Coloured<T>& p, double factor, Coloured<double>& out) const;
  /// Impulse on the masses [N s] of pressure `p` over `dt`; 3 a dof.
  void add_impulse(const std::vector<double>& p, double dt, std::vector<Vec3>& impulse) const;
  /// Adds to the velocity of the wall faces what their masses gained.
  void move_faces(const std::vector<Vec3>& impulse, FaceField& velocity) const;

 private:
  std::vector<double> find_weak_faces();
  void index_cells(const Sides& sides, const Walls& walls, const std::vector<double>& weight);
  void spread_jumps(const std::vector<double>& p) const;

  Grid grid_;
  double coefficient_;
  std::vector<Row> rows_;
  std::vector<Cell> cells_;
  std::vector<Graph::WeakFace> weak_;
  bool light_ = false;
  std::vector<double> inverse_mass_;
  mutable std::vector<double> jump_;  ///< per row
  mutable std::vector<Vec3> push_;    ///< per dof
};

}  // namespace wick::fluid
