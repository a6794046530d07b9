#include "fluid/pressure_faces.h"

#include <algorithm>

#include "core/parallel.h"

namespace wick::fluid {

template <class Body>
void FaceRows::for_face_rows(int axis, Body&& body) const {
  const int ny = grid_.ny + (axis == 1), nz = grid_.nz + (axis == 2);
  parallel_chunks(nz, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint8_t> closed(count(axis));
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < ny; ++j) {
        closed_row(axis, j, static_cast<int>(k), closed.data());
        body(j, static_cast<int>(k), closed.data());
      }
  });
}

FaceRows::Rows FaceRows::rows_beside(int axis, int j, int k) const {
  const auto row = [&](int jj, int kk) {
    return static_cast<std::int64_t>(grid_.nx) * (jj + std::int64_t(grid_.ny) * kk);
  };
  const int n = grid_.size(axis), at = axis == 1 ? j : k;
  int below = at - 1, above = at;
  if (at == 0) below = wraps(axis) ? n - 1 : -1;
  if (at == n) above = wraps(axis) ? 0 : -1;
  const auto of = [&](int place) { return place < 0 ? -1 : axis == 1 ? row(place, k) : row(j, place); };
  return {of(below), of(above)};
}

std::size_t FaceRows::first_copy(int axis, int j, int k) const {
  if (axis == 1 && wraps(1) && j == grid_.ny) j = 0;
  if (axis == 2 && wraps(2) && k == grid_.nz) k = 0;
  return grid_.face(axis, 0, j, k);
}

void FaceRows::closed_row_x(int j, int k, std::uint8_t* closed) const {
  const int n = grid_.nx;
  const bool around = wraps(0);
  std::fill_n(closed, n + 1, std::uint8_t{0});
  if (walls_ != nullptr) {
    const std::uint8_t* marks = walls_->closed[0].data() + grid_.face(0, 0, j, k);
    const std::uint8_t* solid = walls_->solid.data() + grid_.cell(0, j, k);
    for (int i = 0; i < n; ++i) closed[i] = marks[i] | solid[i];
    closed[n] = marks[n];
    for (int i = 0; i < n; ++i) closed[i + 1] |= solid[i];
    if (around) closed[0] = closed[n] = closed[0] | closed[n];
  }
  if (sides_[0] == Side::closed) closed[0] = 1;
  if (sides_[1] == Side::closed) closed[n] = 1;
}

void FaceRows::closed_row(int axis, int j, int k, std::uint8_t* closed) const {
  if (axis == 0) return closed_row_x(j, k, closed);
  const Rows rows = rows_beside(axis, j, k);
  const bool shut =
      (rows.low < 0 && sides_[2 * axis] == Side::closed) || (rows.high < 0 && sides_[2 * axis + 1] == Side::closed);
  const int nx = grid_.nx;
  std::fill_n(closed, nx, static_cast<std::uint8_t>(shut ? 1 : 0));
  if (walls_ == nullptr || shut) return;
  const auto add = [closed, nx](const std::uint8_t* marks) {
    for (int i = 0; i < nx; ++i) closed[i] |= marks[i];
  };
  add(walls_->closed[axis].data() + grid_.face(axis, 0, j, k));
  if (rows.low >= 0) add(walls_->solid.data() + rows.low);
  if (rows.high >= 0) add(walls_->solid.data() + rows.high);
  // Both copies of a periodic face count.
  if (wraps(axis) && (axis == 1 ? j : k) % grid_.size(axis) == 0) {
    const int other = (axis == 1 ? j : k) == 0 ? grid_.size(axis) : 0;
    add(walls_->closed[axis].data() + (axis == 1 ? grid_.face(1, 0, other, k) : grid_.face(2, 0, j, other)));
  }
}

