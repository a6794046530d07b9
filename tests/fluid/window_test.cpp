#include "fluid/window.h"

#include <gtest/gtest.h>

#include "tests/fluid/flows.h"

namespace wick::fluid {
namespace {

using namespace test;

TEST(Window, CroppingAndPastingChangesNothingInside) {
  SmokeParams p;
  p.resolution = {20, 17, 23};
  const Grid g = smoke_grid(p);
  SmokeState s = make_smoke_state(p);
  s.velocity = stirring(g, p.sides, {}, 1.0, 2);
  s.density = cell_field(g, [](const Vec3& x) { return std::sin(40 * x.sum()); });
  const Window w = {{3, 0, 5}, {19, 16, 23}};
  const SmokeState part = crop(s, g, w);
  const SmokeParams inner = window_params(p, w);
  const Grid gw = smoke_grid(inner);
  EXPECT_NEAR(gw.h, g.h, 1e-15);
  EXPECT_EQ(inner.sides[0], Side::open);
  EXPECT_EQ(inner.sides[2], Side::closed);
  for_each({16, 16, 18}, [&](int i, int j, int k) {
    ASSERT_EQ(part.density[gw.cell(i, j, k)], s.density[g.cell(i + 3, j, k + 5)]);
    ASSERT_EQ(part.velocity[1][gw.face(1, i, j, k)], s.velocity[1][g.face(1, i + 3, j, k + 5)]);
  });
  SmokeState back = s;
  paste(part, g, w, back);
  EXPECT_EQ(back.density, s.density);
  EXPECT_EQ(back.velocity[2][g.face(2, 4, 3, 7)], s.velocity[2][g.face(2, 4, 3, 7)]);
  EXPECT_EQ(back.velocity[2][g.face(2, 0, 3, 7)], 0.0F);
}

/// A plate above the middle of the floor whose faces hang on three masses and take their velocities.
struct Plate {
  Walls walls;
  MovableWalls movable;
  std::vector<Vec3> velocity = std::vector<Vec3>(3, Vec3::Zero());

