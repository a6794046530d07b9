/// The launcher, in a tree where everything is built: what it calls is played by small scripts.
#include <gtest/gtest.h>

#include "tests/scenes/program.h"

namespace wick::test {

namespace {

class Launcher : public testing::Test {
 protected:
  Launcher() {
    fs::create_directories(folder_ / "tools");
    fs::create_directories(folder_ / "build/release");
    fs::create_directories(folder_ / "build/bench/tests/bench");
    fs::copy_file(fs::path(WICK_SOURCE) / "wick", folder_ / "wick");
    for (const char* preset : {"release", "bench"}) spit(folder_ / "build" / preset / "build.ninja", "");
    script("tools/ninja", "echo 'ninja: no work to do.'");
    script("tools/dpkg-query", "shift 2; for package; do echo installed; done");
    script("tools/ctest", "case \"$*\" in *none*) echo 'Total Tests: 0';; *) echo \"ctest $*\";; esac");
    script("build/release/wick",
           "[ $# -gt 0 ] || { echo 'wick: a command is missing' >&2; exit 64; }; echo \"Usage $*\"");
    script("build/bench/tests/bench/bench_a",
           "case \"$*\" in *none*) ;; *list*) echo a_case;; *) echo \"measured $*\";; esac");
  }
  void script(const std::string& name, const std::string& text) const {
    spit(folder_ / name, "#!/bin/sh\n" + text + "\n");
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  int launch(const std::vector<std::string>& arguments) {
    const std::string path = (folder_ / "tools").string() + ":" + std::getenv("PATH");
    Program program(
        folder_, arguments, [&] { ::setenv("PATH", path.c_str(), 1); }, folder_ / "wick");
    const int code = program.wait();
    out_ = program.out();
    err_ = program.err();
    return code;
  }
  TemporaryFolder folder_;
  std::string out_, err_;
};

TEST_F(Launcher, ShowsItsOwnUsageBesideTheProgram) {
  EXPECT_EQ(launch({}), 64);
  EXPECT_TRUE(err_.starts_with("wick: a command is missing")) << err_;
  EXPECT_NE(err_.find("wick bench [--filter REGEX]"), std::string::npos) << err_;
  EXPECT_EQ(launch({"--help"}), 0);
  EXPECT_TRUE(out_.starts_with("Usage --help")) << out_;
  EXPECT_NE(out_.find("wick test [--long]"), std::string::npos) << out_;
}

TEST_F(Launcher, SaysThatNothingMatches) {
  EXPECT_EQ(launch({"bench", "--filter", "none"}), 64);
  EXPECT_TRUE(err_.starts_with("wick: no benchmark matches none ")) << err_;
  EXPECT_EQ(launch({"bench", "--filter", "a_"}), 0) << err_;
  EXPECT_EQ(out_, "measured --benchmark_filter=a_\n");
  EXPECT_EQ(launch({"test", "--filter", "none"}), 64);
  EXPECT_TRUE(err_.starts_with("wick: no test matches none ")) << err_;
  EXPECT_EQ(launch({"test", "--filter", "some"}), 0) << err_;
  EXPECT_NE(out_.find("-R some --output-on-failure"), std::string::npos) << out_;
}

}  // namespace

}  // namespace wick::test
