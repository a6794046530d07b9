#include "solid/spin.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>

#include "core/parallel.h"

namespace wick::solid {

namespace {

constexpr std::size_t kChunk = 512;

Vec3 vector(const Row& r) {
  return {r.x, r.y, r.z};
}

}  // namespace

void SpinKeeper::Moments::add(const Moments& other) {
  mass += other.mass;
  first += other.first;
  momentum += other.momentum;
  angular += other.angular;
  second += other.second;
  touched |= other.touched;
}

SpinKeeper::SpinKeeper(const ShellMesh& mesh) : component_(mesh.component) {
  std::int32_t count = 0;
  for (const std::int32_t c : component_) count = std::max(count, c + 1);
  offset_.assign(count + 1, 0);
  for (const std::int32_t c : component_)
    if (c >= 0) ++offset_[c + 1];
  for (std::int32_t c = 0; c < count; ++c) offset_[c + 1] += offset_[c];
  order_.resize(offset_.back());
  std::vector<std::size_t> next(offset_.begin(), offset_.end() - 1);
  for (std::size_t i = 0; i < component_.size(); ++i)
    if (component_[i] >= 0) order_[next[component_[i]]++] = static_cast<std::int32_t>(i);
}

void SpinKeeper::choose_free(const Pins& pins, const ShellInputs& inputs) {
  mass_ = inputs.mass;
  std::vector<std::uint8_t> held(offset_.size() - 1, 0);
  for (const std::int32_t i : pins.vertex)
    if (component_[i] >= 0) held[component_[i]] = 1;
  pieces_.clear();
  chunks_.clear();
  for (std::size_t c = 0; c + 1 < offset_.size(); ++c) {
    if (held[c]) continue;
    const std::size_t first_chunk = chunks_.size();
    for (std::size_t begin = offset_[c]; begin < offset_[c + 1]; begin += kChunk)
      chunks_.push_back({begin, std::min(begin + kChunk, offset_[c + 1]), pieces_.size()});
    pieces_.push_back({offset_[c], offset_[c + 1], first_chunk, chunks_.size()});
  }
  partial_.resize(chunks_.size());
}

template <class Body>
void SpinKeeper::gather(Body&& add_vertex) {
  parallel_for(chunks_.size(), 4, [&](std::size_t k) {
    Moments sum;
    for (std::size_t j = chunks_[k].begin; j < chunks_[k].end; ++j)
      add_vertex(sum, static_cast<std::size_t>(order_[j]), pieces_[chunks_[k].piece].origin);
    partial_[k] = sum;
  });
}

SpinKeeper::Moments SpinKeeper::total(const Piece& piece) const {
  Moments sum;
  for (std::size_t k = piece.first_chunk; k < piece.end_chunk; ++k) sum.add(partial_[k]);
  return sum;
}

void SpinKeeper::remember(const std::vector<Row>& position, const std::vector<Row>& velocity,
                          const std::vector<Row>& push, double keep) {
  for (Piece& piece : pieces_) piece.origin = vector(position[order_[piece.begin]]);
  gather([&](Moments& sum, std::size_t i, const Vec3& origin) {
    const Vec3 x = vector(position[i]) - origin, p = mass_[i] * (keep * vector(velocity[i]) + vector(push[i]));
    sum.mass += mass_[i];
    sum.first += mass_[i] * x;
    sum.momentum += p;
    sum.angular += x.cross(p);
  });
  for (Piece& piece : pieces_) {
    const Moments sum = total(piece);
    if (sum.mass > 0.0) piece.angular = sum.angular - sum.first.cross(sum.momentum) / sum.mass;
  }
}

void SpinKeeper::restore(const std::vector<Row>& position, std::vector<Row>& velocity,
                         const std::vector<std::uint8_t>& touched, double h) {
  gather([&](Moments& sum, std::size_t i, const Vec3& origin) {
    const Vec3 x = vector(position[i]) - origin, p = mass_[i] * vector(velocity[i]);
    sum.mass += mass_[i];
    sum.first += mass_[i] * x;
    sum.momentum += p;
    sum.angular += x.cross(p);
    sum.second += mass_[i] * x * x.transpose();
    sum.touched |= touched[i] != 0;
  });
  for (const Piece& piece : pieces_) {
    const Moments sum = total(piece);
    if (sum.touched || !(sum.mass > 0.0)) continue;
    const Vec3 center = sum.first / sum.mass;
    const Mat3 about = sum.second - sum.mass * center * center.transpose();
    // A piece crushed to a line has no inertia about it; the small share keeps the system regular.
    const Mat3 inertia = (1.0 + 1e-9) * about.trace() * Mat3::Identity() - about;
    const Vec3 lost = piece.angular - (sum.angular - sum.first.cross(sum.momentum) / sum.mass);
    const Vec3 omega = inertia.ldlt().solve(lost);
    // Beyond a twentieth of a radian a substep the piece is not turning, it is being torn about.
    if (!(omega.norm() * h < 0.05)) continue;
    const Vec3 pivot = piece.origin + center;
    for (std::size_t j = piece.begin; j < piece.end; ++j) {
      Row& v = velocity[order_[j]];
      const Vec3 turned = vector(v) + omega.cross(vector(position[order_[j]]) - pivot);
      v = {turned.x(), turned.y(), turned.z(), 0.0};
    }
  }
}

}  // namespace wick::solid
