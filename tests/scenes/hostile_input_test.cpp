/// Scenes and meshes as nobody means them: every one is either run or refused in one line that names the scene file
/// (and, where there is one, the pointer), with nothing left on the disk, and never waited for.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "core/noise.h"
#include "tests/scenes/program.h"

namespace wick::test {

namespace {

struct Outcome {
  int code = 0;
  std::string err;
};

class HostileInput : public testing::Test {
 protected:
  /// Runs s.json for one frame in at most 20 s of processor time.
  Outcome run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> all{"run", "s.json", "--quiet", "--frames", "1", "--out", "result"};
    all.insert(all.end(), more.begin(), more.end());
    Program program(folder_, all, [] {
      const rlimit limit{20, 20};
      ::setrlimit(RLIMIT_CPU, &limit);
    });
    const int code = program.wait();
    return {code, program.err()};
  }
  void expect(const Outcome& outcome, std::initializer_list<int> codes, const std::string& what) {
    EXPECT_TRUE(std::find(codes.begin(), codes.end(), outcome.code) != codes.end())
        << what << ": " << outcome.code << " " << outcome.err;
    if (outcome.code == 0) {
      fs::remove_all(folder_ / "result");
      return;
    }
    EXPECT_TRUE(outcome.err.starts_with("wick: s.json: ")) << what << ": " << outcome.err.substr(0, 300);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << what << ": " << outcome.err;
    EXPECT_LT(outcome.err.size(), 900U) << what;
    EXPECT_FALSE(fs::exists(folder_ / "result")) << what;
  }
  void expect_scene(const std::string& text, std::initializer_list<int> codes, const std::string& what) {
    spit(folder_ / "s.json", text);
    expect(run(), codes, what);
  }
  void use_mesh(const std::string& file) {
    spit(
        folder_ / "s.json",
        R"({"smoke": {"resolution": [8, 8, 8]}, "shells": [{"mesh": {"kind": "file", "file": ")" + file + "\"}}]}");
  }
  void expect_mesh(const std::string& text, std::initializer_list<int> codes, const std::string& what,
                   const std::string& file = "m.ply") {
    use_mesh(file);
    spit(folder_ / file, text);
    expect(run(), codes, what);
  }
  TemporaryFolder folder_;
};

TEST_F(HostileInput, ScenesThatAreNone) {
  const std::string valid = R"({"smoke": {"resolution": [8, 8, 8]}})";
  expect_scene("\xEF\xBB\xBF" + valid, {0}, "byte order mark");
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("null"), std::string(100, '\0'),
        valid + " x", std::string("{\"smoke\": {}, \"smoke\": {}}"),
        std::string("{\"name\": \"\xff\xfe\", \"smoke\": {}}"), std::string("{\"name\": \"../x\", \"smoke\": {}}"),
        std::string("{\"name\": \"a\\nb\", \"smoke\": {}}"), std::string("{\"x\\ny\": 1}"),
        "{\"" + std::string(100000, 'k') + "\": 1}"})
    expect_scene(text, {65}, text.substr(0, 40));
  expect_scene(std::string(100000, '['), {65}, "deep arrays");
  std::string deep;
  for (int n = 0; n < 100000; ++n) deep += "{\"a\":";
  expect_scene(deep, {65}, "deep objects");
  expect_scene(std::string(100000000, ' '), {65}, "100 MB of nothing");
  std::string shells = "{\"shells\": [{}";
  for (int n = 1; n < 400000; ++n) shells += ",{}";
  expect_scene(shells + "]}", {65}, "many shells");
}

TEST_F(HostileInput, ScenesThatAreNoFiles) {
  const Outcome missing = run();
  expect(missing, {66}, "missing");
  fs::create_directories(folder_ / "s.json");
  expect(run(), {66}, "a folder");
  fs::remove(folder_ / "s.json");
  ASSERT_EQ(::mkfifo((folder_ / "s.json").c_str(), 0600), 0);
  expect(run(), {66}, "a pipe");
}

TEST_F(HostileInput, ValuesOfEveryWrongKind) {
  spit(folder_ / "s.json", R"({"shells": [{"mesh": {"vertices": [5, 5]}}], "smoke": {"resolution": [8, 8, 8]},
    "diffusion": {}, "burning": {}, "heat_sources": [{}]})");
  for (const char* pointer : {"/frames", "/fps", "/shells/0/mesh/vertices", "/smoke/resolution", "/gravity",
                              "/heat_sources/0/radius", "/output/volume/names/density"})
    for (const char* value : {"null", "{}", "[]", "\"\"", "1e999", "-1e300", "[1, null, 3]", "[8, 8, 8e9]"}) {
      const Outcome outcome = run({"--set", std::string(pointer) + "=" + value});
      expect(outcome, {0, 65, 77}, std::string(pointer) + "=" + value);
      EXPECT_TRUE(outcome.code == 0 || outcome.err.find(pointer) != std::string::npos) << outcome.err;
    }
}

