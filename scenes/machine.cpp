#include "scenes/machine.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace wick::scenes {

namespace {

constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

/// The value behind `key` of /proc/meminfo or /proc/self/status, in bytes.
std::uint64_t field_of(const char* file, const std::string& key, std::uint64_t otherwise) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key + ":")) continue;
    std::istringstream rest(line.substr(key.size() + 1));
    std::uint64_t kilobytes = 0;
    if (rest >> kilobytes) return kilobytes * 1024;
  }
  return otherwise;
}

std::uint64_t number_in(const std::string& file, std::uint64_t otherwise) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  return in >> value ? value : otherwise;
}

/// What the control groups of this process, each inside its parent, still allow.
std::uint64_t control_group_room() {
  std::ifstream in("/proc/self/cgroup");
  std::uint64_t room = no_limit;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("0::")) continue;
    for (std::filesystem::path group = line.substr(3); !group.empty(); group = group.parent_path()) {
      const std::string folder = "/sys/fs/cgroup" + group.string();
      const std::uint64_t limit = number_in(folder + "/memory.max", no_limit);  // "max" is no number: no limit
      const std::uint64_t used = number_in(folder + "/memory.current", 0);
      if (limit != no_limit) room = std::min(room, limit - std::min(limit, used));
      if (group == group.parent_path()) break;
    }
  }
  return room;
}

std::uint64_t address_room() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return no_limit;
  const std::uint64_t used = field_of("/proc/self/status", "VmSize", 0);
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
}

}  // namespace

std::uint64_t available_memory() {
  return std::min({field_of("/proc/meminfo", "MemAvailable", no_limit), control_group_room(), address_room()});
}

std::uint64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path().string();
}

std::string bytes_text(std::uint64_t bytes) {
  const char* const units[] = {"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
  auto value = static_cast<double>(bytes);
  int unit = 0;
  for (; value >= 999.5 && unit < 6; value /= 1000.0) ++unit;
  return fmt::format("{:.{}f} {}", value, value < 9.95 && unit > 0 ? 1 : 0, units[unit]);
}

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const auto total = static_cast<long long>(std::llround(std::min(seconds, 1e12)));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {} s", total / 60, total % 60);
  return fmt::format("{} h {} min", total / 3600, total % 3600 / 60);
}

}  // namespace wick::scenes
