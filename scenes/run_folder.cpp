#include "scenes/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>

#include "core/require.h"
#include "scenes/atomic_file.h"
#include "scenes/checkpoint.h"
#include "scenes/machine.h"
#include "scenes/manifest.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

/// Tells whether `fd` is still the file of that name: another run may have removed it between open and lock.
bool is_current(int fd, const fs::path& path) {
  struct stat held {
  }, named{};
  return ::fstat(fd, &held) == 0 && ::stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

constexpr const char* nobody = "another process";

/// What the lock file tells of who holds it.
std::string holder(int fd) {
  std::array<char, 400> text{};
  const ssize_t got = ::pread(fd, text.data(), text.size() - 1, 0);
  std::string line(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }),
             line.end());
  return line.empty() ? nobody : line;
}

std::string numbered(const std::string& name, const OutputParams& output, int frame, const char* extension) {
  return fmt::format("{}.{:0{}d}.{}", name, file_number(output, frame), output.frame_padding, extension);
}

/// The number in <name>.<digits>.<extension> and <digits>.<extension>; -1 where there is none.
int number_in(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::string_view digits = std::string_view(stem).substr(stem.rfind('.') + 1);  // all of it without a dot
  int number = -1;
  const auto [last, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc{} && last == digits.data() + digits.size() ? number : -1;
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  require(!error, "", fmt::format("cannot remove {} ({})", path.string(), error.message()),
          ExitCode::output_cannot_be_made);
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : path_(folder / "run.lock") {
  for (;;) {
    fd_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    require(fd_ >= 0, "",
            fmt::format("cannot make {} ({}) choose another --out", path_.string(), std::strerror(errno)),
            ExitCode::output_cannot_be_made);
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
      const std::string who = holder(fd_);
      ::close(fd_);
      throw Refusal(ExitCode::output_cannot_be_made, "",
                    fmt::format("{} is in use by {} (two runs would overwrite each other) wait for it or choose "
                                "another --out",
                                folder.string(), who));
    }
    if (is_current(fd_, path_)) break;
    ::close(fd_);
  }
  const std::string before = holder(fd_);
  if (before != nobody && !before.starts_with("host ")) {
    ::close(fd_);
    throw Refusal(
        ExitCode::output_cannot_be_made, "",
        fmt::format("{} is no lock of a run (it would be replaced) choose another --out", path_.string()));
  }
  const std::string text = fmt::format("host {} pid {}\n", host_name(), ::getpid());
  // The text only informs: where it cannot be written the lock holds all the same.
  if (::ftruncate(fd_, 0) != 0 || ::pwrite(fd_, text.data(), text.size(), 0) < 0) return;
}

FolderLock::~FolderLock() {
  ::unlink(path_.c_str());
  ::close(fd_);
}

int file_number(const OutputParams& output, int frame) {
  return frame - 1 + output.frame_start;
}

fs::path RunFolder::volume(const OutputParams& output, int frame) const {
  return volumes() / numbered("smoke", output, frame, "vdb");
}

fs::path RunFolder::mesh(const OutputParams& output, const std::string& shell, int frame) const {
  return meshes() / numbered(shell, output, frame, "ply");
}

fs::path RunFolder::preview(const OutputParams& output, int frame) const {
  return previews() / fmt::format("{:0{}d}.png", file_number(output, frame), output.frame_padding);
}

fs::path RunFolder::motion_frame(const OutputParams& output, const std::string& shell, int frame) const {
  return motion_frames() / numbered(shell, output, frame, "h5");
}

void RunFolder::require_free_names() const {
  std::error_code error;
  for (const fs::path& file : {record(), metrics(), scene(), manifest()})
    require(!fs::is_directory(file, error), "",
            fmt::format("{} is a folder (the run writes a file of that name) choose another --out", file.string()),
            ExitCode::output_cannot_be_made);
}

std::string RunFolder::recorded_scene() const {
  constexpr std::uint64_t largest_scene = 16 << 20;
  try {
    return read_file(scene(), largest_scene);
  } catch (const Refusal&) {
    return "";
  }
}

std::vector<fs::path> RunFolder::frame_folders() const {
  return {volumes(), meshes(), previews(), motions(), motion_frames()};
}

std::vector<fs::path> RunFolder::listed_frames() const {
  std::vector<fs::path> listed;
  try {
    // A list that was tampered with must not reach beyond the folders of frames.
    const std::vector<fs::path> folders = frame_folders();
    const Manifest list = Manifest::read(manifest());
    for (const auto& [name, entry] : list.entries())
      if (std::find(folders.begin(), folders.end(), (root / name).parent_path()) != folders.end())
        listed.push_back(root / name);
  } catch (const std::runtime_error&) {  // Refusal is one
    listed.clear();
  }
  return listed;
}

bool RunFolder::writes(const Scene& of, const fs::path& name) const {
  const OutputParams& output = of.output;
  const fs::path path = root / name;
  const int frame = number_in(path) - output.frame_start + 1;
  const bool counted = frame >= 1 && frame <= of.frames;
  if (counted && of.world.smoke && output.volume.write && path == volume(output, frame)) return true;
  if (counted && output.preview.write && path == preview(output, frame)) return true;
  if (counted && output.mesh.write && coupling::sheds_embers(of.world) &&
      path == mesh(output, coupling::embers_name, frame))
    return true;
  for (const coupling::ShellSection& shell : of.world.shells) {
    if (counted && output.mesh.write && path == mesh(output, shell.name, frame)) return true;
    if (!output.motion.write) continue;
    if (path == motion(shell.name) || (counted && path == motion_frame(output, shell.name, frame))) return true;
  }
  return false;
}

std::vector<fs::path> RunFolder::frames_of(const Scene& of) const {
  std::vector<fs::path> found;
  for (const fs::path& folder : frame_folders()) {
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (writes(of, it->path().lexically_relative(root))) found.push_back(it->path());
  }
  return found;
}

void RunFolder::tidy() const {
  remove_temporaries(root, [](const std::string& name) {
    return name == "run.json" || name == "scene.json" || name == "metrics.h5" || name == "manifest.json";
  });
  for (const fs::path& folder : frame_folders())
    remove_temporaries(folder, [&](const std::string& name) {
      return number_in(name) >= 0 || (folder == motions() && name.ends_with(".h5"));
    });
  remove_temporaries(checkpoints(), [](const std::string& name) { return number_in(name) >= 0; });
  std::error_code ignored;
  fs::remove(reserve(), ignored);
}

void RunFolder::clear(const Scene& next) const {
  // Checkpoints first: a run killed in between must not go on from one of them. The record last: as long as it is
  // there the next run knows whose the rest is.
  for (const int frame : checkpoint_frames(checkpoints())) remove_file(checkpoints() / checkpoint_name(frame));
  for (const fs::path& file : listed_frames()) remove_file(file);
  for (const fs::path& file : frames_of(next)) remove_file(file);
  for (const fs::path& file : {metrics(), manifest(), scene(), record()}) remove_file(file);
}

void RunFolder::make(const Scene& scene) const {
  make_folder(checkpoints());
  if (scene.world.smoke && scene.output.volume.write) make_folder(volumes());
  if (!scene.world.shells.empty() && scene.output.mesh.write) make_folder(meshes());
  if (scene.output.preview.write) make_folder(previews());
  if (!scene.world.shells.empty() && scene.output.motion.write) make_folder(motion_frames());
}

}  // namespace wick::scenes
