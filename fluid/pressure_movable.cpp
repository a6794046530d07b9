#include "fluid/pressure_movable.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace wick::fluid {

namespace {

/// A coefficient that floats add up without rounding: a multiple of 2⁻¹⁶ up to 2⁷. Rows of the matrix then sum to
/// exactly 0, and constant pressure in a closed box stays without effect. E takes up the difference.
float dyadic(double w) {
  if (w <= 0.0) return 0.0F;
  return static_cast<float>(std::ldexp(std::clamp(std::round(std::ldexp(w, 16)), 1.0, std::ldexp(1.0, 23)), -16));
}

/// Face coefficient from which masses count as light: above it the jumps of faces that hang on one mass tell.
constexpr double light_weight = 0.05;
/// Largest coefficient that the multigrid gets to see where light masses are solved for exactly beside it: more
/// would only make it trust W where T does not follow it, less would close faces that are all but open.
constexpr double most_weight = 4.0;

constexpr int most_rings = 3;
/// Rings of cells, besides those beside the face itself, that are solved for exactly around a face of coefficient
/// w. A sheet much lighter than the gas is a net of short cuts along its steps from cell to cell: it evens out the
/// pressure beside it over distances that grow with w, and W, bounded as it is, does not. Each ring moves the cells
/// for which the multigrid is wrong about that further from the sheet.
int rings_around(double w) {
  return w < 100.0 ? 0 : w < 400.0 ? 1 : w < 1600.0 ? 2 : most_rings;
}

void sort_unique(std::vector<std::int64_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Appends to a list of cells those behind their open faces.
void add_ring(const Grid& grid, const Sides& sides, const Walls& walls, std::vector<std::int64_t>& numbers) {
  const std::size_t inner = numbers.size();
  for (std::size_t c = 0; c < inner; ++c) {
    const std::int64_t row = numbers[c] / grid.nx;
    const Int3 at = {int(numbers[c] % grid.nx), int(row % grid.ny), int(row / grid.ny)};
    for (int side = 0; side < 6; ++side) {
      const int a = side / 2;
      Int3 face = at, other = at;
      face[a] += side % 2;
      other[a] += side % 2 == 0 ? -1 : 1;
      if (other[a] < 0 || other[a] >= grid.size(a)) {
        if (sides[side] != Side::periodic) continue;
        other[a] = other[a] < 0 ? grid.size(a) - 1 : 0;
      }
      const std::size_t cell = grid.cell(other[0], other[1], other[2]);
      if (walls.closed[a][grid.face(a, face[0], face[1], face[2])] == 0 && walls.solid[cell] == 0)
        numbers.push_back(std::int64_t(cell));
    }
  }
}

/// Finds the cells on both sides of faces, and leaves out the faces that no pressure can push.
class RowFinder {
 public:
  RowFinder(const Grid& grid, const Sides& sides, const Walls& walls) : grid_(grid), sides_(sides), walls_(walls) {}

  [[nodiscard]] std::optional<MovableTerm::Row> find(const MovableWalls& movable, std::size_t r) const {
    const int a = movable.axis[r], n = grid_.size(a);
    Int3 high = place(a, movable.face[r]), low = high;
    --low[a];
    MovableTerm::Row row{};
    row.axis = movable.axis[r];
    row.face = movable.face[r];
    row.twin = row.low = row.high = -1;
    row.dof = movable.dof[r];
    row.weight = movable.weight[r];
    // A periodic face is stored twice and named by its lower copy.
    if (sides_[2 * a] == Side::periodic && (high[a] == 0 || high[a] == n)) {
      if (n == 1) return {};
      high[a] = n;
      row.twin = std::int64_t(grid_.face(a, high[0], high[1], high[2]));
      high[a] = 0;
      row.face = std::int64_t(grid_.face(a, high[0], high[1], high[2]));
      low[a] = n - 1;
    }
    if (walls_.closed[a][movable.face[r]] == 0) return {};
    if (low[a] < 0 ? sides_[2 * a] == Side::closed : !join(low, row.low)) return {};
    if (high[a] >= n ? sides_[2 * a + 1] == Side::closed : !join(high, row.high)) return {};
    return row;
  }

 private:
  [[nodiscard]] Int3 place(int a, std::int64_t face) const {
    const std::int64_t nx = grid_.nx + (a == 0), ny = grid_.ny + (a == 1);
    return {int(face % nx), int(face / nx % ny), int(face / (nx * ny))};
  }
  /// Fills in the cell on one side of a row; false where it is solid.
  bool join(const Int3& at, std::int64_t& cell) const {
    cell = std::int64_t(grid_.cell(at[0], at[1], at[2]));
    return walls_.solid[cell] == 0;
  }

  const Grid& grid_;
  const Sides& sides_;
  const Walls& walls_;
};

}  // namespace

MovableTerm::MovableTerm(const Grid& grid, const Sides& sides, const Walls& walls, const MovableWalls& movable,
                         double density)
    : grid_(grid), coefficient_(density * grid.h * grid.h * grid.h), inverse_mass_(movable.inverse_mass) {
  const RowFinder finder(grid, sides, walls);
  std::set<std::pair<int, std::int64_t>> seen;
  for (std::size_t r = 0; r < movable.face.size(); ++r)
    if (const std::optional<Row> row = finder.find(movable, r); row && seen.insert({row->axis, row->face}).second)
      rows_.push_back(*row);
  jump_.resize(rows_.size());
  push_.assign(inverse_mass_.size(), Vec3::Zero());
  index_cells(sides, walls, find_weak_faces());
}

void MovableTerm::index_cells(const Sides& sides, const Walls& walls, const std::vector<double>& weight) {
  const Layout layout({grid_.nx, grid_.ny, grid_.nz});
  std::vector<std::int64_t> numbers;
  for (int rings = most_rings; rings >= 0; --rings) {
    add_ring(grid_, sides, walls, numbers);
    for (std::size_t r = 0; r < rows_.size(); ++r)
      for (const std::int64_t cell : {rows_[r].low, rows_[r].high})
        if (cell >= 0 && rings_around(weight[r]) == rings) numbers.push_back(cell);
    sort_unique(numbers);
  }
  for (const std::int64_t number : numbers) {
    const int i = int(number % grid_.nx), j = int(number / grid_.nx % grid_.ny);
    const int k = int(number / (std::int64_t(grid_.nx) * grid_.ny));
    cells_.push_back({number, static_cast<std::uint32_t>(layout.place(i, j, k)),
                      static_cast<std::uint8_t>(Layout::colour(i, j, k))});
  }
  for (Row& row : rows_) {
    row.low_slot = slot(row.low);
    row.high_slot = slot(row.high);
  }
}

std::int32_t MovableTerm::slot(std::int64_t cell) const {
  const auto at = std::lower_bound(cells_.begin(), cells_.end(), cell,
                                   [](const Cell& c, std::int64_t number) { return c.number < number; });
  return at != cells_.end() && at->number == cell ? static_cast<std::int32_t>(at - cells_.begin()) : -1;
}

/// W from the row sums of N M⁻¹ Nᵀ, axis by axis: velocities along different axes do not mix. Returns the row sums.
std::vector<double> MovableTerm::find_weak_faces() {
  for (const Row& row : rows_)
    for (int k = 0; k < 3; ++k) push_[row.dof[k]][row.axis] += row.weight[k];
  std::vector<double> weight;
  for (const Row& row : rows_) {
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += row.weight[k] * inverse_mass_[row.dof[k]] * push_[row.dof[k]][row.axis];
    weight.push_back(coefficient_ * sum);
    light_ = light_ || weight.back() > light_weight;
  }
  for (std::size_t r = 0; r < rows_.size(); ++r)
    weak_.push_back(
        {rows_[r].axis, rows_[r].face, dyadic(light_ ? weight[r] / (1.0 + weight[r] / most_weight) : weight[r])});
  return weight;
}

void MovableTerm::spread_jumps(const std::vector<double>& p) const {
  for (Vec3& push : push_) push.setZero();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    jump_[r] = (row.low_slot >= 0 ? p[row.low_slot] : 0.0) - (row.high_slot >= 0 ? p[row.high_slot] : 0.0);
    for (int k = 0; k < 3; ++k) push_[row.dof[k]][row.axis] += row.weight[k] * jump_[r];
  }
}

