#include "fluid/walls.h"

#include <gtest/gtest.h>

#include "wall_shapes.h"

namespace wick::fluid {
namespace {

TEST(NearWalls, MarksTwoCellsInEveryDirectionAndAroundPeriodicSides) {
  const Grid grid = unit_grid(12);
  Walls walls = no_walls(grid);
  walls.closed[0][grid.face(0, 1, 6, 6)] = 1;
  for (const bool periodic : {false, true}) {
    const Sides sides = periodic ? Sides{P, P, C, C, C, C} : all_closed;
    mark_near_walls(grid, sides, walls);
    for (int k = 0; k < 12; ++k)
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 12; ++i) {
          // Cells 0 and 1 have the face; two more on both sides of them are near.
          const bool near_x = i <= 3 || (periodic && i >= 10);
          const bool expected = near_x && std::abs(j - 6) <= 2 && std::abs(k - 6) <= 2;
          EXPECT_EQ(walls.near[grid.cell(i, j, k)] != 0, expected) << i << ' ' << j << ' ' << k;
        }
  }
}

}  // namespace
}  // namespace wick::fluid
