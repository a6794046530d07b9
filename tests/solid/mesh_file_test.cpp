/// Reading meshes: every form of the two formats, and files that lie.
#include "solid/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/noise.h"
#include "core/require.h"

namespace wick::solid {
namespace {

const std::string kAscii =
    "ply\nformat ascii 1.0\ncomment a square and a quad\nelement vertex 4\nproperty float x\nproperty double y\n"
    "property float z\nproperty uchar red\nelement material 1\nproperty list uchar int junk\nelement face 1\n"
    "property list uchar int vertex_indices\nproperty float quality\nend_header\n"
    "0 0 0 255\n1 0 0 255\n1 1 0 255\n0 1 0 255\n3 7 8 9\n4 0 1 2 3 0.5\n";

template <class T>
void put(std::string& bytes, T value, bool big) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string binary(bool big) {
  std::string bytes = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                      " 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n"
                      "property ushort label\nelement face 2\nproperty uchar flag\n"
                      "property list uchar uint vertex_index\nend_header\n";
  const double xy[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const auto& p : xy) {
    put(bytes, static_cast<float>(p[0]), big);
    put(bytes, p[1], big);
    put(bytes, 0.25f, big);
    put(bytes, std::uint16_t{77}, big);
  }
  for (const auto& face : {std::vector<std::uint32_t>{0, 1, 2}, std::vector<std::uint32_t>{0, 2, 3}}) {
    put(bytes, std::uint8_t{1}, big);
    put(bytes, static_cast<std::uint8_t>(face.size()), big);
    for (const std::uint32_t i : face) put(bytes, i, big);
  }
  return bytes;
}

const std::string kObj =
    "# square\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    "usemtl a\nf 1/1/1 2/2/1 3/3/1 \\\n 4/4/1\n";

void expect_square(const TriangleSoup& soup) {
  ASSERT_EQ(soup.positions.size(), 4u);
  ASSERT_EQ(soup.triangles.size(), 2u);
  EXPECT_EQ(soup.triangles[0], (Int3{0, 1, 2}));
  EXPECT_EQ(soup.triangles[1], (Int3{0, 2, 3}));
  EXPECT_EQ(soup.positions[2].head<2>(), Vec2(1, 1));
}

std::string message(std::string_view text, bool ply) {
  try {
    ply ? parse_ply(text, "file") : parse_obj(text, "file");
  } catch (const Refusal& r) {
    EXPECT_EQ(r.code(), ExitCode::scene_invalid);
    return r.what();
  }
  return "";
}

TEST(MeshFile, ReadsEveryForm) {
  expect_square(parse_ply(kAscii, "a"));
  expect_square(parse_ply(binary(false), "l"));
  expect_square(parse_ply(binary(true), "b"));
  const TriangleSoup obj = parse_obj(kObj, "o");
  expect_square(obj);
  ASSERT_EQ(obj.material.size(), 4u);
  EXPECT_EQ(obj.material[2], Vec2(1, 1));
  expect_square(parse_obj("v 0 0 0\r\nv +1 0 0\r\nv 1e0 1 0\r\nv 0 1 0\r\nf -4 -3 -2 -1\r\n", "negative"));
  expect_square(
      parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1 3 4 # end", "mixed"));
}

TEST(MeshFile, TextureIsAChartOnlyInMetres) {
  std::string scaled = kObj;
  scaled.replace(scaled.find("vt 1 1"), 6, "vt .5 1");
  EXPECT_TRUE(parse_obj(scaled, "o").material.empty());
  // Two values at one vertex are a seam.
  EXPECT_TRUE(parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 9 9\n"
                        "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n",
                        "o")
                  .material.empty());
}

TEST(MeshFile, SaysWhereItIsWrong) {
  EXPECT_NE(message("v 0 0 0\nv 1 0\n", false).find("line 2"), std::string::npos);
  EXPECT_NE(message("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", false).find("line 4: face 0"), std::string::npos);
  EXPECT_NE(message("v 0 0 0\nv 1 0 0\nf 1 2\n", false).find("three corners"), std::string::npos);
  EXPECT_NE(message("f 0 0 0\n", false).find("face 0"), std::string::npos);
  std::string bad = kAscii;
  bad.replace(bad.find("4 0 1 2 3"), 9, "4 0 1 2 5");
  EXPECT_NE(message(bad, true).find("face 0"), std::string::npos);
  bad = kAscii;
  bad.replace(bad.find("element vertex 4"), 16, "element vertex 4000000000000");
  EXPECT_NE(message(bad, true).find("cannot hold"), std::string::npos);
  EXPECT_NE(message("ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n", true), "");
}

TEST(MeshFile, MissingFileIsItsOwnKindOfRefusal) {
  try {
    read_mesh_file("no/such/file.ply");
    FAIL();
  } catch (const Refusal& r) {
    EXPECT_EQ(r.code(), ExitCode::input_missing);
  }
  EXPECT_THROW(read_mesh_file(std::filesystem::temp_directory_path().string()), Refusal);
}

TEST(MeshFile, ReadsFromDisk) {
  const auto path =
      std::filesystem::temp_directory_path() /
      ("wick_mesh_file_test_" + std::to_string(hash_index(1, reinterpret_cast<std::uintptr_t>(&kObj))) + ".ply");
  std::ofstream(path, std::ios::binary) << binary(true);
  expect_square(read_mesh_file(path.string()));
  std::ofstream(path, std::ios::binary) << "no ply";
  EXPECT_THROW(read_mesh_file(path.string()), Refusal);
  std::filesystem::remove(path);
}

/// Whatever the bytes, the reader gives a soup that build_mesh can judge, or a Refusal.
void survive(const std::string& bytes, bool ply) {
  try {
    TriangleSoup soup = ply ? parse_ply(bytes, "file") : parse_obj(bytes, "file");
    ASSERT_LE(soup.positions.size(), bytes.size());
    build_mesh(std::move(soup));
  } catch (const Refusal&) {
  }
}

TEST(MeshFile, SurvivesTruncationAndNoise) {
  const std::string files[] = {kAscii, binary(false), binary(true), kObj};
  for (int f = 0; f < 4; ++f) {
    for (std::size_t size = 0; size < files[f].size(); ++size) survive(files[f].substr(0, size), f < 3);
    for (std::uint64_t trial = 0; trial < 20000; ++trial) {
      std::string bytes = files[f];
      const int flips = 1 + static_cast<int>(hash_index(f, 100 * trial) % 4);
      for (int k = 0; k < flips; ++k)
        bytes[hash_index(f, 100 * trial + 2 * k + 1) % bytes.size()] =
            static_cast<char>(hash_index(f, 100 * trial + 2 * k + 2));
      survive(bytes, f < 3);
    }
  }
}

}  // namespace
}  // namespace wick::solid