double MovableTerm::quadratic(const std::vector<double>& p) const {
  spread_jumps(p);
  double sum = 0.0;
  for (std::size_t d = 0; d < push_.size(); ++d) sum += coefficient_ * inverse_mass_[d] * push_[d].squaredNorm();
  for (std::size_t r = 0; r < rows_.size(); ++r) sum -= double(weak_[r].weight) * jump_[r] * jump_[r];
  return sum;
}

void MovableTerm::add_product(const std::vector<double>& p, double factor, std::vector<double>& out) const {
  spread_jumps(p);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    double flow = 0.0;
    for (int k = 0; k < 3; ++k) flow += row.weight[k] * inverse_mass_[row.dof[k]] * push_[row.dof[k]][row.axis];
    const double value = factor * (coefficient_ * flow - double(weak_[r].weight) * jump_[r]);
    if (row.low_slot >= 0) out[row.low_slot] += value;
    if (row.high_slot >= 0) out[row.high_slot] -= value;
  }
}

template <class T>
std::vector<double> MovableTerm::gather(const Coloured<T>& p) const {
  std::vector<double> values;
  values.reserve(cells_.size());
  for (const Cell& cell : cells_) values.push_back(double(p[cell.colour][cell.place]));
  return values;
}
template std::vector<double> MovableTerm::gather(const Coloured<float>&) const;
template std::vector<double> MovableTerm::gather(const Coloured<double>&) const;

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
