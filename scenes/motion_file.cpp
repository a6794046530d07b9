#include "scenes/motion_file.h"

#include <fmt/format.h>

#include <cmath>

#include "core/require.h"
#include "core/state.h"
#include "scenes/hdf5_image.h"
#include "scenes/machine.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Int3) == 3 * sizeof(std::int32_t));

/// Farther off than this positions lose the digits that a millimetre needs [m].
constexpr double farthest = 1e6;

/// Adds up what a file holds, in the order of its frames.
class MotionChecksum {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    sum_ = hash_bytes(values.data(), values.size() * sizeof(T), sum_);
  }
  [[nodiscard]] std::uint64_t sum() const { return sum_; }

 private:
  std::uint64_t sum_ = 0;
};

/// A motion file that is being read; problems are told by std::runtime_error.
class MotionReader {
 public:
  explicit MotionReader(const Bytes& bytes) : file_(bytes) {}

  coupling::MotionTrack read() {
    const std::vector<std::size_t> extents = file_.extents("/x", ScalarType::f64);
    if (extents.size() != 3 || extents[2] != 3) throw std::runtime_error("/x is not of frames x vertices x 3");
    const std::size_t frames = extents[0], vertices = extents[1];
    require_room(frames, sizeof(Vec3) * static_cast<double>(vertices), "/x");
    coupling::MotionTrack track;
    track.time = list<double>("/time", ScalarType::f64, 1, frames);
    require_ascending(track.time);
    if (file_.has("/rest")) track.rest = list<Vec3>("/rest", ScalarType::f64, 3, vertices);
    if (file_.has("/triangles"))
      track.triangles = list<Int3>("/triangles", ScalarType::i32, 3, file_.rows("/triangles", ScalarType::i32, 3));
    for (std::size_t n = 0; n < frames; ++n) {
      std::vector<Vec3> x(vertices);
      if (vertices > 0) file_.read_block("/x", n, x.front().data());
      require_near(x, n);
      track.x.push_back(std::move(x));
    }
    require_checksum(track);
    return track;
  }

 private:
  template <class T>
  std::vector<T> list(const std::string& path, ScalarType type, std::size_t columns, std::size_t rows) const {
    const std::size_t found = file_.rows(path, type, columns);
    if (found != rows)
      throw std::runtime_error(fmt::format("{} has {} rows, and /x asks for {}", path, found, rows));
    require_room(rows, sizeof(T), path);
    std::vector<T> values(rows);
    if (rows > 0) file_.read(path, type, values.data());
    return values;
  }

  /// Damaged or packed, a small file may speak of more than memory holds.
  static void require_room(std::size_t rows, double bytes, const std::string& path) {
    if (static_cast<double>(rows) * bytes > 0.5 * static_cast<double>(available_memory()))
      throw std::runtime_error(fmt::format("the {} rows of {} do not fit into memory", rows, path));
  }

  static void require_ascending(const std::vector<double>& time) {
    if (time.empty()) throw std::runtime_error("it has no frames");
    for (std::size_t n = 0; n < time.size(); ++n)
      if (!std::isfinite(time[n]) || (n > 0 && time[n] <= time[n - 1]))
        throw std::runtime_error(fmt::format("/time[{}] = {} does not come after the one before", n, time[n]));
  }

  static void require_near(const std::vector<Vec3>& x, std::size_t n) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!(x[i].cwiseAbs().maxCoeff() <= farthest) || !x[i].allFinite())
        throw std::runtime_error(fmt::format("/x[{}][{}] = ({}, {}, {}) is no place within {} m", n, i, x[i].x(),
                                             x[i].y(), x[i].z(), farthest));
  }

  /// A file without a checksum comes from elsewhere and is taken as it is.
  void require_checksum(const coupling::MotionTrack& track) const {
    if (!file_.has("/checksum")) return;
    MotionChecksum sum;
    for (const std::vector<Vec3>& x : track.x) sum.add(x);
    sum.add(track.time);
    sum.add(list<std::int32_t>("/frame", ScalarType::i32, 1, track.time.size()));
    sum.add(track.rest);
    sum.add(track.triangles);
    const std::vector<std::uint64_t> stored = list<std::uint64_t>("/checksum", ScalarType::u64, 1, 1);
    if (stored.front() != sum.sum())
      throw std::runtime_error("its content is not what /checksum was made of: it is damaged, or was edited");
  }

  Hdf5Reader file_;
};

}  // namespace

Bytes motion_file(const MotionHeader& header, FunctionRef<const std::vector<Vec3>&(std::size_t)> places) {
  const solid::ShellMesh& mesh = *header.mesh;
  Hdf5Writer writer;
  MotionChecksum sum;
  writer.strings("/version", {std::string("wick ") + version});
  writer.strings("/units", {"m,s"});
  writer.dataset("/time", ScalarType::f64, header.time.size(), 1, header.time.data());
  writer.dataset("/frame", ScalarType::i32, header.frame.size(), 1, header.frame.data());
  writer.dataset("/rest", ScalarType::f64, mesh.rest.size(), 3, mesh.rest.data());
  writer.dataset("/triangles", ScalarType::i32, mesh.triangles.size(), 3, mesh.triangles.data());
  writer.blocks("/x", header.time.size(), mesh.rest.size(), 3, [&](std::size_t n) {
    const std::vector<Vec3>& x = places(n);
    sum.add(x);
    return x.front().data();
  });
  sum.add(header.time);
  sum.add(header.frame);
  sum.add(mesh.rest);
  sum.add(mesh.triangles);
  const std::uint64_t checksum = sum.sum();
  writer.dataset("/checksum", ScalarType::u64, 1, 1, &checksum);
  return writer.finish();
}

coupling::MotionTrack read_motion(const fs::path& path, const std::string& pointer) {
  try {
    // The bytes, the library's image of them and the track are in memory together.
    std::error_code unknown;  // what has no size is refused when it is read
    const std::uintmax_t size = fs::is_regular_file(path, unknown) ? fs::file_size(path, unknown) : 0;
    require(unknown || size <= available_memory() / 4, "",
            fmt::format("{} of {} does not fit into memory (it is read whole)", path.string(), bytes_text(size)),
            ExitCode::refused);
    const Bytes bytes = read_file(path, 1ULL << 40);
    return MotionReader(bytes).read();
  } catch (const Refusal& refusal) {
    throw Refusal(refusal.code(), pointer, refusal.what());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Refusal(
        ExitCode::scene_invalid, pointer,
        fmt::format("{} is no motion file ({}) record one with /output/motion/write", path.string(), error.what()));
  }
}

void read_motions(Scene& scene) {
  for (std::size_t n = 0; n < scene.world.shells.size(); ++n) {
    coupling::MotionParams& motion = scene.world.shells[n].motion;
    if (motion.kind != coupling::MotionKind::recorded || motion.file.empty()) continue;
    motion.track = std::make_shared<const coupling::MotionTrack>(
        read_motion(fs::path(scene.world.directory) / motion.file, fmt::format("/shells/{}/motion/file", n)));
  }
}

}  // namespace wick::scenes
