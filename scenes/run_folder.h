#pragma once
/// The output folder of a run: its paths, and the lock that keeps a second run out.
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace wick::scenes {

/// Holds `run.lock` in the folder. The lock is the kernel's (flock) and dies with its process, however it
/// dies; the file's text, host and pid, is for people. Throws Refusal (output_cannot_be_made) while
/// another run holds it.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path path_;
  int fd_ = -1;
};

struct RunFolder {
  std::filesystem::path root;

  [[nodiscard]] std::filesystem::path scene() const { return root / "scene.json"; }
  [[nodiscard]] std::filesystem::path record() const { return root / "run.json"; }
  [[nodiscard]] std::filesystem::path metrics() const { return root / "metrics.h5"; }
  [[nodiscard]] std::filesystem::path manifest() const { return root / "manifest.json"; }
  [[nodiscard]] std::filesystem::path volumes() const { return root / "volumes"; }
  [[nodiscard]] std::filesystem::path meshes() const { return root / "meshes"; }
  [[nodiscard]] std::filesystem::path previews() const { return root / "previews"; }
  [[nodiscard]] std::filesystem::path motions() const { return root / "motion"; }
  [[nodiscard]] std::filesystem::path motion_frames() const { return motions() / "frames"; }
  [[nodiscard]] std::filesystem::path checkpoints() const { return root / "checkpoints"; }
  [[nodiscard]] std::filesystem::path volume(const OutputParams& output, int frame) const;
  [[nodiscard]] std::filesystem::path mesh(const OutputParams& output, const std::string& shell, int frame) const;
  [[nodiscard]] std::filesystem::path preview(const OutputParams& output, int frame) const;
  [[nodiscard]] std::filesystem::path motion(const std::string& shell) const { return motions() / (shell + ".h5"); }
  [[nodiscard]] std::filesystem::path motion_frame(const OutputParams& output, const std::string& shell,
                                                   int frame) const;

  /// Those that hold the files of single frames, and of recorded motion.
  [[nodiscard]] std::vector<std::filesystem::path> frame_folders() const;
  [[nodiscard]] std::filesystem::path reserve() const { return root / ".run.json.reserve"; }  ///< for the record

  /// Tells whether a run of this scene writes `name`, a path below the folder, for one of its frames.
  [[nodiscard]] bool writes(const Scene& of, const std::filesystem::path& name) const;
  /// The frames that the manifest lists; none where it cannot be read.
  [[nodiscard]] std::vector<std::filesystem::path> listed_frames() const;
  /// What is there of the names that a run of this scene writes for its frames.
  [[nodiscard]] std::vector<std::filesystem::path> frames_of(const Scene& of) const;

  /// The effective scene of the last run; empty where it cannot be read.
  [[nodiscard]] std::string recorded_scene() const;

  /// Throws Refusal (output_cannot_be_made) where a folder has the name of a file that every run writes.
  void require_free_names() const;
  /// Removes half-made files of a killed run.
  void tidy() const;
  /// Removes checkpoints and records of an earlier run, the frames that its manifest lists, and those that a run of
  /// `next` will replace (all that can be told where the manifest is damaged); other files stay.
  void clear(const Scene& next) const;
  /// Makes the folders that `scene` writes into.
  void make(const Scene& scene) const;
};

/// The number in the file name of simulation frame `frame` (1 is the initial state).
int file_number(const OutputParams& output, int frame);

}  // namespace wick::scenes
