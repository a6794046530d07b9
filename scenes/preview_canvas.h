#pragma once
/// What the parts of a preview are drawn with: the camera, the canvas and the light.
#include <cmath>
#include <vector>

#include "core/types.h"
#include "scenes/preview.h"

namespace wick::scenes {

struct Camera {
  Vec3 eye, right, up, forward;
  double focal;  ///< pixels per unit of tangent
  int width, height;

  explicit Camera(const PreviewParams& p) : eye(p.from), width(p.size[0]), height(p.size[1]) {
    forward = (p.at - p.from).normalized();
    right = forward.cross(Vec3::UnitZ());
    // Looking straight down or up, any right will do.
    right = right.norm() > 1e-6 ? right.normalized() : Vec3::UnitX();
    up = right.cross(forward);
    focal = 0.5 * height / std::tan(0.5 * p.view_angle * M_PI / 180.0);
  }
  /// x, y in pixels, z the distance along the view direction.
  [[nodiscard]] Vec3 project(const Vec3& x) const {
    const Vec3 d = x - eye;
    const double depth = d.dot(forward);
    return {0.5 * width + focal * d.dot(right) / depth, 0.5 * height - focal * d.dot(up) / depth, depth};
  }
  /// Ray through the middle of a pixel; its length is 1 along the view direction.
  [[nodiscard]] Vec3 ray(int px, int py) const {
    return forward + ((px + 0.5 - 0.5 * width) * right - (py + 0.5 - 0.5 * height) * up) / focal;
  }
};

/// Colour and depth of what is opaque.
struct Canvas {
  std::vector<Vec3> color;
  std::vector<double> depth;
};

inline const Vec3 sun = Vec3(-0.4, -0.7, 0.9).normalized();  ///< direction to the light

}  // namespace wick::scenes
