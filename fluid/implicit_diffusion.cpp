#include "fluid/implicit_diffusion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/parallel.h"

namespace wick::fluid {

namespace {

constexpr std::size_t row_grain = 16;

/// A box of doubles within one layer of ghosts.
struct Box {
  Int3 count;
  std::array<Ghost, 6> ghost{};  ///< of homogeneous data: `mirror` changes sign

  [[nodiscard]] std::ptrdiff_t stride(int axis) const {
    return axis == 0 ? 1 : axis == 1 ? count[0] + 2 : std::ptrdiff_t(count[0] + 2) * (count[1] + 2);
  }
  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    return std::size_t((i + 1) + (j + 1) * stride(1) + (k + 1) * stride(2));
  }
  [[nodiscard]] std::size_t size() const { return std::size_t(stride(2)) * (count[2] + 2); }
  [[nodiscard]] std::size_t rows() const { return std::size_t(count[1]) * count[2]; }
  [[nodiscard]] std::size_t row_start(std::size_t row) const {
    return index(0, int(row % count[1]), int(row / count[1]));
  }
};

void fill_ghosts(const Box& box, std::vector<double>& q) {
  for (int s = 0; s < 6; ++s) {
    const int a = s / 2, b = (a + 1) % 3, c = (a + 2) % 3, n = box.count[a];
    const bool upper = s % 2;
    const Ghost kind = box.ghost[s];
    const double factor = kind == Ghost::mirror ? -1.0 : 1.0;
    const int ghost = upper ? n : -1;
    const int from = kind == Ghost::wrap ? (upper ? 0 : n - 1) : (upper ? n - 1 : 0);
    const std::ptrdiff_t shift = (from - ghost) * box.stride(a);
    parallel_for(std::size_t(box.count[c]), 16, [&](std::size_t p) {
      Int3 at{};
      at[a] = ghost, at[c] = int(p);
      double* out = q.data() + box.index(at[0], at[1], at[2]);
      const std::ptrdiff_t step = box.stride(b);
      for (int i = 0; i < box.count[b]; ++i) out[i * step] = factor * out[i * step + shift];
    });
  }
}

/// The operator I - c Δ on one lattice.
struct Helmholtz {
  Box box;
  double c = 0.0;
  std::vector<std::size_t> fixed;  ///< values that are given and do not change
  struct Links {
    std::size_t point;
    unsigned joined;  ///< bits in the order of the sides
  };
  std::vector<Links> beside_walls;

  /// result = sum of differences of q to its neighbours; ghosts of q are filled.
  void laplacian(std::vector<double>& q, std::vector<double>& result) const {
    fill_ghosts(box, q);
    add_laplacian_rows(q, result);
    // Beside walls add up again what is joined: leaving it out afterwards would leave rounding behind.
    for (const auto& [p, joined] : beside_walls) {
      double sum = 0.0;
      for (int link = 0; link < 6; ++link) {
        const std::ptrdiff_t step = (link % 2 ? 1 : -1) * box.stride(link / 2);
        if (joined >> link & 1) sum += q[p + step] - q[p];
      }
      result[p] = sum;
    }
    for (const std::size_t p : fixed) result[p] = 0.0;
  }
  void add_laplacian_rows(const std::vector<double>& q, std::vector<double>& result) const {
    const std::ptrdiff_t sy = box.stride(1), sz = box.stride(2);
    parallel_for(box.rows(), row_grain, [&](std::size_t row) {
      const double* p = q.data() + box.row_start(row);
      double* r = result.data() + box.row_start(row);
      for (int i = 0; i < box.count[0]; ++i) {
        r[i] = (p[i - 1] + p[i + 1]) + (p[i - sy] + p[i + sy]) + (p[i - sz] + p[i + sz]) - 6.0 * p[i];
      }
    });
  }
  /// result = q - c Δ q.
  void apply(std::vector<double>& q, std::vector<double>& result) const {
    laplacian(q, result);
    for_rows([&](std::size_t i) { result[i] = q[i] - c * result[i]; });
  }
  template <class Body>
  void for_rows(const Body& body) const {
    parallel_for(box.rows(), row_grain, [&](std::size_t row) {
      const std::size_t start = box.row_start(row);
      for (int i = 0; i < box.count[0]; ++i) body(start + i);
    });
  }
  [[nodiscard]] double dot(const std::vector<double>& x, const std::vector<double>& y) const {
    return parallel_sum(box.rows(), row_grain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t row = begin; row < end; ++row) {
        const std::size_t start = box.row_start(row);
        for (int i = 0; i < box.count[0]; ++i) sum += x[start + i] * y[start + i];
      }
      return sum;
    });
  }
};

