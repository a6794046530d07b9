#include "scenes/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view magic = "wick-checkpoint\n";
struct Trailer {
  char name[16];
  std::uint64_t size;
  std::uint64_t hash;
};
static_assert(sizeof(Trailer) == 32 && magic.size() == sizeof Trailer::name);

template <class T>
std::size_t first_bad(const void* data, std::size_t count) {
  const auto* values = static_cast<const T*>(data);
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i])) return i;
  return count;
}

void append_trailer(Bytes& bytes) {
  Trailer trailer{};
  std::copy(magic.begin(), magic.end(), trailer.name);
  trailer.size = bytes.size();
  trailer.hash = hash_bytes(bytes.data(), bytes.size());
  bytes.append(reinterpret_cast<const char*>(&trailer), sizeof trailer);
}

/// The HDF5 part of a checkpoint whose checksum is right.
std::span<const char> verified(const Bytes& bytes) {
  Trailer trailer{};
  if (bytes.size() < sizeof trailer) throw std::runtime_error("it is too short to be a checkpoint");
  const std::size_t size = bytes.size() - sizeof trailer;
  std::memcpy(&trailer, bytes.data() + size, sizeof trailer);
  if (std::string_view(trailer.name, sizeof trailer.name) != magic || trailer.size != size)
    throw std::runtime_error("it is cut off or no checkpoint");
  if (trailer.hash != hash_bytes(bytes.data(), size)) throw std::runtime_error("its checksum is wrong");
  return {bytes.data(), size};
}

std::string only(const std::vector<std::string>& values) {
  if (values.size() != 1) throw std::runtime_error("its header is incomplete");
  return values.front();
}

}  // namespace

void PathVisitor::begin_group(std::string_view name) {
  path_ = below(name);
}
void PathVisitor::end_group() {
  path_ = path_.substr(0, path_.rfind('/'));
}
std::string PathVisitor::below(std::string_view name) const {
  return path_ + '/' + std::string(name);
}

void StateWriter::raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns,
                      const void* data, FunctionRef<void*(std::size_t)>) {
  writer_.dataset(below(name), type, rows, columns, data);
}
void StateWriter::strings(std::string_view name, std::vector<std::string>& values) {
  writer_.strings(below(name), values);
}

void StateReader::raw(std::string_view name, ScalarType type, std::size_t, std::size_t columns, const void*,
                      FunctionRef<void*(std::size_t)> resize) {
  const std::string path = below(name);
  const std::size_t rows = reader_.rows(path, type, columns);
  void* storage = resize(rows);
  if (rows * columns > 0) reader_.read(path, type, storage);
}
void StateReader::strings(std::string_view name, std::vector<std::string>& values) {
  values = reader_.strings(below(name));
}

void FiniteCheck::raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns,
                      const void* data, FunctionRef<void*(std::size_t)>) {
  if (!first_.empty()) return;
  const std::size_t count = rows * columns;
  std::size_t bad = count;
  if (type == ScalarType::f32) bad = first_bad<float>(data, count);
  if (type == ScalarType::f64) bad = first_bad<double>(data, count);
  if (bad == count) return;
  const double value =
      type == ScalarType::f32 ? static_cast<const float*>(data)[bad] : static_cast<const double*>(data)[bad];
  first_ = fmt::format("{}[{}] = {}", below(name), bad, value);
}

Bytes make_checkpoint(const CheckpointHeader& header, FunctionRef<void(StateVisitor&)> visit_metrics,
                      FunctionRef<void(StateVisitor&)> visit_world) {
  Hdf5Writer writer;
  const std::int32_t frame = header.frame;
  writer.dataset("/frame", ScalarType::i32, 1, 1, &frame);
  writer.dataset("/time", ScalarType::f64, 1, 1, &header.time);
  writer.dataset("/state_hash", ScalarType::u64, 1, 1, &header.state_hash);
  writer.strings("/version", {header.version});
  writer.strings("/identity", {header.identity});
  StateWriter metrics(writer, "/metrics"), world(writer, "/world");
  visit_metrics(metrics);
  visit_world(world);
  Bytes bytes = writer.finish();
  append_trailer(bytes);
  return bytes;
}

Checkpoint::Checkpoint(const fs::path& path) : bytes_(read_file(path, 1ULL << 40)) {
  reader_ = std::make_unique<Hdf5Reader>(verified(bytes_));
  std::int32_t frame = 0;
  for (const auto& [name, type] : {std::pair{"/frame", ScalarType::i32}, std::pair{"/time", ScalarType::f64},
                                   std::pair{"/state_hash", ScalarType::u64}})
    if (reader_->rows(name, type, 1) != 1) throw std::runtime_error("its header is incomplete");
  reader_->read("/frame", ScalarType::i32, &frame);
  reader_->read("/time", ScalarType::f64, &header_.time);
  reader_->read("/state_hash", ScalarType::u64, &header_.state_hash);
  header_.frame = frame;
  header_.version = only(reader_->strings("/version"));
  header_.identity = only(reader_->strings("/identity"));
}

void Checkpoint::read(FunctionRef<void(StateVisitor&)> visit_metrics,
                      FunctionRef<void(StateVisitor&)> visit_world) const {
  StateReader metrics(*reader_, "/metrics"), world(*reader_, "/world");
  visit_metrics(metrics);
  visit_world(world);
}

bool is_checkpoint(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  Trailer trailer{};
  in.seekg(-static_cast<std::streamoff>(sizeof trailer), std::ios::end);
  in.read(reinterpret_cast<char*>(&trailer), sizeof trailer);
  return in.good() && std::string_view(trailer.name, sizeof trailer.name) == magic;
}

std::string checkpoint_name(int frame) {
  return fmt::format("{:04d}.h5", frame);
}

std::vector<int> checkpoint_frames(const fs::path& folder) {
  std::vector<int> frames;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string stem = it->path().stem().string();
    int frame = 0;
    const auto [last, parse] = std::from_chars(stem.data(), stem.data() + stem.size(), frame);
    const bool number = parse == std::errc{} && last == stem.data() + stem.size();
    if (number && frame > 0 && it->path().filename() == checkpoint_name(frame)) frames.push_back(frame);
  }
  std::sort(frames.rbegin(), frames.rend());
  return frames;
}

void prune_checkpoints(const fs::path& folder, int newest, int keep) {
  int kept = 0;
  for (const int frame : checkpoint_frames(folder)) {
    if (frame > newest || ++kept <= keep) continue;
    std::error_code ignored;
    fs::remove(folder / checkpoint_name(frame), ignored);
  }
}

}  // namespace wick::scenes
