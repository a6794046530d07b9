/// A run that is stopped, killed, starved of disk or damaged goes on to the state that an undisturbed one reaches.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/noise.h"
#include "scenes/checkpoint.h"
#include "scenes/run_folder.h"
#include "tests/scenes/program.h"

namespace wick::test {

namespace {

using scenes::Checkpoint;
using scenes::checkpoint_frames;
using scenes::checkpoint_name;

constexpr int frames = 24;

class Interruption : public testing::Test {
 protected:
  Interruption() { spit(folder_ / "small.json", small_scene); }

  [[nodiscard]] static std::vector<std::string> arguments(const std::string& out, int count = frames) {
    return {"run", "small.json", "--out", out, "--frames", std::to_string(count), "--quiet"};
  }
  int run(const std::string& out, int count = frames, const std::vector<std::string>& more = {},
          const std::function<void()>& prepare = {}) {
    std::vector<std::string> all = arguments(out, count);
    all.insert(all.end(), more.begin(), more.end());
    Program program(folder_, all, prepare);
    const int code = program.wait();
    error_ = program.err();
    return code;
  }
  [[nodiscard]] nlohmann::json record(const std::string& out) const {
    return nlohmann::json::parse(slurp(folder_ / out / "run.json"));
  }
  [[nodiscard]] std::string hash(const std::string& out) const { return record(out)["state_hash"]; }

  /// Meshes are the same bytes; volumes carry a random identifier of 36 bytes at offset 21 and are otherwise the
  /// same.
  void expect_same_outputs(const std::string& a, const std::string& b) {
    EXPECT_EQ(hash(a), hash(b));
    for (const std::string& file : files_below(folder_ / a)) {
      if (!file.ends_with(".ply") && !file.ends_with(".vdb")) continue;
      EXPECT_TRUE(slurp(folder_ / a / file) == slurp(folder_ / b / file)) << file;
    }
  }
  void wait_for(const fs::path& file) const {
    for (int tries = 0; tries < 3000 && !fs::exists(folder_ / file.string()); ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

  TemporaryFolder folder_;
  std::string error_;
};

TEST_F(Interruption, MoreFramesGoOnWhereTheRunEnded) {
  ASSERT_EQ(run("whole", 9), 0);
  ASSERT_EQ(run("parts", 4), 0);
  ASSERT_EQ(run("parts", 9), 0);
  expect_same_outputs("whole", "parts");
  EXPECT_EQ(run("parts", 9), 0);
  EXPECT_EQ(run("parts", 5), 0);
  EXPECT_EQ(record("parts")["frames"], 9);
}

/// Settings that may change act on frames to come only: a complete run says that there are none.
TEST_F(Interruption, NamesChangedSettingsAndWhereTheyAct) {
  const auto told = [&](int count, const std::vector<std::string>& more) {
    std::vector<std::string> all{"run", "small.json", "--out", "a", "--frames", std::to_string(count)};
    all.insert(all.end(), more.begin(), more.end());
    Program program(folder_, all);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return program.err();
  };
  const std::vector<std::string> previews{"--set", "/output/preview/write=true"};
  told(3, {});
  EXPECT_EQ(told(3, {}), "");
  EXPECT_EQ(told(2, {}), "");
  const std::string complete = told(3, previews);
  EXPECT_NE(
      complete.find("wick: warning: /output/preview/write was false, is true: nothing was computed with that"),
      std::string::npos)
      << complete;
  EXPECT_EQ(std::count(complete.begin(), complete.end(), '\n'), 1) << complete;
  EXPECT_FALSE(fs::exists(folder_ / "a/previews"));
  const std::string longer = told(4, previews);
  EXPECT_NE(longer.find("changed from frame 4 on: /output/preview/write was false, is true\n"), std::string::npos)
      << longer;
  EXPECT_TRUE(fs::exists(folder_ / "a/previews/0004.png"));
  EXPECT_EQ(told(4, previews), "") << "which is what the folder records now";
}

TEST_F(Interruption, StopsOnRequestAndGoesOn) {
  ASSERT_EQ(run("whole"), 0);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR2}) {
    const std::string out = "stopped" + std::to_string(signal);
    Program program(folder_, arguments(out));
    wait_for(out + "/meshes/paper.0004.ply");
    program.signal(signal);
    ASSERT_EQ(program.wait(), 75) << program.err();
    EXPECT_EQ(record(out)["outcome"], "checkpointed");
    EXPECT_EQ(checkpoint_frames(folder_ / out / "checkpoints").front(), record(out)["frames"].get<int>());
    ASSERT_EQ(run(out), 0) << error_;
    expect_same_outputs("whole", out);
  }
}

/// 42 steps a frame: nearly every stop falls within a frame, and goes on from there.
TEST_F(Interruption, StopsWithinAFrameAndGoesOn) {
  const std::vector<std::string> steps{"--set", "/coupling/max_step=0.001", "--set", "/output/checkpoint/every=0"};
  ASSERT_EQ(run("whole", 6, steps), 0);
  int within = 0, code = 75;
  for (std::uint64_t n = 0; n < 40 && code != 0; ++n) {
    std::vector<std::string> all = arguments("stopped", 6);
    all.insert(all.end(), steps.begin(), steps.end());
    Program program(folder_, all);
    wait_for("stopped/run.lock");
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + hash_index(7, n) % 120));
    program.signal(SIGTERM);
    code = program.wait();
    ASSERT_TRUE(code == 75 || code == 0) << code << program.err();
    const int frame = checkpoint_frames(folder_ / "stopped/checkpoints").front();
    const Checkpoint checkpoint(folder_ / "stopped/checkpoints" / checkpoint_name(frame));
    within += checkpoint.header().time > (frame - 1) / 24.0 + 1e-6;
  }
  EXPECT_GE(within, 1);
  ASSERT_EQ(run("stopped", 6, steps), 0) << error_;
  expect_same_outputs("whole", "stopped");
}

