#include "fluid/pressure.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/parameters.h"
#include "core/require.h"
#include "fluid/fast_poisson.h"
#include "fluid/multigrid.h"

namespace wick::fluid {

void describe(ParameterVisitor& visitor, PressureParams& params) {
  visitor.number({"tolerance", "1", above_up_to(0.0, 0.1),
                  "relative 2-norm of the true residual of the pressure equation; too large: smoke thins out and "
                  "leaks through sheets",
                  OnResume::may_change},
                 params.tolerance);
  visitor.integer({"max_iterations", "1", at_least(1),
                   "most conjugate-gradient iterations of one pressure solve; too few: solves end unconverged",
                   OnResume::may_change},
                  params.max_iterations);
}

namespace {

/// Answers whether fluid passes a face, and how faces of one axis lie in memory.
class Faces {
 public:
  Faces(const Grid& grid, const Sides& sides, const Walls* walls) : grid_(grid), sides_(sides), walls_(walls) {
    if (walls_ != nullptr && !walls_->any) walls_ = nullptr;
  }

  [[nodiscard]] const Walls* walls() const { return walls_; }

  /// Calls body(i, j, k, face, low, high) for the faces of an axis; cells are -1 beyond closed and open sides.
  /// Both copies of a periodic face are visited, with the same cells.
  template <class Body>
  void for_each(int a, Body&& body) const {
    const Int3 n = {grid_.nx + (a == 0), grid_.ny + (a == 1), grid_.nz + (a == 2)};
    const std::int64_t step = a == 0 ? 1 : a == 1 ? grid_.nx : std::int64_t(grid_.nx) * grid_.ny;
    const bool wraps = sides_[2 * a] == Side::periodic;
    parallel_for(n[2], 4, [&](std::size_t plane) {
      const int k = static_cast<int>(plane);
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          const int at = a == 0 ? i : a == 1 ? j : k;
          auto high = static_cast<std::int64_t>(i + std::int64_t(grid_.nx) * (j + std::int64_t(grid_.ny) * k));
          std::int64_t low = high - step;
          const std::int64_t around = step * grid_.size(a);
          if (at == 0) low = wraps ? low + around : -1;
          if (at == grid_.size(a)) high = wraps ? high - around : -1;
          body(i, j, k, grid_.face(a, i, j, k), low, high);
        }
    });
  }

  [[nodiscard]] bool marked(int a, std::size_t face) const {
    return walls_ != nullptr && walls_->closed[a][face] != 0;
  }
  [[nodiscard]] bool solid(std::int64_t cell) const {
    return walls_ != nullptr && cell >= 0 && walls_->solid[cell] != 0;
  }

  /// The other copy of a periodic face, or the face itself.
  [[nodiscard]] std::size_t twin(int a, int i, int j, int k) const {
    Int3 at = {i, j, k};
    if (sides_[2 * a] == Side::periodic && (at[a] == 0 || at[a] == grid_.size(a))) at[a] = grid_.size(a) - at[a];
    return grid_.face(a, at[0], at[1], at[2]);
  }

  /// Side of the box that the face lies on and that lets nothing through.
  [[nodiscard]] bool on_closed_side(int a, std::int64_t low, std::int64_t high) const {
    return (low < 0 && sides_[2 * a] == Side::closed) || (high < 0 && sides_[2 * a + 1] == Side::closed);
  }

 private:
  const Grid& grid_;
  const Sides& sides_;
  const Walls* walls_;
};

/// Gives every closed face the velocity of its wall and both copies of a periodic face one value.
void set_wall_velocity(const Faces& faces, FaceField& velocity) {
  for (int a = 0; a < 3; ++a) {
    auto& u = velocity[a];
    // Upper copies of periodic faces take what their lower copies have.
    faces.for_each(a, [&](int i, int j, int k, std::size_t face, std::int64_t low, std::int64_t high) {
      const std::size_t twin = faces.twin(a, i, j, k);
      const bool marked = faces.marked(a, face) || faces.marked(a, twin);
      if (marked)
        u[face] =
            faces.walls()
                ->velocity[a][faces.marked(a, std::min(face, twin)) ? std::min(face, twin) : std::max(face, twin)];
      else if (faces.solid(low) || faces.solid(high) || faces.on_closed_side(a, low, high))
        u[face] = 0.0F;
    });
    faces.for_each(a, [&](int i, int j, int k, std::size_t face, std::int64_t, std::int64_t) {
      if (const std::size_t twin = faces.twin(a, i, j, k); twin < face) u[face] = u[twin];
    });
  }
}

/// Net flow out of cell row (j, k) through its faces, as a velocity: h div u.
void row_outflow(const Grid& grid, const FaceField& velocity, int j, int k, double* out) {
  const auto& [u, v, w] = velocity;
  const float* x = u.data() + grid.face(0, 0, j, k);
  const float *y0 = v.data() + grid.face(1, 0, j, k), *y1 = v.data() + grid.face(1, 0, j + 1, k);
  const float *z0 = w.data() + grid.face(2, 0, j, k), *z1 = w.data() + grid.face(2, 0, j, k + 1);
  for (int i = 0; i < grid.nx; ++i)
    out[i] = (double(x[i + 1]) - double(x[i])) + (double(y1[i]) - double(y0[i])) + (double(z1[i]) - double(z0[i]));
}

}  // namespace