TEST_F(HostileInput, MeshesThatAreNoFiles) {
  use_mesh("none.ply");
  expect(run(), {66}, "missing");
  fs::create_directories(folder_ / "folder.ply");
  use_mesh("folder.ply");
  expect(run(), {66}, "a folder");
  ASSERT_EQ(::mkfifo((folder_ / "pipe.ply").c_str(), 0600), 0);
  use_mesh("pipe.ply");
  expect(run(), {66}, "a pipe");
  fs::create_symlink("/dev/zero", folder_ / "zero.ply");
  use_mesh("zero.ply");
  expect(run(), {66}, "a device");
}

std::string ply(const std::string& vertices, const std::string& vertex_count, const std::string& faces,
                const std::string& face_count) {
  return "ply\nformat ascii 1.0\nelement vertex " + vertex_count +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + face_count +
         "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + faces;
}

TEST_F(HostileInput, MeshesThatAreNoSurface) {
  const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", two = "3 0 1 2\n3 0 2 3\n";
  const std::string good = ply(square, "4", two, "2");
  expect_mesh(good, {0}, "good");
  for (std::size_t cut = 0; cut + 2 < good.size(); cut += 41) expect_mesh(good.substr(0, cut), {65}, "cut");
  expect_mesh(ply("nan 0 0\n1 0 0\n1 1 0\n0 1 0\n", "4", two, "2"), {65}, "nan");
  expect_mesh(ply("1e300 0 0\n1 0 0\n1 1 0\n0 1 0\n", "4", two, "2"), {65}, "infinite as a float");
  expect_mesh(ply("0 0 0\n1 0 0\n2 0 0\n0 1 0\n", "4", two, "2"), {65}, "without area");
  expect_mesh(ply(square, "4", "", "0"), {65}, "no faces");
  expect_mesh(ply("", "0", "", "0"), {65}, "empty");
  expect_mesh(ply(square, "4", "3 0 1 9\n", "1"), {65}, "index out of range");
  expect_mesh(ply(square, "4", "3 0 1 -1\n", "1"), {65}, "negative index");
  expect_mesh(ply(square, "4", "3 0 1 1\n", "1"), {65}, "one vertex twice");
  expect_mesh(ply(square + "0 0 1\n", "5", two + "3 0 2 4\n", "3"), {65}, "three triangles at one edge");
  expect_mesh(ply(square + "2 2 0\n1 2 0\n", "6", two + "3 2 4 5\n", "3"), {65}, "two parts that meet in a vertex");
  EXPECT_NE(run().err.find("/shells/0/mesh/file: vertex 2 "), std::string::npos);
  expect_mesh(ply(square, "4000000000", two, "2"), {65}, "too many vertices");
  expect_mesh(ply(square, "4", two, "1000000000000000000"), {65}, "too many faces");
  expect_mesh("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", {65}, "nan in OBJ", "m.obj");
  expect_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", {65}, "index in OBJ", "m.obj");
  expect_mesh("", {65}, "empty OBJ", "m.obj");
  expect_mesh("solid", {65}, "unknown format", "m.stl");
}

/// 4 TB of nothing take no disk; read, they would take all of the memory.
TEST_F(HostileInput, MeshesThatAreTooLarge) {
  spit(folder_ / "m.obj", "v 0 0 0\n");
  fs::resize_file(folder_ / "m.obj", std::uintmax_t{4} << 40);
  use_mesh("m.obj");
  expect(run(), {77}, "of a sheet");
  EXPECT_NE(run().err.find("/shells/0/mesh/file: "), std::string::npos);
  spit(folder_ / "s.json",
       R"({"smoke": {"resolution": [8, 8, 8]}, "obstacles": [{"kind": "mesh", "file": "m.obj"}]})");
  expect(run(), {77}, "of an obstacle");
  EXPECT_NE(run().err.find("/obstacles/0/file: "), std::string::npos);
}

TEST_F(HostileInput, BinaryMeshesWithFlippedBytes) {
  std::string good =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::int32_t corners[3] = {0, 1, 2};
  good.append(reinterpret_cast<const char*>(points), sizeof points).append(1, '\3');
  good.append(reinterpret_cast<const char*>(corners), sizeof corners);
  expect_mesh(good, {0}, "good");
  for (std::uint64_t n = 0; n < 25; ++n) {
    std::string damaged = good;
    for (std::uint64_t k = 0; k < 3; ++k)
      damaged[hash_index(11, 3 * n + k) % good.size()] = static_cast<char>(hash_index(12, 3 * n + k));
    expect_mesh(damaged, {0, 65, 77}, "flipped " + std::to_string(n));
  }
}

}  // namespace

}  // namespace wick::test
