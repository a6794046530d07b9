#pragma once
/// How the gas sees sheets and obstacles: the segment between every two neighbouring cell centres is tested against
/// every triangle [Guendelman 2005] and obstacle. A hit closes the face between the two cells. Cells whose centre
/// lies in an obstacle are solid; one that is thinner than a cell still lets nothing through.
///
/// Tests are watertight: the edge functions of a triangle side are computed from its two vertices in one
/// fixed order, so neighbours agree bit for bit on which side of a shared edge a grid line passes, and lines
/// on an edge count for both.
#include <cstdint>
#include <vector>

#include "core/obstacle.h"
#include "fluid/walls.h"
#include "solid/shell_mesh.h"

namespace wick::coupling {

/// A sheet as the rasteriser sees it.
struct SheetSurface {
  const solid::ShellMesh* mesh = nullptr;
  const std::vector<Vec3>* x = nullptr;
  const std::vector<Vec3>* v = nullptr;
};

/// One closed face and the sheet point behind it (the one nearest to the face, where there are several).
struct WallHit {
  std::int32_t sheet;
  std::int32_t triangle;
  std::array<double, 3> weight;      ///< barycentric, of the triangle's vertices
  std::int8_t axis;                  ///< of the face
  std::int8_t facing;                ///< +1: the triangle's normal points along +axis, -1: along -axis
  std::int64_t face;                 ///< index among the faces of the axis
  std::array<std::int32_t, 3> cell;  ///< (i, j, k) of the cell above the face; the one below is one less along axis
  std::int32_t crossings = 1;  ///< times that sheets cross the segment: even when its ends are on the same side
};

/// Everything the gas and the exchange need to know of the sheets' place in the grid.
class Raster {
 public:
  Raster(const fluid::Grid& grid, const fluid::Sides& sides);

  /// Marks cells inside obstacles and closes the faces that sheets cross, as they are now.
  void see(const std::vector<SheetSurface>& sheets, const std::vector<Obstacle>& obstacles);

  [[nodiscard]] const fluid::Walls& walls() const { return walls_; }
  [[nodiscard]] const std::vector<WallHit>& hits() const { return hits_; }
  /// Index into hits() of the hit on a face, -1 where no sheet closes it.
  [[nodiscard]] std::int32_t hit_at(int axis, std::size_t face) const { return hit_at_[axis][face]; }
  /// Times that sheets cross the segment through a face; 0 where none closes it.
  [[nodiscard]] int crossings(int axis, std::size_t face) const {
    const std::int32_t hit = hit_at_[axis][face];
    return hit < 0 ? 0 : hits_[hit].crossings;
  }
  [[nodiscard]] const fluid::Grid& grid() const { return grid_; }

 private:
  void clear_sheets();
  void close_sheet_faces(const std::vector<SheetSurface>& sheets);
  void close_obstacle_faces(const std::vector<Obstacle>& obstacles);
  void mark_obstacles(const std::vector<Obstacle>& obstacles);

  fluid::Grid grid_;
  fluid::Sides sides_;
  fluid::Walls walls_;
  std::vector<WallHit> hits_;
  std::array<std::vector<std::int32_t>, 3> hit_at_;
  std::vector<std::uint8_t> obstacle_mark_;                 ///< per cell: 1 + obstacle number (0: none)
  std::array<std::vector<std::uint8_t>, 3> obstacle_face_;  ///< per face: the same of what closes it
  std::vector<Pose> obstacle_place_;                        ///< for which the marks hold
};

/// Cells whose centre a sheet passed while moving linearly from `before` to `after` (V each): an odd number of
/// crossings, so that the cell is on the sheet's other side now. Ascending, unique.
std::vector<std::int64_t> swept_cells(const fluid::Grid& grid, const solid::ShellMesh& mesh,
                                      const std::vector<Vec3>& before, const std::vector<Vec3>& after);

/// Distance by which grid lines are moved off the places where meshes like to lie (cell centres): a mesh that is
/// aligned with the grid is seen as if it lay this fraction of a cell beside it.
Vec3 grid_line_offset();

/// Where an obstacle is asked whether it holds a cell: the cell's centre, off by the same distance.
Vec3 probe(const fluid::Grid& grid, const Int3& cell);

}  // namespace wick::coupling
