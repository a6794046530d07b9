#include "diffusion/operators.h"

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "diffusion/linear_solver.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::plain_diffusion;
using testing::Sheet;
using testing::Values;

Values advance(const Sheet& s, const DiffusionParams& p, Values u, double dt, int steps) {
  DiffusionSolver solver(p);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(solver.step(u, s.input(), dt).solve.converged);
  return u;
}

/// Second moments of u about its centre: along x, along y, and the mixed one.
Vec3 second_moments(const Sheet& s, const Values& u) {
  const double total = s.total(u);
  Vec2 center = Vec2::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) center += s.mass[i] * u[i] * s.mesh.rest[i].head<2>() / total;
  Vec3 m = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec2 d = s.mesh.rest[i].head<2>() - center;
    m += s.mass[i] * u[i] / total * Vec3(d.x() * d.x(), d.y() * d.y(), d.x() * d.y());
  }
  return m;
}

Values gaussian(const Sheet& s, double variance) {
  return s.field(
      [&](const Vec3& p) { return std::exp(-(p - Vec3(0.5, 0.5, 0)).squaredNorm() / (2.0 * variance)); });
}

struct MomentCase {
  const char* name;
  Operator kind;
  double factor, expected, tolerance;
};

TEST(HeatKernel, SecondMomentsGrowAtTwiceTheDiffusivity) {
  // Backward Euler on an unbounded lattice: <x²> grows by 2 α dt per step exactly. The sheet ends 7 standard
  // deviations away.
  const Sheet s(testing::sheet(93, 107));
  const double alpha = 0.01, dt = 0.01;
  const int steps = 10;
  const Values u0 = gaussian(s, 0.003);
  for (const MomentCase& c : {MomentCase{"cotan", Operator::cotan, 2.0, 1.0, 0.01},
                              MomentCase{"umbrella 2", Operator::umbrella, 2.0, 1.0, 0.01},
                              MomentCase{"umbrella literal", Operator::umbrella, 1.0, 0.5, 0.005},
                              MomentCase{"graph", Operator::graph, 2.0, 1.0, 0.02}}) {
    DiffusionParams p = plain_diffusion(alpha);
    p.discretisation = c.kind;
    p.umbrella_factor = c.factor;
    const Values u = advance(s, p, u0, dt, steps);
    const Vec3 growth = (second_moments(s, u) - second_moments(s, u0)) / (2.0 * alpha * dt * steps);
    EXPECT_NEAR(growth[0], c.expected, c.tolerance) << c.name;
    EXPECT_NEAR(growth[1], c.expected, c.tolerance) << c.name;
  }
}

TEST(HeatKernel, ClampedCotanOnAJitteredMeshStaysWithinOnePercent) {
  const Sheet s(testing::jittered(93, 107, 0.25));
  const Values u0 = gaussian(s, 0.003);
  for (const bool clamp : {true, false}) {
    DiffusionParams p = plain_diffusion(0.01);
    p.clamp_weights = clamp;
    const Vec3 growth =
        (second_moments(s, advance(s, p, u0, 0.01, 10)) - second_moments(s, u0)) / (2.0 * 0.01 * 0.1);
    RecordProperty(clamp ? "clamped" : "plain", std::to_string(growth[0]));
    EXPECT_NEAR(growth[0], 1.0, 0.01) << clamp;
    EXPECT_NEAR(growth[1], 1.0, 0.01) << clamp;
  }
}

TEST(HeatKernel, UmbrellaOnASingleDiagonalGridMakesEllipses) {
  // T = [[.5,.2071],[.2071,.5]]: ratio of the principal standard deviations 1.554; cotan stays round.
  const Sheet s(testing::sheet(101, 101, Vec2(1, 1), solid::Lattice::grid));
  const Values u0 = gaussian(s, 0.002);
  DiffusionParams p = plain_diffusion(0.01);
  for (const bool umbrella : {true, false}) {
    p.discretisation = umbrella ? Operator::umbrella : Operator::cotan;
    const Vec3 m = second_moments(s, advance(s, p, u0, 0.01, 10)) - second_moments(s, u0);
    const double ratio = std::sqrt((m[0] + std::abs(m[2])) / (m[0] - std::abs(m[2])));
    EXPECT_NEAR(ratio, umbrella ? 1.554 : 1.0, umbrella ? 0.02 * 1.554 : 0.01);
  }
}

