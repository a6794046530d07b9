/// Exact signs of points, and the count of places where sheets pass through each other.
#include "solid/crossings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/parallel.h"
#include "solid/exact_predicates.h"
#include "solid/primitives.h"

namespace wick::solid {
namespace {

__extension__ using Wide = __int128;

/// Whole numbers up to 2^30, so that a determinant fits into 128 bits.
struct Lattice {
  std::int64_t x, y, z;
  [[nodiscard]] Vec3 at(double scale) const { return scale * Vec3(double(x), double(y), double(z)); }
};

int sign_of(Wide value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

int determinant_sign(const Lattice& a, const Lattice& b, const Lattice& c, const Lattice& d) {
  const Wide ux = a.x - d.x, uy = a.y - d.y, uz = a.z - d.z, vx = b.x - d.x, vy = b.y - d.y, vz = b.z - d.z;
  const Wide wx = c.x - d.x, wy = c.y - d.y, wz = c.z - d.z;
  return sign_of(ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx));
}

TEST(Orientation, IsThatOfWholeNumbersHoweverNearToAPlane) {
  std::mt19937_64 random(7);
  const auto draw = [&](std::int64_t range) {
    return std::uniform_int_distribution<std::int64_t>(-range, range)(random);
  };
  int flat = 0;
  for (int n = 0; n < 200000; ++n) {
    const std::int64_t range = n % 3 == 0 ? 3 : (1 << 28);
    Lattice p[4];
    for (Lattice& q : p) q = {draw(range), draw(range), draw(range)};
    if (n % 2 == 0) {  // d near the plane of the others, or in it
      const std::int64_t s = draw(2), t = draw(2), off = draw(1);
      p[3] = {p[0].x + s * (p[1].x - p[0].x) + t * (p[2].x - p[0].x) + off,
              p[0].y + s * (p[1].y - p[0].y) + t * (p[2].y - p[0].y),
              p[0].z + s * (p[1].z - p[0].z) + t * (p[2].z - p[0].z)};
    }
    const double scale = std::ldexp(1.0, static_cast<int>(draw(300)));
    const int expected = determinant_sign(p[0], p[1], p[2], p[3]);
    flat += expected == 0 ? 1 : 0;
    ASSERT_EQ(orientation(p[0].at(scale), p[1].at(scale), p[2].at(scale), p[3].at(scale)), expected) << n;
  }
  EXPECT_GT(flat, 10000);
}

TEST(Orientation, SeesOneUnitInTheLastPlace) {
  const Vec3 a(0.1, 0.2, 0.3), b(1.1, 0.2, 0.3), c(0.1, 1.2, 0.3);
  for (const double from : {1.0, -1.0}) {
    const Vec3 d(0.4, 0.4, std::nextafter(0.3, from > 0.0 ? 1.0 : -1.0));
    EXPECT_EQ(orientation(a, b, c, d), from > 0.0 ? -1 : 1);
  }
  EXPECT_EQ(orientation(a, b, c, Vec3(0.4, 0.4, 0.3)), 0);
  EXPECT_EQ(orientation(1e-200 * a, 1e-200 * b, 1e-200 * c, 1e-200 * Vec3(0, 0, 1)), -1);
  EXPECT_EQ(orientation(1e200 * a, 1e200 * b, 1e200 * c, 1e200 * Vec3(0, 0, 1)), -1);
}

/// Points of a small lattice: most cases are degenerate ones. The answer is the same in every order of the corners
/// and after every shear by whole numbers.
TEST(SegmentAndTriangle, MeetOrNotInEveryOrderAndShear) {
  std::mt19937_64 random(11);
  const auto draw = [&] { return static_cast<double>(std::uniform_int_distribution<int>(0, 3)(random)); };
  int met = 0, in_plane = 0;
  for (int n = 0; n < 50000; ++n) {
    Vec3 p[5];
    for (Vec3& q : p) q = Vec3(draw(), draw(), n % 4 == 0 ? 1.0 : draw());
    const bool meet = segment_meets_triangle(p[0], p[1], p[2], p[3], p[4]);
    met += meet ? 1 : 0;
    in_plane += meet && orientation(p[2], p[3], p[4], p[0]) == 0 && orientation(p[2], p[3], p[4], p[1]) == 0;
    ASSERT_EQ(segment_meets_triangle(p[1], p[0], p[2], p[3], p[4]), meet);
    ASSERT_EQ(segment_meets_triangle(p[0], p[1], p[3], p[4], p[2]), meet);
    ASSERT_EQ(segment_meets_triangle(p[0], p[1], p[4], p[3], p[2]), meet);
    Mat3 shear = Mat3::Identity();
    shear(n % 3, (n + 1 + n % 2) % 3) = draw() - 1.5 > 0.0 ? 2.0 : -1.0;
    ASSERT_EQ(segment_meets_triangle(shear * p[0], shear * p[1], shear * p[2], shear * p[3], shear * p[4]), meet)
        << n;
    // Against points of both: where a corner or the middle of the segment lies on the triangle, they meet.
    const Vec3 inside = p[2] + 0.25 * (p[3] - p[2]) + 0.5 * (p[4] - p[2]);
    ASSERT_TRUE(segment_meets_triangle(inside, p[1], p[2], p[3], p[4]));
    ASSERT_TRUE(segment_meets_triangle(2.0 * inside - p[1], p[1], p[2], p[3], p[4]));
    ASSERT_TRUE(segments_meet(2.0 * p[2] - p[1], p[1], p[2], p[3]));
  }
  EXPECT_GT(met, 5000);
  EXPECT_GT(in_plane, 1000);
}

std::vector<Crossing> crossings_of(const std::vector<const ShellMesh*>& meshes,
                                   const std::vector<std::vector<Vec3>>& x) {
  std::vector<PosedSheet> sheets;
  for (std::size_t s = 0; s < meshes.size(); ++s) sheets.push_back({meshes[s], &x[s]});
  return find_crossings(sheets);
}

TEST(Crossings, AreThoseOfAllPairs) {
  const ShellMesh mesh = build_mesh(rectangle(9, 11, Vec2(1.0, 1.0)));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  for (int n = 0; n < 10; ++n) {
    std::vector<std::vector<Vec3>> x(2, mesh.rest);
    for (std::vector<Vec3>& sheet : x)
      for (Vec3& p : sheet) p += Vec3(noise(random), noise(random), noise(random));
    std::size_t expected = 0;
    for (int s = 0; s < 2; ++s)
      for (int r = 0; r < 2; ++r)
        for (const Int2& e : mesh.edges)
          for (const Int3& t : mesh.triangles) {
            const bool common =
                s == r && std::any_of(t.begin(), t.end(), [&](int v) { return v == e[0] || v == e[1]; });
            if (!common && segment_meets_triangle(x[s][e[0]], x[s][e[1]], x[r][t[0]], x[r][t[1]], x[r][t[2]]))
              ++expected;
          }
    EXPECT_GT(expected, 100U);
    const std::vector<Crossing> found = crossings_of({&mesh, &mesh}, x);
    EXPECT_EQ(found.size(), expected);
    const ThreadLimit one(1);
    const std::vector<Crossing> again = crossings_of({&mesh, &mesh}, x);
    ASSERT_EQ(again.size(), found.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(again[k].edge, found[k].edge);
      EXPECT_EQ(again[k].triangle, found[k].triangle);
    }
  }
}

TEST(Crossings, NoneOnSheetsThatAreFlatTiltedRolledOrApart) {
  const ShellMesh mesh = build_mesh(rectangle(40, 46, Vec2(1.0, 1.0)));
  std::vector<Vec3> tilted, rolled, above;
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  for (const Vec3& p : mesh.rest) {
    tilted.push_back(turn * p);
    above.push_back(turn * (p + Vec3(0.0, 0.0, 1e-12)));
    const double turned = 12.0 * p.x();  // nearly two turns, each a little wider
    const double radius = 0.08 + 0.004 * p.x();
    rolled.emplace_back(radius * std::cos(turned), p.y(), radius * std::sin(turned));
  }
  EXPECT_TRUE(crossings_of({&mesh}, {mesh.rest}).empty());
  EXPECT_TRUE(crossings_of({&mesh}, {tilted}).empty());
  EXPECT_TRUE(crossings_of({&mesh}, {rolled}).empty());
  EXPECT_TRUE(crossings_of({&mesh, &mesh}, {tilted, above}).empty());
}

TEST(Crossings, NameTheEdgeAndTheTriangle) {
  const ShellMesh one = build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {}, {Int3{0, 1, 2}});
  const std::vector<Vec3> pierced = {Vec3(0.2, 0.2, -1), Vec3(0.2, 0.2, 1), Vec3(2, 2, 0)};
  const std::vector<Crossing> found = crossings_of({&one, &one}, {one.rest, pierced});
  ASSERT_EQ(found.size(), 2U);  // its edge through the first, and the rim of the first through it
  EXPECT_EQ(found[0].triangle_sheet, 0);
  EXPECT_EQ(found[0].edge_sheet, 1);
  EXPECT_EQ(one.edges[found[0].edge], (Int2{0, 1}));
  EXPECT_EQ(found[1].triangle_sheet, 1);
  EXPECT_EQ(one.edges[found[1].edge], (Int2{1, 2}));
}

}  // namespace
}  // namespace wick::solid
