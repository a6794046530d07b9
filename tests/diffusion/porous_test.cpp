/// Capillary flow against the laws of wicking: Lucas-Washburn, Jurin, similarity, the linear limit.
#include "diffusion/porous.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

const Vec3 down(0.0, 0.0, -9.81);

DiffusionParams porous(double permeability) {
  DiffusionParams p = testing::plain_diffusion(0.0);
  p.model = Model::porous;
  p.porous.permeability = permeability;
  p.tolerance = 1e-10;
  return p;
}

/// A strip that drinks at x = 0; `upright` lets it hang with that end below.
struct Strip {
  Sheet sheet;
  Values rate, value, u;
  int nx;
  Strip(int columns, int rows, double width, bool upright)
      : sheet(testing::sheet(columns, rows, Vec2(1.0, width))),
        rate(sheet.mass.size(), 0.0),
        value(sheet.mass.size(), 1.0),
        u(sheet.mass.size(), 0.0),
        nx(columns) {
    for (std::size_t i = 0; i < u.size(); ++i) {
      const Vec3& x = sheet.mesh.rest[i];
      if (x.x() == 0.0) rate[i] = 1e30 * sheet.mass[i];  // held at u = 1
      if (upright) sheet.x[i] = Vec3(0.0, x.y(), x.x());
    }
  }
  DiffusionReport step(DiffusionSolver& solver, double dt) {
    DiffusionInput in = sheet.input();
    in.supply_rate = &rate;
    in.supply_value = &value;
    in.capacity = 1.0;
    in.gravity = down;
    const DiffusionReport report = solver.step(u, in, dt);
    EXPECT_LT(testing::budget_error(report), 1e-12);
    EXPECT_TRUE(report.solve.converged);
    return report;
  }
  /// u at x on the lowest row.
  [[nodiscard]] double at(double x) const {
    const double place = std::clamp(x * (nx - 1), 0.0, nx - 1.000001);
    const auto i = static_cast<std::size_t>(place);
    return std::lerp(u[i], u[i + 1], place - static_cast<double>(i));
  }
  /// Where u falls through `level` on the lowest row.
  [[nodiscard]] double front(double level = 0.5) const {
    for (int i = 0; i + 1 < nx; ++i)
      if (u[i] >= level && u[i + 1] < level) return (i + (u[i] - level) / (u[i] - u[i + 1])) / (nx - 1);
    return u[nx - 1] >= level ? 1.0 : 0.0;
  }
};

TEST(Porous, FrontFollowsTheSquareRootOfTime) {
  // [Lucas 1918, Washburn 1921]: L ~ sqrt(t); and s depends on x/sqrt(t) alone [Boltzmann 1894].
  Strip strip(200, 10, 0.05, false);
  DiffusionSolver solver(porous(1e-8));
  const double dt = 0.005, first = 0.2, last = 2.0;
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  int count = 0;
  std::vector<Values> profiles;
  for (int n = 1; n <= static_cast<int>(std::round(last / dt)); ++n) {
    strip.step(solver, dt);
    const double t = n * dt;
    if (t < first - 1e-9) continue;
    const double x = std::log(t), y = std::log(strip.front());
    sx += x, sy += y, sxx += x * x, sxy += x * y, ++count;
    for (const double moment : {0.2, 0.6, 2.0})
      if (std::abs(t - moment) < 1e-9) {
        Values profile;
        for (int k = 0; k <= 100; ++k) profile.push_back(strip.at(0.006 * k * std::sqrt(t)));
        profiles.push_back(profile);
      }
  }
  const double slope = (count * sxy - sx * sy) / (count * sxx - sx * sx);
  std::printf("  front %.3f m after %.1f s, slope %.4f\n", strip.front(), last, slope);
  EXPECT_NEAR(slope, 0.5, 0.03);
  ASSERT_EQ(profiles.size(), 3u);
  for (const auto& [a, b] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
    std::printf("  collapse of profiles %d and %d: rms %.4f\n", a, b, testing::rms(profiles[a], profiles[b]));
    EXPECT_LT(testing::rms(profiles[a], profiles[b]), 0.02);
  }
}

