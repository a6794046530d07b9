#include "scenes/hdf5_image.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <stdexcept>

namespace wick::scenes {

namespace {

/// An HDF5 identifier with the function that closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
    if (id < 0) throw std::runtime_error("HDF5: " + what);
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): stands for the identifier

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void check(herr_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error("HDF5: " + what);
}

hid_t native_type(ScalarType type) {
  switch (type) {
    case ScalarType::f32:
      return H5T_NATIVE_FLOAT;
    case ScalarType::f64:
      return H5T_NATIVE_DOUBLE;
    case ScalarType::i32:
      return H5T_NATIVE_INT32;
    case ScalarType::i64:
      return H5T_NATIVE_INT64;
    case ScalarType::u8:
      return H5T_NATIVE_UINT8;
    case ScalarType::u64:
      return H5T_NATIVE_UINT64;
  }
  return -1;
}

/// Errors are told by exceptions; the library's own printing is off.
void be_quiet() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

hid_t memory_access(std::size_t increment) {
  be_quiet();
  const hid_t list = H5Pcreate(H5P_FILE_ACCESS);
  if (list >= 0) H5Pset_fapl_core(list, increment, 0);
  return list;
}

/// The library takes two open files in memory of one name for the same file.
std::string unused_name() {
  static std::atomic<std::uint64_t> count{0};
  return fmt::format("memory {}", count++);
}

/// The memory grows by this at a time.
constexpr std::size_t growth = 16 << 20;

std::vector<hsize_t> shape(std::size_t rows, std::size_t columns) {
  return columns == 1 ? std::vector<hsize_t>{rows} : std::vector<hsize_t>{rows, columns};
}

hid_t string_type(std::size_t size) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  if (type >= 0) {
    H5Tset_size(type, size);
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    H5Tset_cset(type, H5T_CSET_UTF8);
  }
  return type;
}

}  // namespace

struct Hdf5Writer::Impl {
  Handle access{memory_access(growth), H5Pclose, "memory driver"};
  Handle links{H5Pcreate(H5P_LINK_CREATE), H5Pclose, "link properties"};
  Handle creation{H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "dataset properties"};
  Handle file{H5Fcreate(unused_name().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
              "cannot make a file in memory"};

  Impl() {
    H5Pset_create_intermediate_group(links, 1);
    H5Pset_obj_track_times(creation, false);  // the same data give the same bytes
  }
  void write(const std::string& path, hid_t type, const std::vector<hsize_t>& dims, bool empty, const void* data) {
    const Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose, path);
    const Handle set(H5Dcreate2(file, path.c_str(), type, space, links, creation, H5P_DEFAULT), H5Dclose,
                     "cannot make " + path);
    if (!empty) check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "cannot write " + path);
  }
};

Hdf5Writer::Hdf5Writer() : impl_(std::make_unique<Impl>()) {}
Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::dataset(const std::string& path, ScalarType type, std::size_t rows, std::size_t columns,
                         const void* data) {
  impl_->write(path, native_type(type), shape(rows, columns), rows * columns == 0, data);
}

void Hdf5Writer::blocks(const std::string& path, std::size_t count, std::size_t rows, std::size_t columns,
                        FunctionRef<const double*(std::size_t)> block) {
  const hsize_t dims[] = {count, rows, columns}, one[] = {1, rows, columns};
  const Handle space(H5Screate_simple(3, dims, nullptr), H5Sclose, path);
  const Handle part(H5Screate_simple(3, one, nullptr), H5Sclose, path);
  const Handle set(
      H5Dcreate2(impl_->file, path.c_str(), H5T_NATIVE_DOUBLE, space, impl_->links, impl_->creation, H5P_DEFAULT),
      H5Dclose, "cannot make " + path);
  for (std::size_t n = 0; n < count && rows * columns > 0; ++n) {
    const hsize_t first[] = {n, 0, 0};
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, first, nullptr, one, nullptr), "cannot select in " + path);
    check(H5Dwrite(set, H5T_NATIVE_DOUBLE, part, space, H5P_DEFAULT, block(n)), "cannot write " + path);
  }
}

void Hdf5Writer::strings(const std::string& path, const std::vector<std::string>& values) {
  std::size_t size = 1;
  for (const std::string& value : values) size = std::max(size, value.size());
  std::vector<char> block(size * values.size(), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) std::copy(values[i].begin(), values[i].end(), &block[i * size]);
  const Handle type(string_type(size), H5Tclose, "string type");
  impl_->write(path, type, {values.size()}, values.empty(), block.data());
}

