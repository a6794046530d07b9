/// What the diffusion step books: amounts before, supplied, lost, rescaled and after must agree.
#include <gtest/gtest.h>

#include <numeric>

#include "core/parallel.h"
#include "core/parameters.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::budget_error;
using testing::Sheet;
using testing::Values;

// Sums of some thousand terms, compensated: rounding of a few operations.
constexpr double closed = 1e-12;

Sheet crumpled(int nx = 31, int ny = 36) {
  Sheet s(testing::sheet(nx, ny));
  s.x = testing::crumple(s.mesh);
  return s;
}

Values strip(const Sheet& s) {
  return s.field([](const Vec3& x) { return 0.95 * std::exp(-20.0 * x.x() * x.x()); });
}

TEST(Budget, ClosesForEveryCombination) {
  Sheet s = crumpled();
  for (std::size_t i = 0; i < s.mass.size(); ++i) s.mass[i] *= 1.0 + 0.5 * hash_unit(1, i);
  const std::size_t n = s.mass.size();
  Values loss(n), rate(n), value(n), amount(n);
  for (std::size_t i = 0; i < n; ++i) {
    loss[i] = 0.4 * s.mass[i];
    rate[i] = s.mesh.rest[i].x() < 0.1 ? 30.0 * s.mass[i] : 0.0;
    value[i] = 0.9;
    amount[i] = 0.02 * s.mass[i] * hash_signed(2, i);
  }
  for (const Operator op : {Operator::cotan, Operator::umbrella, Operator::graph})
    for (const Scope scope : {Scope::global, Scope::component, Scope::front, Scope::local, Scope::local_front})
      for (const SigmaMode mode : {SigmaMode::rate, SigmaMode::per_step, SigmaMode::influx})
        for (const double sigma : {1.0, 0.5, 1.5})
          for (const Total total : {Total::area, Total::plain}) {
            DiffusionParams p;
            p.front_ramp = sigma == 1.0 ? 0.0 : 0.2;
            p.discretisation = op;
            p.scope = scope;
            p.sigma_mode = mode;
            p.sigma = sigma;
            p.total = total;
            DiffusionSolver solver(p);
            Values u = strip(s);
            DiffusionInput in = s.input();
            in.loss = &loss;
            in.supply_rate = &rate;
            in.supply_value = &value;
            in.amount = &amount;
            in.capacity = 1.0;
            for (int step = 0; step < 3; ++step) {
              const DiffusionReport r = solver.step(u, in, 1.0 / 60.0);
              ASSERT_LT(budget_error(r), closed)
                  << static_cast<int>(op) << static_cast<int>(scope) << static_cast<int>(mode);
              ASSERT_GE(testing::smallest(u), 0.0);
              ASSERT_LE(testing::largest(u), 1.0);
              const Values& given = solver.supplied_vertex();
              ASSERT_NEAR(std::accumulate(given.begin(), given.end(), 0.0), r.supplied, closed * r.before);
              if (op == Operator::cotan && total == Total::area) {
                ASSERT_EQ(r.drift, 0.0);
              }
              if (op == Operator::cotan && total == Total::area && sigma == 1.0) {
                ASSERT_NEAR(r.sigma_source, 0.0, closed * r.before);
              }
            }
          }
}

TEST(Budget, SupplyAndLossAreWhatTheVerticesSay) {
  // One isolated vertex pair of known rates: u* = (u + k u_src)/(1 + k + l) for a uniform sheet.
  Sheet s(testing::sheet(8, 9));
  const Values rate(s.mass), value(s.mass.size(), 0.8);
  Values loss = s.mass;
  for (double& l : loss) l *= 2.0;
  Values u(s.mass.size(), 0.5);
  DiffusionParams p = testing::plain_diffusion(0.1);
  DiffusionSolver solver(p);
  DiffusionInput in = s.input();
  in.loss = &loss;
  in.supply_rate = &rate;
  in.supply_value = &value;
  const double dt = 0.3, expected = (0.5 + dt * 0.8) / (1.0 + dt * 3.0);
  const DiffusionReport r = solver.step(u, in, dt);
  for (const double v : u) EXPECT_NEAR(v, expected, 1e-12);
  const double area = s.total(Values(u.size(), 1.0));
  EXPECT_NEAR(r.lost, area * 2.0 * dt * expected, 1e-12);
  EXPECT_NEAR(r.supplied, area * dt * (0.8 - expected), 1e-12);
}

