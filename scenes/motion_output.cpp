#include "scenes/motion_output.h"

#include <fmt/format.h>

#include <stdexcept>

#include "core/require.h"
#include "scenes/hdf5_image.h"
#include "scenes/motion_file.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

/// One sheet at the end of one frame, read back.
struct MotionFrame {
  double time = 0.0;
  std::vector<Vec3> x;
};

MotionFrame read_motion_frame(const fs::path& path, int frame, std::size_t vertices) {
  const Bytes bytes = read_file(path, 4096 + 2 * sizeof(Vec3) * vertices + (1 << 16));
  const Hdf5Reader reader(bytes);
  std::int32_t number = 0;
  MotionFrame result;
  if (reader.rows("/frame", ScalarType::i32, 1) != 1 || reader.rows("/time", ScalarType::f64, 1) != 1 ||
      reader.rows("/x", ScalarType::f64, 3) != vertices)
    throw std::runtime_error("of another sheet");
  reader.read("/frame", ScalarType::i32, &number);
  if (number != frame) throw std::runtime_error("of another frame");
  reader.read("/time", ScalarType::f64, &result.time);
  result.x.resize(vertices);
  reader.read("/x", ScalarType::f64, result.x.front().data());
  return result;
}

/// The frames of one sheet that can be read; what cannot goes to `missing`.
MotionHeader readable_frames(const coupling::ShellView& shell, const Scene& scene, const RunFolder& folder,
                             int last, std::vector<DamagedOutput>& missing) {
  MotionHeader header{.frame = {}, .time = {}, .mesh = shell.original};
  for (int frame = 1; frame <= last; ++frame) {
    const fs::path path = folder.motion_frame(scene.output, shell.name, frame);
    try {
      header.time.push_back(read_motion_frame(path, frame, shell.x->size()).time);
      header.frame.push_back(frame);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      missing.push_back({path.lexically_relative(folder.root).generic_string(), frame, error.what()});
    }
  }
  return header;
}

bool is_joined(const Manifest& manifest, const fs::path& path, const fs::path& root, int last) {
  const auto entry = manifest.entries().find(path.lexically_relative(root).generic_string());
  std::error_code error;
  return entry != manifest.entries().end() && entry->second.frame == last && fs::is_regular_file(path, error);
}

}  // namespace

Bytes motion_frame(const coupling::ShellView& shell, int frame, double time) {
  Hdf5Writer writer;
  const std::int32_t number = frame;
  writer.dataset("/frame", ScalarType::i32, 1, 1, &number);
  writer.dataset("/time", ScalarType::f64, 1, 1, &time);
  writer.dataset("/x", ScalarType::f64, shell.x->size(), 3, shell.x->data());
  return writer.finish();
}

std::vector<DamagedOutput> join_motion(const coupling::World& world, const Scene& scene, const RunFolder& folder,
                                       Manifest& manifest) {
  std::vector<DamagedOutput> missing;
  if (!scene.output.motion.write) return missing;
  bool any = false;
  for (const coupling::ShellView& shell : world.shells()) {
    const fs::path path = folder.motion(shell.name);
    if (is_joined(manifest, path, folder.root, world.frame())) continue;
    const MotionHeader header = readable_frames(shell, scene, folder, world.frame(), missing);
    if (header.frame.empty()) continue;
    MotionFrame read;
    const Bytes bytes = motion_file(header, [&](std::size_t n) -> const std::vector<Vec3>& {
      const fs::path part = folder.motion_frame(scene.output, shell.name, header.frame[n]);
      read = read_motion_frame(part, header.frame[n], shell.x->size());
      return read.x;
    });
    write_file(path, bytes);
    manifest.add(folder.root, path, world.frame(), bytes);
    any = true;
  }
  if (any) write_file(folder.manifest(), manifest.text());
  return missing;
}

}  // namespace wick::scenes
