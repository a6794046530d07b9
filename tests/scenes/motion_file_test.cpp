/// Recorded motion: what a run writes, over interruptions, and what a scene that replays it refuses.
#include "scenes/motion_file.h"

#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/noise.h"
#include "core/require.h"
#include "scenes/hdf5_image.h"
#include "scenes/scene_file.h"
#include "solid/primitives.h"
#include "tests/scenes/program.h"

namespace wick::test {

namespace {

using namespace scenes;

/// A sheet that falls from its pins and is warmed; a few milliseconds a frame.
const char* const recorded_scene = R"({
  "name": "fall", "frames": 12, "fps": 60,
  "shells": [{"name": "cloth", "mesh": {"vertices": [9, 9], "size": [0.5, 0.5], "position": [0, 0, 1]},
              "material": {"young_warp": 1e6, "young_weft": 1e6}, "pins": [{"edge": "-x"}]}],
  "diffusion": {}, "heat_sources": [{"center": [0.5, 0.25, 1], "radius": 0.2, "stop": 10}],
  "output": {"mesh": {"write": false}, "motion": {"write": true}, "checkpoint": {"every": 3}}
})";

/// The same sheet, moved as it was recorded.
const std::vector<std::string> replaying{"--set", R"(/shells/0/pins=[])", "--set",
                                         R"(/shells/0/motion={"kind":"recorded","file":"motion.h5"})"};

class MotionRun : public testing::Test {
 protected:
  MotionRun() { spit(folder_ / "fall.json", recorded_scene); }

  int run(const std::string& out, int frames, const std::vector<std::string>& more = {},
          const std::string& command = "run") {
    std::vector<std::string> all{command, "fall.json", "--out", out, "--frames", std::to_string(frames), "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    Program program(folder_, all);
    const int code = program.wait();
    error_ = program.err();
    return code;
  }
  [[nodiscard]] fs::path motion(const std::string& out) const { return folder_ / out / "motion/cloth.h5"; }
  [[nodiscard]] nlohmann::json json(const std::string& out, const std::string& file = "run.json") const {
    return nlohmann::json::parse(slurp(folder_ / out / file));
  }
  void expect_same_motion(const std::string& a, const std::string& b) const {
    ASSERT_TRUE(fs::exists(motion(a)) && fs::exists(motion(b)));
    EXPECT_TRUE(slurp(motion(a)) == slurp(motion(b))) << b;
  }

  TemporaryFolder folder_;
  std::string error_;
};

TEST_F(MotionRun, LeavesOneFileASheetAndListsIt) {
  ASSERT_EQ(run("a", 5), 0) << error_;
  const coupling::MotionTrack track = read_motion(motion("a"), "");
  ASSERT_EQ(track.time.size(), 5U);
  for (std::size_t n = 0; n < 5; ++n) EXPECT_NEAR(track.time[n], double(n) / 60, 1e-15);
  EXPECT_EQ(track.x[0], track.rest);
  EXPECT_LT(track.x[4].back().z(), track.rest.back().z());
  EXPECT_EQ(track.triangles.size(), 128U);
  const Bytes bytes = slurp(motion("a"));
  EXPECT_EQ(Hdf5Reader(bytes).strings("/units").front(), "m,s");
  const nlohmann::json files = json("a", "manifest.json")["files"];
  EXPECT_EQ(files["motion/cloth.h5"]["frame"], 5);
  EXPECT_EQ(files["motion/cloth.h5"]["bytes"], bytes.size());
  EXPECT_TRUE(files.contains("motion/frames/cloth.0005.h5"));
  ASSERT_EQ(run("b", 5, {"--set", "/output/motion/write=false"}), 0);
  EXPECT_FALSE(fs::exists(folder_ / "b/motion"));
}

TEST_F(MotionRun, MoreFramesGiveTheFileOfOneRun) {
  ASSERT_EQ(run("whole", 12), 0);
  for (const int frames : {4, 9, 12}) ASSERT_EQ(run("parts", frames), 0) << error_;
  expect_same_motion("whole", "parts");
  EXPECT_EQ(run("parts", 12, {"--set", "/output/motion/write=false"}), 73) << "a motion has all frames or none";
  EXPECT_NE(error_.find("/output/motion/write was true, is false"), std::string::npos) << error_;
  ASSERT_EQ(run("parts", 4, {"--restart"}), 0);
  EXPECT_EQ(read_motion(motion("parts"), "").time.size(), 4U);
  EXPECT_FALSE(fs::exists(folder_ / "parts/motion/frames/cloth.0005.h5")) << "frames of the earlier run are gone";
}

TEST_F(MotionRun, IsTheSameAfterStopsAndKills) {
  ASSERT_EQ(run("whole", 40), 0);
  int interrupted = 0;
  for (std::uint64_t n = 0; n < 12; ++n) {
    Program program(folder_, {"run", "fall.json", "--out", "parts", "--frames", "40", "--quiet"});
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + hash_index(3, n) % 150));
    program.signal(n % 2 == 0 ? SIGKILL : SIGTERM);
    interrupted += program.wait() != 0;
  }
  EXPECT_GT(interrupted, 0);
  ASSERT_EQ(run("parts", 40), 0) << error_;
  expect_same_motion("whole", "parts");
  for (const std::string& file : files_below(folder_ / "parts")) EXPECT_FALSE(file.ends_with(".tmp")) << file;
}

