#pragma once
/// HDF5 files as bytes in memory. The library never opens a file on the disk: on a full one it loses data
/// without an error and then crashes at exit; the bytes go through write_file instead.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/function_ref.h"
#include "core/state.h"
#include "scenes/atomic_file.h"

namespace wick::scenes {

/// Builds one HDF5 file. Not for two threads at a time (the library is not thread-safe).
class Hdf5Writer {
 public:
  Hdf5Writer();
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// Writes rows x columns scalars (a plain list when there is one column); groups in `path` are made.
  void dataset(const std::string& path, ScalarType type, std::size_t rows, std::size_t columns, const void* data);
  /// Writes blocks x rows x columns doubles, asking `block` for the rows x columns of one block at a time.
  void blocks(const std::string& path, std::size_t count, std::size_t rows, std::size_t columns,
              FunctionRef<const double*(std::size_t)> block);
  void strings(const std::string& path, const std::vector<std::string>& values);
  /// The bytes of the file; nothing can be added afterwards.
  Bytes finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads what Hdf5Writer made, or what others made of the same types. Throws std::runtime_error for anything that
/// is not there as expected.
class Hdf5Reader {
 public:
  /// `bytes` must outlive the reader.
  explicit Hdf5Reader(std::span<const char> bytes);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  [[nodiscard]] bool has(const std::string& path) const;
  [[nodiscard]] std::size_t rows(const std::string& path, ScalarType type, std::size_t columns) const;
  void read(const std::string& path, ScalarType type, void* data) const;
  /// Extents of a dataset of `type`, whatever its rank.
  [[nodiscard]] std::vector<std::size_t> extents(const std::string& path, ScalarType type) const;
  /// Reads one block of count x rows x columns doubles.
  void read_block(const std::string& path, std::size_t block, double* data) const;
  [[nodiscard]] std::vector<std::string> strings(const std::string& path) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::scenes
