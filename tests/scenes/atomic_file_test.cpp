#include "scenes/atomic_file.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>

#include <csignal>

#include "core/require.h"
#include "scenes/signals.h"
#include "tests/scenes/program.h"

namespace wick::scenes {

namespace {

using test::slurp;
using test::TemporaryFolder;

/// Runs `body` in a child process and returns its exit code.
int in_child(const std::function<int()>& body) {
  const pid_t pid = ::fork();
  if (pid == 0) ::_exit(body());
  int status = 0;
  ::waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// The exit code of the refusal that writing gives; 1 where its message lacks the file or the size.
int write_and_tell(const fs::path& path, std::size_t size) {
  try {
    write_file(path, std::string(size, 'x'));
    return 0;
  } catch (const Refusal& refusal) {
    const std::string message = refusal.what();
    const bool named = message.find(path.string()) != std::string::npos &&
                       message.find(std::to_string(size) + " bytes") != std::string::npos;
    return named ? static_cast<int>(refusal.code()) : 1;
  }
}

constexpr int input_output = static_cast<int>(ExitCode::input_output);
constexpr int cannot_be_made = static_cast<int>(ExitCode::output_cannot_be_made);

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  write_file(folder / "a", "first");
  EXPECT_EQ(slurp(folder / "a"), "first");
  write_file(folder / "a", "");
  EXPECT_EQ(slurp(folder / "a"), "");
  const std::string large(300000, 'y');
  write_file(folder / "a", large);
  EXPECT_EQ(slurp(folder / "a"), large);
  EXPECT_EQ(test::files_below(folder.path()), std::vector<std::string>{"a"});
}

TEST(AtomicFile, KeepsTheOldFileAtAFileSizeLimit) {
  const TemporaryFolder folder;
  write_file(folder / "a", "before");
  const int code = in_child([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{10000, 10000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    return write_and_tell(folder / "a", 100000);
  });
  EXPECT_EQ(code, input_output);
  EXPECT_EQ(slurp(folder / "a"), "before");
  EXPECT_EQ(test::files_below(folder.path()), std::vector<std::string>{"a"});
}

TEST(AtomicFile, RefusesAFolderThatItMayNotWrite) {
  const TemporaryFolder folder;
  write_file(folder / "a", "before");
  fs::permissions(folder.path(), fs::perms(0555));
  const int code = in_child([&] {
    if (::getuid() == 0 && ::setuid(65534) != 0) return cannot_be_made;  // root may write anywhere
    return write_and_tell(folder / "a", 10);
  });
  fs::permissions(folder.path(), fs::perms(0755));
  EXPECT_EQ(code, cannot_be_made);
  EXPECT_EQ(slurp(folder / "a"), "before");
}

TEST(AtomicFile, KeepsTheOldFileOnAFullDisk) {
  const TemporaryFolder folder;
  constexpr int skipped = 200;
  const int code = in_child([&] {
    const bool mounted = ::unshare(CLONE_NEWNS) == 0 &&
                         ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                         ::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=1m") == 0;
    if (!mounted) return skipped;
    write_file(folder / "a", "before");
    const int result = write_and_tell(folder / "a", 2 << 20);
    const bool kept = slurp(folder / "a") == "before" && test::files_below(folder.path()).size() == 1;
    return kept ? result : 2;
  });
  if (code == skipped) GTEST_SKIP() << "a small file system cannot be mounted here";
  EXPECT_EQ(code, input_output);
}

TEST(AtomicFile, RefusesAFileThatIsNotThereOrTooLarge) {
  const TemporaryFolder folder;
  const auto code = [](const std::function<void()>& body) {
    try {
      body();
    } catch (const Refusal& refusal) {
      return refusal.code();
    }
    return ExitCode::done;
  };
  EXPECT_EQ(code([&] { read_file(folder / "none", 10); }), ExitCode::input_missing);
  EXPECT_EQ(code([&] { read_file(folder.path(), 10); }), ExitCode::input_missing);
  EXPECT_EQ(code([&] { read_file("/dev/zero", 1000); }), ExitCode::input_missing);
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(code([&] { read_file(folder / "pipe", 1000); }), ExitCode::input_missing) << "and does not wait for it";
  write_file(folder / "a", "12345");
  EXPECT_EQ(code([&] { read_file(folder / "a", 4); }), ExitCode::scene_invalid);
  EXPECT_EQ(read_file(folder / "a", 5), "12345");
  EXPECT_EQ(code([&] { make_folder(folder / "a"); }), ExitCode::output_cannot_be_made);
  EXPECT_EQ(code([&] { make_folder(folder / "a" / "b"); }), ExitCode::output_cannot_be_made);
}

TEST(AtomicFile, RemovesWhatAKilledRunLeft) {
  const TemporaryFolder folder;
  test::spit(temporary_path(folder / "a"), "half");
  test::spit(folder / "mine.tmp", "kept");
  test::spit(folder / ".b.tmp", "kept");
  remove_temporaries(folder.path(), [](const std::string& name) { return name == "a"; });
  std::vector<std::string> left = test::files_below(folder.path());
  std::sort(left.begin(), left.end());
  EXPECT_EQ(left, (std::vector<std::string>{".b.tmp", "mine.tmp"}));
}

TEST(AtomicFile, WritesFromAReserve) {
  const TemporaryFolder folder;
  write_file(folder / "a", "before");
  ASSERT_TRUE(make_reserve(folder / "reserve", 100));
  EXPECT_EQ(fs::file_size(folder / "reserve"), 100U);
  write_file_from(folder / "reserve", folder / "a", "after");
  EXPECT_EQ(test::slurp(folder / "a"), "after");
  EXPECT_EQ(test::files_below(folder.path()), std::vector<std::string>{"a"}) << "the reserve has become the file";
  write_file_from(folder / "reserve", folder / "a", "without one");
  EXPECT_EQ(test::slurp(folder / "a"), "without one");
}

}  // namespace

}  // namespace wick::scenes
