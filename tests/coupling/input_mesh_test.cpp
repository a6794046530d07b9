/// Mesh files that are not quite what they should be: vertices without triangles, obstacles finer than their
/// samples.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>

#include "core/require.h"
#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

/// A name of its own for each test: they may run side by side.
std::string file() {
  return std::string("wick_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".obj";
}

void write_mesh(const std::vector<Vec3>& positions, const std::vector<Int3>& triangles) {
  std::ofstream out(testing::TempDir() + "/" + file());
  for (const Vec3& x : positions) out << "v " << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
  for (const Int3& t : triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
}

/// A box around the origin, turned so that its sides lie askew to the axes unless `turn` is false.
void write_box(const Vec3& size, bool turn = true) {
  const Mat3 turned =
      (Eigen::AngleAxisd(0.5, Vec3::UnitZ()) * Eigen::AngleAxisd(0.4, Vec3::UnitX())).toRotationMatrix();
  std::vector<Vec3> corners;
  for (int n = 0; n < 8; ++n) {
    const Vec3 x = Vec3((n & 1) - 0.5, (n >> 1 & 1) - 0.5, (n >> 2) - 0.5).cwiseProduct(size);
    corners.push_back(turn ? Vec3(turned * x) : x);
  }
  write_mesh(corners, {{0, 2, 1},
                       {1, 2, 3},
                       {4, 5, 6},
                       {5, 7, 6},
                       {0, 1, 4},
                       {1, 5, 4},
                       {2, 6, 3},
                       {3, 6, 7},
                       {0, 4, 2},
                       {2, 4, 6},
                       {1, 3, 5},
                       {3, 7, 5}});
}

/// A sheet above an obstacle mesh.
WorldParams above_obstacle(double spacing) {
  WorldParams params;
  params.directory = testing::TempDir();
  params.shells.push_back(test::flat_sheet(5, 0.5, 1.0));
  params.obstacles.push_back({.kind = ObstacleKind::mesh, .file = file(), .spacing = spacing});
  return params;
}

std::string refusal_of(const WorldParams& params) {
  try {
    const World world(params);
  } catch (const Refusal& refusal) {
    return refusal.pointer() + ": " + refusal.what();
  }
  return "accepted";
}

TEST(ObstacleMesh, MustBeAsThickAsItsSamplesNeed) {
  for (const bool turn : {false, true})
    for (const double thickness : {0.001, 0.004, 0.008, 0.012, 0.016}) {
      write_box(Vec3(0.3, 0.3, thickness), turn);
      const std::string refused = refusal_of(above_obstacle(0.01));
      EXPECT_TRUE(refused.starts_with("/obstacles/0/spacing: loses thin parts of the mesh, ")) << refused;
    }
  for (const bool turn : {false, true}) {
    write_box(Vec3(0.3, 0.3, 0.02), turn);
    EXPECT_EQ(refusal_of(above_obstacle(0.01)), "accepted");
    write_box(Vec3(0.3, 0.3, 0.008), turn);
    const std::string refused = refusal_of(above_obstacle(0.01));
    EXPECT_NE(refused.find("take 0.004 or less"), std::string::npos) << refused;
    EXPECT_EQ(refusal_of(above_obstacle(0.004)), "accepted") << "which is what the message asks for";
  }
}

TEST(ObstacleMesh, ThatLosesItsEdgesOnlyIsReported) {
  write_box(Vec3(0.2, 0.2, 0.2));
  const World askew(above_obstacle(0.01));
  ASSERT_EQ(askew.warnings().size(), 1U);
  EXPECT_TRUE(askew.warnings()[0].starts_with("/obstacles/0/spacing: rounds edges and corners"))
      << askew.warnings()[0];
  write_box(Vec3(0.2, 0.2, 0.2), false);
  EXPECT_TRUE(World(above_obstacle(0.01)).warnings().empty()) << "its corners are nodes";
}

/// A blade loses its edge at any spacing, which is no reason to refuse it.
TEST(ObstacleMesh, MayEndInAnEdge) {
  const double half = 0.3 * std::tan(10 * M_PI / 180);
  write_mesh({Vec3(0, -0.15, 0), Vec3(0.3, -0.15, -half), Vec3(0.3, -0.15, half), Vec3(0, 0.15, 0),
              Vec3(0.3, 0.15, -half), Vec3(0.3, 0.15, half)},
             {{0, 1, 2}, {3, 5, 4}, {0, 3, 1}, {1, 3, 4}, {0, 2, 3}, {2, 5, 3}, {1, 4, 2}, {2, 4, 5}});
  for (const double spacing : {0.02, 0.01, 0.005}) EXPECT_EQ(refusal_of(above_obstacle(spacing)), "accepted");
}

TEST(ObstacleMesh, OfOrdinaryShapePassesAtTheDefaultSpacing) {
  WorldParams params = above_obstacle(ObstacleParams{}.spacing);
  params.directory = std::string(WICK_SOURCE) + "/scenes/meshes";
  params.obstacles[0].file = "bunny.ply";
  params.obstacles[0].scale = 0.05;  // as in the bundled scene
  params.obstacles[0].center = Vec3(0.5, 0.5, -0.5);
  EXPECT_EQ(refusal_of(params), "accepted");
}

/// A square whose vertices 0 and 3 belong to nothing, the latter far away.
class LooseVertices : public testing::Test {
 protected:
  LooseVertices() {
    write_mesh({Vec3(9, 9, 9), Vec3(0.3, 0.3, 0.5), Vec3(0.6, 0.3, 0.5), Vec3(0.4, 0.4, 0.9), Vec3(0.6, 0.6, 0.5),
                Vec3(0.3, 0.6, 0.5)},
               {{1, 2, 4}, {1, 4, 5}});
    params_.directory = testing::TempDir();
    ShellSection& shell = params_.shells.emplace_back();
    shell.mesh.kind = MeshKind::file;
    shell.mesh.file = file();
    shell.mesh.subdivisions = 1;
  }
  WorldParams params_;
};

TEST_F(LooseVertices, AreLeftOutAndCounted) {
  World world(params_);
  ASSERT_EQ(world.warnings().size(), 1U);
  EXPECT_TRUE(world.warnings()[0].starts_with("/shells/0/mesh/file: 2 of 6 vertices are in no triangle"));
  EXPECT_EQ(world.shells()[0].mesh->vertex_count(), 4U + 5U);
  for (const double area : world.shells()[0].mesh->vertex_area) EXPECT_GT(area, 0.0);
}

TEST_F(LooseVertices, DoNotChangeWhatPinsName) {
  params_.shells[0].pins.push_back({.vertices = {4, 6}});  // a corner, and the first vertex that subdivision adds
  World world(params_);
  const std::vector<Vec3> before = *world.shells()[0].x;
  world.step(1.0 / 24);
  const std::vector<Vec3>& after = *world.shells()[0].x;
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_EQ(before[i] == after[i], i == 2 || i == 4) << i;
  EXPECT_EQ(before[2], Vec3(0.6, 0.6, 0.5));
  params_.shells[0].pins = {{.vertices = {3}}};
  EXPECT_EQ(refusal_of(params_),
            "/shells/0/pins/0/vertices: vertex 3 is in no triangle (so it is left out) name another");
  params_.shells[0].pins = {{.vertices = {11}}};
  EXPECT_EQ(refusal_of(params_), "/shells/0/pins/0/vertices: vertex 11 does not exist (the mesh has 11)");
}

}  // namespace
}  // namespace wick::coupling