TEST_F(Interruption, SaysTheRequeueCodeAfterAStop) {
  std::vector<std::string> all = arguments("a", 200);
  all.insert(all.end(), {"--requeue-code", "99"});
  Program program(folder_, all);
  wait_for("a/meshes/paper.0002.ply");
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), 99);
  EXPECT_EQ(record("a")["outcome"], "checkpointed");
}

TEST_F(Interruption, MakesDamagedOutputsAgain) {
  ASSERT_EQ(run("whole", 6), 0);
  ASSERT_EQ(run("a", 6), 0);
  fs::remove(folder_ / "a/volumes/smoke.0005.vdb");
  spit(folder_ / "a/meshes/paper.0006.ply", "damaged");
  ASSERT_EQ(run("a", 6), 0) << error_;
  EXPECT_EQ(record("a")["damaged_outputs"].dump(), "[\"meshes/paper.0006.ply\",\"volumes/smoke.0005.vdb\"]");
  expect_same_outputs("whole", "a");
  ASSERT_EQ(run("a", 7), 0) << error_;
  EXPECT_EQ(record("a")["damaged_outputs"].dump(), "[]") << "they were made again";
}

TEST_F(Interruption, NamesDamagedOutputsThatItCannotMakeAgain) {
  ASSERT_EQ(run("a", 12), 0);
  fs::remove(folder_ / "a/meshes/paper.0001.ply");
  ASSERT_EQ(run("a", 13), 0) << error_;
  EXPECT_NE(record("a")["warnings"].dump().find("meshes/paper.0001.ply (missing)"), std::string::npos);
  EXPECT_EQ(record("a")["frames"], 13);
  fs::remove(folder_ / "a/manifest.json");
  ASSERT_EQ(run("a", 14), 0) << error_;
  EXPECT_NE(record("a")["warnings"].dump().find("not verified"), std::string::npos);
}

TEST_F(Interruption, WritesACheckpointOnRequestAndGoesOn) {
  Program program(folder_, {"run", "small.json", "--out", "a", "--frames", "60", "--quiet", "--set",
                            "/output/checkpoint={\"every\": 0, \"keep\": 10}"});
  wait_for("a/meshes/paper.0004.ply");
  program.signal(SIGUSR1);
  ASSERT_EQ(program.wait(), 0);
  const std::vector<int> found = checkpoint_frames(folder_ / "a/checkpoints");
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found.front(), 60);
  EXPECT_EQ(found.back(), 1);
}

/// Killed at any moment, writes included: no visible file is half-made, and the next run reaches the same state.
TEST_F(Interruption, SurvivesBeingKilled) {
  ASSERT_EQ(run("whole"), 0);
  int killed = 0;
  for (std::uint64_t n = 0; n < 25; ++n) {
    Program program(folder_, arguments("killed"));
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + hash_index(5, n) % 200));
    program.signal(SIGKILL);
    const int code = program.wait();
    killed += code == 128 + SIGKILL;
    for (const int frame : checkpoint_frames(folder_ / "killed/checkpoints"))
      EXPECT_NO_THROW(Checkpoint(folder_ / "killed/checkpoints" / checkpoint_name(frame))) << frame;
    if (code == 0) fs::remove_all(folder_ / "killed");
  }
  EXPECT_GT(killed, 5);
  ASSERT_EQ(run("killed"), 0) << error_;
  expect_same_outputs("whole", "killed");
  for (const std::string& file : files_below(folder_ / "killed")) EXPECT_FALSE(file.ends_with(".tmp")) << file;
}

TEST_F(Interruption, FallsBackToTheCheckpointBefore) {
  ASSERT_EQ(run("whole", 8), 0);
  ASSERT_EQ(run("a", 6), 0);
  const fs::path newest = folder_ / "a/checkpoints" / checkpoint_name(6);
  std::string bytes = slurp(newest);
  bytes[bytes.size() / 2] ^= 1;
  spit(newest, bytes);
  ASSERT_EQ(run("a", 8), 0);
  expect_same_outputs("whole", "a");
  EXPECT_NE(record("a")["warnings"].dump().find("checksum is wrong"), std::string::npos);
}

