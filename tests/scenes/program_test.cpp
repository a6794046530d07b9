/// The program from outside: exit codes, what it says, and what it leaves on the disk.
#include "tests/scenes/program.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "scenes/disk_estimate.h"
#include "scenes/hdf5_image.h"
#include "scenes/scene_file.h"
#include "tests/support/sanitized.h"

namespace wick::test {

namespace {

struct Outcome {
  int code;
  std::string out, err;
};

/// A folder with small.json in it, where programs are run.
class ProgramTest : public testing::Test {
 protected:
  ProgramTest() { spit(folder_ / "small.json", small_scene); }
  Outcome run(const std::vector<std::string>& arguments, const std::function<void()>& prepare = {}) {
    Program program(folder_, arguments, prepare);
    const int code = program.wait();
    return {code, program.out(), program.err()};
  }
  [[nodiscard]] nlohmann::json record(const std::string& out = "out/small") const {
    return nlohmann::json::parse(slurp(folder_ / out / "run.json"));
  }
  TemporaryFolder folder_;
};

using Command = ProgramTest;

TEST_F(Command, RunsASceneAndLeavesTheContractedFiles) {
  const Outcome outcome = run({"run", "small.json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* file :
       {"scene.json", "run.json", "metrics.h5", "volumes/smoke.0001.vdb", "volumes/smoke.0006.vdb",
        "meshes/paper.0001.ply", "meshes/paper.0006.ply", "checkpoints/0006.h5"})
    EXPECT_TRUE(fs::exists(folder_ / "out/small" / file)) << file;
  EXPECT_FALSE(fs::exists(folder_ / "out/small/volumes/smoke.0007.vdb"));
  EXPECT_FALSE(fs::exists(folder_ / "out/small/run.lock"));
  const nlohmann::json json = record();
  EXPECT_EQ(json["outcome"], "done");
  EXPECT_EQ(json["frames"], 6);
  EXPECT_EQ(json["state_hash"].get<std::string>().size(), 16U);
  for (const char* key :
       {"version", "models", "threads", "wall_s", "peak_rss_bytes", "unconverged_solves", "warnings"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_NE(outcome.err.find("frame 6/6"), std::string::npos);
  EXPECT_NE(outcome.out.find("whole run"), std::string::npos);
}

/// Every frame's row tells what its outputs cost, the first and the last too, and no residual is missing.
TEST_F(Command, TimesItsOutputs) {
  const std::vector<std::string> command{"run", "small.json", "--set", "/output/preview/write=true"};
  const Outcome outcome = run(command);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto column = [&](const std::string& path) {
    const std::string bytes = slurp(folder_ / "out/small/metrics.h5");
    const scenes::Hdf5Reader reader(bytes);
    std::vector<double> values(reader.rows(path, ScalarType::f64, 1));
    reader.read(path, ScalarType::f64, values.data());
    return values;
  };
  for (const char* path : {"/timing/output", "/timing/output_background"}) {
    const std::vector<double> seconds = column(path);
    ASSERT_EQ(seconds.size(), 6U);
    for (const double s : seconds) EXPECT_GT(s, 0.0) << path;
    EXPECT_LT(std::accumulate(seconds.begin(), seconds.end(), 0.0), record()["wall_s"].get<double>()) << path;
  }
  EXPECT_EQ(column("/solve/pressure/residual").front(), 0.0) << "nothing is solved for the initial state";
  for (const char* row : {"\noutput  ", "\n  pressure ", "\nwriting, meanwhile "})
    EXPECT_NE(outcome.out.find(row), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("background"), std::string::npos) << "which is no part of the steps";

  const std::vector<double> waited = column("/timing/output"), meanwhile = column("/timing/output_background");
  ASSERT_EQ(run(command).code, 0);
  EXPECT_EQ(column("/timing/output"), waited) << "a complete run keeps what it measured";
  EXPECT_EQ(column("/timing/output_background"), meanwhile);
  ASSERT_EQ(run({"run", "small.json", "--set", "/output/preview/write=true", "--frames", "8"}).code, 0);
  EXPECT_EQ(column("/timing/output")[5], waited[5]) << "and so does one that goes on";
  EXPECT_EQ(column("/timing/output_background")[5], meanwhile[5]);
}

/// What an installed program needs is installed with it, the origin of its meshes included.
TEST_F(Command, RunsInstalledFromAnotherFolder) {
  const fs::path place = folder_ / "place";
  Program install(folder_, {"--install", WICK_BUILD, "--prefix", place.string()}, {}, WICK_CMAKE);
  ASSERT_EQ(install.wait(), 0) << install.err();
  EXPECT_TRUE(fs::exists(place / "share/wick/scenes/meshes/bunny.ply"));
  EXPECT_NE(slurp(place / "share/wick/scenes/meshes/README.md").find("Stanford"), std::string::npos);
  Program bundled(folder_,
                  {"run", "burning_bunny", "--frames", "1", "--quiet", "--set", "/smoke/resolution=[8,8,8]"}, {},
                  place / "bin/wick");
  EXPECT_EQ(bundled.wait(), 0) << bundled.err();
  EXPECT_TRUE(fs::exists(folder_ / "out/burning_bunny/run.json"));
}

TEST_F(Command, EffectiveSceneGivesTheSameRun) {
  ASSERT_EQ(run({"run", "small.json", "--quiet"}).code, 0);
  ASSERT_EQ(run({"run", "out/small/scene.json", "--out", "again", "--quiet"}).code, 0);
  EXPECT_EQ(record("again")["state_hash"], record()["state_hash"]);
}

TEST_F(Command, GivesTheSameStateAtAnyThreadCount) {
  ASSERT_EQ(run({"run", "small.json", "--threads", "1", "--out", "one", "--quiet"}).code, 0);
  ASSERT_EQ(run({"run", "small.json", "--threads", "2", "--out", "two", "--quiet"}).code, 0);
  EXPECT_EQ(record("one")["state_hash"], record("two")["state_hash"]);
  for (const char* file : {"meshes/paper.0006.ply"})
    EXPECT_EQ(slurp(folder_ / "one" / file), slurp(folder_ / "two" / file));
}

TEST_F(Command, IsQuietWhenAsked) {
  const Outcome outcome = run({"run", "small.json", "--frames", "2", "--quiet"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(Command, LeavesNothingOfAnInvalidScene) {
  const auto refused = [&](const std::vector<std::string>& arguments, int code, const std::string& part) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  };
  refused({"run", "small.json", "--set", "/smoke/resolutoin=[8,8,8]"}, 65,
          "small.json: /smoke/resolutoin: unknown key");
  refused({"run", "small.json", "--set", "/fps=0"}, 65, "/fps: 0 is out of range");
  refused({"run", "small.json", "--set", "/fps=0.001"}, 65,
          "/fps: a frame of 1000 s takes 30000 steps or more of /coupling/max_step");
  refused({"check", "small.json", "--set", "/frames=none"}, 65, "/frames: expected a whole number");
  refused({"run", "small.json", "--set", "frames=3"}, 64, "is not /pointer=value");
  refused({"run", "none.json"}, 66, "no such file");
  refused({"run", "small.json", "--set", "/smoke/resolution=[4000,4000,4000]"}, 77,
          "/smoke/resolution: needs about");
  for (const auto& [section, kind] : {std::pair{"/shells/0/mesh", "file"}, std::pair{"/obstacles/0", "mesh"},
                                      std::pair{"/shells/0/motion", "recorded"}}) {
    const std::string pointer = section;
    refused({"run", "small.json", "--set", pointer + "={\"kind\": \"" + kind + "\", \"file\": \"none.x\"}"}, 66,
            "small.json: " + pointer + "/file: ");
  }
  refused({"run", "small.json", "--set", "/shells/0/mesh/vertices=[20000,20000]"}, 77,
          "small.json: /shells/0/mesh/vertices: needs about 1.0 TB");
  refused({"run", "small.json", "--set", "/shells/0/name=../x"}, 65,
          "small.json: /shells/0/name: \"../x\" cannot be");
  refused({"run", "small.json", "--set", "/shells/1={\"name\": \"paper\"}"}, 65, "small.json: /shells/1/name: ");
  refused({"explain", "/nothing/like/it"}, 64, "no parameter");
}

TEST_F(Command, RefusesABadCommandLine) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{},
                                             {"walk"},
                                             {"run"},
                                             {"run", "small.json", "--frames", "0"},
                                             {"run", "small.json", "--unknown"},
                                             {"run", "small.json", "--out", ""},
                                             {"check", ""},
                                             {"run", "small.json", "--threads", "x"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 64);
    EXPECT_TRUE(outcome.err.starts_with("wick: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_NE(run({}).err.find("a command is missing (there are run, check, "), std::string::npos);
  const std::string two_lines = run({"run", "two\nlines"}).err;
  EXPECT_EQ(std::count(two_lines.begin(), two_lines.end(), '\n'), 1) << two_lines;
  EXPECT_NE(run({"run", "--help"}).out.find("--frames N "), std::string::npos);
  EXPECT_NE(run({"chekc", "small.json"}).err.find("did you mean check?"), std::string::npos);
  EXPECT_EQ(run({"--help"}).code, 0);
  EXPECT_NE(run({"--help"}).out.find("Usage: wick "), std::string::npos);
  EXPECT_EQ(run({"--version"}).code, 0);
}

TEST_F(Command, WarnsOfParametersWithoutEffect) {
  const std::string warned = "wick: warning: /burning/pre_exponential: has no effect (law is not arrhenius)\n";
  for (const char* command : {"check", "run"}) {
    const Outcome outcome = run({command, "small.json", "--set", "/burning/pre_exponential=7", "--frames", "2"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(warned), std::string::npos) << outcome.err;
  }
  const Outcome still =
      run({"check", "small.json", "--set", "/shells/0/pins=[{\"edge\": \"-x\", \"velocity\": [1, 0, 0]}]"});
  EXPECT_NE(still.err.find("/shells/0/pins/0/velocity: has no effect (stop_time is 0"), std::string::npos)
      << still.err;
  const Outcome late = run({"check", "small.json", "--set", "/heat_sources=[{\"start\": 900, \"stop\": 901}]"});
  EXPECT_NE(late.err.find("/heat_sources/0/start: the source has no effect (the last frame is at "),
            std::string::npos)
      << late.err;
}

/// What went wrong on the way is said once, at the end, and kept.
TEST_F(Command, SaysAtItsEndWhatARunMetRarely) {
  const auto said = [&](const std::string& setting, const std::string& text) {
    const Outcome outcome = run({"run", "small.json", "--restart", "--frames", "4", "--set", setting});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
    EXPECT_NE(record()["warnings"].dump().find(text), std::string::npos) << record()["warnings"];
  };
  const Outcome usual = run({"run", "small.json"});
  EXPECT_EQ(usual.err.find("warning"), std::string::npos) << usual.err;
  said("/smoke/pressure/max_iterations=1", "solves stopped at their iteration limit, above their tolerance");
  said("/heat_sources=[{\"center\": [50, 0, 0], \"stop\": 9}]", "was heated in no frame");
  said("/shells/0/pins=[{\"edge\": \"-x\"}, {\"edge\": \"+x\", \"velocity\": [2, 0, 0], \"stop_time\": 9}]",
       "where it does not burn");
}

TEST_F(Command, AnswersWithoutRunning) {
  EXPECT_EQ(run({"check", "small.json", "--set", "/fps=0.001", "--set", "/coupling/max_substeps=30000"}).code, 0);
  EXPECT_EQ(run({"check", "small.json"}).code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  EXPECT_NE(run({"list"}).out.find("burning_sheet"), std::string::npos);
  EXPECT_NE(run({"list"}).out.find("1 shell,"), std::string::npos);
  EXPECT_NE(run({"explain", "/smoke"}).out.find("/smoke/resolution"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::accept(run({"schema"}).out));
  EXPECT_EQ(run({"experiment", "list"}).code, 0);
}

/// An installed program finds its scenes beside itself, wherever it is carried.
TEST_F(Command, FindsTheScenesInstalledBesideIt) {
  fs::create_directories(folder_ / "place/bin");
  fs::create_directories(folder_ / "place/share/wick/scenes");
  fs::copy_file(WICK_PROGRAM, folder_ / "place/bin/wick");
  spit(folder_ / "place/share/wick/scenes/only_here.json", R"({"frames": 1, "smoke": {"resolution": [8, 8, 8]}})");
  Program list(folder_, {"list"}, {}, folder_ / "place/bin/wick");
  EXPECT_EQ(list.wait(), 0);
  EXPECT_EQ(list.out(), "only_here                   1 frame, smoke 8x8x8\n");
  Program bundled(folder_, {"run", "only_here", "--quiet"}, {}, folder_ / "place/bin/wick");
  EXPECT_EQ(bundled.wait(), 0) << bundled.err();
  EXPECT_TRUE(fs::exists(folder_ / "out/only_here/run.json"));
}

/// A run outlives whoever reads what it prints; an answer that cannot be printed is no success.
TEST_F(Command, MindsItsStreams) {
  const auto on = [](int fd, const char* device) {
    if (device == nullptr)
      ::close(fd);
    else
      ::dup2(::open(device, O_WRONLY), fd);
  };
  for (const char* device : {static_cast<const char*>(nullptr), "/dev/full"}) {
    const Outcome outcome = run({"run", "small.json", "--frames", "3", "--restart"}, [&] {
      on(STDOUT_FILENO, device);
      on(STDERR_FILENO, device);
    });
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(record()["outcome"], "done");
    EXPECT_EQ(slurp(folder_ / "out/small/scene.json").find("frame 2/"), std::string::npos);
  }
  const Outcome list = run({"list"}, [&] { on(STDOUT_FILENO, "/dev/full"); });
  EXPECT_EQ(list.code, 74);
  EXPECT_EQ(list.err, "wick: cannot print the answer (No space left on device)\n");
}

TEST_F(Command, ChangesParametersFromTheCommandLine) {
  ASSERT_EQ(run({"run", "small.json", "--set", "/output/frame_start=1001", "--set", "/output/frame_padding=5",
                 "--set", "/smoke=null", "--frames", "2", "--quiet"})
                .code,
            0);
  EXPECT_TRUE(fs::exists(folder_ / "out/small/meshes/paper.01002.ply"));
  EXPECT_FALSE(fs::exists(folder_ / "out/small/volumes"));
}

TEST_F(Command, RefusesAFolderThatCannotBeMade) {
  spit(folder_ / "file", "x");
  EXPECT_EQ(run({"run", "small.json", "--out", "file"}).code, 73);
  EXPECT_EQ(run({"run", "small.json", "--out", "file/below"}).code, 73);
  EXPECT_EQ(run({"run", "small.json", "--out", "/proc/none"}).code, 73);
  for (const char* name :
       {"run.json", "scene.json", "metrics.h5", "manifest.json", "run.lock", "volumes/smoke.0001.vdb"}) {
    const fs::path out = fs::path("taken") / fs::path(name).stem();
    fs::create_directories(folder_ / (out / name).string());
    const Outcome outcome = run({"run", "small.json", "--out", out.string(), "--quiet"});
    EXPECT_EQ(outcome.code, 73) << name;
    EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(Command, DamagedSceneFilesNeverCrashIt) {
  const std::string whole = small_scene;
  for (std::size_t n = 0; n < 40; ++n) {
    std::string damaged = n % 2 ? whole.substr(0, n * whole.size() / 40) : whole;
    if (n % 2 == 0) damaged[n * whole.size() / 40] = static_cast<char>(n * 37);
    spit(folder_ / "small.json", damaged);
    const int code = run({"check", "small.json", "--quiet"}).code;
    EXPECT_TRUE(code == 0 || code == 65 || code == 66 || code == 77) << code << "\n" << damaged;
  }
}

/// The estimate that refuses a scene: at least 0.9 and at most 1.5 of what the run then takes.
TEST_F(Command, EstimatesTheMemoryItNeeds) {
  if (sanitized) GTEST_SKIP() << "what a sanitized program resides in is no measure";
  const std::vector<std::string> box{"--set", "/smoke/resolution=[96,96,96]"};
  ASSERT_EQ(run({"run", "small.json", "--frames", "4", "--quiet", box[0], box[1]}).code, 0);
  const std::string text = run({"check", "small.json", box[0], box[1]}).out;
  const auto at = text.find("about ");
  ASSERT_NE(at, std::string::npos) << text;
  const double megabytes = std::stod(text.substr(at + 6));
  ASSERT_NE(text.find(" MB of", at), std::string::npos) << text;
  const double ratio = 1e6 * megabytes / record()["peak_rss_bytes"].get<double>();
  EXPECT_GE(ratio, 0.9);
  EXPECT_LE(ratio, 1.5);
}

TEST_F(Command, RefusesMoreMemoryThanItMayHave) {
  if (sanitized) GTEST_SKIP() << "a sanitized program needs all of the address space";
  const auto expect_named = [&](const std::string& change, const std::string& pointer) {
    const Outcome outcome = run({"run", "small.json", "--set", change}, [] {
      const rlimit limit{600 << 20, 600 << 20};
      ::setrlimit(RLIMIT_AS, &limit);
    });
    EXPECT_EQ(outcome.code, 77) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("wick: small.json: " + pointer + "needs about ")) << outcome.err;
  };
  expect_named("/smoke/resolution=[200,200,200]", "/smoke/resolution: ");
  expect_named("/shells/0/mesh/vertices=[1000,1000]", "/shells/0/mesh/vertices: ");
  expect_named(R"(/shells/0/mesh={"kind": "icosphere", "subdivisions": 8})", "/shells/0/mesh/subdivisions: ");
  expect_named(R"(/output/preview={"write": true, "size": [8000, 8000]})", "/output/preview/size: ");
  std::string many = "/shells=[";
  for (int n = 0; n < 100; ++n) many += std::string(n ? "," : "") + R"({"name": "s)" + std::to_string(n) + "\"}";
  expect_named(many + "]", "/shells: ");
}

/// Mounts a disk of `size` at disk/, seen by the program alone; ends the program with `skipped` where it may not.
constexpr int skipped = 97;
void mount_small_disk(const char* size) {
  const bool mounted = ::unshare(CLONE_NEWNS) == 0 &&
                       ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                       ::mount("tmpfs", "disk", "tmpfs", 0, size) == 0;
  if (!mounted) ::_exit(skipped);
}

/// On a disk of 1 MB a frame of 64^3 cells cannot be written, which is said before anything is.
TEST_F(Command, RefusesMoreDiskThanThereIs) {
  fs::create_directories(folder_ / "disk");
  const Outcome outcome = run({"run", "small.json", "--out", "disk/a", "--set", "/smoke/resolution=[64,64,64]"},
                              [] { mount_small_disk("size=1m"); });
  if (outcome.code == skipped) GTEST_SKIP() << "this user may not mount a small disk";
  EXPECT_EQ(outcome.code, 77) << outcome.err;
  EXPECT_NE(outcome.err.find("of disk for one frame"), std::string::npos) << outcome.err;
}

/// A hundred frames of 100 kB do not fit on 3 MB if the smoke fills the box; three do.
TEST_F(Command, WarnsOfARunThatMayFillTheDisk) {
  fs::create_directories(folder_ / "disk");
  for (const char* command : {"check", "run"}) {
    const Outcome tight =
        run({command, "small.json", "--out", "disk/a", "--frames", "100"}, [] { mount_small_disk("size=3m"); });
    if (tight.code == skipped) GTEST_SKIP() << "this user may not mount a small disk";
    const std::size_t warned = tight.err.find("wick: warning: the 100 frames of the run may take up to ");
    EXPECT_NE(warned, std::string::npos) << tight.err;
    EXPECT_TRUE(warned < tight.err.find("frame 2/100")) << "before it computes: " << tight.err;
    const Outcome enough =
        run({command, "small.json", "--out", "disk/a", "--frames", "3"}, [] { mount_small_disk("size=3m"); });
    EXPECT_EQ(enough.code, 0) << enough.err;
    EXPECT_EQ(enough.err.find("warning"), std::string::npos) << enough.err;
  }
}

/// The estimate that refuses is an upper bound of what is written, and no wild one: the checkpoint within 30 %, as
/// its 200 kB hold the metrics and the tables of HDF5 too.
TEST_F(Command, EstimatesTheDiskItNeeds) {
  const scenes::Scene scene = scenes::read_scene(folder_ / "small.json");
  coupling::World world(scene.world);
  const scenes::DiskEstimate estimate = scenes::estimate_disk(world, scene);
  ASSERT_EQ(run({"run", "small.json", "--quiet"}).code, 0);
  const auto size = [&](const std::string& file) { return fs::file_size(folder_ / "out/small" / file); };
  for (const char* frame : {"0001", "0006"})
    EXPECT_LE(
        size(std::string("volumes/smoke.") + frame + ".vdb") + size(std::string("meshes/paper.") + frame + ".ply"),
        estimate.frame);
  const auto checkpoint = static_cast<double>(size("checkpoints/0006.h5"));
  EXPECT_NEAR(static_cast<double>(estimate.checkpoint) / checkpoint, 1.0, 0.3);
}

}  // namespace

}  // namespace wick::test
