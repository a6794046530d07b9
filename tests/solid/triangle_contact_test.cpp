/// Obstacles that reach between the vertices of a sheet, and sheets that are fast.
#include "solid/triangle_contact.h"

#include <gtest/gtest.h>

#include <random>

#include "core/parallel.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

/// A slab sampled at nodes, solid for |z| < half.
SampledShape sampled_slab(double half) {
  SampledShape slab;
  slab.origin = Vec3(-0.2, -0.2, -0.1);
  slab.spacing = 0.01;
  slab.nodes = {41, 41, 21};
  for (int k = 0; k < 21; ++k)
    for (int n = 0; n < 41 * 41; ++n) slab.distance.push_back(static_cast<float>(std::abs(0.01 * k - 0.1) - half));
  return slab;
}

/// Least distance of the whole sheet, on a lattice of 66 points in each triangle.
double least_distance(const Sheet& sheet, const Obstacle& obstacle) {
  constexpr int kParts = 10;
  double least = INFINITY;
  for (const Int3& t : sheet.mesh.triangles)
    for (int a = 0; a <= kParts; ++a)
      for (int b = 0; a + b <= kParts; ++b) {
        const Vec3 p =
            (a * sheet.state.x[t[0]] + b * sheet.state.x[t[1]] + (kParts - a - b) * sheet.state.x[t[2]]) / kParts;
        least = std::min(least, sample_distance(obstacle, p).distance);
      }
  return least;
}

/// Lowest point of the sheet on the vertical through p; infinite if there is none.
double height_over(const Sheet& sheet, const Vec3& p) {
  double lowest = INFINITY;
  for (const Int3& t : sheet.mesh.triangles) {
    const Vec3 &a = sheet.state.x[t[0]], &b = sheet.state.x[t[1]], &c = sheet.state.x[t[2]];
    const auto area = [&](const Vec3& u, const Vec3& v) {
      return (u.x() - p.x()) * (v.y() - p.y()) - (u.y() - p.y()) * (v.x() - p.x());
    };
    const double wa = area(b, c), wb = area(c, a), wc = area(a, b), sum = wa + wb + wc;
    if (sum == 0.0 || std::min({wa / sum, wb / sum, wc / sum}) < 0.0) continue;
    lowest = std::min(lowest, (wa * a.z() + wb * b.z() + wc * c.z()) / sum);
  }
  return lowest;
}

TEST(DeepestPoint, IsNoShallowerThanAnyPointOfALattice) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto point = [&] { return Vec3(place(random), place(random), place(random)); };
  for (int n = 0; n < 2000; ++n) {
    const std::array<Vec3, 3> corner = {point(), point(), point()};
    Obstacle obstacle;
    if (n % 2 == 0)
      obstacle.shape = SphereShape{point(), 0.1};
    else
      obstacle.shape = BoxShape{Vec3(-0.3, -0.02, -0.2), Vec3(0.3, 0.02, 0.2)};
    const DeepestPoint deepest = deepest_point(obstacle, corner);
    constexpr int kParts = 40;
    double least = INFINITY;
    for (int a = 0; a <= kParts; ++a)
      for (int b = 0; a + b <= kParts; ++b)
        least = std::min(
            least,
            sample_distance(obstacle, (a * corner[0] + b * corner[1] + (kParts - a - b) * corner[2]) / kParts)
                .distance);
    if (n % 2 != 0 && least < -0.01) continue;  // half through the plate
    // Exact for spheres; the descent ends within a hundredth of the triangle's size of a box.
    EXPECT_LT(deepest.distance, least + (n % 2 == 0 ? 1e-12 : 0.02)) << n;
    EXPECT_NEAR(deepest.weight[0] + deepest.weight[1] + deepest.weight[2], 1.0, 1e-12);
  }
}

