#include "scenes/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/require.h"
#include "scenes/sha256.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

/// A million files; what is larger was not written here.
constexpr std::uint64_t largest_manifest = 256 << 20;

/// A name that stays below the folder: the manifest is read from a disk that others may write.
bool is_inside(const fs::path& name) {
  return name.is_relative() && !name.empty() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

/// Why a file is not what its entry says; empty where it is.
std::string difference(const fs::path& path, const ManifestEntry& entry) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return fs::exists(path, error) ? "no file" : "missing";
  const std::uint64_t size = fs::file_size(path, error);
  if (error) return error.message();
  if (size != entry.bytes) return fmt::format("{} bytes instead of {}", size, entry.bytes);
  try {
    return sha256(read_file(path, size)) == entry.sha256 ? "" : "checksum differs";
  } catch (const Refusal&) {
    return "cannot be read";
  }
}

}  // namespace

Manifest Manifest::read(const fs::path& file) {
  const Bytes bytes = read_file(file, largest_manifest);
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!json.is_object() || !json.contains("files") || !json["files"].is_object())
    throw std::runtime_error("it is no list of files");
  Manifest manifest;
  for (const auto& [name, entry] : json["files"].items()) {
    const bool whole = entry.is_object() && entry.contains("frame") && entry["frame"].is_number_integer() &&
                       entry.contains("bytes") && entry["bytes"].is_number_unsigned() && entry.contains("sha256") &&
                       entry["sha256"].is_string();
    if (!whole || !is_inside(name)) throw std::runtime_error("one of its entries is damaged");
    manifest.entries_[name] = {entry["frame"], entry["bytes"], entry["sha256"]};
  }
  return manifest;
}

void Manifest::add(const fs::path& root, const fs::path& path, int frame, std::string_view bytes) {
  entries_[path.lexically_relative(root).generic_string()] = {frame, bytes.size(), sha256(bytes)};
}

void Manifest::keep_up_to(int frame) {
  std::erase_if(entries_, [&](const auto& entry) { return entry.second.frame > frame; });
}

Bytes Manifest::text() const {
  nlohmann::json files = nlohmann::json::object();
  for (const auto& [name, entry] : entries_)
    files[name] = {{"frame", entry.frame}, {"bytes", entry.bytes}, {"sha256", entry.sha256}};
  return nlohmann::json{{"files", std::move(files)}}.dump(1) + "\n";
}

std::vector<DamagedOutput> Manifest::damaged(const fs::path& root, FunctionRef<bool()> stop) const {
  std::vector<DamagedOutput> found;
  for (const auto& [name, entry] : entries_) {
    if (stop()) break;
    const std::string why = difference(root / name, entry);
    if (!why.empty()) found.push_back({name, entry.frame, why});
  }
  return found;
}

std::string summary_of(const std::vector<DamagedOutput>& damaged) {
  constexpr std::size_t shown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, damaged.size()); ++i)
    text += fmt::format("{}{} ({})", i ? ", " : "", damaged[i].file, damaged[i].why);
  if (damaged.size() > shown) text += fmt::format(" and {} more", damaged.size() - shown);
  return text;
}

}  // namespace wick::scenes