TEST(Budget, HalfLineSupplyFollowsTheErrorFunction) {
  // u(0) = 1, rest dry: u = erfc(x/(2 sqrt(α t))), uptake per width 2 sqrt(α t/π).
  Sheet s(testing::sheet(201, 24, Vec2(1.0, 0.1)));
  Values rate(s.mass.size(), 0.0), value(s.mass.size(), 1.0), u(s.mass.size(), 0.0);
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (s.mesh.rest[i].x() == 0.0) rate[i] = 1e12 * s.mass[i];
  const double alpha = 0.01, time = 1.0;
  const int steps = 400;
  DiffusionSolver solver(testing::plain_diffusion(alpha));
  DiffusionInput in = s.input();
  in.supply_rate = &rate;
  in.supply_value = &value;
  double supplied = 0.0;
  for (int k = 0; k < steps; ++k) {
    const DiffusionReport r = solver.step(u, in, time / steps);
    supplied += r.supplied;
    ASSERT_TRUE(r.solve.converged);
    ASSERT_LT(budget_error(r), closed);
  }
  EXPECT_NEAR(supplied / 0.1 / (2.0 * std::sqrt(alpha * time / M_PI)), 1.0, 0.01);
  EXPECT_NEAR(s.total(u), supplied, 1e-10 * supplied);
  for (std::size_t i = 0; i < u.size(); ++i)
    EXPECT_NEAR(u[i], std::erfc(s.mesh.rest[i].x() / (2.0 * std::sqrt(alpha * time))), 0.005);
}

/// Total after `steps` steps with no supply.
double total_after(SigmaMode mode, double sigma, double dt, int steps) {
  Sheet s = crumpled();
  DiffusionParams p;
  p.sigma = sigma;
  p.sigma_mode = mode;
  p.sigma_tau = 0.7;
  DiffusionSolver solver(p);
  Values u = strip(s);
  const double start = s.total(u);
  for (int k = 0; k < steps; ++k) solver.step(u, s.input(), dt);
  return s.total(u) / start;
}

TEST(Sigma, FormulasOfTheThreeModes) {
  for (const double sigma : {0.5, 1.5}) {
    EXPECT_NEAR(total_after(SigmaMode::rate, sigma, 0.1, 10) / std::pow(sigma, 1.0 / 0.7), 1.0, 1e-10);
    EXPECT_NEAR(total_after(SigmaMode::rate, sigma, 0.05, 20) / std::pow(sigma, 1.0 / 0.7), 1.0, 1e-10);
    EXPECT_NEAR(total_after(SigmaMode::per_step, sigma, 0.1, 10) / std::pow(sigma, 10), 1.0, 1e-10);
    EXPECT_NEAR(total_after(SigmaMode::influx, sigma, 0.1, 10), 1.0, 1e-10);
  }
}

TEST(Sigma, InfluxScalesWhatIsTakenUp) {
  Sheet s = crumpled();
  Values amount(s.mass.size(), 0.0);
  for (std::size_t i = 0; i < amount.size(); ++i)
    if (s.mesh.rest[i].x() < 0.1) amount[i] = 0.01 * s.mass[i];
  const double given = std::accumulate(amount.begin(), amount.end(), 0.0);
  for (const double sigma : {0.5, 1.0, 2.0}) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.alpha = 0.01;
    p.sigma = sigma;
    DiffusionSolver solver(p);
    Values u = strip(s);
    const double start = s.total(u);
    DiffusionInput in = s.input();
    in.amount = &amount;
    for (int k = 0; k < 10; ++k) solver.step(u, in, 1.0 / 60.0);
    EXPECT_NEAR((s.total(u) - start) / (10.0 * sigma * given), 1.0, 1e-10);
  }
}

TEST(Identity, RigidMotionLeavesTheIsotropicResultBitForBit) {
  Sheet s(testing::sheet(31, 36));
  for (const Scope scope : {Scope::global, Scope::front, Scope::local_front}) {
    DiffusionParams p;
    p.scope = scope;
    DiffusionParams iso = p;
    iso.model = Model::isotropic;
    Values a = strip(s), b = a;
    DiffusionSolver(p).step(a, s.input(), 0.02);
    DiffusionSolver(iso).step(b, s.input(), 0.02);
    EXPECT_EQ(a, b);
  }
}

