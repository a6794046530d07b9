#include "coupling/obstacles.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "core/require.h"
#include "coupling/mesh_resolution.h"
#include "solid/mesh_file.h"

namespace wick::coupling {

namespace {

/// Thickness of the thinnest sheet that can touch anything [m]; infinite where there is none.
double thinnest_sheet(const WorldParams& world) {
  double thinnest = INFINITY;
  for (const ShellSection& shell : world.shells)
    if (shell.moves && shell.motion.kind == MotionKind::none)
      thinnest = std::min(thinnest, shell.material.thickness);
  return thinnest;
}

/// Refuses a mesh of which the samples have lost thin parts; warns of edges that they round.
void require_resolved(const Obstacle& body, double h, const solid::TriangleSoup& soup, const WorldParams& world,
                      const std::string& pointer, std::vector<std::string>& warnings) {
  const MeshResolution found = resolution_of(body, h, soup.positions, soup.triangles);
  // Less than a patch of a spacing or two is the tip of a spike, rounded like an edge.
  const auto at = [&](int axis) { return number_text(found.where[axis]); };
  require(found.lost_area <= 2.0 * h * h, pointer + "/spacing",
          "loses thin parts of the mesh, " + number_text(found.lost_area) + " m2 of its surface, the thinnest of " +
              number_text(found.thickness) + " m at (" + at(0) + ", " + at(1) + ", " + at(2) +
              ") (a part needs two spacings to be sampled) take " + number_text(0.5 * found.thickness) +
              " or less, or thicken them");
  const double half = 0.5 * thinnest_sheet(world);
  if (found.rounding > std::max(half, 0.1 * h))
    warnings.push_back(pointer + "/spacing: rounds edges and corners of the mesh by up to " +
                       number_text(found.rounding) + " m, more than half the thickness of a sheet (" +
                       number_text(2.0 * half) + " m); a smaller one keeps them sharper");
}

void sample_mesh(Obstacle& obstacle, const ObstacleParams& p, const std::string& pointer, const WorldParams& world,
                 std::vector<std::string>& warnings) {
  require(!p.file.empty(), pointer + "/file",
          "missing (kind is \"mesh\"); name a closed PLY or OBJ beside the scene");
  solid::TriangleSoup soup = read_mesh_beside_scene(world, p.file, pointer + "/file", warnings).soup;
  for (Vec3& x : soup.positions) x = p.scale * x + p.center;
  obstacle.shape = sample_mesh_distance(soup.positions, soup.triangles, p.spacing, pointer);
  require_resolved(obstacle, p.spacing, soup, world, pointer, warnings);
}

}  // namespace

void require_outside(const std::vector<Sheet>& sheets, const std::vector<Obstacle>& obstacles) {
  for (std::size_t n = 0; n < obstacles.size(); ++n)
    for (const Sheet& sheet : sheets) {
      if (!sheet.free()) continue;
      std::vector<std::uint8_t> held(sheet.mesh.vertex_count(), 0);
      for (const PinSet& pin : sheet.pins)
        for (const std::int32_t i : pin.vertices) held[i] = 1;
      double edge = 0.0, deepest = 0.0;
      for (const double l : sheet.mesh.rest_length) edge += l / static_cast<double>(sheet.mesh.rest_length.size());
      std::size_t inside = 0;
      for (std::size_t i = 0; i < held.size(); ++i) {
        const double depth = -sample_distance(obstacles[n], sheet.state.x[i]).distance;
        if (held[i] != 0 || !(depth > 0.0)) continue;
        ++inside;
        deepest = std::max(deepest, depth);
      }
      // Less than half an edge is undone at the first contact; what lies deeper would be torn apart, some of it to
      // one side of the obstacle and some to the other.
      require(!(deepest > 0.5 * edge), "/obstacles/" + std::to_string(n),
              "holds " + std::to_string(inside) + " vertices of shell \"" + sheet.name + "\" at the start, up to " +
                  number_text(deepest) + " m deep (a sheet cannot start across an obstacle) move one of them");
    }
}

std::vector<Obstacle> build_obstacles(const WorldParams& world, std::vector<std::string>& warnings) {
  std::vector<Obstacle> obstacles;
  // The grid marks obstacle cells with a byte.
  require(world.obstacles.size() <= 254, "/obstacles", "more than 254; join some into one mesh");
  for (std::size_t n = 0; n < world.obstacles.size(); ++n) {
    const ObstacleParams& p = world.obstacles[n];
    const std::string pointer = "/obstacles/" + std::to_string(n);
    Obstacle obstacle{
        .name = p.name, .shape = SphereShape{p.center, p.radius}, .friction = p.friction, .velocity = p.velocity};
    if (p.kind == ObstacleKind::box) {
      require((p.upper - p.lower).minCoeff() > 0.0, pointer + "/upper", "must exceed lower in every direction");
      obstacle.shape = BoxShape{p.lower, p.upper};
    } else if (p.kind == ObstacleKind::plane) {
      require(p.normal.norm() > 1e-9, pointer + "/normal", "has no length (a plane needs a direction)");
      obstacle.shape = PlaneShape{p.center, p.normal.normalized()};
    } else if (p.kind == ObstacleKind::mesh) {
      sample_mesh(obstacle, p, pointer, world, warnings);
    }
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

}  // namespace wick::coupling
