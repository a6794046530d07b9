/// Thermals and plumes against similarity theory [Morton, Taylor & Turner 1956].
#include <gtest/gtest.h>

#include "fluid/smoke.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;

/// Slope and value at 0 of the least-squares line.
struct Line {
  double slope = 0.0, intercept = 0.0;
};
Line fit(const std::vector<double>& x, const std::vector<double>& y) {
  double n = double(x.size()), sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, (sy - slope * sx) / n};
}
/// Exponent of y ~ (x - origin)^p.
double exponent(const std::vector<double>& x, const std::vector<double>& y, double origin) {
  std::vector<double> lx, ly;
  for (std::size_t i = 0; i < x.size(); ++i) lx.push_back(std::log(x[i] - origin)), ly.push_back(std::log(y[i]));
  return fit(lx, ly).slope;
}

/// A ball of slightly warm air, roughened by noise, so that it mixes as a thermal does.
SmokeState warm_ball(const SmokeParams& p, const Vec3& center, double radius, double excess) {
  SmokeState s = make_smoke_state(p);
  const Grid g = smoke_grid(p);
  for_each(p.resolution, [&](int i, int j, int k) {
    const std::size_t c = g.cell(i, j, k);
    if ((g.cell_center(i, j, k) - center).norm() > radius) return;
    s.temperature[c] = static_cast<float>(excess * (1 + 0.3 * hash_signed(1, c)));
  });
  return s;
}

SmokeParams thermal_box(int n) {
  SmokeParams p;
  p.resolution = {n, n, 2 * n};
  p.scalar_advection = Advection::conservative;
  p.vorticity = 0.0;
  p.active_window = false;
  return p;
}

TEST(Buoyancy, AThermalKeepsItsBuoyancy) {
  const SmokeParams p = thermal_box(24);
  SmokeState s = warm_ball(p, Vec3(0.5, 0.5, 0.3), 0.15, 10.0);
  SmokeSolver solver(p);
  const double before = total_heat(s, p);
  for (int step = 0; step < 40; ++step) {
    const auto r = solver.step(s, {}, {}, std::min(0.05, stable_dt(s, p, Vec3(0, 0, -9.81))));
    ASSERT_NEAR(total_heat(s, p) + r.heat_out, before, 1e-6 * before);
  }
}

/// Height of the top and half the width of a thermal: a twentieth of its heat lies beyond each.
struct Extent {
  double top = 0.0, half_width = 0.0;
};
Extent extent(const SmokeState& s, const Grid& g) {
  std::vector<double> along_z(g.nz, 0.0), along_x(g.nx, 0.0);
  double heat = 0.0;
  for_each({g.nx, g.ny, g.nz}, [&](int i, int j, int k) {
    const double q = s.temperature[g.cell(i, j, k)];
    heat += q, along_z[k] += q, along_x[i] += q;
  });
  const auto reached = [&](const std::vector<double>& q, bool from_top) {
    double beyond = 0.0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const std::size_t at = from_top ? q.size() - 1 - i : i;
      if ((beyond += q[at]) > 0.05 * heat) return (double(at) + 0.5) * g.h;
    }
    return 0.0;
  };
  return {reached(along_z, true), 0.5 * (reached(along_x, true) - reached(along_x, false))};
}

// Heights count from where the half width, which grows in proportion to height, would be 0; time from release.
TEST(LongBuoyancy, AThermalRisesAsTheRootOfTime) {
  SmokeParams p = thermal_box(64);
  p.sides = {Side::open, Side::open, Side::open, Side::open, Side::closed, Side::open};
  p.active_window = true;
  SmokeState s = warm_ball(p, Vec3(0.5, 0.5, 0.15), 0.07, 10.0);
  const Grid g = smoke_grid(p);
  SmokeSolver solver(p);
  std::vector<double> time, top, half_width;
  for (double t = 0; t < 16.0;) {
    const double dt = std::min(0.05, stable_dt(s, p, Vec3(0, 0, -9.81)));
    solver.step(s, {}, {}, dt);
    t += dt;
    const Extent e = extent(s, g);
    if (e.top < 0.5) continue;  // still a ball: it has to roll up first
    time.push_back(t), top.push_back(e.top), half_width.push_back(e.half_width);
  }
  const Line growth = fit(top, half_width);
  for (double& z : top) z += growth.intercept / growth.slope;
  const double power = exponent(time, top, 0.0);
  std::printf("thermal: entrainment %.3f exponent %.3f\n", growth.slope, power);
  EXPECT_NEAR(power, 0.5, 0.07);
  EXPECT_GT(growth.slope, 0.1);
  EXPECT_LT(growth.slope, 0.35);
}

