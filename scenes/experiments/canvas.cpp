#include "scenes/experiments/canvas.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>

namespace wick::scenes {

struct Canvas2d::Impl {
  cairo_surface_t* surface;
  cairo_t* context;
  int width, height;
};

Canvas2d::Canvas2d(int width, int height) : impl_(std::make_unique<Impl>()) {
  impl_->width = width;
  impl_->height = height;
  impl_->surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  impl_->context = cairo_create(impl_->surface);
  cairo_set_source_rgb(impl_->context, 1.0, 1.0, 1.0);
  cairo_paint(impl_->context);
  cairo_select_font_face(impl_->context, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
}

Canvas2d::~Canvas2d() {
  cairo_destroy(impl_->context);
  cairo_surface_destroy(impl_->surface);
}

void Canvas2d::triangle(const std::array<Vec2, 3>& p, const std::array<Rgb, 3>& color) {
  // Cairo leaves seams between triangles; so the pixels whose middles are inside are set here, each by one
  // triangle.
  cairo_surface_flush(impl_->surface);
  unsigned char* data = cairo_image_surface_get_data(impl_->surface);
  const int stride = cairo_image_surface_get_stride(impl_->surface);
  const Vec2 low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  const double area = (p[1] - p[0]).x() * (p[2] - p[0]).y() - (p[1] - p[0]).y() * (p[2] - p[0]).x();
  if (area == 0.0) return;
  const int y_end = static_cast<int>(std::min<double>(impl_->height, std::ceil(high.y())));
  const int x_end = static_cast<int>(std::min<double>(impl_->width, std::ceil(high.x())));
  for (int y = std::max(0, static_cast<int>(std::floor(low.y()))); y < y_end; ++y)
    for (int x = std::max(0, static_cast<int>(std::floor(low.x()))); x < x_end; ++x) {
      const Vec2 q(x + 0.5, y + 0.5);
      std::array<double, 3> w;
      for (int k = 0; k < 3; ++k) {
        const Vec2 a = p[(k + 1) % 3] - q, b = p[(k + 2) % 3] - q;
        w[k] = (a.x() * b.y() - a.y() * b.x()) / area;
      }
      // A little more than inside, so that no pixel between two triangles is missed.
      if (std::min({w[0], w[1], w[2]}) < -1e-9) continue;
      unsigned char* pixel = data + static_cast<std::ptrdiff_t>(y) * stride + 4 * static_cast<std::ptrdiff_t>(x);
      for (int c = 0; c < 3; ++c) {
        const double value = w[0] * color[0][c] + w[1] * color[1][c] + w[2] * color[2][c];
        pixel[2 - c] = static_cast<unsigned char>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
      }
    }
  cairo_surface_mark_dirty(impl_->surface);
}

void Canvas2d::line(const std::vector<Vec2>& points, bool closed, const Rgb& color, double width) {
  if (points.size() < 2) return;
  cairo_t* c = impl_->context;
  cairo_set_source_rgb(c, color[0], color[1], color[2]);
  cairo_set_line_width(c, width);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_move_to(c, points[0].x(), points[0].y());
  for (const Vec2& p : points) cairo_line_to(c, p.x(), p.y());
  if (closed) cairo_close_path(c);
  cairo_stroke(c);
}

void Canvas2d::dot(const Vec2& p, const Rgb& color, double radius) {
  cairo_set_source_rgb(impl_->context, color[0], color[1], color[2]);
  cairo_arc(impl_->context, p.x(), p.y(), radius, 0.0, 2.0 * M_PI);
  cairo_fill(impl_->context);
}

void Canvas2d::text(const Vec2& p, const std::string& words, double size, double align, bool upright) {
  cairo_t* c = impl_->context;
  cairo_text_extents_t extents;
  cairo_set_font_size(c, size);
  cairo_text_extents(c, words.c_str(), &extents);
  cairo_save(c);
  cairo_set_source_rgb(c, 0.1, 0.1, 0.1);
  cairo_translate(c, p.x(), p.y());
  if (upright) cairo_rotate(c, -0.5 * M_PI);
  cairo_move_to(c, -align * extents.x_advance, 0.0);
  cairo_show_text(c, words.c_str());
  cairo_restore(c);
}

Picture Canvas2d::picture() {
  cairo_surface_flush(impl_->surface);
  const unsigned char* data = cairo_image_surface_get_data(impl_->surface);
  const int stride = cairo_image_surface_get_stride(impl_->surface);
  Picture result{impl_->width, impl_->height, {}};
  result.rgb.reserve(3 * static_cast<std::size_t>(impl_->width) * static_cast<std::size_t>(impl_->height));
  for (int y = 0; y < impl_->height; ++y)
    for (int x = 0; x < impl_->width; ++x)
      for (int k = 2; k >= 0; --k)
        result.rgb.push_back(
            data[static_cast<std::ptrdiff_t>(y) * stride + 4 * static_cast<std::ptrdiff_t>(x) + k]);
  return result;
}

}  // namespace wick::scenes
