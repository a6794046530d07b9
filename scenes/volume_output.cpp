#include "scenes/volume_output.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/parallel.h"
#include "scenes/git_revision.h"
#include "scenes/sha256.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace {

/// Largest finite 16-bit float; what is beyond it is kept in 32 bits.
constexpr double largest_half = 65504.0;
constexpr int leaf_size = 8;

/// The grid as the output's axes see it: index (I,J,K) of the file to cell (i,j,k) of the simulation.
/// With y up, (X,Y,Z) = (x, z, -y), so K runs against j.
struct Axes {
  const fluid::Grid& grid;
  bool y_up;

  [[nodiscard]] Int3 size() const {
    return y_up ? Int3{grid.nx, grid.nz, grid.ny} : Int3{grid.nx, grid.ny, grid.nz};
  }
  [[nodiscard]] Int3 cell(int I, int J, int K) const { return y_up ? Int3{I, grid.ny - 1 - K, J} : Int3{I, J, K}; }
  [[nodiscard]] openvdb::Vec3d first_center() const {
    const Int3 c = cell(0, 0, 0);
    const Vec3 x = grid.cell_center(c[0], c[1], c[2]);
    return y_up ? openvdb::Vec3d(x.x(), x.z(), -x.y()) : openvdb::Vec3d(x.x(), x.y(), x.z());
  }
  [[nodiscard]] openvdb::Vec3f vector(const openvdb::Vec3f& v) const {
    return y_up ? openvdb::Vec3f(v[0], v[2], -v[1]) : v;
  }
};

float difference(float a, float b) {
  return std::abs(a - b);
}
float difference(const openvdb::Vec3f& a, const openvdb::Vec3f& b) {
  return (a - b).length();
}

/// Fills one leaf; null where nothing in it differs from the background by more than `clip`.
template <class Tree, class Value, class Sample>
std::unique_ptr<typename Tree::LeafNodeType> make_leaf(const Int3& size, const Int3& lower, const Value& background,
                                                       float clip, const Sample& sample) {
  using Leaf = typename Tree::LeafNodeType;
  std::unique_ptr<Leaf> leaf;
  for (int I = lower[0]; I < std::min(lower[0] + leaf_size, size[0]); ++I)
    for (int J = lower[1]; J < std::min(lower[1] + leaf_size, size[1]); ++J)
      for (int K = lower[2]; K < std::min(lower[2] + leaf_size, size[2]); ++K) {
        const Value value = sample(I, J, K);
        if (!(difference(value, background) > clip)) continue;
        const openvdb::Coord at(I, J, K);
        if (!leaf) leaf = std::make_unique<Leaf>(openvdb::Coord(lower[0], lower[1], lower[2]), background);
        leaf->setValueOn(Leaf::coordToOffset(at), value);
      }
  return leaf;
}

/// Builds a sparse grid leaf by leaf, in parallel; leaves enter the tree in index order.
template <class GridType, class Sample>
typename GridType::Ptr make_grid(const Axes& axes, const typename GridType::ValueType& background, double clip,
                                 const Sample& sample) {
  using Tree = typename GridType::TreeType;
  const Int3 size = axes.size();
  Int3 leaves;
  for (int a = 0; a < 3; ++a) leaves[a] = (size[a] + leaf_size - 1) / leaf_size;
  std::vector<std::unique_ptr<typename Tree::LeafNodeType>> made(std::size_t(leaves[0]) * leaves[1] * leaves[2]);
  parallel_for(made.size(), 16, [&](std::size_t n) {
    const auto i = static_cast<int>(n % leaves[0]), j = static_cast<int>(n / leaves[0] % leaves[1]),
               k = static_cast<int>(n / leaves[0] / leaves[1]);
    made[n] = make_leaf<Tree>(size, {leaf_size * i, leaf_size * j, leaf_size * k}, background,
                              static_cast<float>(clip), sample);
  });
  auto grid = GridType::create(background);
  for (auto& leaf : made)
    if (leaf) grid->tree().addLeaf(leaf.release());
  auto transform = openvdb::math::Transform::createLinearTransform(axes.grid.h);
  transform->postTranslate(axes.first_center());
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

double largest(const fluid::CellField& field, double offset) {
  return parallel_max(field.size(), 1 << 16, 0.0, [&](std::size_t begin, std::size_t end) {
    double most = 0.0;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(field[i] + offset));
    return most;
  });
}

struct Finish {
  const VolumeParams& params;
  openvdb::GridPtrVec grids;

  void add(const openvdb::GridBase::Ptr& grid, const std::string& name, const std::string& unit, double magnitude) {
    grid->setName(name);
    grid->setSaveFloatAsHalf(params.precision == Precision::half && magnitude <= largest_half);
    grid->insertMeta("unit", openvdb::StringMetadata(unit));
    grids.push_back(grid);
  }
};