/// Real zonal harmonic P_l(z) of the unit sphere.
double legendre(int l, double z) {
  double a = 1.0, b = z;
  if (l == 0) return a;
  for (int k = 2; k <= l; ++k) {
    const double next = ((2 * k - 1) * z * b - (k - 1) * a) / k;
    a = b;
    b = next;
  }
  return b;
}

/// Relative error of the decay rate of P_l on an icosphere, one backward Euler step undone exactly.
double harmonic_error(int level, int l, Operator kind, double factor, double expected = 1.0) {
  const Sheet s(solid::build_mesh(solid::icosphere(level, 1.0)));
  DiffusionParams p = plain_diffusion(1.0);
  p.discretisation = kind;
  p.umbrella_factor = factor;
  const Vec3 axis = Vec3(1, 2, 3).normalized();
  // Lifted by 2 so that u stays positive; the constant does not decay.
  const Values y = s.field([&](const Vec3& x) { return legendre(l, x.normalized().dot(axis)); });
  Values u;
  for (const double value : y) u.push_back(2.0 + value);
  const double dt = 0.5 / (l * (l + 1));
  const Values v = advance(s, p, u, dt, 1);
  double yy = 0.0, vy = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) yy += s.mass[i] * y[i] * y[i], vy += s.mass[i] * y[i] * (v[i] - 2.0);
  const double rate = (yy / vy - 1.0) / (dt * l * (l + 1));
  return rate / expected - 1.0;
}

TEST(SphericalHarmonics, CotanDecaysAtTheRightRateWithSecondOrder) {
  for (const int l : {1, 2, 4, 6}) {
    const double e3 = harmonic_error(3, l, Operator::cotan, 2.0), e4 = harmonic_error(4, l, Operator::cotan, 2.0),
                 e5 = harmonic_error(5, l, Operator::cotan, 2.0);
    if (l <= 4) {
      EXPECT_LT(std::abs(e5), 0.01) << l;
    }
    // At least second order; l = 1 reaches fourth on the regular icosphere.
    EXPECT_GT(std::log2(std::abs(e3 / e4)), 1.8) << l << ' ' << e3 << ' ' << e4;
    EXPECT_GT(std::log2(std::abs(e4 / e5)), 1.8) << l << ' ' << e4 << ' ' << e5;
    std::printf("  l = %d: relative error of the rate %.1e %.1e %.1e at levels 3, 4, 5\n", l, e3, e4, e5);
  }
}

TEST(SphericalHarmonics, LiteralUmbrellaRunsAtHalfTheRate) {
  EXPECT_NEAR(harmonic_error(4, 2, Operator::umbrella, 1.0, 0.5), 0.0, 0.03);
  EXPECT_NEAR(harmonic_error(4, 2, Operator::umbrella, 2.0), 0.0, 0.03);
}

TEST(Umbrella, ConservesTheSumWeightedWithEdgeLengths) {
  const Sheet s(testing::jittered(20, 23, 0.3));
  Values weight(s.mesh.vertex_count(), 0.0);
  for (std::size_t e = 0; e < s.mesh.edges.size(); ++e)
    for (const int i : s.mesh.edges[e]) weight[i] += s.mesh.rest_length[e];
  DiffusionParams p = plain_diffusion(0.01);
  p.discretisation = Operator::umbrella;
  p.scope = Scope::component;
  const auto weighted = [&](const Values& u) {
    double sum = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) sum += weight[i] * u[i];
    return sum;
  };
  const Values u0 = s.field([](const Vec3& x) { return x.x() < 0.3 ? 1.0 : 0.0; });
  EXPECT_NEAR(weighted(advance(s, p, u0, 0.02, 20)) / weighted(u0), 1.0, 1e-12);
}