TEST(Porous, RisesToTheHeightThatItsSuctionHolds) {
  // At rest Ψ is constant: k_c (1 - s + ε)^a = k_c ε^a + ρ g z [Jurin 1718].
  Strip strip(200, 10, 0.05, true);
  const DiffusionParams p = porous(1e-8);
  DiffusionSolver solver(p);
  for (int n = 0; n < 40; ++n) strip.step(solver, 0.01 * std::pow(1.5, n));
  const double weight = p.porous.density * 9.81, eps = p.porous.regularisation, a = p.porous.exponent;
  const auto height = [&](double s) {
    return p.porous.capillary * (std::pow(1.0 - s + eps, a) - std::pow(eps, a)) / weight;
  };
  for (const double s : {0.9, 0.5, 0.1}) {
    std::printf("  s = %.1f at %.4f m, closed form %.4f\n", s, strip.front(s), height(s));
    EXPECT_NEAR(strip.front(s) / height(s), 1.0, 0.03);
  }
  EXPECT_EQ(strip.at(0.9), 0.0);
}

TEST(Porous, SharpFrontRisesAsTheOdeSays) {
  // dL/dt = a/L - b with a = b = 1 [Washburn 1921, with gravity]: t = -L - ln(1 - L). With the exponent near 0
  // the suction acts at the front alone; what is left of its width is 1/ln(1/ε) = 4 % of the height.
  Strip strip(101, 3, 0.02, true);
  DiffusionParams p = porous(0.0);
  p.porous.exponent = 0.02;
  p.porous.regularisation = 1e-12;
  const double weight = p.porous.density * 9.81;
  p.porous.capillary = weight / (1.0 - std::pow(p.porous.regularisation, p.porous.exponent));
  p.porous.permeability = p.porous.porosity * p.porous.viscosity / weight;
  DiffusionSolver solver(p);
  double t = 0.0;
  for (const auto& [time, length] :
       {std::pair{0.00536052, 0.1}, std::pair{0.19314718, 0.5}, std::pair{1.40258509, 0.9}}) {
    while (t < time) {
      const double dt = std::min(time - t, std::max(2e-5, 0.01 * t));
      strip.step(solver, dt);
      t = time - t - dt < 1e-12 ? time : t + dt;
    }
    std::printf("  t = %.5f: L = %.4f, ODE %.1f\n", t, strip.front(), length);
    EXPECT_NEAR(strip.front() / length, 1.0, 0.05);
  }
}

TEST(Porous, SmallDisturbancesDiffuseLinearly) {
  // D = K k_c a/(φ μ) kr(s) (1 - s + ε)^(a-1); backward Euler damps cos(πx) by 1/(1 + D π² dt) a step.
  struct Case {
    double s, exponent, relative;
  };
  for (const Case& c : {Case{0.5, 0.1, 1.0}, Case{0.9, 0.1, 1.0}, Case{0.3, 0.5, 3.0}, Case{0.6, 2.0, 2.0}}) {
    Sheet sheet(testing::sheet(41, 47));
    DiffusionParams p = porous(1e-8);
    p.tolerance = 1e-14;
    p.porous.exponent = c.exponent;
    p.porous.relative = c.relative;
    const PorousParams& q = p.porous;
    const double d = q.permeability * q.capillary * q.exponent / (q.porosity * q.viscosity) *
                     std::pow(c.s, q.relative) * std::pow(1.0 - c.s + q.regularisation, q.exponent - 1.0);
    Values u = sheet.field([&](const Vec3& x) { return c.s + 1e-3 * std::cos(M_PI * x.x()); });
    const auto mode = [&] {
      double sum = 0.0;
      for (std::size_t i = 0; i < u.size(); ++i)
        sum += sheet.mass[i] * (u[i] - c.s) * std::cos(M_PI * sheet.mesh.rest[i].x());
      return sum;
    };
    const double dt = 0.05 / (d * M_PI * M_PI), before = mode();
    DiffusionSolver solver(p);
    for (int n = 0; n < 20; ++n) solver.step(u, sheet.input(), dt);
    const double measured = (std::pow(before / mode(), 1.0 / 20.0) - 1.0) / (dt * M_PI * M_PI);
    // 1 %: (π h)²/12 of the mesh, and what the disturbance itself changes of D.
    EXPECT_NEAR(measured / d, 1.0, 0.01) << "s " << c.s << " a " << c.exponent << " n " << c.relative;
  }
}

