/// What a run may replace in its output folder, and what it must leave: files that somebody else put there.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>

#include "scenes/run_folder.h"
#include "tests/scenes/program.h"

namespace wick::test {

namespace {

class Owner : public testing::Test {
 protected:
  Owner() { spit(folder_ / "small.json", small_scene); }
  int run(const std::vector<std::string>& more = {}, const std::string& scene = "small.json") {
    std::vector<std::string> all{"run", scene, "--quiet"};
    all.insert(all.end(), more.begin(), more.end());
    for (const auto& [option, value] : {std::pair{"--frames", "3"}, std::pair{"--out", "a"}})
      if (std::find(more.begin(), more.end(), option) == more.end()) all.insert(all.end(), {option, value});
    Program program(folder_, all);
    const int code = program.wait();
    error_ = program.err();
    EXPECT_LE(std::count(error_.begin(), error_.end(), '\n'), 1) << error_;
    return code;
  }
  void expect_refused(const std::string& part, const std::vector<std::string>& more = {}) {
    EXPECT_EQ(run(more), 73) << error_;
    EXPECT_NE(error_.find(part), std::string::npos) << error_;
  }
  void put(const std::string& file, const std::string& text = "mine") {
    fs::create_directories((folder_ / file).parent_path());
    spit(folder_ / file, text);
  }
  TemporaryFolder folder_;
  std::string error_;
};

const std::vector<std::string> of_the_user = {"a/volumes/smoke.9999.vdb",
                                              "a/volumes/explosion.0001.vdb",
                                              "a/meshes/ball.0001.ply",
                                              "a/meshes/paper.0004.ply",
                                              "a/previews/0001.png",
                                              "a/motion/walk.h5",
                                              "a/notes.txt",
                                              "a/.swap.tmp"};

TEST_F(Owner, RestartRemovesWhatTheRunWroteAndNothingElse) {
  ASSERT_EQ(run(), 0) << error_;
  for (const std::string& file : of_the_user) put(file);
  ASSERT_EQ(run({"--restart", "--frames", "2", "--set", "/fps=30"}), 0) << error_;
  for (const std::string& file : of_the_user) EXPECT_EQ(slurp(folder_ / file), "mine") << file;
  for (const char* file : {"a/volumes/smoke.0003.vdb", "a/meshes/paper.0003.ply", "a/checkpoints/0003.h5"})
    EXPECT_FALSE(fs::exists(folder_ / file)) << file;
  EXPECT_TRUE(fs::exists(folder_ / "a/meshes/paper.0002.ply"));
}

/// Without a list only names are left to go by that the new run is going to write itself.
TEST_F(Owner, RestartWithADamagedManifestTouchesOnlyItsOwnNames) {
  for (const std::string& damage : {std::string(), std::string("{\"files\""), std::string("[]"),
                                    std::string(R"({"files": {"../small.json": {}}})")}) {
    ASSERT_EQ(run({"--restart"}), 0) << error_;
    for (const std::string& file : of_the_user) put(file);
    put("a/manifest.json", damage);
    ASSERT_EQ(run({"--restart", "--frames", "2"}), 0) << error_;
    for (const std::string& file : of_the_user) EXPECT_EQ(slurp(folder_ / file), "mine") << file;
    EXPECT_TRUE(fs::exists(folder_ / "a/volumes/smoke.0003.vdb")) << "it could be anybody's";
    EXPECT_TRUE(fs::exists(folder_ / "small.json"));
  }
}

/// A manifest that was tampered with reaches no file outside the folders of frames.
TEST_F(Owner, RestartBelievesNoManifestThatListsOtherFiles) {
  ASSERT_EQ(run(), 0) << error_;
  put("a/mine/thesis.tex");
  put("a/manifest.json", R"({"files": {"mine/thesis.tex": {"frame": 1, "bytes": 4, "sha256": "x"}}})");
  ASSERT_EQ(run({"--restart"}), 0) << error_;
  EXPECT_EQ(slurp(folder_ / "a/mine/thesis.tex"), "mine");
}

TEST_F(Owner, NeverReplacesASceneThatNoRunWrote) {
  for (const std::string& text : {std::string("{\"frames\": 2, \"smoke\": {}}"), std::string(), std::string("x")}) {
    put("a/scene.json", text);
    expect_refused("a/scene.json was not written by a run");
    expect_refused("a/scene.json was not written by a run", {"--restart"});
    EXPECT_EQ(slurp(folder_ / "a/scene.json"), text);
    EXPECT_EQ(files_below(folder_ / "a"), std::vector<std::string>{"scene.json"}) << "and leaves nothing there";
  }
}

TEST_F(Owner, NeverReplacesARunsSceneThatWasEdited) {
  ASSERT_EQ(run(), 0) << error_;
  nlohmann::json scene = nlohmann::json::parse(slurp(folder_ / "a/scene.json"));
  scene["fps"] = 48;
  put("a/scene.json", scene.dump(2));
  expect_refused("a/scene.json was not written by a run");
  expect_refused("a/scene.json was not written by a run", {"--restart"});
  EXPECT_EQ(slurp(folder_ / "a/scene.json"), scene.dump(2));
}

TEST_F(Owner, NeverReplacesTheSceneThatIsRun) {
  put("a/scene.json", small_scene);
  EXPECT_EQ(run({}, "a/scene.json"), 73);
  EXPECT_NE(error_.find("--out is the folder of the scene file"), std::string::npos) << error_;
  fs::create_directory_symlink("a", folder_ / "link");
  EXPECT_EQ(run({"--out", "link"}, "a/scene.json"), 73) << error_;
  EXPECT_EQ(slurp(folder_ / "a/scene.json"), small_scene);
}

TEST_F(Owner, RefusesTheFolderOfAnotherSceneByName) {
  std::string other = small_scene;
  other.replace(other.find("small"), 5, "other");
  spit(folder_ / "other.json", other);
  ASSERT_EQ(run({}, "other.json"), 0) << error_;
  const std::string scene = slurp(folder_ / "a/scene.json");
  expect_refused("a holds another run, of other (");
  fs::remove_all(folder_ / "a/checkpoints");
  expect_refused("a holds a run of other (its run.json");
  EXPECT_EQ(slurp(folder_ / "a/scene.json"), scene);
  EXPECT_EQ(run({"--restart"}), 0) << error_;
  EXPECT_EQ(nlohmann::json::parse(slurp(folder_ / "a/run.json"))["scene"], "small");
}

TEST_F(Owner, ResumedWithOtherFramesItReplacesItsOwnScene) {
  ASSERT_EQ(run({"--frames", "2"}), 0) << error_;
  ASSERT_EQ(run({"--frames", "4"}), 0) << error_;
  ASSERT_EQ(run({"--frames", "3"}), 0) << "complete: " << error_;
  ASSERT_EQ(run({"--frames", "5", "--set", "/output/checkpoint/every=3"}), 0) << error_;
  EXPECT_EQ(nlohmann::json::parse(slurp(folder_ / "a/scene.json"))["frames"], 5);
}

TEST_F(Owner, KnowsItsOwnSceneAfterItsRecordWasLost) {
  ASSERT_EQ(run(), 0) << error_;
  fs::remove(folder_ / "a/run.json");
  ASSERT_EQ(run(), 0) << error_;
  ASSERT_EQ(run({"--frames", "4"}), 0) << error_;
  EXPECT_EQ(run({"--set", "/heat_sources=[]"}), 73);
  EXPECT_NE(error_.find("(/heat_sources was [{"), std::string::npos) << error_;
}

TEST_F(Owner, RefusesAFolderWithForeignFilesOfItsNames) {
  for (const char* file :
       {"run.json", "metrics.h5", "manifest.json", "meshes/paper.0002.ply", "checkpoints/0002.h5", "run.lock"}) {
    put(std::string("a/") + file);
    expect_refused(file);
    EXPECT_EQ(slurp(folder_ / "a" / file), "mine");
    fs::remove_all(folder_ / "a");
  }
  put("a/meshes/paper.0002.ply");
  put("a/meshes/cloth.0002.ply");
  // Beginning anew is for what a run began: here none did.
  EXPECT_EQ(run({"--restart"}), 73);
  EXPECT_EQ(slurp(folder_ / "a/meshes/paper.0002.ply"), "mine");
  fs::remove(folder_ / "a/meshes/paper.0002.ply");
  EXPECT_EQ(run({"--restart"}), 0) << error_;
  EXPECT_EQ(slurp(folder_ / "a/meshes/cloth.0002.ply"), "mine");
}

TEST_F(Owner, NeverReplacesAFileThatTheSceneReads) {
  const std::vector<std::string> record{"--set", "/output/motion/write=true", "--set", "/burning=null"};
  ASSERT_EQ(run(record), 0) << error_;
  ASSERT_TRUE(fs::exists(folder_ / "a/motion/paper.h5"));
  std::vector<std::string> replay = record;
  replay.insert(replay.end(), {"--set", R"(/shells/0/motion={"kind": "recorded", "file": "a/motion/paper.h5"})"});
  replay.emplace_back("--restart");
  expect_refused("/shells/0/motion/file: ", replay);
  EXPECT_TRUE(fs::exists(folder_ / "a/motion/paper.h5"));
}

/// Killed while it takes a folder over, or begins anew in it, a run leaves nothing that the next one takes for
/// somebody else's.
TEST_F(Owner, KnowsWhatAKilledRunLeft) {
  for (int n = 0; n < 40; ++n) {
    const std::string fps = "/fps=" + std::to_string(24 + n % 3);
    Program program(folder_, {"run", "small.json", "--quiet", "--out", "a", "--restart", "--set", fps});
    ::usleep(static_cast<useconds_t>(4000 + 1500 * n));
    program.signal(SIGKILL);
    program.wait();
    if (n % 8 < 7) continue;
    EXPECT_EQ(run({"--restart", "--set", fps}), 0) << n << ": " << error_;
  }
}

}  // namespace

}  // namespace wick::test