  Plate(const Grid& g, const Sides& sides) {
    walls = bag(g, [](const Vec3&) { return false; });
    const int k = int(0.42 / g.h);
    for_each({g.nx, g.ny, 1}, [&](int i, int j, int) {
      const Vec3 x = g.face_center(2, i, j, k);
      if (std::abs(x.x() - 0.5) > 0.15 || std::abs(x.y() - 0.5) > 0.15) return;
      const std::size_t face = g.face(2, i, j, k);
      const double s = x.x(), t = (1.0 - s) * x.y();
      walls.closed[2][face] = 1;
      movable.axis.push_back(2), movable.face.push_back(std::int64_t(face));
      movable.dof.push_back({0, 1, 2}), movable.weight.push_back({s, t, 1.0 - s - t});
    });
    mark_near_walls(g, sides, walls);
    movable.inverse_mass.assign(3, 3.0 / (0.14 * 0.3 * 0.3));
  }
  /// Sets the faces to the velocity of the masses, which `impulse` has changed.
  void push(const std::vector<Vec3>& impulse) {
    for (std::size_t d = 0; d < velocity.size(); ++d) velocity[d] += movable.inverse_mass[d] * impulse[d];
    for (std::size_t r = 0; r < movable.face.size(); ++r) {
      double w = 0.0;
      for (int m = 0; m < 3; ++m) w += movable.weight[r][m] * velocity[movable.dof[r][m]].z();
      walls.velocity[2][movable.face[r]] = float(w);
    }
  }
};

struct Plume {
  SmokeState state;
  double height = 0.0;  ///< of the middle of the smoke
  double share = 0.0;   ///< of the box stepped, mean over the steps
  double lost = 0.0;    ///< smoke that the books cannot place [kg]
  double lifted = 0.0;  ///< speed of the plate, mean of its masses [m/s]
};

Plume plume(bool active, int steps, Advection scheme, bool with_plate = false) {
  SmokeParams p;
  p.resolution = {64, 64, 96};
  p.active_window = active;
  p.scalar_advection = scheme;
  const Grid g = smoke_grid(p);
  Plume result = {make_smoke_state(p), 0, 0, 0, 0};
  Plate plate(g, p.sides);
  SmokeState& s = result.state;
  SmokeSolver solver(p);
  SmokeSources sources;
  for_each(p.resolution, [&](int i, int j, int k) {
    if ((g.cell_center(i, j, k) - Vec3(0.5, 0.5, 0.2)).norm() < 0.07)
      sources.cell.push_back(std::int64_t(g.cell(i, j, k)));
  });
  sources.heat.assign(sources.cell.size(), 20.0 / double(sources.cell.size()));
  sources.smoke.assign(sources.cell.size(), 1e-5 / double(sources.cell.size()));
  double booked = 0.0;
  for (int step = 0; step < steps; ++step) {
    std::vector<Vec3> impulse;
    const auto r = with_plate ? solver.step(s, sources, plate.walls, 0.02, &plate.movable, &impulse)
                              : solver.step(s, sources, {}, 0.02);
    if (with_plate) plate.push(impulse);
    booked += 1e-5 - r.smoke_out + r.smoke_advection;
    result.share += double(r.active_cells) / double(g.cells()) / steps;
  }
  result.lost = booked - total_smoke(s, p);
  for (const Vec3& v : plate.velocity) result.lifted += v.z() / 3.0;
  double smoke = 0.0;
  for_each(p.resolution, [&](int i, int j, int k) {
    smoke += s.density[g.cell(i, j, k)];
    result.height += s.density[g.cell(i, j, k)] * (g.cell_center(i, j, k).z() - 0.2);
  });
  result.height /= smoke;
  return result;
}

double relative_distance(const CellField& a, const CellField& b) {
  return distance(a, b) / distance(b, CellField(b.size(), 0.0F));
}

// What the truncated pressure costs: under two percent of the smoke field (rms), half of one of its rise.
TEST(Window, APlumeIsThatOfTheWholeBox) {
  const Plume window = plume(true, 50, Advection::maccormack), whole = plume(false, 50, Advection::maccormack);
  const double field = relative_distance(window.state.density, whole.state.density);
  std::printf("window: share %.3f, smoke %.4f, rise %.4f\n", window.share, field, window.height / whole.height - 1);
  EXPECT_LT(window.share, 0.8);
  EXPECT_LT(field, 0.02);
  EXPECT_NEAR(window.height, whole.height, 0.005 * whole.height);
}

// With a light plate in the way, pushed by the gas: the same tolerance on the smoke, two percent on the plate,
// whose pressure is what the window truncates.
TEST(Window, APlateIsLiftedAsInTheWholeBox) {
  const Plume window = plume(true, 50, Advection::maccormack, true);
  const Plume whole = plume(false, 50, Advection::maccormack, true);
  const double field = relative_distance(window.state.density, whole.state.density);
  std::printf("window with plate: share %.3f, smoke %.4f, rise %.4f, plate %.4f %.4f m/s\n", window.share, field,
              window.height / whole.height - 1, window.lifted, whole.lifted);
  EXPECT_LT(window.share, 0.8);
  EXPECT_LT(field, 0.02);
  EXPECT_NEAR(window.height, whole.height, 0.005 * whole.height);
  EXPECT_GT(whole.lifted, 0.0);
  EXPECT_NEAR(window.lifted, whole.lifted, 0.02 * whole.lifted);
}

TEST(Window, LosesNoSmoke) {
  const Plume window = plume(true, 20, Advection::conservative);
  EXPECT_NEAR(window.lost, 0.0, 1e-6 * 20 * 1e-5);
}

TEST(Window, ANewSolverGoesOnWithTheSameBits) {
  SmokeParams p;
  p.resolution = {48, 48, 64};
  SmokeState s = make_smoke_state(p);
  SmokeSources sources;
  sources.cell = {std::int64_t(smoke_grid(p).cell(24, 24, 10))};
  sources.heat = {5.0}, sources.smoke = {1e-5};
  SmokeSolver solver(p);
  for (int step = 0; step < 4; ++step) solver.step(s, sources, {}, 0.03);
  SmokeState again = s;
  SmokeSolver other(p);
  for (int step = 0; step < 4; ++step) solver.step(s, sources, {}, 0.03), other.step(again, sources, {}, 0.03);
  EXPECT_EQ(s.density, again.density);
  EXPECT_EQ(s.velocity, again.velocity);
  EXPECT_EQ(s.window, again.window);
}

}  // namespace
}  // namespace wick::fluid
