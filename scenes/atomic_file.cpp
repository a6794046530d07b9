#include "scenes/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/require.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

/// An open file; closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool valid() const { return fd_ >= 0; }
  /// Closes now and tells whether the system had an error to report.
  bool close() {
    const int result = ::close(fd_);
    fd_ = -1;
    return result == 0;
  }

 private:
  int fd_;
};

int open_file(const fs::path& path, int flags) {
  int fd = -1;
  do fd = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  while (fd < 0 && errno == EINTR);
  return fd;
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      if (written == 0) errno = ENOSPC;  // a write of nothing without an error: there is no room
      return false;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

/// Compares what the file now holds with what it should hold.
bool holds(int fd, std::string_view bytes) {
  std::array<char, 1 << 16> buffer;
  std::size_t offset = 0;
  for (;;) {
    const ssize_t got = ::pread(fd, buffer.data(), buffer.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    const auto size = static_cast<std::size_t>(got);
    if (size > bytes.size() - offset || std::memcmp(buffer.data(), bytes.data() + offset, size) != 0) {
      errno = EIO;
      return false;
    }
    offset += size;
  }
  if (offset != bytes.size()) errno = EIO;
  return offset == bytes.size();
}

bool sync(int fd) {
  int result = -1;
  do result = ::fsync(fd);
  while (result != 0 && errno == EINTR);
  return result == 0;
}

/// Forces the new name itself to the disk. Some file systems cannot sync a folder (EINVAL): their rename is
/// all that there is.
bool sync_folder(const fs::path& folder) {
  const Descriptor fd(open_file(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY));
  return fd.valid() && (sync(fd.get()) || errno == EINVAL || errno == EROFS);
}

/// Writes over what the file holds, cuts off the rest, forces and verifies it; false with errno set where a step
/// fails.
bool write_temporary(const fs::path& path, std::string_view bytes) {
  Descriptor fd(open_file(path, O_RDWR | O_CREAT | O_NOFOLLOW));
  return fd.valid() && write_all(fd.get(), bytes) && ::ftruncate(fd.get(), static_cast<off_t>(bytes.size())) == 0 &&
         sync(fd.get()) && holds(fd.get(), bytes) && fd.close();
}

bool write_and_rename(const fs::path& temporary, const fs::path& path, std::string_view bytes) {
  return write_temporary(temporary, bytes) && ::rename(temporary.c_str(), path.c_str()) == 0 &&
         sync_folder(path.parent_path());
}

}  // namespace

fs::path temporary_path(const fs::path& path) {
  return path.parent_path() / fmt::format(".{}.tmp", path.filename().string());
}

void write_file(const fs::path& path, std::string_view bytes) {
  const fs::path temporary = temporary_path(path);
  ::unlink(temporary.c_str());
  if (write_and_rename(temporary, path, bytes)) return;
  const int error = errno;
  ::unlink(temporary.c_str());
  const bool forbidden = error == EISDIR || error == EACCES || error == EPERM || error == EROFS;
  throw Refusal(forbidden ? ExitCode::output_cannot_be_made : ExitCode::input_output, "",
                fmt::format("cannot write {} of {} bytes ({}) free some space or choose another --out",
                            path.string(), bytes.size(), std::strerror(error)));
}

bool make_reserve(const fs::path& reserve, std::size_t bytes) {
  // Zeros could be stored as a hole, which has no space.
  if (write_temporary(reserve, std::string(bytes, '.'))) return true;
  ::unlink(reserve.c_str());
  return false;
}

void write_file_from(const fs::path& reserve, const fs::path& path, std::string_view bytes) {
  std::error_code error;
  if (fs::is_regular_file(reserve, error) && write_and_rename(reserve, path, bytes)) return;
  ::unlink(reserve.c_str());
  write_file(path, bytes);
}

Bytes read_file(const fs::path& path, std::uint64_t limit) {
  const auto missing = [&](int error) {
    return Refusal(ExitCode::input_missing, "",
                   fmt::format("cannot read {} ({})", path.string(), std::strerror(error)));
  };
  // Not blocking: opening a pipe that nobody writes to would wait for ever.
  const Descriptor fd(open_file(path, O_RDONLY | O_NONBLOCK));
  if (!fd.valid()) throw missing(errno);
  struct stat kind {};
  if (::fstat(fd.get(), &kind) != 0) throw missing(errno);
  if (S_ISDIR(kind.st_mode)) throw missing(EISDIR);
  require(S_ISREG(kind.st_mode), "",
          fmt::format("cannot read {} (it is no file but a device or pipe)", path.string()),
          ExitCode::input_missing);
  const auto require_size = [&](std::uint64_t size) {
    require(size <= limit, "",
            fmt::format("{} is larger than {} bytes (no valid file of this kind is)", path.string(), limit));
  };
  require_size(static_cast<std::uint64_t>(kind.st_size));
  Bytes bytes;
  std::array<char, 1 << 16> buffer;
  for (;;) {
    const ssize_t got = ::read(fd.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw missing(errno);
    if (got == 0) return bytes;
    bytes.append(buffer.data(), static_cast<std::size_t>(got));
    require_size(bytes.size());
  }
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && fs::is_directory(folder, error)) {
    if (::access(folder.c_str(), W_OK | X_OK) == 0) return;
    error = {errno, std::generic_category()};
  }
  throw Refusal(ExitCode::output_cannot_be_made, "",
                fmt::format("cannot make the folder {} ({}) choose another --out", folder.string(),
                            error ? error.message() : "something else has that name"));
}

void remove_temporaries(const fs::path& folder, FunctionRef<bool(const std::string& name)> ours) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.starts_with('.') && name.ends_with(".tmp") && ours(name.substr(1, name.size() - 5))) {
      std::error_code ignored;
      fs::remove(it->path(), ignored);
    }
  }
}

}  // namespace wick::scenes