double max_divergence(const Grid& grid, const FaceField& velocity, const Walls* walls, const CellField* expansion) {
  return parallel_max(grid.nz, 4, 0.0, [&](std::size_t begin, std::size_t end) {
    std::vector<double> outflow(grid.nx);
    double largest = 0.0;
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < grid.ny; ++j) {
        row_outflow(grid, velocity, j, static_cast<int>(k), outflow.data());
        for (int i = 0; i < grid.nx; ++i) {
          const std::size_t c = grid.cell(i, j, static_cast<int>(k));
          if (walls != nullptr && walls->any && walls->solid[c]) continue;
          const double error = std::abs(outflow[i] / grid.h - (expansion != nullptr ? (*expansion)[c] : 0.0));
          // Written so that NaN is seen.
          if (!(error <= largest)) largest = error;
        }
      }
    return largest;
  });
}

struct PressureSolver::Impl {
  Impl(const Grid& g, const Sides& s, const PressureParams& p) : grid(g), sides(s), params(p) {}

  Grid grid;
  Sides sides;
  PressureParams params;
  std::optional<FastPoisson> transform;  // made at the first empty box
  std::optional<Multigrid> multigrid;    // made at the first walls
  std::vector<double> rhs;

  /// f = (ρ h²/dt) (s - div u*), 0 in solid cells; true when all values are finite.
  bool fill_rhs(const FaceField& velocity, const ProjectionInput& input, const Faces& faces) {
    rhs.resize(grid.cells());
    const double factor = input.density * grid.h / input.dt;
    const double bad = parallel_sum(grid.nz, 4, [&](std::size_t begin, std::size_t end) {
      double zeros = 0.0;
      for (std::size_t k = begin; k < end; ++k)
        for (int j = 0; j < grid.ny; ++j) {
          double* f = rhs.data() + grid.cell(0, j, static_cast<int>(k));
          row_outflow(grid, velocity, j, static_cast<int>(k), f);
          const std::size_t row = grid.cell(0, j, static_cast<int>(k));
          for (int i = 0; i < grid.nx; ++i) {
            const double s = input.expansion != nullptr ? (*input.expansion)[row + i] : 0.0;
            f[i] = faces.solid(static_cast<std::int64_t>(row) + i) ? 0.0 : factor * (grid.h * s - f[i]);
            zeros += 0.0 * f[i];
          }
        }
      return zeros;
    });
    return bad == 0.0;
  }