// Time means on the axis of a plume over 6..20 source radii: w ~ z^(-1/3), g' ~ z^(-5/3).
TEST(LongBuoyancy, APlumeThinsOutAsItRises) {
  SmokeParams p;
  const int n = 48;
  const double cells = 3.0;  // radius of the source
  p.resolution = {n, n, 80};
  p.sides = {Side::open, Side::open, Side::open, Side::open, Side::closed, Side::open};
  p.vorticity = 0.0;
  p.active_window = false;
  const Grid g = smoke_grid(p);
  SmokeState s = make_smoke_state(p);
  SmokeSolver solver(p);
  SmokeSources sources;
  for_each({n, n, 2}, [&](int i, int j, int k) {
    if (std::hypot(i + 0.5 - n / 2.0, j + 0.5 - n / 2.0) <= cells)
      sources.cell.push_back(std::int64_t(g.cell(i, j, k)));
  });
  const double power = 60.0;  // [W]
  std::vector<double> mean_w(g.cells(), 0.0), mean_t(g.cells(), 0.0);
  double t = 0.0;
  for (int step = 0; t < 20.0; ++step) {
    const double dt = std::min(0.03, stable_dt(s, p, Vec3(0, 0, -9.81)));
    sources.heat.clear();
    for (const auto c : sources.cell) {
      sources.heat.push_back(power * dt / double(sources.cell.size()) * (1 + 0.5 * hash_signed(step, c)));
    }
    solver.step(s, sources, {}, dt);
    t += dt;
    if (t < 5.0) continue;
    for_each(p.resolution, [&](int i, int j, int k) {
      const std::size_t c = g.cell(i, j, k);
      mean_w[c] += dt * 0.5 * (s.velocity[2][g.face(2, i, j, k)] + s.velocity[2][g.face(2, i, j, k + 1)]);
      mean_t[c] += dt * s.temperature[c];
    });
  }
  std::vector<double> z, w, theta, width;
  for (int k = int(6 * cells); k < int(20 * cells); ++k) {
    double most_w = 0.0, most_t = 0.0, flux = 0.0, momentum = 0.0;
    for_each({n, n, 1}, [&](int i, int j, int) {
      most_w = std::max(most_w, mean_w[g.cell(i, j, k)]), most_t = std::max(most_t, mean_t[g.cell(i, j, k)]);
    });
    for_each({n, n, 1}, [&](int i, int j, int) {
      const double v = mean_w[g.cell(i, j, k)];
      if (v > 0.1 * most_w) flux += v, momentum += v * v;
    });
    z.push_back((k + 0.5) * g.h), w.push_back(most_w), theta.push_back(most_t);
    width.push_back(g.h * flux / std::sqrt(momentum));
  }
  const Line growth = fit(z, width);
  const double origin = -growth.intercept / growth.slope;
  const double p_w = exponent(z, w, origin), p_t = exponent(z, theta, origin);
  std::printf("plume: db/dz %.3f origin %.3f exponents w %.3f g' %.3f\n", growth.slope, origin, p_w, p_t);
  EXPECT_NEAR(p_w, -1.0 / 3.0, 0.08);
  EXPECT_NEAR(p_t, -5.0 / 3.0, 0.25);
}

}  // namespace
}  // namespace wick::fluid
