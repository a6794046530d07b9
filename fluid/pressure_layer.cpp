#include "fluid/pressure_layer.h"

#include <Eigen/SparseCholesky>

namespace wick::fluid {

namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int32_t>;
using Triplet = Eigen::Triplet<double, std::int32_t>;

/// The row of B of one cell.
struct Stencil {
  struct Arm {
    double weight = 0.0;
    std::uint32_t place = 0;  ///< of the cell at the other end
    std::uint8_t colour = 0;
    std::int32_t slot = -1;  ///< of that cell in the layer
  };
  double diagonal = 0.0;
  std::array<Arm, 6> arms{};  ///< those that lead out of the box have weight 0
};

Stencil read_stencil(const Level& level, const MovableTerm& term, const MovableTerm::Cell& cell) {
  const Layout& layout = level.layout;
  const Int3 at = {int(cell.number % layout.nx), int(cell.number / layout.nx % layout.ny),
                   int(cell.number / (std::int64_t(layout.nx) * layout.ny))};
  Stencil stencil;
  stencil.diagonal = level.diagonal[cell.colour][cell.place];
  for (int side = 0; side < 6; ++side) {
    const int a = side / 2;
    Int3 owner = at, other = at;
    owner[a] += side % 2;
    other[a] += side % 2 == 0 ? -1 : 1;
    if (other[a] < 0 || other[a] >= layout.size(a)) {
      if (!level.wraps[a]) continue;
      other[a] = other[a] < 0 ? layout.size(a) - 1 : 0;
    }
    Stencil::Arm& arm = stencil.arms[side];
    arm.weight =
        level.weight[a][Layout::colour(owner[0], owner[1], owner[2])][layout.place(owner[0], owner[1], owner[2])];
    arm.place = static_cast<std::uint32_t>(layout.place(other[0], other[1], other[2]));
    arm.colour = static_cast<std::uint8_t>(Layout::colour(other[0], other[1], other[2]));
    arm.slot = term.slot(other[0] + std::int64_t(layout.nx) * (other[1] + std::int64_t(layout.ny) * other[2]));
  }
  return stencil;
}

/// B between the cells of the layer, lower half.
void add_cells(const std::vector<Stencil>& stencils, std::vector<Triplet>& entries) {
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(stencils.size()); ++c) {
    // A part of the fluid that lies in the layer as a whole is free by a constant: the shift keeps its factor
    // finite and is far below what a preconditioner feels.
    entries.emplace_back(c, c, stencils[c].diagonal * (1.0 + 1e-9));
    for (const Stencil::Arm& arm : stencils[c].arms)
      if (arm.slot >= 0 && arm.slot < c) entries.emplace_back(c, arm.slot, -arm.weight);
  }
}

/// Takes the faces that stand for the masses out of B and puts the masses themselves in.
void add_masses(const MovableTerm& term, std::vector<Triplet>& entries) {
  std::vector<std::int32_t> unknown(3 * term.inverse_mass().size(), -1);
  auto next = static_cast<std::int32_t>(term.cells().size());
  for (std::size_t r = 0; r < term.rows().size(); ++r) {
    const MovableTerm::Row& row = term.rows()[r];
    const double weak = term.weak_faces()[r].weight;
    const std::int32_t low = row.low_slot, high = row.high_slot;
    for (const std::int32_t c : {low, high})
      if (c >= 0) entries.emplace_back(c, c, -weak);
    if (low >= 0 && high >= 0) entries.emplace_back(std::max(low, high), std::min(low, high), weak);
    for (int k = 0; k < 3; ++k) {
      const double inverse = term.inverse_mass()[row.dof[k]];
      if (inverse <= 0.0) continue;
      std::int32_t& mass = unknown[3 * row.dof[k] + row.axis];
      if (mass < 0) {
        mass = next++;
        entries.emplace_back(mass, mass, -1.0 / (term.coefficient() * inverse));
      }
      if (low >= 0) entries.emplace_back(mass, low, row.weight[k]);
      if (high >= 0) entries.emplace_back(mass, high, -row.weight[k]);
    }
  }
}

}  // namespace

struct WallLayer::Impl {
  const MovableTerm& term;
  std::vector<Stencil> stencils;
  Eigen::SimplicialLDLT<Matrix> factor;
  Eigen::VectorXd right, solution;
  std::vector<double> z, direction;  ///< at the cells

  Impl(const Level& level, const MovableTerm& movable) : term(movable) {
    for (const MovableTerm::Cell& cell : term.cells()) stencils.push_back(read_stencil(level, term, cell));
    std::vector<Triplet> entries;
    entries.reserve(8 * stencils.size() + 12 * term.rows().size());
    add_cells(stencils, entries);
    add_masses(term, entries);
    std::int32_t size = 0;
    for (const Triplet& entry : entries) size = std::max(size, entry.row() + 1);
    Matrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor.compute(matrix);
    right.setZero(size);
    z.assign(stencils.size(), 0.0);
    direction = z;
  }
};

WallLayer::WallLayer(const Level& finest, const MovableTerm& term) : impl_(std::make_unique<Impl>(finest, term)) {}
WallLayer::~WallLayer() = default;
WallLayer::WallLayer(WallLayer&&) noexcept = default;
WallLayer& WallLayer::operator=(WallLayer&&) noexcept = default;

void WallLayer::correct(const Coloured<double>& r, Coloured<float>& z) {
  Impl& s = *impl_;
  const auto& cells = s.term.cells();
  s.z = s.term.gather(z);
  if (s.factor.info() != Eigen::Success) return;
  std::vector<double> residual = s.term.gather(r);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    residual[c] -= s.stencils[c].diagonal * s.z[c];
    for (const Stencil::Arm& arm : s.stencils[c].arms) residual[c] += arm.weight * double(z[arm.colour][arm.place]);
  }
  s.term.add_product(s.z, -1.0, residual);
  std::copy(residual.begin(), residual.end(), s.right.data());
  s.solution = s.factor.solve(s.right);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    s.z[c] += s.solution[static_cast<Eigen::Index>(c)];
    z[cells[c].colour][cells[c].place] = static_cast<float>(s.z[c]);
  }
}

void WallLayer::turn(double beta) {
  for (std::size_t c = 0; c < impl_->z.size(); ++c) impl_->direction[c] = impl_->z[c] + beta * impl_->direction[c];
}

const std::vector<double>& WallLayer::direction() const {
  return impl_->direction;
}

void WallLayer::advance(double alpha, const Coloured<float>& rounded, Coloured<double>& x,
                        Coloured<double>& r) const {
  const auto& cells = impl_->term.cells();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto [number, place, colour] = cells[c];
    const double missing = alpha * (impl_->direction[c] - double(rounded[colour][place]));
    x[colour][place] += missing;
    r[colour][place] -= impl_->stencils[c].diagonal * missing;
    for (const Stencil::Arm& arm : impl_->stencils[c].arms) r[arm.colour][arm.place] += arm.weight * missing;
  }
}

}  // namespace wick::fluid