TEST(MaximumPrinciple, HoldsOnObtuseMeshesWithClampedWeights) {
  // Rows of slivers: opposite angles far above 180 degrees together.
  solid::TriangleSoup soup = solid::rectangle(30, 30, Vec2(1.0, 0.08));
  const Sheet s(solid::build_mesh(std::move(soup)));
  const Values u0 = s.field([](const Vec3& x) { return x.x() > 0.4 && x.x() < 0.5 ? 1.0 : 0.0; });
  for (const Operator kind : {Operator::cotan, Operator::umbrella, Operator::graph}) {
    DiffusionParams p = plain_diffusion(1e-3);
    p.discretisation = kind;
    const Values u = advance(s, p, u0, 0.05, 3);
    EXPECT_GE(testing::smallest(u), 0.0);
    EXPECT_LE(testing::largest(u), 1.0 + 1e-9);
  }
  // Plain weights undershoot here; what is cut off is taken back, so the amount stays.
  DiffusionParams p = plain_diffusion(1e-3);
  p.clamp_weights = false;
  const Values u = advance(s, p, u0, 0.05, 3);
  EXPECT_GE(testing::smallest(u), 0.0);
  EXPECT_NEAR(s.total(u) / s.total(u0), 1.0, 1e-12);
}

TEST(Metric, StretchSlowsDiffusionByItsSquare) {
  Sheet s(testing::sheet(61, 70));
  for (Vec3& x : s.x) x *= 1.25;
  const Values u0 = gaussian(s, 0.003);
  DiffusionParams p = plain_diffusion(0.01);
  for (const Operator kind : {Operator::cotan, Operator::umbrella, Operator::graph}) {
    p.discretisation = kind;
    p.metric = Metric::current;
    p.alpha = 0.01 * 1.25 * 1.25;
    const Values a = advance(s, p, u0, 0.02, 3);
    p.metric = Metric::rest;
    p.alpha = 0.01;
    const Values b = advance(s, p, u0, 0.02, 3);
    EXPECT_LT(testing::rms(a, b), 1e-10);
  }
}

/// A matrix with the reference of a real step.
struct System {
  Sheet s;
  SheetGraph graph;
  SheetOperator op;
  SheetMatrix matrix;
  explicit System(int n, double diffusion) : s(testing::jittered(n, n, 0.2)), graph(build_graph(s.mesh)) {
    build_operator(s.mesh, graph, {}, s.mesh.rest, corner_cotangents(s.mesh, s.mesh.rest), s.mass, op);
    assemble(graph, op, diffusion, {}, {}, matrix);
    matrix.reference = &op;
  }
};

/// Gauss elimination without pivoting, which a positive definite matrix does not need.
Values eliminate(std::vector<Values> a, Values b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

TEST(LinearSolver, AgreesWithADenseSolveOverTwelveDecades) {
  for (const double diffusion : {1e-9, 1e-5, 1e-3, 1e-1, 1e1, 1e3}) {
    System y(15, diffusion);
    const std::size_t n = y.s.mesh.vertex_count();
    std::vector<Values> dense(n, Values(n, 0.0));
    Values rhs(n), x(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      dense[i][i] = y.matrix.diagonal[i];
      for (int k = y.graph.offset[i]; k < y.graph.offset[i + 1]; ++k)
        dense[i][y.graph.column[k]] = y.matrix.entry[k];
      rhs[i] = y.s.mass[i] * hash_unit(3, i);
    }
    const Values exact = eliminate(dense, rhs);
    LinearSolver solver;
    const SolveReport report = solver.solve(y.matrix, rhs, 1e-12, x);
    EXPECT_TRUE(report.converged) << diffusion;
    EXPECT_LE(report.residual_after, 1e-12);
    // The dense solve itself loses digits with the condition number, about diffusion / h².
    const double tolerance = 1e-10 * std::max(1.0, diffusion * 1e3);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(x[i], exact[i], tolerance) << diffusion;
  }
}

TEST(LinearSolver, StiffSystemsTakeFewIterationsAndDoNotRememberTheirPast) {
  System soft(60, 1e-4), stiff(60, 1.0), other(60, 3.7);
  EXPECT_LT(estimated_iterations(soft.matrix, 1e-8), factor_threshold);
  EXPECT_GT(estimated_iterations(stiff.matrix, 1e-8), factor_threshold);
  const std::size_t n = stiff.s.mesh.vertex_count();
  Values rhs(n), first(n, 0.0), second(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) rhs[i] = stiff.s.mass[i] * hash_unit(5, i);
  LinearSolver fresh, used;
  const SolveReport report = fresh.solve(stiff.matrix, rhs, 1e-8, first);
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.iterations, 12);
  Values scratch(n, 0.0);
  used.solve(other.matrix, rhs, 1e-8, scratch);
  used.solve(soft.matrix, rhs, 1e-8, scratch);
  used.solve(stiff.matrix, rhs, 1e-8, second);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace wick::diffusion