/// Solves A δ = b from δ = 0. The diagonal is nearly constant, so scaling by it would gain nothing.
SolveReport conjugate_gradients(const Helmholtz& a, const DiffusionInput& input, DiffusionWork& work) {
  SolveReport report;
  const std::vector<double>& b = work.rhs;
  std::vector<double>&delta = work.delta, &r = work.residual, &p = work.direction, &ap = work.image;
  r = b, p = b;
  ap.assign(b.size(), 0.0);
  double rr = a.dot(r, r);
  const double target = input.tolerance * input.tolerance * rr;
  const double start = rr;
  report.residual_before = rr > 0.0 ? 1.0 : 0.0;
  while (rr > target && report.iterations < input.max_iterations) {
    a.apply(p, ap);
    const double alpha = rr / a.dot(p, ap);
    a.for_rows([&](std::size_t i) { delta[i] += alpha * p[i], r[i] -= alpha * ap[i]; });
    const double next = a.dot(r, r);
    const double beta = next / rr;
    rr = next;
    a.for_rows([&](std::size_t i) { p[i] = r[i] + beta * p[i]; });
    ++report.iterations;
  }
  if (start == 0.0) return report;

  // Report the residual that the solution really has.
  a.apply(delta, ap);
  a.for_rows([&](std::size_t i) { r[i] = b[i] - ap[i]; });
  report.residual_after = std::sqrt(a.dot(r, r) / start);
  report.converged = report.residual_after <= 2.0 * input.tolerance;
  return report;
}

/// Diffuses the lattice values `q` (dense, x fastest, rows of `row_length`) by operator `a`; `shift` is the part
/// of Δ q that comes from moving sides.
template <class Shift>
SolveReport diffuse_lattice(const Helmholtz& a, const DiffusionInput& input, float* q, const Int3& lattice,
                            const Shift& shift, DiffusionWork& work) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<double>&values = work.values, &rhs = work.rhs, &delta = work.delta;
  for (auto* array : {&values, &rhs, &delta}) array->assign(a.box.size(), 0.0);
  const auto dense_row = [&](std::size_t row) {
    return q + std::size_t(lattice[0]) * (row % a.box.count[1] + std::size_t(lattice[1]) * (row / a.box.count[1]));
  };
  parallel_for(a.box.rows(), row_grain, [&](std::size_t row) {
    std::copy_n(dense_row(row), a.box.count[0], values.data() + a.box.row_start(row));
  });
  a.laplacian(values, rhs);
  shift(rhs);
  for (const std::size_t p : a.fixed) rhs[p] = 0.0;
  a.for_rows([&](std::size_t i) { rhs[i] *= a.c; });
  SolveReport report = conjugate_gradients(a, input, work);
  parallel_for(a.box.rows(), row_grain, [&](std::size_t row) {
    float* out = dense_row(row);
    const double* v = values.data() + a.box.row_start(row);
    const double* d = delta.data() + a.box.row_start(row);
    for (int i = 0; i < a.box.count[0]; ++i) out[i] = static_cast<float>(v[i] + d[i]);
  });
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

/// Collects links that are cut and hands them over as the points they belong to.
class Cuts {
 public:
  explicit Cuts(const Box& box) : box_(box), joined_(box.size(), 63) {}
  /// Cuts the link between the values at `upper` and at `lower`, its neighbour below along `axis`.
  void cut(const Int3& upper, const Int3& lower, int axis) {
    joined_[box_.index(upper[0], upper[1], upper[2])] &= std::uint8_t(~(1U << (2 * axis)));
    joined_[box_.index(lower[0], lower[1], lower[2])] &= std::uint8_t(~(2U << (2 * axis)));
  }
  [[nodiscard]] std::vector<Helmholtz::Links> points() const {
    std::vector<Helmholtz::Links> list;
    for (std::size_t p = 0; p < joined_.size(); ++p) {
      if (joined_[p] != 63) list.push_back({p, joined_[p]});
    }
    return list;
  }

 private:
  const Box& box_;
  std::vector<std::uint8_t> joined_;
};

template <class Body>
void for_each_point(const Int3& count, const Body& body) {
  for (int k = 0; k < count[2]; ++k) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) body(Int3{i, j, k});
    }
  }
}

/// Lists the pairs of cells between which a face is closed; sides of the box let nothing through anyway.
void block_walls(const Grid& g, const Sides& sides, const Walls& walls, Helmholtz& op) {
  if (!walls.any) return;
  Cuts cuts(op.box);
  for (int a = 0; a < 3; ++a) {
    for_each_point(op.box.count, [&](const Int3& c) {
      if (!walls.closed[a][g.face(a, c[0], c[1], c[2])]) return;
      Int3 other = c;
      --other[a];
      if (other[a] < 0 && sides[2 * a] != Side::periodic) return;
      if (other[a] < 0) other[a] = g.size(a) - 1;
      cuts.cut(c, other, a);
    });
  }
  op.beside_walls = cuts.points();
}

