/// Gradients of the constraints against central differences over decades of size and deformation, and lanes against
/// doubles.
#include <gtest/gtest.h>

#include "core/noise.h"
#include "solid/bending.h"
#include "solid/membrane.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

Triple<double> triple(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 vec(const Triple<double>& v) {
  return {v.x, v.y, v.z};
}
Vec3 random_vector(std::uint64_t seed, std::uint64_t i) {
  return {hash_signed(seed, 3 * i), hash_signed(seed, 3 * i + 1), hash_signed(seed, 3 * i + 2)};
}

using Corners = std::array<Vec3, 3>;

Vec3 strain(const RestEdges<double>& b, const Corners& x) {
  const auto c = green_strain(deformation(b, triple(x[1] - x[0]), triple(x[2] - x[0])));
  return {c.g00, c.g11, c.g01_twice};
}

TEST(Derivative, GreenStrainOverDecadesOfSizeAndStretch) {
  for (double size = 1e-5; size < 1e4; size *= 10.0)
    for (double stretch = 1e-2; stretch < 1e3; stretch *= 10.0)
      for (int trial = 0; trial < 20; ++trial) {
        const RestEdges<double> b = {1.0 / size, 0.2 / size, -0.4 / size, 1.3 / size};
        Corners x;
        for (int k = 0; k < 3; ++k) x[k] = stretch * size * random_vector(7, 3 * trial + k);
        const auto F = deformation(b, triple(x[1] - x[0]), triple(x[2] - x[0]));
        const double rows[3][2] = {{-(b.b10 + b.b20), -(b.b11 + b.b21)}, {b.b10, b.b11}, {b.b20, b.b21}};
        for (int c = 0; c < 3; ++c) {
          const Strain<double> unit = {c == 0 ? 1.0 : 0.0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
          for (int k = 0; k < 3; ++k) {
            const Vec3 gradient = vec(pull_back(F, unit, rows[k][0], rows[k][1]));
            for (int axis = 0; axis < 3; ++axis) {
              // The strain is quadratic, so central differences are exact but for rounding.
              const double step = 1e-3 * stretch * size;
              Corners up = x, down = x;
              up[k][axis] += step;
              down[k][axis] -= step;
              const double difference = (strain(b, up)[c] - strain(b, down)[c]) / (2.0 * step);
              const double scale = (stretch + 1e-3 / stretch) / size;
              EXPECT_NEAR(gradient[axis] / scale, difference / scale, 1e-9);
            }
          }
        }
      }
}

TEST(Derivative, DihedralAngleOverDecadesOfSizeAndAngle) {
  for (double size = 1e-5; size < 1e4; size *= 10.0)
    for (const double fold : {-3.1, -2.0, -1.0, -1e-2, -1e-5, 0.0, 1e-8, 1e-4, 1e-2, 0.5, 1.5, 2.5, 3.1}) {
      std::array<Vec3, 4> x = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.3, 0.8, 0),
                               Vec3(0.6, -0.9 * std::cos(fold), -0.9 * std::sin(fold))};
      for (int k = 0; k < 4; ++k) x[k] *= size;
      const auto hinge = hinge_angle(triple(x[0]), triple(x[1]), triple(x[2]), triple(x[3]));
      EXPECT_NEAR(hinge.angle, fold, 1e-14 + 1e-13 * std::abs(fold));
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        sum += vec(hinge.gradient[k]);
        for (int axis = 0; axis < 3; ++axis) {
          const double step = 1e-5 * size;
          auto up = x, down = x;
          up[k][axis] += step;
          down[k][axis] -= step;
          const double difference =
              (dihedral_angle(up[0], up[1], up[2], up[3]) - dihedral_angle(down[0], down[1], down[2], down[3])) /
              (2.0 * step);
          // Truncation (1e-5)², rounding 1e-16/1e-5.
          EXPECT_NEAR(vec(hinge.gradient[k])[axis] * size, difference * size, 1e-8) << fold;
        }
      }
      EXPECT_LT(sum.norm() * size, 1e-13);
    }
}

