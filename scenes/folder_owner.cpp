#include "scenes/folder_owner.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/require.h"
#include "scenes/atomic_file.h"
#include "scenes/checkpoint.h"
#include "scenes/effective_scene.h"
#include "scenes/manifest.h"
#include "scenes/sha256.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw Refusal(ExitCode::output_cannot_be_made, "", message);
}

/// Tells whether a run has been here: by its record, or by a checkpoint where the record is lost or damaged.
bool holds_run(const RunFolder& folder, const std::optional<RecordedRun>& record) {
  if (record) return true;
  const std::vector<int> frames = checkpoint_frames(folder.checkpoints());
  return std::any_of(frames.begin(), frames.end(),
                     [&](int frame) { return is_checkpoint(folder.checkpoints() / checkpoint_name(frame)); });
}

/// Tells whether scene.json is what a run wrote, or what this one is going to write.
bool is_effective_scene(const fs::path& file, const std::string& text, const std::optional<RecordedRun>& record) {
  constexpr std::uint64_t largest_scene = 16 << 20;
  try {
    const Bytes bytes = read_file(file, largest_scene);
    return bytes == text || (record && sha256(bytes) == record->scene_file_sha256);
  } catch (const Refusal&) {
    return false;
  }
}

/// The path of `file` below the folder, through links; empty where it lies elsewhere.
fs::path inside(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path name = fs::relative(file, folder, error);
  return error || name.empty() || *name.begin() == ".." ? fs::path() : name;
}

/// A scene must not read what its run replaces, or removes for a new beginning.
void require_inputs_stay(const RunFolder& folder, const Scene& scene) {
  const std::vector<fs::path> listed = folder.listed_frames();
  for (const auto& [path, pointer] : input_files(scene)) {
    const fs::path name = inside(path, folder.root);
    const bool replaced =
        !name.empty() &&
        (folder.writes(scene, name) || std::find(listed.begin(), listed.end(), folder.root / name) != listed.end());
    require(
        !replaced, pointer,
        fmt::format("{} is a file of the output folder (the run replaces it) choose another --out", path.string()),
        ExitCode::output_cannot_be_made);
  }
}

}  // namespace

void require_own_files(const RunFolder& folder, const FolderClaim& claim) {
  std::error_code error;
  if (fs::equivalent(folder.scene(), claim.scene_path, error))
    refuse("--out is the folder of the scene file, which the effective scene would replace; choose another");
  require_inputs_stay(folder, claim.scene);
  const std::optional<RecordedRun> record = read_run_record(folder.record());
  const auto require_written_by_run = [&](const fs::path& file, bool ours) {
    if (ours || !fs::exists(fs::symlink_status(file, error))) return;
    refuse(fmt::format("{} was not written by a run, which would replace it: move it away, or choose another --out",
                       file.string()));
  };
  const bool ours = holds_run(folder, record);
  for (const fs::path& file : {folder.record(), folder.metrics(), folder.manifest()})
    require_written_by_run(file, ours);
  for (const int frame : checkpoint_frames(folder.checkpoints()))
    require_written_by_run(folder.checkpoints() / checkpoint_name(frame), ours);
  require_written_by_run(folder.scene(), is_effective_scene(folder.scene(), claim.scene_text, record));
  if (ours) return;
  for (const fs::path& file : folder.frames_of(claim.scene)) require_written_by_run(file, false);
}

void require_no_other_run(const RunFolder& folder, const std::string& identity_sha256) {
  const std::optional<RecordedRun> record = read_run_record(folder.record());
  if (!record || record->scene_sha256 == identity_sha256) return;
  refuse(
      fmt::format("{} holds a run of {} (its run.json names another scene, or a changed one) choose another "
                  "--out, or --restart to replace it",
                  folder.root.string(), record->scene.empty() ? "another scene" : record->scene));
}

void require_same_run(const RunFolder& folder, const CheckpointHeader& header, const std::string& identity) {
  const std::string difference = identity_difference(header.identity, identity);
  if (!difference.empty())
    refuse(fmt::format("{} holds another run, of {} ({}) choose another --out, or --restart to replace it",
                       folder.root.string(), name_in_identity(header.identity), difference));
  if (header.version != version)
    refuse(
        fmt::format("{} was begun by wick {}, this is {} (the state may mean something else) choose another --out, "
                    "or --restart to replace it",
                    folder.root.string(), header.version, version));
}

}  // namespace wick::scenes
