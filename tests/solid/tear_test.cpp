/// Sheets that are pulled apart.
#include "solid/tear.h"

#include <gtest/gtest.h>

#include "tests/solid/sheet.h"

namespace wick::solid {
namespace {

/// Strain of a sheet that is stretched, sheared and turned as a whole: the eigenvalues of U - 1.
TEST(Tear, StrainsAreThoseOfTheStretch) {
  const ShellMesh mesh = build_mesh(rectangle(9, 9, {0.4, 0.3}, Lattice::staggered));
  const Mat3 turn =
      (Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(-0.4, Vec3::UnitY())).toRotationMatrix();
  const double angle = 0.5, most = 1.2, least = 0.9;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), across(-std::sin(angle), std::cos(angle), 0);
  const Mat3 stretch = most * along * along.transpose() + least * across * across.transpose() +
                       Vec3::UnitZ() * Vec3::UnitZ().transpose();
  std::vector<Vec3> x;
  for (const Vec3& rest : mesh.rest) x.emplace_back(turn * stretch * rest);
  for (const double scale : {1.0, 0.8}) {
    for (const VertexStrain& s : vertex_strains(mesh, x, std::vector<double>(mesh.triangle_count(), scale))) {
      EXPECT_NEAR(s.strain, most / scale - 1.0, 1e-12);
      EXPECT_NEAR(std::abs(s.direction.dot(along)), 1.0, 1e-9);
    }
  }
  // On a bent rest shape too: a tube that is pulled along its axis.
  const ShellMesh tube = build_mesh(cylinder(0.1, 0.5, 40, 20));
  x.clear();
  for (const Vec3& rest : tube.rest) x.emplace_back(rest.x(), rest.y(), 1.1 * rest.z());
  for (const VertexStrain& s : vertex_strains(tube, x, std::vector<double>(tube.triangle_count(), 1.0))) {
    EXPECT_NEAR(s.strain, 0.1, 2e-3);
    EXPECT_GT(std::abs(s.direction.z()), 0.99);
  }
  // Crushed flat to a line or a point: finite.
  for (const double width : {1e-3, 0.0}) {
    x.clear();
    for (const Vec3& rest : mesh.rest) x.emplace_back(rest.x() * (width > 0.0 ? 1.0 : 0.0), width * rest.y(), 0.0);
    for (const VertexStrain& s : vertex_strains(mesh, x, std::vector<double>(mesh.triangle_count(), 1.0)))
      EXPECT_TRUE(std::isfinite(s.strain) && s.direction.allFinite());
  }
}

/// A single overstrained vertex opens as a slit of two edges, across the pull; area is kept.
TEST(Tear, OneVertexOpensASlit) {
  const ShellMesh mesh = build_mesh(rectangle(9, 9, {1.0, 1.0}, Lattice::grid));
  std::vector<VertexStrain> strains(mesh.vertex_count(), {0.01, Vec3::UnitX()});
  const std::vector<double> strength(mesh.vertex_count(), 0.05);
  strains[4 * 9 + 4].strain = 0.2;
  std::vector<Int3> triangles = mesh.triangles;
  const MeshCut cut = tear(mesh, strains, strength, triangles);
  ASSERT_EQ(cut.blends.size(), 1u);
  EXPECT_EQ(cut.blends[0].a, 4 * 9 + 4);
  std::vector<Vec3> rest = mesh.rest;
  apply(cut.blends, rest);
  const ShellMesh torn = build_mesh(rest, {}, triangles);
  EXPECT_EQ(torn.triangle_count(), mesh.triangle_count());
  EXPECT_EQ(torn.edges.size(), mesh.edges.size() + 2);
  // A vertex at the rim parts along one edge.
  strains[4 * 9 + 4].strain = 0.01;
  strains[4].strain = 0.2;
  triangles = mesh.triangles;
  EXPECT_EQ(tear(mesh, strains, strength, triangles).born, 1u);
  // Nothing parts below its strength.
  strains[4].strain = 0.049;
  triangles = mesh.triangles;
  EXPECT_FALSE(tear(mesh, strains, strength, triangles).any());
  EXPECT_EQ(triangles, mesh.triangles);
}

}  // namespace
}  // namespace wick::solid
