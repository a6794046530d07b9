#include "fluid/pressure.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "core/parallel.h"
#include "core/parameters.h"
#include "core/require.h"
#include "fluid/fast_poisson.h"
#include "fluid/multigrid.h"
#include "fluid/pressure_faces.h"

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

double max_divergence(const Grid& grid, const FaceField& velocity, const Walls* walls, const CellField* expansion) {
  const Sides any_sides{};
  const FaceRows faces(grid, any_sides, walls);
  return parallel_max(grid.nz, 4, 0.0, [&](std::size_t begin, std::size_t end) {
    std::vector<double> outflow(grid.nx);
    double largest = 0.0;
    for (std::size_t k = begin; k < end; ++k)
      for (int j = 0; j < grid.ny; ++j) {
        faces.outflow(velocity, j, static_cast<int>(k), outflow.data());
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
  bool fill_rhs(const FaceField& velocity, const ProjectionInput& input, const FaceRows& faces) {
    rhs.resize(grid.cells());
    const double factor = input.density * grid.h / input.dt;
    const double bad = parallel_sum(grid.nz, 4, [&](std::size_t begin, std::size_t end) {
      double zeros = 0.0;
      for (std::size_t k = begin; k < end; ++k)
        for (int j = 0; j < grid.ny; ++j) {
          double* f = rhs.data() + grid.cell(0, j, static_cast<int>(k));
          faces.outflow(velocity, j, static_cast<int>(k), f);
          const std::size_t row = grid.cell(0, j, static_cast<int>(k));
          if (input.expansion != nullptr)
            for (int i = 0; i < grid.nx; ++i) f[i] -= grid.h * double((*input.expansion)[row + i]);
          for (int i = 0; i < grid.nx; ++i) f[i] *= -factor;
          if (faces.walls() != nullptr)
            for (int i = 0; i < grid.nx; ++i) f[i] = faces.walls()->solid[row + i] ? 0.0 : f[i];
          for (int i = 0; i < grid.nx; ++i) zeros += 0.0 * f[i];
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
  const FaceRows faces(s.grid, s.sides, input.walls);
  pressure.resize(s.grid.cells(), 0.0);
  faces.set_wall_velocity(velocity);

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
  faces.subtract_gradient(pressure, input.dt / (input.density * s.grid.h), velocity);
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
