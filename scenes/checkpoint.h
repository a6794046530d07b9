#pragma once
/// Checkpoints: the whole state of a run as an HDF5 file with a checksum of our own behind it. The checksum is
/// verified before the HDF5 library sees a byte; a file is never opened for writing again.
///
///   /frame /time /version /identity    whose checkpoint this is; /time may lie within the frame after /frame
///   /state_hash                        World::state_hash of /world
///   /metrics/...                       the table of metrics.h5 so far
///   /world/...                         what World::visit walks
///   last 32 bytes                      "wick-checkpoint\n", size and hash_bytes of all before them
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/function_ref.h"
#include "core/state.h"
#include "scenes/hdf5_image.h"

namespace wick::scenes {

/// Knows the path of the group that it is in.
class PathVisitor : public StateVisitor {
 public:
  void begin_group(std::string_view name) final;
  void end_group() final;

 protected:
  explicit PathVisitor(std::string root) : path_(std::move(root)) {}
  [[nodiscard]] std::string below(std::string_view name) const;

 private:
  std::string path_;
};

/// Writes what it visits into groups below `root`.
class StateWriter final : public PathVisitor {
 public:
  StateWriter(Hdf5Writer& writer, const std::string& root) : PathVisitor(root), writer_(writer) {}
  void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
           FunctionRef<void*(std::size_t)> resize) override;
  void strings(std::string_view name, std::vector<std::string>& values) override;

 private:
  Hdf5Writer& writer_;
};

/// Fills what it visits. Throws std::runtime_error where the file holds something else.
class StateReader final : public PathVisitor {
 public:
  StateReader(const Hdf5Reader& reader, const std::string& root) : PathVisitor(root), reader_(reader) {}
  void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
           FunctionRef<void*(std::size_t)> resize) override;
  void strings(std::string_view name, std::vector<std::string>& values) override;

 private:
  const Hdf5Reader& reader_;
};

/// Looks for values that are not finite.
class FiniteCheck final : public PathVisitor {
 public:
  FiniteCheck() : PathVisitor("") {}
  void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
           FunctionRef<void*(std::size_t)> resize) override;
  void strings(std::string_view, std::vector<std::string>&) override {}
  /// Path, index and value of the first one; empty where all are finite.
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  std::string first_;
};

struct CheckpointHeader {
  int frame = 0;
  double time = 0.0;
  std::string version;   ///< of the program that wrote it
  std::string identity;  ///< scene_identity() of its scene
  std::uint64_t state_hash = 0;
};

/// The bytes of a checkpoint: the header, and what the two walks visit.
Bytes make_checkpoint(const CheckpointHeader& header, FunctionRef<void(StateVisitor&)> visit_metrics,
                      FunctionRef<void(StateVisitor&)> visit_world);

/// A checkpoint read from disk and found whole.
class Checkpoint {
 public:
  /// Throws std::runtime_error or Refusal where the file is missing, damaged or no checkpoint.
  explicit Checkpoint(const std::filesystem::path& path);
  [[nodiscard]] const CheckpointHeader& header() const { return header_; }
  void read(FunctionRef<void(StateVisitor&)> visit_metrics, FunctionRef<void(StateVisitor&)> visit_world) const;

 private:
  Bytes bytes_;
  std::unique_ptr<Hdf5Reader> reader_;
  CheckpointHeader header_;
};

/// Tells by its last bytes whether a file is a checkpoint, or was one before it was damaged.
bool is_checkpoint(const std::filesystem::path& path);
/// 0010.h5 for frame 10.
std::string checkpoint_name(int frame);
/// Frames that have a checkpoint in `folder`, newest first.
std::vector<int> checkpoint_frames(const std::filesystem::path& folder);
/// Removes all but the `keep` newest checkpoints up to `newest`.
void prune_checkpoints(const std::filesystem::path& folder, int newest, int keep);

}  // namespace wick::scenes