TEST_F(Interruption, BeginsAnewWhenEveryCheckpointIsDamaged) {
  ASSERT_EQ(run("whole", 8), 0);
  ASSERT_EQ(run("a", 6), 0);
  for (const int frame : checkpoint_frames(folder_ / "a/checkpoints"))
    spit(folder_ / "a/checkpoints" / checkpoint_name(frame), "damaged");
  ASSERT_EQ(run("a", 8), 0);
  expect_same_outputs("whole", "a");
}

TEST_F(Interruption, KeepsRunsOfDifferentScenesApart) {
  ASSERT_EQ(run("a", 3), 0);
  const std::vector<std::string> other{"--set", "/fps=30"};
  EXPECT_EQ(run("a", 4, other), 73);
  EXPECT_NE(error_.find("/fps was 24.0, is 30.0"), std::string::npos) << error_;
  fs::remove_all(folder_ / "a/checkpoints");
  EXPECT_EQ(run("a", 4, other), 73) << "run.json still tells whose folder it is";
  EXPECT_EQ(run("a", 4, {"--set", "/output/checkpoint/every=3"}), 0) << "what may change is no other scene";
  EXPECT_EQ(run("a", 2, {"--set", "/fps=30", "--restart"}), 0);
  EXPECT_FALSE(fs::exists(folder_ / "a/meshes/paper.0003.ply")) << "frames of the earlier run are gone";
}

TEST_F(Interruption, KeepsASecondRunOut) {
  Program first(folder_, arguments("a", 100));
  wait_for("a/meshes/paper.0002.ply");
  EXPECT_EQ(run("a", 100), 73);
  EXPECT_NE(error_.find("is in use by host "), std::string::npos) << error_;
  first.signal(SIGKILL);
  first.wait();
  EXPECT_TRUE(fs::exists(folder_ / "a/run.lock")) << "the killed run left its lock behind";
  EXPECT_EQ(record("a")["outcome"], "running");
  EXPECT_GE(record("a")["frames"], 1) << "how far it was at its last checkpoint";
  EXPECT_EQ(run("a", 3), 0) << "which holds nobody up";
}

TEST_F(Interruption, SaysThatTheDiskIsFull) {
  ASSERT_EQ(run("whole"), 0);
  ASSERT_EQ(run("a", 6), 0);
  // Metrics and meshes stay small; the checkpoint is the first that no longer fits.
  const auto size = static_cast<rlim_t>(fs::file_size(folder_ / "a/checkpoints" / checkpoint_name(6)));
  const int code = run("a", frames, {}, [&] {
    const rlimit limit{size / 2, size / 2};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(code, 74) << error_;
  EXPECT_NE(error_.find(" bytes (File too large)"), std::string::npos) << error_;
  EXPECT_EQ(checkpoint_frames(folder_ / "a/checkpoints").front(), 6);
  EXPECT_EQ(record("a")["outcome"], "failed");
  for (const std::string& file : files_below(folder_ / "a")) EXPECT_FALSE(file.ends_with(".tmp")) << file;
  ASSERT_EQ(run("a"), 0);
  expect_same_outputs("whole", "a");
}

/// On a real disk that is full not even a record fits: its space was set aside.
TEST_F(Interruption, LeavesATruthfulRecordOnAFullDisk) {
  fs::create_directories(folder_ / "disk");
  constexpr int skipped = 97;
  // The disk is seen by the program alone, and whatever it frees there is filled at once by somebody else.
  const std::string script =
      "mount -t tmpfs -o size=3m none disk || exit 97; \"$0\" run small.json --out disk/a --frames 4000 --quiet & "
      "run=$!; while [ ! -e disk/a/meshes/paper.0002.ply ]; do sleep 0.01; done; "
      "while kill -0 $run; do cat /dev/zero >> disk/fill; done 2> /dev/null; wait $run; code=$?; "
      "cp disk/a/run.json record.json; ls -A disk/a > left; exit $code";
  Program program(
      folder_, {"-c", script, WICK_PROGRAM},
      [] {
        if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0)
          ::_exit(skipped);
      },
      "/bin/sh");
  const int code = program.wait();
  if (code == skipped) GTEST_SKIP() << "this user may not mount a small disk";
  EXPECT_EQ(code, 74) << program.err();
  EXPECT_NE(program.err().find("(No space left on device)"), std::string::npos) << program.err();
  const nlohmann::json record = nlohmann::json::parse(slurp(folder_ / "record.json"));
  EXPECT_EQ(record["outcome"], "failed");
  EXPECT_NE(record["reason"].get<std::string>().find("No space left"), std::string::npos);
  EXPECT_EQ(slurp(folder_ / "left").find("reserve"), std::string::npos) << "the space is given back";
}

}  // namespace

}  // namespace wick::test
