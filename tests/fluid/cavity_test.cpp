/// Lid-driven cavity against the tables of [Ghia 1982]: u on x = 1/2, v on y = 1/2.
#include <gtest/gtest.h>

#include "fluid/smoke.h"
#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;

struct Row {
  double y, u100, u1000, x, v100, v1000;
};
constexpr Row ghia[] = {
    {0.9766, 0.84123, 0.65928, 0.9688, -0.05906, -0.21388},  {0.9688, 0.78871, 0.57492, 0.9609, -0.07391, -0.27669},
    {0.9609, 0.73722, 0.51117, 0.9531, -0.08864, -0.33714},  {0.9531, 0.68717, 0.46604, 0.9453, -0.10313, -0.39188},
    {0.8516, 0.23151, 0.33304, 0.9063, -0.16914, -0.51550},  {0.7344, 0.00332, 0.18719, 0.8594, -0.22445, -0.42665},
    {0.6172, -0.13641, 0.05702, 0.8047, -0.24533, -0.31966}, {0.5000, -0.20581, -0.06080, 0.5000, 0.05454, 0.02526},
    {0.4531, -0.21090, -0.10648, 0.2344, 0.17527, 0.32235},  {0.2813, -0.15662, -0.27805, 0.2266, 0.17507, 0.33075},
    {0.1719, -0.10150, -0.38289, 0.1563, 0.16077, 0.37095},  {0.1016, -0.06434, -0.29730, 0.0938, 0.12317, 0.32627},
    {0.0703, -0.04775, -0.22220, 0.0781, 0.10890, 0.30353},  {0.0625, -0.04192, -0.20196, 0.0703, 0.10091, 0.29012},
    {0.0547, -0.03717, -0.18109, 0.0625, 0.09233, 0.27485},
};

struct Cavity {
  double error = 0.0;   ///< largest difference from the table
  double change = 0.0;  ///< largest |du/dt| at the end
  double vortex_x = 0.0, vortex_y = 0.0;
};

/// Value at `where` between values at (i + 1/2)/n, linear between them and to the sides.
double between(const std::vector<double>& q, double low, double high, double where) {
  const int n = int(q.size());
  const double s = where * n - 0.5;
  if (s < 0) return low + (q.front() - low) * (where * n / 0.5);
  if (s > n - 1) return high + (q.back() - high) * ((1 - where) * n / 0.5);
  const int i = std::min(int(s), n - 2);
  return q[i] + (s - i) * (q[i + 1] - q[i]);
}

Cavity run_cavity(int n, double reynolds, double end) {
  SmokeParams p;
  p.resolution = {n, n, 1};
  p.sides = {Side::closed, Side::closed, Side::closed, Side::closed, Side::periodic, Side::periodic};
  p.no_slip = true;
  p.side_velocity[3] = Vec3(1, 0, 0);
  p.viscosity = 1.0 / reynolds, p.vorticity = 0.0;
  p.active_window = false;
  const Grid g = smoke_grid(p);
  SmokeState s = make_smoke_state(p);
  SmokeSolver solver(p);
  SmokeSources still;
  still.gravity = Vec3::Zero();
  const double dt = 1.0 / n;
  Cavity result;
  for (double t = 0; t < end; t += dt) {
    const FaceField before = s.velocity;
    solver.step(s, still, {}, dt);
    result.change = 0.0;
    for (int a = 0; a < 2; ++a) {
      for (std::size_t f = 0; f < before[a].size(); ++f) {
        result.change = std::max(result.change, std::abs(double(s.velocity[a][f]) - before[a][f]) / dt);
      }
    }
    if (result.change < 1e-4) break;
  }

  std::vector<double> u(n), v(n);
  for (int i = 0; i < n; ++i) {
    u[i] = s.velocity[0][g.face(0, n / 2, i, 0)];
    v[i] = s.velocity[1][g.face(1, i, n / 2, 0)];
  }
  for (const Row& row : ghia) {
    const double wanted_u = reynolds < 500 ? row.u100 : row.u1000, wanted_v = reynolds < 500 ? row.v100 : row.v1000;
    result.error = std::max(result.error, std::abs(between(u, 0, 1, row.y) - wanted_u));
    result.error = std::max(result.error, std::abs(between(v, 0, 0, row.x) - wanted_v));
  }
  // The centre of the vortex is where the stream function, summed up from the floor, is lowest.
  double lowest = 0.0;
  for (int i = 1; i < n; ++i) {
    double psi = 0.0;
    for (int j = 0; j < n; ++j) {
      psi += s.velocity[0][g.face(0, i, j, 0)] / n;
      if (psi < lowest) lowest = psi, result.vortex_x = double(i) / n, result.vortex_y = (j + 1.0) / n;
    }
  }
  std::printf("cavity %d Re %g: error %.4f change %.1e vortex %.4f %.4f\n", n, reynolds, result.error,
              result.change, result.vortex_x, result.vortex_y);
  return result;
}

// Half the resolution of the long test: four times its allowance for a second-order scheme, of which we take two.
TEST(Cavity, Reynolds100OnACoarseGrid) {
  const Cavity c = run_cavity(64, 100, 15);
  EXPECT_LT(c.error, 0.02);
  EXPECT_NEAR(c.vortex_x, 0.617, 0.02);
  EXPECT_NEAR(c.vortex_y, 0.734, 0.02);
}
TEST(LongCavity, Reynolds100) {
  const Cavity c = run_cavity(128, 100, 30);
  EXPECT_LT(c.error, 0.01);
  EXPECT_NEAR(c.vortex_x, 0.617, 0.01);
  EXPECT_NEAR(c.vortex_y, 0.734, 0.01);
}
TEST(LongCavity, Reynolds1000) {
  const Cavity c = run_cavity(128, 1000, 80);
  EXPECT_LT(c.error, 0.03);
  EXPECT_NEAR(c.vortex_x, 0.531, 0.01);
  EXPECT_NEAR(c.vortex_y, 0.563, 0.01);
}

}  // namespace
}  // namespace wick::fluid