TEST(Unconstrained, AddsStrainEverywhereAndBooksIt) {
  Sheet s = crumpled();
  DiffusionParams p;
  p.model = Model::strain_unconstrained;
  p.order = Order::after;
  DiffusionSolver solver(p);
  Values u(s.mass.size(), 0.0);
  const DiffusionReport r = solver.step(u, s.input(), 0.02);
  for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], solver.strain_vertex()[i], 1e-15);
  EXPECT_GT(r.strain_added, 0.0);
  EXPECT_LT(budget_error(r), closed);
}

TEST(Unconstrained, ClosesItsBudgetWithOperatorsThatDrift) {
  Sheet s(testing::jittered(21, 24, 0.25));
  s.x = testing::crumple(s.mesh);
  for (const Operator kind : {Operator::cotan, Operator::umbrella, Operator::graph}) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.model = Model::strain_unconstrained;
    p.discretisation = kind;
    DiffusionSolver solver(p);
    Values u = s.field([](const Vec3& x) { return std::exp(-20.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
    for (int k = 0; k < 5; ++k) EXPECT_LT(budget_error(solver.step(u, s.input(), 1.0 / 60.0)), 1e-12);
  }
}

TEST(Constrained, KeepsThePlainSumWhereThatIsTheTotal) {
  Sheet s(testing::jittered(21, 24, 0.4));
  s.x = testing::crumple(s.mesh);
  for (const Order order : {Order::inside, Order::after})
    for (const Scope scope : {Scope::global, Scope::front, Scope::local_front}) {
      DiffusionParams p = make_preset(Preset::wetting);
      p.total = Total::plain;
      p.order = order;
      p.scope = scope;
      p.alpha = 0.0;
      DiffusionSolver solver(p);
      Values u = s.field([](const Vec3& x) { return std::exp(-20.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
      const double before = std::accumulate(u.begin(), u.end(), 0.0);
      for (int k = 0; k < 10; ++k) EXPECT_LT(budget_error(solver.step(u, s.input(), 1.0 / 60.0)), 1e-12);
      EXPECT_NEAR(std::accumulate(u.begin(), u.end(), 0.0) / before, 1.0, 1e-12);
    }
}

TEST(Constrained, WithNextToNoStrainIsIsotropicForEveryOperator) {
  Sheet s(testing::jittered(21, 24, 0.25));
  s.x = testing::crumple(s.mesh);
  for (const Operator kind : {Operator::cotan, Operator::umbrella, Operator::graph}) {
    const auto run = [&](double gain) {
      DiffusionParams p = make_preset(Preset::wetting);
      p.discretisation = kind;
      p.gain = gain;
      p.tolerance = 1e-12;
      DiffusionSolver solver(p);
      Values u = s.field([](const Vec3& x) { return std::exp(-20.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
      for (int k = 0; k < 5; ++k) solver.step(u, s.input(), 1.0 / 60.0);
      return u;
    };
    EXPECT_LT(testing::rms(run(0.0), run(1e-9)), 1e-10);
  }
}

TEST(Constrained, APieceForWhichTheStepIsTooLongLeavesTheOthersAlone) {
  // Two pieces with the same front; one of them loses nearly all within a step.
  Sheet s = testing::two_pieces(testing::sheet(41, 24), 0.45, 0.55);
  s.x = testing::crumple(s.mesh);
  for (const Scope scope : {Scope::component, Scope::front, Scope::local_front}) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.scope = scope;
    p.gain = 1e4;
    std::size_t misjudged = 0;
    const auto run = [&](double loss) {
      Values rate = s.field([&](const Vec3& x) { return x.x() > 0.5 ? loss : 0.0; });
      for (std::size_t i = 0; i < rate.size(); ++i) rate[i] *= s.mass[i];
      DiffusionInput in = s.input();
      in.loss = &rate;
      Values u = s.field([](const Vec3& x) { return std::exp(-20.0 * (x.y() - 0.3) * (x.y() - 0.3)); });
      DiffusionSolver solver(p);
      for (int k = 0; k < 3; ++k) {
        const DiffusionReport r = solver.step(u, in, 1.0 / 30.0);
        EXPECT_LT(budget_error(r), 1e-12);
        misjudged += r.misjudged;
      }
      return u;
    };
    const Values calm = run(0.0);
    EXPECT_EQ(misjudged, 0U);
    const Values losing = run(2000.0);
    EXPECT_GT(misjudged, 0U);
    double most = 0.0;
    for (std::size_t i = 0; i < calm.size(); ++i)
      if (s.mesh.rest[i].x() < 0.5) most = std::max(most, std::abs(calm[i] - losing[i]));
    EXPECT_LT(most, 1e-5);
  }
}

TEST(Permutation, RenumberingTheVerticesRenumbersTheResult) {
  const Sheet s = crumpled(15, 17);
  const int n = static_cast<int>(s.mass.size());
  std::vector<int> to(n);
  for (int i = 0; i < n; ++i) to[i] = (i * 101 + 7) % n;  // 101 and 255 have no common factor
  solid::TriangleSoup soup;
  soup.positions.resize(n);
  soup.material.resize(n);
  for (int i = 0; i < n; ++i) soup.positions[to[i]] = s.mesh.rest[i], soup.material[to[i]] = s.mesh.material[i];
  for (const Int3& t : s.mesh.triangles) soup.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
  Sheet q(solid::build_mesh(std::move(soup)));
  for (int i = 0; i < n; ++i) q.x[to[i]] = s.x[i];
  for (const Scope scope : {Scope::global, Scope::front, Scope::local_front}) {
    DiffusionParams p;
    p.scope = scope;
    p.tolerance = 1e-13;
    Values a = strip(s), b = strip(q);
    DiffusionSolver first(p), second(p);
    for (int k = 0; k < 3; ++k) {
      first.step(a, s.input(), 0.02);
      second.step(b, q.input(), 0.02);
    }
    for (int i = 0; i < n; ++i) EXPECT_NEAR(b[to[i]], a[i], 1e-10);
  }
}

TEST(Determinism, SameBitsAtOneAndTwoThreadsAndAfterARestart) {
  Sheet s = crumpled(93, 107);
  DiffusionParams p = make_preset(Preset::wetting);
  p.alpha = 0.02;
  Values one = strip(s), two = one, restarted = one;
  {
    const ThreadLimit limit(1);
    DiffusionSolver solver(p);
    for (int k = 0; k < 4; ++k) solver.step(one, s.input(), k % 2 == 0 ? 0.02 : 0.013);
  }
  {
    const ThreadLimit limit(2);
    DiffusionSolver solver(p);
    for (int k = 0; k < 4; ++k) solver.step(two, s.input(), k % 2 == 0 ? 0.02 : 0.013);
  }
  for (int k = 0; k < 4; ++k) DiffusionSolver(p).step(restarted, s.input(), k % 2 == 0 ? 0.02 : 0.013);
  EXPECT_EQ(one, two);
  EXPECT_EQ(one, restarted);
}

/// Sets the preset and one field, as a scene file would; counts what is listed.
class Reader final : public ParameterVisitor {
 public:
  int preset = 0, listed = 0;
  void number(const About& about, double& value) override {
    ++listed, value = std::string(about.key) == "u_max" ? 0.7 : value;
  }
  void integer(const About&, int&) override { ++listed; }
  void flag(const About&, bool&) override { ++listed; }
  void text(const About&, std::string&) override { ++listed; }
  void numbers(const About&, std::span<double>) override { ++listed; }
  void integers(const About&, std::span<int>) override { ++listed; }
  void index_list(const About&, std::vector<int>&) override { ++listed; }
  void choice_index(const About& about, int& value, std::span<const char* const>) override {
    ++listed;
    if (std::string(about.key) == "preset") value = preset;
  }
  void group(const char*, const char*, FunctionRef<void(ParameterVisitor&)>) override {}
  void optional_group(const char*, const char*, bool, FunctionRef<void(bool)>,
                      FunctionRef<void(ParameterVisitor&)>) override {}
  void group_list(const char*, const char*, std::size_t, FunctionRef<void(std::size_t)>,
                  FunctionRef<void(ParameterVisitor&, std::size_t)>,
                  FunctionRef<void(ParameterVisitor&)>) override {}
};

TEST(Presets, ChoosingOneResetsTheRestBeforeItIsRead) {
  DiffusionParams p;
  p.alpha = 7.0;
  Reader reader;
  reader.preset = static_cast<int>(Preset::wetting);
  describe(reader, p);
  EXPECT_EQ(p.alpha, make_preset(Preset::wetting).alpha);
  EXPECT_EQ(p.scope, Scope::local_front);
  EXPECT_EQ(p.u_max, 0.7);
  EXPECT_EQ(reader.listed, 30);
}

}  // namespace
}  // namespace wick::diffusion
