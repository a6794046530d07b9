#pragma once
/// Lines, areas and words on a picture, through Cairo.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/types.h"
#include "scenes/preview.h"

namespace wick::scenes {

using Rgb = std::array<double, 3>;  ///< 0..1

class Canvas2d {
 public:
  Canvas2d(int width, int height);
  ~Canvas2d();
  Canvas2d(const Canvas2d&) = delete;
  Canvas2d& operator=(const Canvas2d&) = delete;

  /// Triangle with colours that run linearly between its corners; pixels.
  void triangle(const std::array<Vec2, 3>& p, const std::array<Rgb, 3>& color);
  void line(const std::vector<Vec2>& points, bool closed, const Rgb& color, double width);
  void dot(const Vec2& p, const Rgb& color, double radius);
  /// `align` 0: p is the left end of the words, 0.5 their middle, 1 their right end; on the base line.
  void text(const Vec2& p, const std::string& words, double size, double align = 0.0, bool upright = false);
  [[nodiscard]] Picture picture();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::scenes
