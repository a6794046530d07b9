/// The diffusion step with parameters and meshes at the ends of their ranges stays finite and within its bounds.
#include <gtest/gtest.h>

#include <limits>

#include "core/require.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::budget_error;
using testing::Sheet;
using testing::Values;

constexpr double closed = 1e-12;

/// Steps a few times and checks what must hold in any case.
void check(const DiffusionParams& p, const DiffusionInput& in, Values u, double dt, int steps = 3) {
  DiffusionSolver solver(p);
  const double top = std::max(testing::largest(u), 1.0);
  for (int k = 0; k < steps; ++k) {
    const DiffusionReport r = solver.step(u, in, dt);
    ASSERT_LT(budget_error(r), closed) << "dt " << dt << " alpha " << p.alpha << " sigma " << p.sigma;
    for (const double v : u) ASSERT_TRUE(std::isfinite(v) && v >= 0.0) << v;
    ASSERT_TRUE(r.solve.converged) << "dt " << dt << " alpha " << p.alpha << ' ' << r.solve.residual_after
                                   << " after " << r.solve.iterations;
    if (p.model == Model::isotropic && p.sigma == 1.0) {
      ASSERT_LE(testing::largest(u), top * (1.0 + 1e-7));
    }
  }
}

Values blob(const Sheet& s) {
  return s.field([](const Vec3& x) { return std::exp(-30.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
}

TEST(Extremes, TimeStepsAndDiffusivitiesOverTwelveDecades) {
  Sheet s(testing::jittered(21, 24, 0.25));
  s.x = testing::crumple(s.mesh);
  for (const double dt : {0.0, 1e-9, 1e-6, 1e-3, 1.0, 1e3})
    for (const double alpha : {0.0, 1e-9, 1e-6, 1e-3, 1.0, 1e3})
      for (const Preset preset : {Preset::burning, Preset::wetting, Preset::literal}) {
        DiffusionParams p = make_preset(preset);
        p.alpha = alpha;
        check(p, s.input(), blob(s), dt);
        p.model = Model::isotropic;
        p.sharpness = 2;
        check(p, s.input(), blob(s), dt);
      }
}

TEST(Extremes, SigmaGainAndBandOverManyDecades) {
  Sheet s(testing::sheet(21, 24));
  s.x = testing::crumple(s.mesh);
  for (const Scope scope : {Scope::global, Scope::component, Scope::front, Scope::local, Scope::local_front})
    for (const double sigma : {0.0, 0.01, 1.0, 100.0})
      for (const double gain : {0.0, 1.0, 1e6, 1e300})
        for (const auto& [low, high] : {std::pair{0.05, 0.6}, std::pair{1e-300, 1e300}, std::pair{5.0, 6.0}})
          for (const double capacity : {0.0, 1.0}) {
            DiffusionParams p;
            p.scope = scope;
            p.sigma = sigma;
            p.sigma_mode = SigmaMode::per_step;
            p.gain = gain;
            p.u_min = low;
            p.u_max = high;
            DiffusionInput in = s.input();
            in.capacity = capacity;
            check(p, in, blob(s), 1.0 / 60.0);
            p.order = Order::after;
            check(p, in, blob(s), 1.0 / 60.0);
          }
}

TEST(Extremes, StepsThatLoseAlmostAllOfWhatTheExchangeCountsOn) {
  // The toll is reckoned with what the vertices hold at the beginning; loss and supply may leave next to nothing.
  Sheet s(testing::sheet(21, 24));
  s.x = testing::crumple(s.mesh);
  const Values cold(s.mass.size(), 0.0);
  for (const double dt : {0.1, 1.0, 40.0, 1e3})
    for (const double loss : {0.1, 10.0, 1e3})
      for (const Scope scope : {Scope::global, Scope::front, Scope::local_front}) {
        Values rate = s.field([&](const Vec3& x) { return x.x() < 0.5 ? loss : 0.0; });
        for (std::size_t i = 0; i < rate.size(); ++i) rate[i] *= s.mass[i];
        DiffusionParams p;
        p.scope = scope;
        DiffusionInput in = s.input();
        in.loss = &rate;
        check(p, in, blob(s), dt);
        in.loss = nullptr;
        in.supply_rate = &rate;
        in.supply_value = &cold;
        check(p, in, blob(s), dt);
      }
}

TEST(Extremes, DrySheetOfOneTriangleOrphansAndPieces) {
  for (const Scope scope : {Scope::global, Scope::component, Scope::front, Scope::local, Scope::local_front}) {
    DiffusionParams p;
    p.scope = scope;
    Sheet one(solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {}, {{0, 1, 2}}));
    one.x[1] *= 1.3;
    check(p, one.input(), {0.0, 0.0, 0.0}, 0.1);
    check(p, one.input(), {1.0, 0.3, 0.0}, 0.1);

    // Cut a band out of a sheet: two pieces and orphans that still have a value.
    const solid::ShellMesh whole = testing::sheet(21, 24);
    Sheet pieces = testing::two_pieces(whole, 0.4, 0.6);
    pieces.x = testing::crumple(pieces.mesh);
    Values u = blob(pieces);
    check(p, pieces.input(), u, 0.1);
    check(p, pieces.input(), Values(u.size(), 0.0), 0.1);

    // No amount crosses the gap unless the scope is the whole sheet.
    const auto left = [&](const Values& w) {
      double sum = 0.0;
      for (std::size_t i = 0; i < w.size(); ++i) sum += pieces.mesh.rest[i].x() < 0.5 ? pieces.mass[i] * w[i] : 0.0;
      return sum;
    };
    const double before = left(u);
    DiffusionSolver(p).step(u, pieces.input(), 0.1);
    if (scope != Scope::global) {
      EXPECT_NEAR(left(u) / before, 1.0, closed);
    }

    // Nothing at all is left.
    Sheet gone(solid::without_triangles(whole, std::vector<std::uint8_t>(whole.triangle_count(), 0)));
    check(p, gone.input(), blob(gone), 0.1);
  }
}

TEST(Extremes, CollapsedInvertedAndHugeTriangles) {
  Sheet s(testing::sheet(11, 12));
  const std::vector<Vec3> rest = s.x;
  const std::vector<std::function<Vec3(const Vec3&)>> maps = {
      [](const Vec3&) { return Vec3(Vec3::Zero()); }, [](const Vec3& x) { return Vec3(x.x(), 0, 0); },
      [](const Vec3& x) { return Vec3(-x.x(), x.y(), 0); }, [](const Vec3& x) { return Vec3(1e6 * x); },
      [](const Vec3& x) { return Vec3(x.x(), 1e-9 * x.y(), 0); }};
  for (const auto& map : maps) {
    for (std::size_t i = 0; i < rest.size(); ++i) s.x[i] = map(rest[i]);
    for (const Operator op : {Operator::cotan, Operator::umbrella, Operator::graph})
      for (const bool clamp : {true, false}) {
        DiffusionParams p;
        p.discretisation = op;
        p.metric = Metric::current;
        p.clamp_weights = clamp;
        check(p, s.input(), blob(s), 0.1);
      }
  }
}

TEST(Extremes, SupplyAndLossFromNothingToInfinitelyStiff) {
  Sheet s(testing::sheet(15, 17));
  s.x = testing::crumple(s.mesh);
  const std::size_t n = s.mass.size();
  const Values value(n, 0.9);
  for (const double stiffness : {0.0, 1e-12, 1.0, 1e6, 1e12, 1e200}) {
    Values rate(n, 0.0), loss(n, 0.0), amount(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      if (s.mesh.rest[i].x() < 0.2) rate[i] = stiffness * s.mass[i];
      if (s.mesh.rest[i].x() > 0.8) loss[i] = stiffness * s.mass[i];
      amount[i] = -stiffness * s.mass[i] * hash_unit(1, i);
    }
    DiffusionInput in = s.input();
    in.supply_rate = &rate;
    in.supply_value = &value;
    in.loss = &loss;
    for (const double alpha : {0.0, 1e-3, 1e3}) {
      DiffusionParams p;
      p.alpha = alpha;
      check(p, in, blob(s), 0.1);
      in.amount = &amount;
      check(p, in, blob(s), 0.1);
      in.amount = nullptr;
    }
  }
}

TEST(Extremes, VerticesWithoutMassRefuseWhatTheyAreGiven) {
  Sheet s(testing::sheet(11, 12));
  for (std::size_t i = 0; i < s.mass.size(); i += 3) s.mass[i] = 0.0;
  const Values amount(s.mass.size(), 1e-4);
  for (const Operator op : {Operator::cotan, Operator::umbrella}) {
    DiffusionParams p;
    p.discretisation = op;
    DiffusionInput in = s.input();
    in.amount = &amount;
    check(p, in, blob(s), 0.1);
  }
}

TEST(Extremes, NotANumberIsRefusedByName) {
  Sheet s(testing::sheet(5, 6));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  DiffusionSolver solver{DiffusionParams{}};
  Values u = blob(s);
  u[3] = nan;
  EXPECT_THROW(solver.step(u, s.input(), 0.1), Refusal);
  u = blob(s);
  EXPECT_THROW(solver.step(u, s.input(), -0.1), Refusal);
  s.x[4].y() = nan;
  EXPECT_THROW(solver.step(u, s.input(), 0.1), Refusal);
  DiffusionParams p;
  p.u_min = 0.7;
  EXPECT_THROW(DiffusionSolver{p}, Refusal);
}

}  // namespace
}  // namespace wick::diffusion
