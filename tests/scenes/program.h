#pragma once
/// Runs the program as a user or a farm would, and small folders to run it in.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

namespace wick {
namespace fs = std::filesystem;
}

namespace wick::test {

/// A folder that is gone after the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "wick-test-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] fs::path operator/(const std::string& name) const { return path_ / name; }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void spit(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// A process; its output goes to files in its folder.
class Program {
 public:
  Program(const TemporaryFolder& folder, std::vector<std::string> arguments,
          const std::function<void()>& prepare = {}, const fs::path& program = WICK_PROGRAM)
      : out_(folder / "stdout.txt"), err_(folder / "stderr.txt") {
    arguments.insert(arguments.begin(), program.string());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ != 0) return;
    for (const auto& [path, fd] : {std::pair{out_, STDOUT_FILENO}, std::pair{err_, STDERR_FILENO}})
      ::dup2(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), fd);
    if (::chdir(folder.path().c_str()) != 0) ::_exit(99);
    if (prepare) prepare();
    ::execv(argv[0], argv.data());
    ::_exit(98);
  }
  void signal(int number) const { ::kill(pid_, number); }
  /// Exit code, or 128 + signal.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  [[nodiscard]] std::string out() const { return slurp(out_); }
  [[nodiscard]] std::string err() const { return slurp(err_); }

 private:
  fs::path out_, err_;
  pid_t pid_ = -1;
};

/// A burning sheet in a little smoke: every part of the world, a few milliseconds a frame.
inline const char* const small_scene = R"({
  "name": "small", "frames": 6,
  "shells": [{"name": "paper", "mesh": {"vertices": [9, 9], "size": [0.5, 0.5], "position": [0.25, 0.25, 0.3]}}],
  "smoke": {"resolution": [16, 16, 16]},
  "diffusion": {}, "burning": {},
  "heat_sources": [{"center": [0.3, 0.3, 0.3], "radius": 0.1}],
  "output": {"checkpoint": {"every": 2}}
})";

/// Every file that a reader could see, by path; names of temporary files included.
inline std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), folder).string());
  return files;
}

}  // namespace wick::test