TEST(Porous, SqueezingDrivesLiquidOutAndStretchingDoesNot) {
  // Half of the sheet is narrower by a tenth along y: its pores shrink and are under pressure.
  for (const double width : {0.9, 1.1}) {
    Sheet sheet(testing::sheet(41, 24, Vec2(1.0, 0.5)));
    for (Vec3& x : sheet.x)
      if (x.x() > 0.5) x.y() *= width;
    Values u(sheet.mass.size(), 0.5);
    DiffusionParams p = porous(1e-8);
    DiffusionSolver solver(p);
    for (int n = 0; n < 60; ++n) solver.step(u, sheet.input(), 1.0);
    double left = 0.0, right = 0.0, count = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double x = sheet.mesh.rest[i].x();
      if (x < 0.4) left += u[i], ++count;
      if (x > 0.6) right += u[i];
    }
    if (width < 1.0)
      EXPECT_LT(right, 0.8 * left);
    else
      EXPECT_GT(right, left);  // larger pores hold more at the same suction
    EXPECT_NEAR(sheet.total(u), 0.25, 1e-12);
  }
}

TEST(Porous, RetentionCurveInverts) {
  PorousParams p;
  for (const double a : {0.01, 0.1, 1.0, 4.0})
    for (const double eps : {1e-12, 1e-3, 0.1})
      for (const double stiffness : {0.0, 1.0, 1e4, 1e9}) {
        p.exponent = a;
        p.regularisation = eps;
        const Retention curve(p);
        for (const double s : {-0.5, 0.0, 1e-6, 0.3, 0.9, 0.999, 1.0, 1.7}) {
          const double psi = curve.potential(s, stiffness, 12.0);
          // Rounding of Ψ, seen through ds/dΨ.
          const double rounding = 1e-13 * (std::abs(psi) + p.capillary + stiffness) * curve.storage(s, stiffness);
          EXPECT_NEAR(curve.saturation(psi, stiffness, 12.0), s, 1e-12 + 10.0 * rounding) << a << ' ' << eps;
        }
      }
}

TEST(Porous, HalvingTheStepHalvesTheChange) {
  const auto wet = [](double dt) {
    Strip strip(100, 5, 0.05, true);
    DiffusionSolver solver(porous(1e-8));
    for (int n = 0; n < static_cast<int>(std::round(1.0 / dt)); ++n) strip.step(solver, dt);
    return strip.u;
  };
  const Values a = wet(0.05), b = wet(0.025), c = wet(0.0125);
  std::printf("  rms change of u under dt/2: %.5f %.5f\n", testing::rms(a, b), testing::rms(b, c));
  EXPECT_LT(testing::rms(b, c), 0.6 * testing::rms(a, b));
}

TEST(Porous, StiffSupplyIsTheLimitOfStifferOnes) {
  for (const double dt : {0.05, 0.0125}) {
    Values last;
    for (const double stiffness : {1e6, 1e9, 1e12, 1e30}) {
      Strip strip(100, 5, 0.05, true);
      for (double& k : strip.rate)
        if (k > 0.0) k *= stiffness / 1e30;
      DiffusionSolver solver(porous(1e-8));
      for (int n = 0; n < static_cast<int>(std::round(0.5 / dt)); ++n) strip.step(solver, dt);
      std::printf("  rate %.0e 1/s, dt %.4f: front %.4f\n", stiffness, dt, strip.front());
      if (stiffness > 1e9) {
        EXPECT_LT(testing::rms(strip.u, last), 1e-3);
      }
      last = strip.u;
    }
  }
}

}  // namespace
}  // namespace wick::diffusion
