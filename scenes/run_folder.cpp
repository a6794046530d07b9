#include "scenes/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/require.h"
#include "scenes/atomic_file.h"
#include "scenes/checkpoint.h"
#include "scenes/machine.h"

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

std::string holder(int fd) {
  std::array<char, 400> text{};
  const ssize_t got = ::pread(fd, text.data(), text.size() - 1, 0);
  std::string line(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }),
             line.end());
  return line.empty() ? "another process" : line;
}

std::string numbered(const std::string& name, const OutputParams& output, int frame, const char* extension) {
  return fmt::format("{}.{:0{}d}.{}", name, file_number(output, frame), output.frame_padding, extension);
}

/// Matches <name>.<digits>.<extension> and <digits>.<extension>.
bool is_frame_file(const fs::path& path, const std::string& extension) {
  if (path.extension() != extension) return false;
  const std::string stem = path.stem().string();
  const std::string number = stem.substr(stem.rfind('.') + 1);  // all of the stem where it has no dot
  return !number.empty() && std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  require(!error, "", fmt::format("cannot remove {} ({})", path.string(), error.message()),
          ExitCode::output_cannot_be_made);
}

void remove_frames(const fs::path& folder, const std::string& extension) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_frame_file(it->path(), extension)) remove_file(it->path());
}

/// Motion files carry no frame number, and the names of an earlier run's shells are not known.
void remove_all_of(const fs::path& folder, const std::string& extension) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == extension && it->is_regular_file(error)) remove_file(it->path());
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

void RunFolder::tidy() const {
  for (const fs::path& folder : {root, volumes(), meshes(), previews(), motions(), motion_frames(), checkpoints()})
    remove_temporaries(folder);
}

void RunFolder::clear() const {
  // Checkpoints first: a run killed in between must not go on from one of them.
  for (const int frame : checkpoint_frames(checkpoints())) remove_file(checkpoints() / checkpoint_name(frame));
  for (const fs::path& file : {record(), metrics(), scene(), manifest()}) remove_file(file);
  remove_frames(volumes(), ".vdb");
  remove_frames(meshes(), ".ply");
  remove_frames(previews(), ".png");
  remove_frames(motion_frames(), ".h5");
  remove_all_of(motions(), ".h5");
}

void RunFolder::make(const Scene& scene) const {
  make_folder(checkpoints());
  if (scene.world.smoke && scene.output.volume.write) make_folder(volumes());
  if (!scene.world.shells.empty() && scene.output.mesh.write) make_folder(meshes());
  if (scene.output.preview.write) make_folder(previews());
  if (!scene.world.shells.empty() && scene.output.motion.write) make_folder(motion_frames());
}

}  // namespace wick::scenes