void add_scalars(Finish& out, const VolumeFrame& frame, const Axes& axes) {
  const auto scalar = [&](const fluid::CellField& field, float offset, double clip) {
    return make_grid<openvdb::FloatGrid>(axes, offset, clip, [&](int I, int J, int K) {
      const Int3 c = axes.cell(I, J, K);
      return field[frame.grid.cell(c[0], c[1], c[2])] + offset;
    });
  };
  const auto ambient = static_cast<float>(frame.ambient_temperature);
  const GridNames& names = out.params.names;
  const ClipParams& clip = out.params.clip;
  out.add(scalar(frame.state.density, 0.0F, clip.density), names.density, "kg/m3",
          largest(frame.state.density, 0.0));
  out.add(scalar(frame.state.temperature, ambient, clip.temperature), names.temperature, "K",
          largest(frame.state.temperature, ambient));
  out.add(scalar(frame.state.flame, 0.0F, clip.flame), names.flame, "1", largest(frame.state.flame, 0.0));
}

void add_velocity(Finish& out, const VolumeFrame& frame, const Axes& axes) {
  const bool per_frame = out.params.velocity_unit == VelocityUnit::frame;
  const double scale = per_frame ? 1.0 / frame.fps : 1.0;
  const fluid::FaceField& u = frame.state.velocity;
  const auto centred = [&](int axis, const Int3& c) {
    Int3 next = c;
    ++next[axis];
    const float lower = u[axis][frame.grid.face(axis, c[0], c[1], c[2])];
    const float upper = u[axis][frame.grid.face(axis, next[0], next[1], next[2])];
    return static_cast<float>(0.5 * scale * (double(lower) + upper));
  };
  const auto grid = make_grid<openvdb::Vec3SGrid>(
      axes, openvdb::Vec3f(0.0F), out.params.clip.velocity * scale, [&](int I, int J, int K) {
        const Int3 c = axes.cell(I, J, K);
        return axes.vector({centred(0, c), centred(1, c), centred(2, c)});
      });
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  const double magnitude = scale * std::max({largest(u[0], 0.0), largest(u[1], 0.0), largest(u[2], 0.0)});
  out.add(grid, out.params.names.velocity, per_frame ? "m/frame" : "m/s", magnitude);
}

openvdb::MetaMap file_metadata(const VolumeFrame& frame, const VolumeParams& params, UpAxis up_axis) {
  openvdb::MetaMap meta;
  const auto text = [&](const char* key, const std::string& value) {
    meta.insertMeta(key, openvdb::StringMetadata(value));
  };
  // Not "Houdini...": Blender turns the volumes of files whose creator begins so.
  text("creator", std::string("wick ") + version);
  text("version", version);
  text("git", git_revision());
  text("scene_sha256", frame.scene_sha256);
  text("units", "m,s,kg,K");
  text("up_axis", up_axis == UpAxis::y ? "y" : "z");
  text("velocity_units", params.velocity_unit == VelocityUnit::frame ? "m/frame" : "m/s");
  meta.insertMeta("frame", openvdb::Int32Metadata(frame.frame));
  meta.insertMeta("time", openvdb::DoubleMetadata(frame.time));
  meta.insertMeta("fps", openvdb::DoubleMetadata(frame.fps));
  meta.insertMeta("dx", openvdb::DoubleMetadata(frame.grid.h));
  meta.insertMeta("ambient_temperature", openvdb::DoubleMetadata(frame.ambient_temperature));
  return meta;
}

/// OpenVDB draws the unique id of a file at random; drawn from the file's own bytes, equal volumes are equal files.
void derive_unique_id(std::string& file) {
  constexpr std::size_t kPlace = 21, kLength = 36;  // behind magic number, versions and the flag of grid offsets
  constexpr std::size_t kDashes[] = {8, 13, 18, 23};
  const auto is_id = [&](std::size_t dash) { return file.size() > kPlace + kLength && file[kPlace + dash] == '-'; };
  if (!std::all_of(std::begin(kDashes), std::end(kDashes), is_id)) return;  // some other version's header
  std::string id(kLength, '0');
  file.replace(kPlace, kLength, id);
  const std::string digits = sha256(file);
  std::copy_n(digits.begin(), kLength, id.begin());
  for (const std::size_t dash : kDashes) id[dash] = '-';
  file.replace(kPlace, kLength, id);
}

}  // namespace

std::string smoke_vdb(const VolumeFrame& frame, const VolumeParams& params, UpAxis up_axis) {
  static const bool ready = (openvdb::initialize(), true);
  static_cast<void>(ready);
  const Axes axes{frame.grid, up_axis == UpAxis::y};
  Finish out{params, {}};
  add_scalars(out, frame, axes);
  add_velocity(out, frame, axes);

  std::ostringstream bytes(std::ios::binary);
  openvdb::io::Stream stream(bytes);
  stream.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(out.grids, file_metadata(frame, params, up_axis));
  if (!bytes) throw std::runtime_error("OpenVDB could not build a volume in memory");
  std::string file = std::move(bytes).str();
  derive_unique_id(file);
  return file;
}

}  // namespace wick::scenes
