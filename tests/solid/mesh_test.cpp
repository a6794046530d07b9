/// Topology, rest shapes and primitives of triangle meshes.
#include <gtest/gtest.h>

#include <limits>

#include "core/require.h"
#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

std::string refusal(std::vector<Vec3> rest, std::vector<Int3> triangles, std::vector<Vec2> material = {}) {
  try {
    build_mesh(std::move(rest), std::move(material), std::move(triangles));
  } catch (const Refusal& r) {
    EXPECT_EQ(r.code(), ExitCode::scene_invalid);
    return r.what();
  }
  return "accepted";
}

const std::vector<Vec3> kSquare = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};

TEST(Mesh, RefusesWhatIsNoSheetAndNamesThePlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refusal(kSquare, {{0, 1, 2}, {0, 2, 9}}), "triangle 1");
  expect(refusal(kSquare, {{0, 1, 2}, {0, -1, 3}}), "triangle 1");
  expect(refusal(kSquare, {{0, 1, 1}}), "twice");
  expect(refusal({{0, 0, 0}, {1, 0, 0}, {2, 1e-9, 0}}, {{0, 1, 2}}), "no area");
  expect(refusal({{0, 0, 0}, {1, 0, 0}, {0, nan, 0}}, {{0, 1, 2}}), "vertex 2");
  expect(refusal({{0, 0, 0}, {1, 0, 0}, {0, 1e300, 0}}, {{0, 1, 2}}), "vertex 2");
  expect(refusal(kSquare, {{0, 1, 2}, {0, 2, 3}, {2, 0, 4}}), "triangle 2");
  expect(refusal(kSquare, {{0, 1, 2}, {0, 3, 2}}), "flip");
  expect(refusal(kSquare, {{0, 1, 2}}, {{0, 0}}), "material coordinates");
  expect(refusal({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {{0, 0}, {1, 0}, {2, 0}}), "material");
  // A bow tie; two closed cones that share their tip; and the same square with its fan whole.
  expect(refusal(kSquare, {{0, 1, 4}, {2, 3, 4}}), "vertex 4 (counted from 0) joins triangles 0 and 1 at a point");
  expect(refusal({{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {-1, -1, 1}, {1, 0, -1}, {0, 1, -1}, {-1, -1, -1}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 5, 4}, {0, 6, 5}, {0, 4, 6}}),
         "vertex 0 (counted from 0) joins triangles 0 and 3");
  EXPECT_EQ(refusal(kSquare, {{2, 3, 4}, {0, 1, 4}, {3, 0, 4}}), "accepted");
  EXPECT_EQ(refusal(kSquare, {{2, 3, 4}, {0, 1, 4}, {3, 0, 4}, {1, 2, 4}}), "accepted");
  EXPECT_EQ(refusal(kSquare, {{0, 1, 2}, {0, 2, 3}}), "accepted");
  EXPECT_EQ(refusal({}, {}), "accepted");
  // A needle of tiny size is bad by its shape, not by its size.
  EXPECT_EQ(refusal({{0, 0, 0}, {1e-7, 0, 0}, {0, 1e-7, 0}}, {{0, 1, 2}}), "accepted");
}

TEST(Mesh, CountsOfPrimitives) {
  for (const Lattice lattice : {Lattice::staggered, Lattice::grid, Lattice::union_jack}) {
    const ShellMesh mesh = build_mesh(rectangle(100, 100, {1.0, std::sqrt(0.75)}, lattice));
    EXPECT_EQ(mesh.triangle_count(), 19602u);
    EXPECT_EQ(mesh.edges.size(), 19602u + 10000u - 1u);  // Euler: V − E + T = 1
    double area = 0.0;
    for (const double a : mesh.rest_area) area += a;
    EXPECT_NEAR(area, std::sqrt(0.75), 1e-12);
    EXPECT_EQ(*std::max_element(mesh.component.begin(), mesh.component.end()), 0);
    for (const Vec3& n : vertex_normals(mesh, mesh.rest)) EXPECT_LT((n - Vec3(0, 0, 1)).norm(), 1e-12);
  }
  const ShellMesh sphere = build_mesh(icosphere(3, 0.5));
  EXPECT_EQ(sphere.triangle_count(), 1280u);
  EXPECT_EQ(sphere.hinges.size(), sphere.edges.size());
  const std::vector<Vec3> normals = vertex_normals(sphere, sphere.rest);
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_GT(normals[i].dot(sphere.rest[i]), 0.49);
  const ShellMesh tube = build_mesh(cylinder(0.1, 0.5, 20, 11));
  EXPECT_EQ(tube.triangle_count(), 400u);
  EXPECT_EQ(tube.vertex_count(), tube.edges.size() - 400u);  // Euler characteristic of an annulus is 0
}