TEST_F(MotionRun, IsMadeAgainWhereItIsDamagedOrMissing) {
  ASSERT_EQ(run("whole", 9), 0);
  ASSERT_EQ(run("a", 9), 0);
  spit(motion("a"), "damaged");
  ASSERT_EQ(run("a", 9), 0) << error_;
  EXPECT_EQ(json("a")["damaged_outputs"].dump(), "[\"motion/cloth.h5\"]");
  expect_same_motion("whole", "a");
  fs::remove(folder_ / "a/motion/frames/cloth.0008.h5");
  ASSERT_EQ(run("a", 9), 0) << error_;
  expect_same_motion("whole", "a");
  // Killed between the last checkpoint and the joining: the frames are there, and no manifest names the file.
  fs::remove(motion("a"));
  nlohmann::json manifest = json("a", "manifest.json");
  manifest["files"].erase("motion/cloth.h5");
  spit(folder_ / "a/manifest.json", manifest.dump());
  ASSERT_EQ(run("a", 9), 0) << error_;
  expect_same_motion("whole", "a");
}

TEST_F(MotionRun, NamesFramesThatAreLost) {
  ASSERT_EQ(run("a", 12), 0);
  fs::remove(folder_ / "a/motion/frames/cloth.0002.h5");
  ASSERT_EQ(run("a", 13), 0) << error_;
  EXPECT_NE(json("a")["warnings"].dump().find("motion/frames/cloth.0002.h5"), std::string::npos);
  EXPECT_EQ(read_motion(motion("a"), "").time.size(), 12U);
}

TEST_F(MotionRun, ReplaysToTheSameHeatWithoutAShellSolver) {
  ASSERT_EQ(run("a", 12), 0);
  fs::copy(motion("a"), folder_ / "motion.h5");
  ASSERT_EQ(run("b", 12, replaying), 0) << error_;
  EXPECT_EQ(json("b")["models"].dump(), "[\"diffusion\"]");
  expect_same_motion("a", "b");
  EXPECT_EQ(run("b", 12, replaying, "check"), 0) << error_;
  const auto theta = [&](const std::string& out) {
    const Bytes bytes = slurp(folder_ / out / "metrics.h5");
    const Hdf5Reader reader(bytes);
    std::vector<double> values(reader.rows("/shell/cloth/theta_max", ScalarType::f64, 1));
    reader.read("/shell/cloth/theta_max", ScalarType::f64, values.data());
    return values;
  };
  EXPECT_EQ(theta("a"), theta("b"));
}

TEST_F(MotionRun, RefusesToGoOnWithAnotherMotionFile) {
  ASSERT_EQ(run("a", 12), 0);
  ASSERT_EQ(run("other", 12, {"--set", "/gravity=[0,0,-5]"}), 0);
  fs::copy(motion("a"), folder_ / "motion.h5");
  ASSERT_EQ(run("b", 6, replaying), 0) << error_;
  ASSERT_EQ(run("b", 7, replaying), 0) << error_;
  fs::copy(motion("other"), folder_ / "motion.h5", fs::copy_options::overwrite_existing);
  EXPECT_EQ(run("b", 12, replaying), 73);
  EXPECT_NE(error_.find("/shells/0/motion/file was"), std::string::npos) << error_;
}

TEST_F(MotionRun, ReplayGoesOnBitForBit) {
  ASSERT_EQ(run("a", 12), 0);
  fs::copy(motion("a"), folder_ / "motion.h5");
  ASSERT_EQ(run("whole", 12, replaying), 0);
  for (const int frames : {3, 8, 12}) ASSERT_EQ(run("parts", frames, replaying), 0) << error_;
  EXPECT_EQ(json("whole")["state_hash"], json("parts")["state_hash"]);
}

