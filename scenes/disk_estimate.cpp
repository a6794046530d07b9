#include "scenes/disk_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/require.h"
#include "scenes/machine.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

/// Adds up what a checkpoint stores.
class StateSize final : public StateVisitor {
 public:
  void raw(std::string_view, ScalarType type, std::size_t rows, std::size_t columns, const void*,
           FunctionRef<void*(std::size_t)>) override {
    // 600 bytes: header and table entry of one HDF5 dataset.
    bytes_ += rows * columns * scalar_size(type) + 600;
  }
  void strings(std::string_view, std::vector<std::string>& values) override {
    for (const std::string& value : values) bytes_ += value.size() + 16;
  }
  void begin_group(std::string_view) override { bytes_ += 1500; }
  void end_group() override {}
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_ = 4096;
};

std::uint64_t volume_bytes(const Scene& scene) {
  if (!scene.world.smoke || !scene.output.volume.write) return 0;
  const Int3& n = scene.world.smoke->resolution;
  const std::uint64_t values = 6ULL * n[0] * n[1] * n[2];  // three scalars and one vector a cell
  const std::uint64_t bytes = values * (scene.output.volume.precision == Precision::half ? 2 : 4);
  return bytes + bytes / 10 + 20000;  // masks of the leaves and the tree above them
}

std::uint64_t mesh_bytes(const coupling::World& world, const Scene& scene) {
  if (!scene.output.mesh.write) return 0;
  std::uint64_t bytes = 0;
  for (std::size_t n = 0; n < world.shells().size(); ++n) {
    const coupling::ShellView view = world.shells()[n];
    // At worst every triangle of a sheet that tears ends with corners of its own.
    const bool tears = scene.world.shells[n].tearing.has_value();
    const std::size_t vertices = tears ? 3 * view.mesh->triangle_count() : view.x->size();
    bytes += 1000 + vertices * (48 + 4 * view.values.size()) + 13 * view.mesh->triangle_count();
  }
  if (coupling::sheds_embers(scene.world)) bytes += 1000 + 40 * world.embers().x->size();
  return bytes;
}

/// Of one frame of the motion of all sheets: positions in double precision.
std::uint64_t motion_bytes(const coupling::World& world, const Scene& scene) {
  if (!scene.output.motion.write) return 0;
  std::uint64_t bytes = 0;
  for (const coupling::ShellView& view : world.shells()) bytes += 24 * view.x->size();
  return bytes;
}

/// Of the files around it: header and table of an HDF5 file of three datasets, rest shape and triangles of the
/// last.
constexpr std::uint64_t motion_frame_header = 4096;
std::uint64_t motion_header_bytes(const coupling::World& world, const Scene& scene) {
  if (!scene.output.motion.write) return 0;
  std::uint64_t bytes = 0;
  for (const coupling::ShellView& view : world.shells())
    bytes += 3 * motion_frame_header + 24 * view.x->size() + 12 * view.original->triangle_count();
  return bytes;
}

std::uint64_t preview_bytes(const Scene& scene) {
  const Int2& size = scene.output.preview.size;
  return scene.output.preview.write ? 4ULL * size[0] * size[1] : 0;
}

}  // namespace

DiskEstimate estimate_disk(coupling::World& world, const Scene& scene) {
  StateSize state;
  world.visit(state);
  DiskEstimate estimate;
  estimate.checkpoint = state.bytes();
  const std::uint64_t motion = motion_bytes(world, scene);
  const std::uint64_t motion_files = motion > 0 ? world.shells().size() * motion_frame_header : 0;
  estimate.frame = volume_bytes(scene) + mesh_bytes(world, scene) + preview_bytes(scene) + motion + motion_files;
  const auto frames = static_cast<std::uint64_t>(scene.frames);
  const auto kept = static_cast<std::uint64_t>(scene.output.checkpoint.keep) + 1;
  // Motion is on the disk twice: frame by frame, and joined at the end.
  estimate.joined = motion;
  estimate.all =
      frames * (estimate.frame + motion) + kept * estimate.checkpoint + motion_header_bytes(world, scene);
  return estimate;
}

std::uint64_t free_disk(const fs::path& folder) {
  std::error_code error;
  fs::path at = fs::absolute(folder, error);
  while (!fs::exists(at, error) && at.has_relative_path()) at = at.parent_path();
  const fs::space_info space = fs::space(at, error);
  // File systems without a size (as /proc) are no disks: writing there fails by itself, for a better reason.
  return error || space.capacity == 0 ? std::numeric_limits<std::uint64_t>::max() : space.available;
}

std::string disk_shortage(const DiskEstimate& estimate, const Scene& scene, int done, const fs::path& folder) {
  const auto left = static_cast<std::uint64_t>(std::max(scene.frames - done, 0));
  // A run that goes on replaces its checkpoints one by one.
  const std::uint64_t needed =
      done == 0 ? estimate.all : left * (estimate.frame + estimate.joined) + estimate.checkpoint;
  const std::uint64_t there = free_disk(folder);
  if (needed <= there) return "";
  return fmt::format(
      "the {} frames {} may take up to {} of disk ({} are free at {}): a run that fills the disk stops with its "
      "last "
      "checkpoint kept, and goes on once there is room; fewer /frames or less /output takes less",
      left, done == 0 ? "of the run" : "to come", bytes_text(needed), bytes_text(there), folder.string());
}

void require_disk(const DiskEstimate& estimate, const fs::path& folder) {
  const std::uint64_t needed = estimate.frame + estimate.checkpoint, there = free_disk(folder);
  require(
      needed <= there, "",
      fmt::format("needs up to {} of disk for one frame and its checkpoint ({} are free at {}) free some space, "
                  "lower the resolution or choose another --out",
                  bytes_text(needed), bytes_text(there), folder.string()),
      ExitCode::refused);
}

}  // namespace wick::scenes