TEST(TriangleContact, ABallSmallerThanATriangleHoldsTheSheetUp) {
  // Under the centroid of a triangle of 2 cm; the sheet is pinned at two sides and sags on it.
  ShellParams params;
  params.bending = 1e-5;
  Sheet sheet(equilateral(11, 11, 0.02), params);
  sheet.pin_where([](const Vec3& x) { return x.x() < 0.011 || x.x() > 0.189; });
  const Int3& t = sheet.mesh.triangles[sheet.mesh.triangle_count() / 2];
  const Vec3 under = (sheet.mesh.rest[t[0]] + sheet.mesh.rest[t[1]] + sheet.mesh.rest[t[2]]) / 3.0;
  constexpr double kRadius = 0.002;
  sheet.obstacles.push_back({"pea", SphereShape{under - Vec3(0, 0, kRadius - 0.005), kRadius}, 0.5});
  for (Vec3& x : sheet.state.x) x.z() += 0.006;
  for (Vec3& x : sheet.pins.target) x.z() = -0.004;  // drawn down around it
  sheet.gravity = Vec3(0, 0, -9.81);
  for (int k = 0; k < 60; ++k) {
    sheet.step(1.0 / 60.0);
    // A tenth of the thickness is left to the sweep that follows the contact.
    ASSERT_GT(least_distance(sheet, sheet.obstacles[0]), 0.4 * params.thickness) << k;
  }
  EXPECT_TRUE(sheet.finite());
}

TEST(TriangleContact, AKnifeHoldsTheSheetUp) {
  for (const double turn : {0.0, 0.4, 0.8}) {
    ShellParams params;
    params.bending = 1e-6;
    Sheet sheet(equilateral(31, 31, 0.01), params);
    Vec3 center = Vec3::Zero();
    for (const Vec3& x : sheet.mesh.rest) center += x / double(sheet.mesh.vertex_count());
    for (Vec3& x : sheet.state.x) {
      const Vec3 d = x - center;
      x = Vec3(std::cos(turn) * d.x() - std::sin(turn) * d.y(), std::sin(turn) * d.x() + std::cos(turn) * d.y(),
               0.01);
    }
    sheet.obstacles.push_back({"knife", BoxShape{Vec3(-0.3, -0.0005, -0.3), Vec3(0.3, 0.0005, 0.0)}, 1.0});
    sheet.gravity = Vec3(0, 0, -9.81);
    double least = INFINITY;
    for (int k = 0; k < 60; ++k) {
      sheet.step(1.0 / 60.0);
      least = std::min(least, least_distance(sheet, sheet.obstacles[0]));
    }
    EXPECT_GT(least, 0.25 * params.thickness) << turn;
  }
}

TEST(TriangleContact, FastSheetsDoNotPassThinPlates) {
  // Plates of 1 mm, sheets of 0.2 mm at 1 to 100 m/s: up to 28 mm a substep, from all angles.
  for (const double speed : {1.0, 10.0, 100.0})
    for (const double tilt : {0.0, 0.7, 1.5}) {
      ShellParams params;
      Sheet sheet(equilateral(9, 9, 0.01), params);
      for (Vec3& x : sheet.state.x) {
        const Vec3 d = x - Vec3(0.04, 0.035, 0.0);
        x = Vec3(std::cos(tilt) * d.x(), d.y(), 0.06 + std::sin(tilt) * d.x());
      }
      for (Vec3& v : sheet.state.v) v = Vec3(0.3, 0.1, -1.0).normalized() * speed;
      sheet.obstacles.push_back({"plate", BoxShape{Vec3(-1, -1, -0.0005), Vec3(1, 1, 0.0005)}, 0.3});
      sheet.run(0.1, 1.0 / 60.0);
      double lowest = INFINITY;
      for (const Vec3& x : sheet.state.x) lowest = std::min(lowest, x.z());
      EXPECT_GT(lowest, 0.0005) << speed << ' ' << tilt;
      EXPECT_TRUE(sheet.finite());
    }
}

TEST(TriangleContact, AFastRodPushesTheSheetThatItHitsBetweenVertices) {
  // A rod of 4 mm crosses a hanging sheet of triangles of 2 cm at 1 to 50 m/s, up to 14 mm a substep.
  for (const double speed : {1.0, 10.0, 50.0}) {
    ShellParams params;
    params.air_drag = 0.0;
    Sheet sheet(equilateral(11, 11, 0.02), params);
    const Int3& t = sheet.mesh.triangles[sheet.mesh.triangle_count() / 2];
    const Vec3 middle = (sheet.mesh.rest[t[0]] + sheet.mesh.rest[t[1]] + sheet.mesh.rest[t[2]]) / 3.0;
    const Vec3 half(0.001, 0.001, 0.002), center = middle - Vec3(0, 0, 0.03);
    sheet.obstacles.push_back({"rod", BoxShape{center - half, center + half}, 0.3});
    sheet.obstacles[0].velocity = Vec3(0, 0, speed);
    const double until = 0.05 / speed;
    const int steps = std::max(1, static_cast<int>(std::ceil(until * 60.0)));
    for (int k = 0; k < steps; ++k) {
      sheet.step(until / steps);
      sheet.obstacles[0].pose.shift += Vec3(0, 0, speed * until / steps);
    }
    EXPECT_GT(least_distance(sheet, sheet.obstacles[0]), 0.0) << speed;
    // The sheet over the rod's axis is above the rod, or has been thrown off.
    const Vec3 top = sheet.obstacles[0].pose.shift + center + Vec3(0, 0, half.z());
    EXPECT_GT(height_over(sheet, top), top.z()) << speed;
  }
}