Bytes Hdf5Writer::finish() {
  check(H5Fflush(impl_->file, H5F_SCOPE_GLOBAL), "cannot flush a file in memory");
  const ssize_t size = H5Fget_file_image(impl_->file, nullptr, 0);
  if (size <= 0) throw std::runtime_error("HDF5: no image of a file in memory");
  Bytes bytes(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(impl_->file, bytes.data(), bytes.size()) != size)
    throw std::runtime_error("HDF5: incomplete image of a file in memory");
  return bytes;
}

struct Hdf5Reader::Impl {
  explicit Impl(std::span<const char> bytes)
      : access(with_image(bytes), H5Pclose, "memory driver"),
        file(H5Fopen(unused_name().c_str(), H5F_ACC_RDONLY, access), H5Fclose, "not an HDF5 file") {}

  static hid_t with_image(std::span<const char> bytes) {
    const hid_t list = memory_access(growth);
    // The library copies the image and does not write through the pointer.
    if (list >= 0) H5Pset_file_image(list, const_cast<char*>(bytes.data()), bytes.size());
    return list;
  }
  [[nodiscard]] Handle open(const std::string& path) const {
    return {H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "no dataset " + path};
  }

  Handle access;
  Handle file;
};

Hdf5Reader::Hdf5Reader(std::span<const char> bytes) : impl_(std::make_unique<Impl>(bytes)) {}
Hdf5Reader::~Hdf5Reader() = default;

bool Hdf5Reader::has(const std::string& path) const {
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    if (H5Lexists(impl_->file, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

std::vector<std::size_t> Hdf5Reader::extents(const std::string& path, ScalarType type) const {
  const Handle set = impl_->open(path);
  const Handle space(H5Dget_space(set), H5Sclose, path);
  const Handle stored(H5Dget_type(set), H5Tclose, path);
  if (H5Tequal(stored, native_type(type)) <= 0) throw std::runtime_error("HDF5: another type in " + path);
  std::array<hsize_t, H5S_MAX_RANK> dims{};
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1) throw std::runtime_error("HDF5: another shape in " + path);
  H5Sget_simple_extent_dims(space, dims.data(), nullptr);
  return {dims.begin(), dims.begin() + rank};
}

std::size_t Hdf5Reader::rows(const std::string& path, ScalarType type, std::size_t columns) const {
  const std::vector<std::size_t> dims = extents(path, type);
  if (dims.size() > 2 || (dims.size() == 2 ? dims[1] : 1) != columns)
    throw std::runtime_error("HDF5: another shape in " + path);
  return dims[0];
}

void Hdf5Reader::read_block(const std::string& path, std::size_t block, double* data) const {
  const Handle set = impl_->open(path);
  const Handle space(H5Dget_space(set), H5Sclose, path);
  hsize_t one[3] = {};
  if (H5Sget_simple_extent_ndims(space) != 3) throw std::runtime_error("HDF5: another shape in " + path);
  H5Sget_simple_extent_dims(space, one, nullptr);
  one[0] = 1;
  const hsize_t first[] = {block, 0, 0};
  const Handle part(H5Screate_simple(3, one, nullptr), H5Sclose, path);
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, first, nullptr, one, nullptr), "cannot select in " + path);
  check(H5Dread(set, H5T_NATIVE_DOUBLE, part, space, H5P_DEFAULT, data), "cannot read " + path);
}

void Hdf5Reader::read(const std::string& path, ScalarType type, void* data) const {
  const Handle set = impl_->open(path);
  check(H5Dread(set, native_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "cannot read " + path);
}

std::vector<std::string> Hdf5Reader::strings(const std::string& path) const {
  const Handle set = impl_->open(path);
  const Handle space(H5Dget_space(set), H5Sclose, path);
  const Handle type(H5Dget_type(set), H5Tclose, path);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  const std::size_t size = H5Tget_size(type);
  if (H5Tget_class(type) != H5T_STRING || count < 0) throw std::runtime_error("HDF5: no strings in " + path);
  std::vector<char> block(size * static_cast<std::size_t>(count));
  if (!block.empty()) check(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), "cannot read " + path);
  std::vector<std::string> values;
  for (hssize_t i = 0; i < count; ++i) {
    const char* begin = block.data() + static_cast<std::size_t>(i) * size;
    values.emplace_back(begin, strnlen(begin, size));
  }
  return values;
}

}  // namespace wick::scenes