/// Lists what velocity component a does not exchange: given values on closed faces, and neighbouring faces
/// with a wall between all of the cells that they share.
void block_velocity(const Grid& g, const Sides& sides, const Walls& walls, int a, Helmholtz& op) {
  const bool periodic = sides[2 * a] == Side::periodic;
  for_each_point(op.box.count, [&](const Int3& f) {
    const bool on_side = !periodic && ((f[a] == 0 && sides[2 * a] == Side::closed) ||
                                       (f[a] == g.size(a) && sides[2 * a + 1] == Side::closed));
    const bool wall = walls.any && walls.closed[a][g.face(a, f[0], f[1], f[2])];
    if (on_side || wall) op.fixed.push_back(op.box.index(f[0], f[1], f[2]));
  });
  if (!walls.any) return;
  Cuts cuts(op.box);
  for (int b = 0; b < 3; ++b) {
    if (b == a) continue;
    for_each_point(op.box.count, [&](const Int3& f) {
      // Faces f and f - e_b are joined through the cells below and above them along a.
      Int3 other = f;
      other[b] = f[b] > 0 ? f[b] - 1 : g.size(b) - 1;
      if (f[b] == 0 && sides[2 * b] != Side::periodic) return;
      bool joined = false;
      for (int below = 0; below < 2; ++below) {
        Int3 cell = f;
        cell[a] -= below;
        if (periodic) cell[a] = (cell[a] + g.size(a)) % g.size(a);
        if (cell[a] < 0 || cell[a] >= g.size(a)) continue;
        joined = joined || !walls.closed[b][g.face(b, cell[0], cell[1], cell[2])];
      }
      if (!joined) cuts.cut(f, other, b);
    });
  }
  op.beside_walls = cuts.points();
}

double diffusion_number(const Grid& grid, const DiffusionInput& input) {
  return input.coefficient * input.dt / (grid.h * grid.h);
}

}  // namespace

SolveReport diffuse(const Grid& grid, const Sides& sides, const Walls& walls, const DiffusionInput& input,
                    CellField& field, DiffusionWork& work) {
  Helmholtz op;
  op.box.count = {grid.nx, grid.ny, grid.nz};
  op.c = diffusion_number(grid, input);
  if (op.c == 0.0) return {};
  for (int s = 0; s < 6; ++s) op.box.ghost[s] = sides[s] == Side::periodic ? Ghost::wrap : Ghost::copy;
  block_walls(grid, sides, walls, op);
  return diffuse_lattice(
      op, input, field.data(), op.box.count, [](std::vector<double>&) {}, work);
}

SolveReport diffuse(const Grid& grid, const Sides& sides, const SideMotion& motion, const Walls& walls,
                    const DiffusionInput& input, FaceField& velocity, DiffusionWork& work) {
  SolveReport slowest;
  for (int a = 0; a < 3; ++a) {
    Helmholtz op;
    op.c = diffusion_number(grid, input);
    if (op.c == 0.0) return {};
    const Int3 lattice = lattice_size(grid, a);
    op.box.count = lattice;
    if (sides[2 * a] == Side::periodic) --op.box.count[a];
    const GhostRules rules = velocity_ghosts(sides, a, motion, 1.0);
    for (int s = 0; s < 6; ++s) op.box.ghost[s] = rules[s].kind;
    block_velocity(grid, sides, walls, a, op);

    // A side that moves with velocity w adds 2 w to the ghost -q of the homogeneous operator.
    const auto moving_sides = [&](std::vector<double>& sum) {
      for (int s = 0; s < 6; ++s) {
        if (rules[s].kind != Ghost::mirror || rules[s].wall == 0.0F) continue;
        Int3 layer = op.box.count;
        const int at = s % 2 ? layer[s / 2] - 1 : 0;
        layer[s / 2] = 1;
        for_each_point(layer, [&](Int3 p) {
          p[s / 2] = at;
          sum[op.box.index(p[0], p[1], p[2])] += 2.0 * double(rules[s].wall);
        });
      }
    };
    const SolveReport report = diffuse_lattice(op, input, velocity[a].data(), lattice, moving_sides, work);
    const bool worse = report.iterations > slowest.iterations || !report.converged;
    const double seconds = slowest.seconds + report.seconds;
    if (worse || a == 0) slowest = report;
    slowest.seconds = seconds;
  }
  join_periodic_faces(grid, sides, velocity);
  return slowest;
}

}  // namespace wick::fluid
