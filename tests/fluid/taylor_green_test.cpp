/// Taylor-Green vortices: u = sin x cos y e^{-2νt}, v = -cos x sin y e^{-2νt} on a periodic square of side 2π.
#include <gtest/gtest.h>

#include "fluid/smoke.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;
constexpr double pi = std::numbers::pi;

struct Result {
  double energy = 0.0;          ///< at the end over that at the start
  double error = 0.0;           ///< rms of the velocity against the exact one
  double divergence = 0.0;      ///< largest after any step [1/s]
  double pressure_error = 0.0;  ///< rms at the end over that of the exact pressure
};

Result taylor_green(int n, double dt, double end, double viscosity, Advection advection) {
  SmokeParams p;
  p.resolution = {n, n, 1};
  p.width = 2 * pi;
  p.sides = all_sides(Side::periodic);
  p.viscosity = viscosity, p.vorticity = 0.0;
  p.velocity_advection = advection;
  p.active_window = false;
  const Grid g = smoke_grid(p);
  const auto exact = [&](double t) {
    const double a = std::exp(-2 * viscosity * t);
    return face_field(g, [a](const Vec3& x) {
      return Vec3(a * std::sin(x.x()) * std::cos(x.y()), -a * std::cos(x.x()) * std::sin(x.y()), 0);
    });
  };
  const auto energy = [&](const FaceField& u) {
    double e = 0.0;
    for (int a = 0; a < 3; ++a) {
      for_each({g.nx, g.ny, 1}, [&](int i, int j, int k) { e += std::pow(double(u[a][g.face(a, i, j, k)]), 2); });
    }
    return e;
  };
  SmokeState s = make_smoke_state(p);
  s.velocity = exact(0);
  const double start = energy(s.velocity);
  SmokeSolver solver(p);
  SmokeSources still;
  still.gravity = Vec3::Zero();
  Result r;
  const int steps = int(std::lround(end / dt));
  for (int i = 0; i < steps; ++i) {
    r.divergence = std::max(r.divergence, solver.step(s, still, {}, dt).max_divergence);
  }
  r.energy = energy(s.velocity) / start;
  const FaceField wanted = exact(end);
  for (int a = 0; a < 2; ++a) r.error = std::max(r.error, distance(s.velocity[a], wanted[a]));
  // p = (ρ/4)(cos 2x + cos 2y) e^{-4νt} up to a constant; a projection's is that of the middle of its step.
  const double a2 = std::exp(-4 * viscosity * (end - 0.5 * dt));
  double off = 0.0, whole = 0.0, mean = 0.0;
  for (const double p_c : s.pressure) mean += p_c / double(g.cells());
  for_each({g.nx, g.ny, 1}, [&](int i, int j, int k) {
    const Vec3 x = g.cell_center(i, j, k);
    const double exact_p = 0.25 * a2 * p.air_density * (std::cos(2 * x.x()) + std::cos(2 * x.y()));
    off += std::pow(s.pressure[g.cell(i, j, k)] - mean - exact_p, 2), whole += exact_p * exact_p;
  });
  r.pressure_error = std::sqrt(off / whole);
  return r;
}

TEST(TaylorGreen, ViscousDecayHasTheRateOfTheEquation) {
  const double nu = 0.01, end = 10.0;
  const Result second = taylor_green(128, 0.01, end, nu, Advection::maccormack);
  const Result first = taylor_green(64, 0.02, end, nu, Advection::semi_lagrangian);
  const double rate = -std::log(second.energy) / end, first_rate = -std::log(first.energy) / end;
  RecordProperty("maccormack_rate_over_4nu", std::to_string(rate / (4 * nu)));
  RecordProperty("semi_lagrangian_rate_over_4nu", std::to_string(first_rate / (4 * nu)));
  std::printf("decay over 4 nu: maccormack %.4f semi-lagrangian %.4f div %.2e\n", rate / (4 * nu),
              first_rate / (4 * nu), second.divergence);
  EXPECT_NEAR(rate, 4 * nu, 0.03 * 4 * nu);
  EXPECT_GE(first_rate, 4 * nu);
  // Pressure goes as energy, which may be off by 3 % of the 40 % that it decays; as much again for its own order.
  std::printf("pressure error %.4f\n", second.pressure_error);
  EXPECT_LT(second.pressure_error, 0.03);
  // Velocity is held in floats of size 1 on cells of 0.05: one rounding each of six faces.
  EXPECT_LE(second.divergence, 6 * 6e-8 / (2 * pi / 128) * 2);
}

TEST(TaylorGreen, WithoutViscosityTheErrorFallsWithTheOrderOfTheScheme) {
  const auto run = [](int n, Advection a) { return taylor_green(n, 0.64 / n, 2.0, 0.0, a); };
  const Result coarse = run(32, Advection::maccormack), fine = run(64, Advection::maccormack);
  const Result c1 = run(32, Advection::semi_lagrangian), f1 = run(64, Advection::semi_lagrangian);
  std::printf("slopes %.3f %.3f  energies %.6f %.6f\n", std::log2(coarse.error / fine.error),
              std::log2(c1.error / f1.error), fine.energy, f1.energy);
  EXPECT_GE(std::log2(coarse.error / fine.error), 1.8);
  EXPECT_NEAR(std::log2(c1.error / f1.error), 1.0, 0.25);
  EXPECT_GT(fine.energy, f1.energy);
}

TEST(TaylorGreen, WithoutViscosityMacCormackKeepsMoreEnergyThanSemiLagrangian) {
  const double second = taylor_green(64, 0.02, 10.0, 0.0, Advection::maccormack).energy;
  const double first = taylor_green(64, 0.02, 10.0, 0.0, Advection::semi_lagrangian).energy;
  std::printf("energy left after 10: maccormack %.5f semi-lagrangian %.5f\n", second, first);
  EXPECT_GT(second, first);
  EXPECT_LE(second, 1.0 + 1e-6);
}

}  // namespace
}  // namespace wick::fluid
