#include "scenes/preview_obstacles.h"

#include <algorithm>

#include "core/parallel.h"

namespace wick::scenes {

namespace {

const Vec3 kBody(0.30, 0.36, 0.44), kGround(0.16, 0.155, 0.15);  // linear; what stands on a plane is told from it

/// Falls off all the way round a body, so that its far side has a shape too.
double shade(const Vec3& normal) {
  const double half = 0.5 + 0.5 * normal.dot(sun);
  return 0.25 + 0.75 * half * half;
}

struct Ball {
  Vec3 center;
  double radius;
};

Ball ball_around(const SphereShape& s) {
  return {s.center, s.radius};
}
Ball ball_around(const BoxShape& s) {
  return {0.5 * (s.lower + s.upper), 0.5 * (s.upper - s.lower).norm()};
}
Ball ball_around(const SampledShape& s) {
  const Vec3 half = 0.5 * s.spacing * Vec3(s.nodes[0] - 1, s.nodes[1] - 1, s.nodes[2] - 1);
  return {s.origin + half, half.norm()};
}

/// Where a ray may meet a shape, ahead of the eye; leave <= enter where it cannot.
struct Span {
  double enter = 0.0, leave = 0.0;
};

/// Where the ray is inside a ball around the shape.
template <class Shape>
Span span_of(const Shape& shape, const Vec3& eye, const Vec3& ray) {
  const Ball ball = ball_around(shape);
  const Vec3 d = eye - ball.center;
  const double a = ray.squaredNorm(), b = d.dot(ray), c = d.squaredNorm() - ball.radius * ball.radius;
  const double root2 = b * b - a * c;
  if (root2 <= 0.0) return {};
  const double root = std::sqrt(root2);
  return {std::max(0.0, (-b - root) / a), (-b + root) / a};
}

/// A plane is met at once: a march towards it is slow for rays that hardly sink.
Span span_of(const PlaneShape& plane, const Vec3& eye, const Vec3& ray) {
  const double height = (eye - plane.point).dot(plane.normal), sinking = -ray.dot(plane.normal);
  return sinking > 0.0 ? Span{height / sinking, INFINITY} : Span{};
}

/// Distance along the ray to the surface; infinite where it is not met before `leave`.
double first_hit(const Obstacle& obstacle, const Camera& camera, const Vec3& ray, Span span) {
  constexpr int kMostSteps = 400;
  constexpr double kPixels = 0.3;  // nearer than this share of a pixel counts as met
  const double length = ray.norm();
  double t = span.enter;
  for (int step = 0; step < kMostSteps && t < span.leave; ++step) {
    const double distance = sample_distance(obstacle, camera.eye + t * ray).distance;
    // Close to the eye a pixel is smaller than rounding.
    if (distance <= std::max(kPixels * t / camera.focal, 1e-9)) return t;
    t += distance / length;
  }
  return INFINITY;
}

}  // namespace

void draw_obstacle(const Camera& camera, Canvas& canvas, const Obstacle& obstacle) {
  if (sample_distance(obstacle, camera.eye).distance <= 0.0) return;
  const Vec3 eye = obstacle.pose.body(camera.eye);
  const Vec3& color = std::holds_alternative<PlaneShape>(obstacle.shape) ? kGround : kBody;
  parallel_for(static_cast<std::size_t>(camera.height), 4, [&](std::size_t row) {
    for (int px = 0; px < camera.width; ++px) {
      const std::size_t at = px + std::size_t(camera.width) * row;
      const Vec3 ray = camera.ray(px, static_cast<int>(row));
      Span span =
          std::visit([&](const auto& shape) { return span_of(shape, eye, obstacle.pose.turn.transpose() * ray); },
                     obstacle.shape);
      span.leave = std::min(span.leave, canvas.depth[at]);
      if (span.leave <= span.enter) continue;
      const double depth = first_hit(obstacle, camera, ray, span);
      if (!(depth < canvas.depth[at])) continue;
      canvas.depth[at] = depth;
      canvas.color[at] = shade(sample_distance(obstacle, camera.eye + depth * ray).gradient) * color;
    }
  });
}

}  // namespace wick::scenes