  /// Residual norms of the empty box, |f - A p|² and |f|².
  [[nodiscard]] double empty_residual(const std::vector<double>& p) const {
    const Int3 n = {grid.nx, grid.ny, grid.nz};
    const std::ptrdiff_t step[3] = {1, grid.nx, std::ptrdiff_t(grid.nx) * grid.ny};
    return parallel_sum(grid.nz, 4, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t k = begin; k < end; ++k)
        for (int j = 0; j < grid.ny; ++j)
          for (int i = 0; i < grid.nx; ++i) {
            const Int3 at = {i, j, static_cast<int>(k)};
            const std::size_t c = grid.cell(i, j, at[2]);
            double product = 0.0;
            for (int side = 0; side < 6; ++side) {
              const int a = side / 2;
              const bool lower = side % 2 == 0;
              if (at[a] != (lower ? 0 : n[a] - 1))
                product += p[c] - p[lower ? c - step[a] : c + step[a]];
              else if (sides[side] == Side::open)
                product += 2.0 * p[c];
              else if (sides[side] == Side::periodic)
                product += p[c] - p[lower ? c + step[a] * (n[a] - 1) : c - step[a] * (n[a] - 1)];
            }
            sum += (rhs[c] - product) * (rhs[c] - product);
          }
      return sum;
    });
  }

  SolveReport solve_empty(std::vector<double>& p) {
    SolveReport report;
    if (!transform) transform.emplace(Int3{grid.nx, grid.ny, grid.nz}, sides);
    if (transform->singular()) {
      const double sum = parallel_sum(rhs.size(), 1U << 15, [&](std::size_t begin, std::size_t end) {
        double part = 0.0;
        for (std::size_t c = begin; c < end; ++c) part += rhs[c];
        return part;
      });
      report.rhs_sum = std::abs(sum);
      const double mean = sum / static_cast<double>(rhs.size());
      parallel_for(rhs.size(), 1U << 15, [&](std::size_t c) { rhs[c] -= mean; });
    }
    const double norm = parallel_sum(rhs.size(), 1U << 15, [&](std::size_t begin, std::size_t end) {
      double part = 0.0;
      for (std::size_t c = begin; c < end; ++c) part += rhs[c] * rhs[c];
      return part;
    });
    report.residual_before = norm > 0.0 ? std::sqrt(empty_residual(p) / norm) : 0.0;
    p = rhs;
    transform->solve(p);
    report.residual_after = norm > 0.0 ? std::sqrt(empty_residual(p) / norm) : 0.0;
    report.converged = report.residual_after <= std::max(params.tolerance, 1e-10);
    return report;
  }

  SolveReport solve_walled(std::vector<double>& p, const ProjectionInput& input, const MovableTerm* movable) {
    if (!multigrid) multigrid.emplace(grid, sides);
    multigrid->set_walls(*input.walls, movable != nullptr ? movable->weak_faces() : std::vector<Graph::WeakFace>{});
    parallel_for(p.size(), 1U << 15, [&](std::size_t c) {
      if (input.walls->solid[c]) p[c] = 0.0;
    });
    return multigrid->solve(rhs, p, movable, params.tolerance, params.max_iterations);
  }

  /// u -= dt/(ρ h) (p_high - p_low) on open faces; p = 0 on the face of an open side, half a cell away.
  void subtract_gradient(const std::vector<double>& p, const ProjectionInput& input, const Faces& faces,
                         FaceField& velocity) {
    const double factor = input.dt / (input.density * grid.h);
    for (int a = 0; a < 3; ++a)
      faces.for_each(a, [&](int i, int j, int k, std::size_t face, std::int64_t low, std::int64_t high) {
        if (faces.marked(a, face) || faces.marked(a, faces.twin(a, i, j, k)) || faces.solid(low) ||
            faces.solid(high) || faces.on_closed_side(a, low, high))
          return;
        double jump = 0.0;
        if (low < 0)
          jump = 2.0 * p[high];
        else if (high < 0)
          jump = -2.0 * p[low];
        else
          jump = p[high] - p[low];
        velocity[a][face] = static_cast<float>(double(velocity[a][face]) - factor * jump);
      });
  }
};

PressureSolver::PressureSolver(const Grid& grid, const Sides& sides, const PressureParams& params)
    : impl_(std::make_unique<Impl>(grid, sides, params)) {
  for (int a = 0; a < 3; ++a)
    require((sides[2 * a] == Side::periodic) == (sides[2 * a + 1] == Side::periodic), "/smoke/sides",
            "one of two opposite sides is periodic (a periodic side joins its opposite): make both so, or none");
  require(grid.nx > 0 && grid.ny > 0 && grid.nz > 0 && grid.h > 0.0, "/smoke/resolution",
          "the grid is empty (pressure needs at least one cell of positive size): give a positive resolution");
}
PressureSolver::~PressureSolver() = default;
PressureSolver::PressureSolver(PressureSolver&&) noexcept = default;
PressureSolver& PressureSolver::operator=(PressureSolver&&) noexcept = default;

SolveReport PressureSolver::project(FaceField& velocity, std::vector<double>& pressure,
                                    const ProjectionInput& input, std::vector<Vec3>* impulse) {
  const auto start = std::chrono::steady_clock::now();
  Impl& s = *impl_;
  const Faces faces(s.grid, s.sides, input.walls);
  pressure.resize(s.grid.cells(), 0.0);
  set_wall_velocity(faces, velocity);

  // Build and solve the equation.
  std::optional<MovableTerm> movable;
  if (input.movable != nullptr && faces.walls() != nullptr)
    movable.emplace(s.grid, s.sides, *input.walls, *input.movable, input.density);
  if (impulse != nullptr)
    impulse->assign(input.movable != nullptr ? input.movable->inverse_mass.size() : 0, Vec3::Zero());
  SolveReport report;
  if (!s.fill_rhs(velocity, input, faces)) {
    report.converged = false;
    report.residual_before = report.residual_after = std::numeric_limits<double>::quiet_NaN();
    return report;
  }
  report = faces.walls() != nullptr ? s.solve_walled(pressure, input, movable ? &*movable : nullptr)
                                    : s.solve_empty(pressure);

  // Push the fluid and the masses.
  s.subtract_gradient(pressure, input, faces, velocity);
  if (movable) {
    std::vector<Vec3> gained;
    movable->add_impulse(pressure, input.dt, gained);
    movable->move_faces(gained, velocity);
    if (impulse != nullptr) *impulse = std::move(gained);
  }
  report.rhs_sum *= s.grid.h * input.dt / input.density;
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace wick::fluid
