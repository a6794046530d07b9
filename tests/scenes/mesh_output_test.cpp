#include "scenes/mesh_output.h"

#include <gtest/gtest.h>

#include <cstring>

namespace wick::scenes {

namespace {

struct Sheet {
  solid::ShellMesh mesh = solid::build_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
                                            {{0, 0}, {1, 0}, {0, 1}, {1, 1}}, {{0, 1, 2}, {1, 3, 2}});
  std::vector<Vec3> x{{0, 0, 2}, {1, 0, 2}, {0, 1, 2}, {1, 1, 2}};
  std::vector<Vec3> v{{0, 3, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}};

  [[nodiscard]] coupling::ShellView view() const {
    return {"paper", &mesh, &x, &v, {{"temperature", {300, 300, 300, 1400}}, {"char", {0, 0.3F, 0.7F, 0.7F}}}};
  }
};

constexpr std::size_t vertex_bytes = 11 * 4 + 4 + 3 * 4;

struct Vertex {
  float x[3], n[3], v[3], st[2];
  std::uint8_t rgba[4];
  float temperature, charred;
  std::int32_t id;
};
static_assert(sizeof(Vertex) == vertex_bytes);

std::vector<Vertex> vertices_of(const Bytes& bytes) {
  std::vector<Vertex> vertices(4);
  std::memcpy(vertices.data(), bytes.data() + bytes.find("end_header\n") + 11, 4 * vertex_bytes);
  return vertices;
}

TEST(MeshOutput, WritesWhatItsHeaderSays) {
  const Bytes bytes = shell_ply(Sheet().view(), UpAxis::z);
  const std::string expected =
      "ply\nformat binary_little_endian 1.0\ncomment wick paper\nelement vertex 4\nproperty float x\nproperty "
      "float "
      "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float vx\nproperty "
      "float "
      "vy\nproperty float vz\nproperty float s\nproperty float t\nproperty uchar red\nproperty uchar "
      "green\nproperty uchar "
      "blue\nproperty uchar alpha\nproperty float temperature\nproperty float char\nproperty int id\nelement face 2\nproperty list "
      "uchar "
      "int vertex_indices\nend_header\n";
  ASSERT_TRUE(bytes.starts_with(expected)) << bytes.substr(0, 700);
  ASSERT_EQ(bytes.size(), expected.size() + 4 * vertex_bytes + 2 * 13);
  const std::vector<Vertex> vertices = vertices_of(bytes);
  EXPECT_EQ(vertices[3].x[0], 1.0F);
  EXPECT_EQ(vertices[3].x[2], 2.0F);
  EXPECT_EQ(vertices[0].n[2], 1.0F);
  EXPECT_EQ(vertices[0].v[1], 3.0F);
  EXPECT_EQ(vertices[2].st[1], 1.0F);
  EXPECT_EQ(vertices[3].temperature, 1400.0F);
  EXPECT_EQ(vertices[1].charred, 0.3F);
  std::int32_t triangle[3];
  std::memcpy(triangle, bytes.data() + bytes.size() - 12, sizeof triangle);
  EXPECT_EQ(triangle[0], 1);
  EXPECT_EQ(triangle[1], 3);
  EXPECT_EQ(triangle[2], 2);
}

/// Vertices whose triangles have burnt away are gone; the others keep their number as `id`.
TEST(MeshOutput, HoldsOnlyWhatIsLeft) {
  Sheet sheet;
  sheet.mesh = solid::without_triangles(sheet.mesh, {0, 1});
  const Bytes bytes = shell_ply(sheet.view(), UpAxis::z);
  EXPECT_NE(bytes.find("element vertex 3\n"), std::string::npos);
  EXPECT_NE(bytes.find("element face 1\n"), std::string::npos);
  std::vector<Vertex> vertices(3);
  std::memcpy(vertices.data(), bytes.data() + bytes.find("end_header\n") + 11, 3 * vertex_bytes);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(vertices[k].id, k + 1);
    EXPECT_EQ(vertices[k].x[0], static_cast<float>(sheet.x[k + 1].x()));
  }
  std::int32_t triangle[3];
  std::memcpy(triangle, bytes.data() + bytes.size() - 12, sizeof triangle);
  EXPECT_EQ(triangle[0], 0);
  EXPECT_EQ(triangle[1], 2);
  EXPECT_EQ(triangle[2], 1);
}

TEST(MeshOutput, ColoursShowTheBurning) {
  const std::vector<Vertex> vertices = vertices_of(shell_ply(Sheet().view(), UpAxis::z));
  const auto light = [&](int i) { return vertices[i].rgba[0] + vertices[i].rgba[1] + vertices[i].rgba[2]; };
  EXPECT_GT(light(0), light(1));
  EXPECT_GT(light(1), light(2));
  EXPECT_GT(vertices[3].rgba[0], vertices[2].rgba[0] + 100) << "embers glow red";
  EXPECT_GT(vertices[3].rgba[0], vertices[3].rgba[2]);
  EXPECT_EQ(vertices[0].rgba[3], 255);
}

TEST(MeshOutput, TurnsUpTogether) {
  const std::vector<Vertex> vertices = vertices_of(shell_ply(Sheet().view(), UpAxis::y));
  EXPECT_EQ(vertices[2].x[1], 2.0F);
  EXPECT_EQ(vertices[2].x[2], -1.0F);
  EXPECT_EQ(vertices[0].n[1], 1.0F);
  EXPECT_EQ(vertices[0].v[2], -3.0F);
}

}  // namespace

}  // namespace wick::scenes