TEST(TriangleContact, TakesAnImpulseThroughThePointThatIsHit) {
  // One free triangle falls on a small ball off its centroid: the impulse passes through the point of contact, so
  // that the angular momentum about it stays.
  ShellParams params;
  params.air_drag = params.damping = 0.0;
  params.substeps = 20;
  Sheet sheet(equilateral(2, 2, 0.02), params);
  for (Vec3& v : sheet.state.v) v = Vec3(0, 0, -1.0);
  const Vec3 at(0.004, 0.003, -0.004);
  sheet.obstacles.push_back({"pea", SphereShape{at, 0.001}, 0.0});
  const auto about = [&](const Vec3& p) -> Vec3 { return sheet.angular_momentum() - p.cross(sheet.momentum()); };
  const Vec3 contact = at + Vec3(0, 0, 0.001 + 0.5 * params.thickness);
  const Vec3 before = about(contact), momentum = sheet.momentum();
  sheet.run(0.0042, 0.0042 / 5.0);
  EXPECT_GT((sheet.momentum() - momentum).z(), 0.1 * momentum.norm());
  EXPECT_LT((about(contact) - before).norm(), 0.05 * before.norm());
}

TEST(TriangleContact, APinInsideAnObstacleThrowsNothing) {
  // A ball rises through the pinned middle of a sheet, and a box through its pinned corners.
  for (const bool ball : {true, false}) {
    ShellParams params;
    Sheet sheet(equilateral(21, 23, 0.02), params);
    const Vec3 middle = sheet.mesh.rest[sheet.mesh.vertex_count() / 2];
    sheet.pin_where([&](const Vec3& x) {
      return ball ? (x - middle).norm() < 0.015 : (x - sheet.mesh.rest[0]).norm() < 0.015 || x.x() > 0.39;
    });
    Obstacle obstacle;
    obstacle.velocity = Vec3(0, 0, 0.5);
    if (ball)
      obstacle.shape = SphereShape{middle - Vec3(0, 0, 0.2), 0.1};
    else
      obstacle.shape = BoxShape{Vec3(-1, -1, -0.3), Vec3(1, 1, -0.1)};
    sheet.obstacles.push_back(obstacle);
    sheet.gravity = Vec3(0, 0, -9.81);
    double fastest = 0.0, highest = 0.0;
    for (int k = 0; k < 40; ++k) {  // until the obstacle is a third of the sheet beyond the pins
      fastest = std::max(fastest, sheet.step(1.0 / 60.0).max_speed);
      sheet.obstacles[0].pose.shift += obstacle.velocity / 60.0;
      for (const Vec3& x : sheet.state.x) highest = std::max(highest, x.norm());
    }
    EXPECT_LT(fastest, 20.0) << ball;
    EXPECT_LT(highest, 1.5) << ball;
  }
}

TEST(TriangleContact, IsTheSameAtOneAndTwoThreads) {
  std::uint64_t hash[2];
  for (const int threads : {1, 2}) {
    ThreadLimit limit(threads);
    ShellParams params;
    params.bending = 1e-6;
    Sheet sheet(equilateral(61, 61, 0.005), params);
    for (Vec3& x : sheet.state.x) x += Vec3(-0.15, -0.13, 0.03);
    sheet.obstacles.push_back({"slab", sampled_slab(0.02), 0.3});
    sheet.obstacles.push_back({"knife", BoxShape{Vec3(-0.01, -1, 0.0), Vec3(0.01, 1, 0.025)}, 0.3});
    sheet.gravity = Vec3(0, 0, -9.81);
    sheet.run(0.25, 1.0 / 60.0);
    StateHash digest;
    visit(digest, sheet.state);
    hash[threads - 1] = digest.digest();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

}  // namespace
}  // namespace wick::solid
