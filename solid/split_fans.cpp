#include <algorithm>
#include <numeric>

#include "solid/mesh_cut.h"

namespace wick::solid {

namespace {

/// The corners of a triangle after `vertex`, in its sense.
Int2 others(const Int3& v, std::int32_t vertex) {
  const int k = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
  return {v[(k + 1) % 3], v[(k + 2) % 3]};
}

/// Takes the triangles out of `star` that hang together with its first one by edges at `vertex`.
std::vector<std::int32_t> take_fan(const std::vector<Int3>& triangles, std::int32_t vertex,
                                   std::vector<std::int32_t>& star) {
  std::vector<std::int32_t> fan{star.front()};
  star.erase(star.begin());
  for (std::size_t n = 0; n < fan.size(); ++n) {
    const auto [b, c] = others(triangles[fan[n]], vertex);
    const auto joined = [&, b = b, c = c](std::int32_t t) {
      const auto [d, e] = others(triangles[t], vertex);
      return b == e || c == d;
    };
    std::copy_if(star.begin(), star.end(), std::back_inserter(fan), joined);
    std::erase_if(star, joined);
  }
  return fan;
}

void give_twin(CutSurface& surface, MeshCut& cut, std::int32_t vertex, const std::vector<std::int32_t>& fan) {
  const Blend twin{static_cast<std::int32_t>(surface.rest.size()), vertex, vertex, 0.0};
  cut.blends.push_back(twin);
  ++cut.born;
  apply({twin}, surface.rest);
  apply({twin}, surface.snapping);
  for (std::vector<double>& density : surface.density) apply({twin}, density);
  for (const std::int32_t t : fan)
    std::replace(surface.triangles[t].begin(), surface.triangles[t].end(), vertex, twin.vertex);
}

}  // namespace

void split_fans(CutSurface& surface, MeshCut& cut) {
  const std::size_t vertices = surface.rest.size();
  std::vector<std::int32_t> offset(vertices + 1, 0);
  for (const Int3& v : surface.triangles)
    for (const std::int32_t i : v) ++offset[i + 1];
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  std::vector<std::int32_t> incident(3 * surface.triangles.size()), next(offset.begin(), offset.end() - 1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::int32_t i : surface.triangles[t]) incident[next[i]++] = static_cast<std::int32_t>(t);

  std::vector<std::int32_t> star;
  for (std::size_t i = 0; i < vertices; ++i) {
    const auto vertex = static_cast<std::int32_t>(i);
    star.assign(incident.begin() + offset[i], incident.begin() + offset[i + 1]);
    if (star.empty()) continue;
    take_fan(surface.triangles, vertex, star);  // keeps the vertex
    while (!star.empty()) give_twin(surface, cut, vertex, take_fan(surface.triangles, vertex, star));
  }
}

}  // namespace wick::solid