TEST(Derivative, ArcTangentMatchesTheLibrary) {
  for (double angle = -3.14; angle < 3.14; angle += 1e-3)
    for (const double length : {1e-200, 1e-20, 1.0, 1e20, 1e150}) {
      const double y = length * std::sin(angle), x = length * std::cos(angle);
      EXPECT_NEAR(arc_tangent(y, x), std::atan2(y, x), 1e-15 * 4.0) << angle;
    }
  EXPECT_EQ(arc_tangent(0.0, 0.0), 0.0);
}

TEST(Isometric, WeightsVanishOnAffineLayouts) {
  for (int trial = 0; trial < 100; ++trial) {
    std::array<Vec3, 4> X = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.4, 0.8, 0), Vec3(0.5, -0.7, 0)};
    for (int k = 0; k < 4; ++k) X[k].head<2>() += 0.2 * random_vector(3, 4 * trial + k).head<2>();
    const auto K = isometric_weights(X[0], X[1], X[2], X[3]);
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) sum += K[k] * (2.0 * X[k] + X[k].y() * Vec3(0, 3, 1) + Vec3(5, 6, 7));
    EXPECT_LT(sum.norm(), 1e-12);
    EXPECT_NEAR(K[0] + K[1] + K[2] + K[3], 0.0, 1e-13);
  }
}

TEST(Lanes, GatherScatterAndKernelsAgreeWithDoubles) {
  std::vector<Row> rows(40);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vec3 r = random_vector(9, i);
    rows[i] = {r.x(), r.y(), r.z(), 1.0 + hash_unit(10, i)};
  }
  const std::int32_t index[4][4] = {{0, 10, 20, 30}, {1, 11, 21, 31}, {2, 12, 22, 32}, {3, 13, 23, 33}};
  std::array<Vertex<Lanes>, 4> v;
  std::array<Triple<Lanes>, 4> before;
  for (int k = 0; k < 4; ++k) {
    v[k] = gather(rows.data(), index[k]);
    const Lanes shift = {0.01, 0.02, -0.03, 0.01};
    before[k] = {v[k].p.x + shift * k, v[k].p.y - shift, v[k].p.z};
  }
  const MembraneLaw law = {1e-3, -2e-4, 2e-3, 5e-3};
  const auto lane = [](const Triple<Lanes>& t, int l) { return Triple<double>{t.x[l], t.y[l], t.z[l]}; };
  auto triangle = v, hinge = v;
  const RestEdges<Lanes> b = {constant<Lanes>(1.0), constant<Lanes>(0.1), constant<Lanes>(-0.2),
                              constant<Lanes>(1.5)};
  project_triangle(b, constant<Lanes>(30.0), law, 0.7, triangle[0], triangle[1], triangle[2], before[0], before[1],
                   before[2]);
  project_bent_hinge(constant<Lanes>(0.4), constant<Lanes>(0.3), 0.7, hinge, before);
  for (int l = 0; l < 4; ++l) {
    std::array<Vertex<double>, 4> s, t;
    for (int k = 0; k < 4; ++k) s[k] = t[k] = {lane(v[k].p, l), v[k].w[l]};
    project_triangle(RestEdges<double>{1.0, 0.1, -0.2, 1.5}, 30.0, law, 0.7, s[0], s[1], s[2], lane(before[0], l),
                     lane(before[1], l), lane(before[2], l));
    std::array<Triple<double>, 4> old;
    for (int k = 0; k < 4; ++k) old[k] = lane(before[k], l);
    project_bent_hinge(0.4, 0.3, 0.7, t, old);
    for (int k = 0; k < 3; ++k) EXPECT_LT((vec(s[k].p) - vec(lane(triangle[k].p, l))).norm(), 1e-12);
    for (int k = 0; k < 4; ++k) EXPECT_LT((vec(t[k].p) - vec(lane(hinge[k].p, l))).norm(), 1e-12);
  }
  const std::vector<Row> copy = rows;
  for (int k = 0; k < 4; ++k) scatter(rows.data(), index[k], v[k]);
  EXPECT_EQ(0, std::memcmp(copy.data(), rows.data(), rows.size() * sizeof(Row)));
}

}  // namespace
}  // namespace wick::solid
