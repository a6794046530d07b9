/// Signed distance of a closed mesh, sampled by OpenVDB. The one place in this room that includes it.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/number_text.h"
#include "core/require.h"
#include "coupling/obstacles.h"

namespace wick::coupling {

namespace {

/// Every edge must be passed once in each direction: otherwise there is no inside.
void require_closed(const std::vector<Int3>& triangles, const std::string& pointer) {
  std::map<Int2, int> passes;
  for (const Int3& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      passes[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (const auto& [edge, sum] : passes)
    require(sum == 0, pointer + "/file",
            "is not closed at the edge of vertices " + std::to_string(edge[0]) + " and " + std::to_string(edge[1]) +
                " (an obstacle needs an inside)");
}

}  // namespace

SampledShape sample_mesh_distance(const std::vector<Vec3>& positions, const std::vector<Int3>& triangles,
                                  double spacing, const std::string& pointer) {
  constexpr int kMargin = 3;          // cells around the mesh; beyond it the distance to the box is added
  constexpr double kMostNodes = 2e8;  // 0.8 GB of float
  require(!triangles.empty(), pointer + "/file", "has no triangles");
  require_closed(triangles, pointer);
  Vec3 low = positions.front(), high = low;
  for (const Vec3& x : positions) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const Vec3 extent = (high - low) / spacing;
  const double nodes =
      (extent.x() + 2 * kMargin + 2) * (extent.y() + 2 * kMargin + 2) * (extent.z() + 2 * kMargin + 2);
  require(nodes <= kMostNodes, pointer + "/spacing",
          "would need " + number_text(nodes * 4e-9) + " GB for the obstacle's distance; take a larger one",
          ExitCode::refused);

  openvdb::initialize();
  SampledShape shape;
  shape.spacing = spacing;
  shape.origin = low - Vec3::Constant(kMargin * spacing);
  for (int a = 0; a < 3; ++a) shape.nodes[a] = static_cast<int>(std::ceil(extent[a])) + 2 * kMargin + 1;

  std::vector<openvdb::Vec3s> points;
  for (const Vec3& x : positions) {
    const Vec3 q = (x - shape.origin) / spacing;
    points.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()));
  }
  std::vector<openvdb::Vec3I> faces;
  for (const Int3& t : triangles) faces.emplace_back(t[0], t[1], t[2]);
  // Inside, the distance is wanted everywhere: a vertex that got in must find its way out.
  const float inner = static_cast<float>(extent.maxCoeff()) + 2 * kMargin;
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(points, faces);
  const auto grid =
      openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, openvdb::math::Transform(), kMargin + 2.0F, inner);

  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(
      openvdb::CoordBBox(0, 0, 0, shape.nodes[0] - 1, shape.nodes[1] - 1, shape.nodes[2] - 1), 0.0F);
  openvdb::tools::copyToDense(*grid, dense);
  shape.distance.assign(dense.data(), dense.data() + dense.valueCount());
  bool inside = false;
  for (float& d : shape.distance) {
    inside = inside || d < 0.0F;
    d *= static_cast<float>(spacing);
  }
  require(inside, pointer + "/file", "has no inside at this spacing (the mesh is open, or thinner than a cell)");
  return shape;
}

}  // namespace wick::coupling
