#include "fluid/pressure_movable.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace wick::fluid {

namespace {

/// A coefficient that floats add up without rounding: a multiple of 2⁻¹⁶ up to 2⁷. Rows of the matrix then sum to
/// exactly 0, and constant pressure in a closed box stays without effect. E takes up the difference.
float dyadic(double w) {
  if (w <= 0.0) return 0.0F;
  return static_cast<float>(std::ldexp(std::clamp(std::round(std::ldexp(w, 16)), 1.0, std::ldexp(1.0, 23)), -16));
}

}  // namespace

MovableTerm::MovableTerm(const Grid& grid, const Sides& sides, const Walls& walls, const MovableWalls& movable,
                         double density)
    : grid_(grid), coefficient_(density * grid.h * grid.h * grid.h), inverse_mass_(movable.inverse_mass) {
  const Layout layout({grid.nx, grid.ny, grid.nz});
  std::set<std::pair<int, std::int64_t>> seen;
  for (std::size_t r = 0; r < movable.face.size(); ++r) {
    const int a = movable.axis[r];
    const std::int64_t face = movable.face[r];
    const Int3 faces = {grid.nx + (a == 0), grid.ny + (a == 1), grid.nz + (a == 2)};
    Int3 high = {int(face % faces[0]), int(face / faces[0] % faces[1]),
                 int(face / (std::int64_t(faces[0]) * faces[1]))};
    Int3 low = high;
    --low[a];
    Row row{.axis = movable.axis[r],
            .face = face,
            .twin = -1,
            .low = -1,
            .high = -1,
            .low_at = 0,
            .high_at = 0,
            .low_colour = 0,
            .high_colour = 0,
            .dof = movable.dof[r],
            .weight = movable.weight[r]};

    // Find the cells on both sides; a periodic face is stored twice and named by its lower copy.
    const int n = grid.size(a);
    if (sides[2 * a] == Side::periodic && (high[a] == 0 || high[a] == n)) {
      if (n == 1) continue;
      high[a] = 0;
      low[a] = n - 1;
      Int3 first = high, last = high;
      last[a] = n;
      row.face = std::int64_t(grid.face(a, first[0], first[1], first[2]));
      row.twin = std::int64_t(grid.face(a, last[0], last[1], last[2]));
    }
    const bool below = low[a] < 0, above = high[a] >= n;
    if ((below && sides[2 * a] == Side::closed) || (above && sides[2 * a + 1] == Side::closed)) continue;
    if (!below) row.low = std::int64_t(grid.cell(low[0], low[1], low[2]));
    if (!above) row.high = std::int64_t(grid.cell(high[0], high[1], high[2]));
    if ((row.low >= 0 && walls.solid[row.low]) || (row.high >= 0 && walls.solid[row.high])) continue;
    const bool closed = walls.closed[a][face] != 0;
    if (!closed || !seen.insert({a, row.face}).second) continue;

    if (!below) {
      row.low_colour = static_cast<std::uint8_t>(Layout::colour(low[0], low[1], low[2]));
      row.low_at = static_cast<std::uint32_t>(layout.place(low[0], low[1], low[2]));
    }
    if (!above) {
      row.high_colour = static_cast<std::uint8_t>(Layout::colour(high[0], high[1], high[2]));
      row.high_at = static_cast<std::uint32_t>(layout.place(high[0], high[1], high[2]));
    }
    rows_.push_back(row);
  }
  jump_.resize(rows_.size());
  push_.assign(inverse_mass_.size(), Vec3::Zero());

  // Row sums of N M⁻¹ Nᵀ, axis by axis: velocities along different axes do not mix.
  for (const Row& row : rows_)
    for (int k = 0; k < 3; ++k) push_[row.dof[k]][row.axis] += row.weight[k];
  for (const Row& row : rows_) {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += row.weight[k] * inverse_mass_[row.dof[k]] * push_[row.dof[k]][row.axis];
    weak_.push_back({row.axis, row.face, dyadic(coefficient_ * sum)});
  }
}

template <class T>
void MovableTerm::spread_jumps(const Coloured<T>& p) const {
  for (Vec3& push : push_) push.setZero();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const double low = row.low >= 0 ? double(p[row.low_colour][row.low_at]) : 0.0;
    const double high = row.high >= 0 ? double(p[row.high_colour][row.high_at]) : 0.0;
    jump_[r] = low - high;
    for (int k = 0; k < 3; ++k) push_[row.dof[k]][row.axis] += row.weight[k] * jump_[r];
  }
}

double MovableTerm::quadratic(const Coloured<float>& p) const {
  spread_jumps(p);
  double sum = 0.0;
  for (std::size_t d = 0; d < push_.size(); ++d) sum += coefficient_ * inverse_mass_[d] * push_[d].squaredNorm();
  for (std::size_t r = 0; r < rows_.size(); ++r) sum -= double(weak_[r].weight) * jump_[r] * jump_[r];
  return sum;
}

template <class T>
void MovableTerm::add_product(const Coloured<T>& p, double factor, Coloured<double>& out) const {
  spread_jumps(p);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    double flow = 0.0;
    for (int k = 0; k < 3; ++k) flow += row.weight[k] * inverse_mass_[row.dof[k]] * push_[row.dof[k]][row.axis];
    const double value = factor * (coefficient_ * flow - double(weak_[r].weight) * jump_[r]);
    if (row.low >= 0) out[row.low_colour][row.low_at] += value;
    if (row.high >= 0) out[row.high_colour][row.high_at] -= value;
  }
}
template void MovableTerm::add_product(const Coloured<float>&, double, Coloured<double>&) const;
template void MovableTerm::add_product(const Coloured<double>&, double, Coloured<double>&) const;

void MovableTerm::add_impulse(const std::vector<double>& p, double dt, std::vector<Vec3>& impulse) const {
  impulse.resize(inverse_mass_.size(), Vec3::Zero());
  for (const Row& row : rows_) {
    const double jump = (row.low >= 0 ? p[row.low] : 0.0) - (row.high >= 0 ? p[row.high] : 0.0);
    for (int k = 0; k < 3; ++k) impulse[row.dof[k]][row.axis] += row.weight[k] * dt * grid_.h * grid_.h * jump;
  }
}

void MovableTerm::move_faces(const std::vector<Vec3>& impulse, FaceField& velocity) const {
  for (const Row& row : rows_) {
    double gain = 0.0;
    for (int k = 0; k < 3; ++k) gain += row.weight[k] * inverse_mass_[row.dof[k]] * impulse[row.dof[k]][row.axis];
    velocity[row.axis][row.face] += static_cast<float>(gain);
    if (row.twin >= 0) velocity[row.axis][row.twin] = velocity[row.axis][row.face];
  }
}

}  // namespace wick::fluid