void FaceRows::set_row(int axis, int j, int k, const std::uint8_t* closed, std::vector<float>& u) const {
  const std::size_t row = grid_.face(axis, 0, j, k), first = first_copy(axis, j, k);
  const int n = count(axis);
  if (walls_ == nullptr) {
    for (int i = 0; i < n; ++i) u[row + i] = closed[i] ? 0.0F : u[row + i];
    return;
  }
  const auto& marks = walls_->closed[axis];
  const auto& wall = walls_->velocity[axis];
  // A closed face that is not marked bounds a solid cell or the box and rests. Of two copies the first decides.
  for (int i = 0; i < n; ++i) {
    if (!closed[i]) continue;
    const bool last_of_two = axis == 0 && i == grid_.nx && wraps(0);
    const std::size_t leader = last_of_two ? row : first + i;
    u[row + i] = marks[leader] ? wall[leader] : marks[row + i] ? wall[row + i] : 0.0F;
  }
}

void FaceRows::set_wall_velocity(FaceField& velocity) const {
  for (int a = 0; a < 3; ++a)
    for_face_rows(a, [&](int j, int k, const std::uint8_t* closed) { set_row(a, j, k, closed, velocity[a]); });
  // Make both copies of periodic faces equal.
  for (int a = 0; a < 3; ++a) {
    if (!wraps(a)) continue;
    auto& u = velocity[a];
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (int m = 0; m < grid_.size(b); ++m)
      for (int l = 0; l < grid_.size(c); ++l) {
        Int3 low{}, high{};
        low[b] = high[b] = m;
        low[c] = high[c] = l;
        high[a] = grid_.size(a);
        u[grid_.face(a, high[0], high[1], high[2])] = u[grid_.face(a, low[0], low[1], low[2])];
      }
  }
}

void FaceRows::subtract_gradient(const std::vector<double>& p, double factor, FaceField& velocity) const {
  for_face_rows(0, [&](int j, int k, const std::uint8_t* closed) {
    float* u = velocity[0].data() + grid_.face(0, 0, j, k);
    const double* row = p.data() + grid_.cell(0, j, k);
    const int n = grid_.nx;
    for (int i = 1; i < n; ++i)
      u[i] = static_cast<float>(double(u[i]) - (closed[i] ? 0.0 : factor * (row[i] - row[i - 1])));
    const double around = row[0] - row[n - 1];
    if (!closed[0]) u[0] = static_cast<float>(double(u[0]) - factor * (wraps(0) ? around : 2.0 * row[0]));
    if (!closed[n]) u[n] = static_cast<float>(double(u[n]) - factor * (wraps(0) ? around : -2.0 * row[n - 1]));
  });
  for (int a = 1; a < 3; ++a)
    for_face_rows(a, [&](int j, int k, const std::uint8_t* closed) {
      float* u = velocity[a].data() + grid_.face(a, 0, j, k);
      const Rows rows = rows_beside(a, j, k);
      const double* low = rows.low >= 0 ? p.data() + rows.low : nullptr;
      const double* high = rows.high >= 0 ? p.data() + rows.high : nullptr;
      for (int i = 0; i < grid_.nx; ++i) {
        const double jump = low == nullptr ? 2.0 * high[i] : high == nullptr ? -2.0 * low[i] : high[i] - low[i];
        u[i] = static_cast<float>(double(u[i]) - (closed[i] ? 0.0 : factor * jump));
      }
    });
}

void FaceRows::outflow(const FaceField& velocity, int j, int k, double* out) const {
  const auto& [u, v, w] = velocity;
  const float* x = u.data() + grid_.face(0, 0, j, k);
  const float *y0 = v.data() + grid_.face(1, 0, j, k), *y1 = v.data() + grid_.face(1, 0, j + 1, k);
  const float *z0 = w.data() + grid_.face(2, 0, j, k), *z1 = w.data() + grid_.face(2, 0, j, k + 1);
  for (int i = 0; i < grid_.nx; ++i)
    out[i] = (double(x[i + 1]) - double(x[i])) + (double(y1[i]) - double(y0[i])) + (double(z1[i]) - double(z0[i]));
}

}  // namespace wick::fluid
