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

namespace {

/// The middle of the shape as given: it moves as keyframes tell.
Vec3 pivot_of(const Obstacle& obstacle, const ObstacleParams& p) {
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape)) return 0.5 * (box->lower + box->upper);
  return p.center;
}

/// Displacement of the pivot and orientation.
struct Stand {
  Vec3 position;
  Eigen::Quaterniond turn;
};
Stand stand_of(const Keyframe& frame) {
  return {frame.position, Eigen::Quaterniond(rotation(frame.rotation))};
}

/// Between keyframes places are linear and turns the shortest; before the first and after the last it stands still.
Stand stand_at(const ObstacleParams& p, double t) {
  const auto after = std::upper_bound(p.keyframes.begin(), p.keyframes.end(), t,
                                      [](double time, const Keyframe& frame) { return time < frame.time; });
  if (after == p.keyframes.begin()) return stand_of(p.keyframes.front());
  if (after == p.keyframes.end()) return stand_of(p.keyframes.back());
  const Stand a = stand_of(*(after - 1)), b = stand_of(*after);
  const double share = (t - (after - 1)->time) / (after->time - (after - 1)->time);
  return {a.position + share * (b.position - a.position), a.turn.slerp(share, b.turn)};
}

void place_at(Obstacle& obstacle, const ObstacleParams& p, double t) {
  const Vec3 middle = pivot_of(obstacle, p);
  const Stand stand = stand_at(p, t);
  obstacle.pivot = middle + stand.position;
  obstacle.pose.turn = stand.turn.toRotationMatrix();
  obstacle.pose.shift = obstacle.pivot - obstacle.pose.turn * middle;
}

void require_keyframes(const ObstacleParams& p, const std::string& pointer) {
  require(p.keyframes.empty() || p.velocity.isZero(), pointer + "/velocity",
          "the keyframes move the obstacle; remove one of the two");
  for (std::size_t n = 1; n < p.keyframes.size(); ++n)
    require(p.keyframes[n].time > p.keyframes[n - 1].time, pointer + "/keyframes/" + std::to_string(n) + "/time",
            "is not after the keyframe before it; keyframes follow each other in time");
}

}  // namespace

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
    require_keyframes(p, pointer);
    obstacle.pivot = pivot_of(obstacle, p);
    if (!p.keyframes.empty()) place_at(obstacle, p, 0.0);
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

void aim(Obstacle& obstacle, const ObstacleParams& p, double t, double dt) {
  if (p.keyframes.empty()) return;
  const Stand next = stand_at(p, t + dt);
  obstacle.velocity = (pivot_of(obstacle, p) + next.position - obstacle.pivot) / dt;
  const Eigen::AngleAxisd turn(next.turn * Eigen::Quaterniond(obstacle.pose.turn).conjugate());
  obstacle.spin = turn.angle() / dt * turn.axis();
}

void visit(StateVisitor& visitor, Obstacle& obstacle) {
  visitor.value("shift", obstacle.pose.shift);
  visitor.value("pivot", obstacle.pivot);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 column = obstacle.pose.turn.col(axis);
    visitor.value("turn_" + std::to_string(axis), column);
    obstacle.pose.turn.col(axis) = column;
  }
}

}  // namespace wick::coupling
