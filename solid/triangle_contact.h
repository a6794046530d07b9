#pragma once
/// Contact where an obstacle reaches between the vertices of a sheet: edges of boxes, balls smaller than a
/// triangle, peaks of sampled shapes. Each triangle near such an obstacle is touched at the point that is deepest
/// in it [Macklin 2020], with the point's weights on its corners.
#include <array>
#include <vector>

#include "core/obstacle.h"
#include "solid/lanes.h"
#include "solid/shell_mesh.h"

namespace wick::solid {

/// The point of a triangle that is nearest to an obstacle, or deepest in it.
struct DeepestPoint {
  std::array<double, 3> weight;  ///< of the corners, sum 1
  double distance;               ///< [m]
};
/// Exact for spheres and planes; elsewhere by descent [Frank 1956], which finds the global minimum where the
/// distance is convex, as it is for boxes. `corner` are positions as sample_distance() takes them.
DeepestPoint deepest_point(const Obstacle& obstacle, const std::array<Vec3, 3>& corner);

class TriangleContact {
 public:
  /// `offset` [m] is the distance to keep.
  TriangleContact(const ShellMesh& mesh, double offset);

  /// Chooses the obstacles that can reach between vertices, which must live through the step.
  void begin_step(const std::vector<Obstacle>& obstacles);

  /// Pushes triangles out after the vertices have been pushed out; gives the vertices that it moves their new
  /// velocity and marks them in `touched`. The obstacles are where they were `start` before the substep of length
  /// h.
  std::size_t resolve(double start, double h, std::vector<Row>& position, std::vector<Row>& previous,
                      std::vector<Row>& velocity, std::vector<std::uint8_t>& touched);

 private:
  struct Touch {
    std::int32_t triangle;
    const Obstacle* obstacle;
    std::array<double, 3> weight;
  };
  [[nodiscard]] double fastest(const std::vector<Row>& position) const;
  void find(std::size_t triangle, double start, double h, const std::vector<Row>& position,
            const std::vector<Row>& previous, std::vector<Touch>& found);
  bool push_point(const Touch& touch, double start, double h, std::vector<Row>& position,
                  std::vector<Row>& previous) const;
  std::size_t push_out(Touch touch, double start, double h, std::vector<Row>& position, std::vector<Row>& previous,
                       std::vector<Row>& velocity, std::vector<std::uint8_t>& touched) const;

  std::vector<Int3> triangles_;
  double offset_, longest_edge_ = 0.0;
  std::vector<const Obstacle*> obstacles_;  ///< the step's, that can reach between vertices
  double steepest_ = 1.0;                   ///< slope of distance among them
  std::vector<double> clearance_;           ///< per triangle: a distance to all of them that is certainly there [m]
  std::vector<std::vector<Touch>> found_;   ///< one a chunk
};

}  // namespace wick::solid