/// Small motion files made by hand.
class MotionFile : public testing::Test {
 protected:
  struct Content {
    std::vector<double> time{0.0, 0.5, 1.0};
    std::size_t vertices = 9;
    double bad = 0.0;           ///< of one coordinate of the second frame
    Vec3 shift = Vec3::Zero();  ///< of one rest position
    bool turned = false;        ///< first triangle
  };
  MotionFile() {
    spit(folder_ / "scene.json", R"({"shells": [{"mesh": {"vertices": [3, 3], "lattice": "grid"},
      "motion": {"kind": "recorded", "file": "motion.h5"}}]})");
  }
  void write(const Content& c) const {
    solid::ShellMesh mesh = solid::build_mesh(solid::rectangle(3, 3, Vec2(1, 1), solid::Lattice::grid));
    mesh.rest.resize(c.vertices, Vec3::Zero());
    mesh.rest[4] += c.shift;
    if (c.turned) std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
    std::vector<Vec3> x = mesh.rest;
    spit(folder_ / "motion.h5", motion_file(
                                    {{1, 2, 3}, c.time, &mesh}, [&](std::size_t n) -> const auto& {
                                      x[5].y() = n == 1 ? c.bad : 0.5;
                                      return x;
                                    }));
  }
  /// What reading the scene and building its world says; empty where it goes well.
  std::string problem() {
    try {
      const Scene scene = read_scene(folder_ / "scene.json");
      const coupling::World world(scene.world);
      return "";
    } catch (const Refusal& refusal) {
      EXPECT_EQ(refusal.pointer(), "/shells/0/motion/file") << refusal.what();
      const std::string line = format_refusal("scene.json", refusal);
      EXPECT_EQ(line.find('\n'), std::string::npos);
      code_ = refusal.code();
      return line;
    }
  }
  void expect_refused(const std::string& part, ExitCode code = ExitCode::scene_invalid) {
    const std::string line = problem();
    EXPECT_NE(line.find(part), std::string::npos) << line;
    EXPECT_EQ(code_, code);
  }
  TemporaryFolder folder_;
  ExitCode code_ = ExitCode::done;
};

TEST_F(MotionFile, IsRefusedWhereItIsNoMotionOfThisSheet) {
  expect_refused("No such file", ExitCode::input_missing);
  write({});
  EXPECT_EQ(problem(), "");
  spit(folder_ / "motion.h5", "ply\nformat ascii 1.0\n");
  expect_refused("is no motion file (HDF5: not an HDF5 file)");
  write({.time = {0.0, 1.0, 1.0}});
  expect_refused("/time[2] = 1 does not come after the one before");
  write({.time = {0.0, NAN, 1.0}});
  expect_refused("/time[1] = nan");
  write({.bad = NAN});
  expect_refused("/x[1][5] = (1, nan, 0) is no place");
  write({.bad = INFINITY});
  expect_refused("/x[1][5]");
  write({.bad = 1e12});
  expect_refused("is no place within 1000000 m");
  write({.vertices = 10});
  expect_refused("10 vertices (this one has 9)");
  write({.shift = Vec3(0, 0, 1e-3)});
  expect_refused("another rest shape (vertex 4 is 0.001 m away)");
  write({.turned = true});
  expect_refused("other triangles");
}

TEST_F(MotionFile, NeedsTimesAndPlacesOnly) {
  const std::vector<double> time{0.0, 1.0};
  std::vector<double> x(2 * 9 * 3, 0.25);
  const auto write_parts = [&](bool with_time, std::size_t columns) {
    Hdf5Writer writer;
    if (with_time) writer.dataset("/time", ScalarType::f64, 2, 1, time.data());
    writer.blocks("/x", 2, 27 / columns, columns, [&](std::size_t n) { return &x[27 * n]; });
    spit(folder_ / "motion.h5", writer.finish());
  };
  write_parts(true, 3);
  EXPECT_EQ(problem(), "");
  write_parts(false, 3);
  expect_refused("no dataset /time");
  write_parts(true, 9);
  expect_refused("/x is not of frames x vertices x 3");
}

/// Cut anywhere and with bytes changed anywhere, a file is refused or means the same: never a crash, never another
/// motion.
TEST_F(MotionFile, SurvivesDamage) {
  write({});
  const std::string whole = slurp(folder_ / "motion.h5");
  for (std::size_t size = 0; size < whole.size(); size += 97) {
    spit(folder_ / "motion.h5", whole.substr(0, size));
    EXPECT_NE(problem(), "") << size;
  }
  const coupling::MotionTrack right = [&] {
    spit(folder_ / "motion.h5", whole);
    return read_motion(folder_ / "motion.h5", "");
  }();
  for (std::uint64_t n = 0; n < 400; ++n) {
    std::string bytes = whole;
    bytes[hash_index(11, n) % bytes.size()] ^= static_cast<char>(1 + hash_index(12, n) % 255);
    spit(folder_ / "motion.h5", bytes);
    if (!problem().empty()) continue;
    EXPECT_EQ(read_motion(folder_ / "motion.h5", "").x, right.x) << n;
  }
}

}  // namespace

}  // namespace wick::test