TEST(Mesh, StaggeredLatticeIsEquilateralInside) {
  const ShellMesh mesh = build_mesh(equilateral(11, 9, 0.1));
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    const Vec3 middle = 0.5 * (mesh.rest[mesh.edges[e][0]] + mesh.rest[mesh.edges[e][1]]);
    if (middle.x() > 0.2 && middle.x() < 0.8) {
      EXPECT_NEAR(mesh.rest_length[e], 0.1, 1e-12);
    }
  }
}

TEST(Mesh, SubdivisionKeepsAreaAndChart) {
  const TriangleSoup coarse = rectangle(4, 5, {0.3, 0.4});
  const ShellMesh fine = build_mesh(subdivide(coarse));
  EXPECT_EQ(fine.triangle_count(), 4 * coarse.triangles.size());
  double area = 0.0;
  for (const double a : fine.rest_area) area += a;
  EXPECT_NEAR(area, 0.12, 1e-14);
  for (std::size_t i = 0; i < fine.vertex_count(); ++i)
    EXPECT_LT((fine.rest[i].head<2>() - fine.material[i]).norm(), 1e-15);
}

TEST(Mesh, FramesDoNotDependOnTheOrderOfCorners) {
  // The strain a triangle sees is that of its own frame: Bᵀ EᵀE B must not change when the corners are relabelled.
  const TriangleSoup soup = icosphere(2, 0.3);
  const ShellMesh reference = build_mesh(soup);
  const auto gram = [](const ShellMesh& mesh, std::size_t t) {
    const Int3& v = mesh.triangles[t];
    const auto deformed = [&](int i) { return Vec3(mesh.rest[i].cwiseProduct(Vec3(1.1, 0.9, 1.3))); };
    Mat32 E;
    E << deformed(v[1]) - deformed(v[0]), deformed(v[2]) - deformed(v[0]);
    const Mat32 F = E * mesh.inverse_rest_edges[t];
    return Mat2(F.transpose() * F);
  };
  for (int turn = 1; turn < 3; ++turn) {
    TriangleSoup turned = soup;
    for (Int3& v : turned.triangles) std::rotate(v.begin(), v.begin() + turn, v.end());
    const ShellMesh mesh = build_mesh(turned);
    for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
      EXPECT_LT((gram(mesh, t) - gram(reference, t)).norm(), 1e-13) << t;
  }
}

TEST(Mesh, WithoutTrianglesLeavesOrphansAndSplitsComponents) {
  const ShellMesh mesh = build_mesh(rectangle(5, 2, {0.4, 0.1}, Lattice::grid));
  std::vector<std::uint8_t> keep(mesh.triangle_count(), 1);
  keep[2] = keep[3] = 0;
  const ShellMesh cut = without_triangles(mesh, keep);
  EXPECT_EQ(cut.triangle_count(), 6u);
  EXPECT_EQ(cut.component[0], 0);
  EXPECT_EQ(cut.component[4], 1);
  keep.assign(mesh.triangle_count(), 0);
  keep[0] = 1;
  const ShellMesh one = without_triangles(mesh, keep);
  EXPECT_EQ(one.component[9], -1);
  EXPECT_EQ(one.vertex_area[9], 0.0);
  EXPECT_EQ(vertex_normals(one, one.rest)[9], Vec3(0, 0, 0));
  EXPECT_EQ(one.inverse_rest_edges[0], mesh.inverse_rest_edges[0]);
}

}  // namespace
}  // namespace wick::solid
