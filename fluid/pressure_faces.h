#pragma once
/// Which faces let fluid through, and what the projection does to the velocities on them, row by row.
#include "fluid/walls.h"

namespace wick::fluid {

class FaceRows {
 public:
  /// `walls` may be null: only the sides of the box close faces then.
  FaceRows(const Grid& grid, const Sides& sides, const Walls* walls)
      : grid_(grid), sides_(sides), walls_(walls != nullptr && walls->any ? walls : nullptr) {}

  [[nodiscard]] const Walls* walls() const { return walls_; }

  /// Gives every closed face the velocity of its wall and both copies of a periodic face one value.
  void set_wall_velocity(FaceField& velocity) const;
  /// u -= factor (p_high - p_low) on open faces; p = 0 on the face of an open side, half a cell away.
  void subtract_gradient(const std::vector<double>& p, double factor, FaceField& velocity) const;
  /// Net outflow of the cells of row (j, k) as a velocity, h div u.
  void outflow(const FaceField& velocity, int j, int k, double* out) const;

 private:
  /// Cells of the rows below and above the faces of row (j, k); -1: beyond a side of the box.
  struct Rows {
    std::int64_t low, high;
  };
  [[nodiscard]] Rows rows_beside(int axis, int j, int k) const;
  [[nodiscard]] bool wraps(int axis) const { return sides_[2 * axis] == Side::periodic; }
  [[nodiscard]] int count(int axis) const { return grid_.nx + (axis == 0); }
  /// closed[i] != 0 where no fluid passes face i of row (j, k).
  void closed_row(int axis, int j, int k, std::uint8_t* closed) const;
  void closed_row_x(int j, int k, std::uint8_t* closed) const;
  /// The first of the two rows in which a row of periodic faces is stored, or the row itself.
  [[nodiscard]] std::size_t first_copy(int axis, int j, int k) const;
  void set_row(int axis, int j, int k, const std::uint8_t* closed, std::vector<float>& u) const;
  template <class Body>
  void for_face_rows(int axis, Body&& body) const;

  const Grid& grid_;
  const Sides& sides_;
  const Walls* walls_;
};

}  // namespace wick::fluid
