#pragma once
/// manifest.json: size and SHA-256 of every file that belongs to one frame (volumes, meshes, previews), so that a
/// resumed run, or whoever has copied the folder, can tell whether they are still what was written.
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/function_ref.h"
#include "scenes/atomic_file.h"

namespace wick::scenes {

struct ManifestEntry {
  int frame = 0;
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct DamagedOutput {
  std::string file;  ///< below the output folder
  int frame = 0;
  std::string why;
};

class Manifest {
 public:
  /// Reads what `file` lists. Throws Refusal or std::runtime_error where it is missing or no manifest.
  static Manifest read(const std::filesystem::path& file);

  /// Notes the content of `path`, a file of `frame` somewhere below `root`.
  void add(const std::filesystem::path& root, const std::filesystem::path& path, int frame, std::string_view bytes);
  /// Forgets the frames after `frame`: they will be made anew.
  void keep_up_to(int frame);
  [[nodiscard]] Bytes text() const;
  [[nodiscard]] const std::map<std::string, ManifestEntry>& entries() const { return entries_; }

  /// Compares every listed file below `root` with its entry, in the order of names; ends early where `stop` says
  /// so.
  [[nodiscard]] std::vector<DamagedOutput> damaged(const std::filesystem::path& root,
                                                   FunctionRef<bool()> stop) const;

 private:
  std::map<std::string, ManifestEntry> entries_;
};

/// "meshes/a.0003.ply (missing), ... and 7 more": one line however many there are.
std::string summary_of(const std::vector<DamagedOutput>& damaged);

}  // namespace wick::scenes
