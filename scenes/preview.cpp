#include "scenes/preview.h"

#include <png.h>

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/parameters.h"
#include "core/require.h"
#include "scenes/preview_canvas.h"
#include "scenes/preview_gas.h"
#include "scenes/preview_obstacles.h"
#include "scenes/sheet_color.h"

namespace wick::scenes {

namespace {

const Vec3 kSkyTop(0.30, 0.34, 0.40), kSkyBottom(0.62, 0.62, 0.60);

/// Sheets are lit on both sides.
double shade(const Vec3& normal) {
  return 0.35 + 0.65 * std::abs(normal.dot(sun));
}

/// Fills one triangle: barycentric colour, depth test on 1/z.
void draw_triangle(const Camera& camera, Canvas& canvas, const std::array<Vec3, 3>& x,
                   const std::array<Vec3, 3>& lit) {
  std::array<Vec3, 3> p;
  for (int k = 0; k < 3; ++k) {
    p[k] = camera.project(x[k]);
    if (!(p[k].z() > 1e-3)) return;  // behind the eye
  }
  const double area = (p[1].x() - p[0].x()) * (p[2].y() - p[0].y()) - (p[1].y() - p[0].y()) * (p[2].x() - p[0].x());
  if (area == 0.0 || !std::isfinite(area)) return;
  const auto bound = [](double v, int limit) { return static_cast<int>(std::clamp(v, 0.0, double(limit))); };
  const int left = bound(std::min({p[0].x(), p[1].x(), p[2].x()}) - 0.5, camera.width);
  const int right = bound(std::max({p[0].x(), p[1].x(), p[2].x()}) + 0.5, camera.width - 1);
  const int top = bound(std::min({p[0].y(), p[1].y(), p[2].y()}) - 0.5, camera.height);
  const int bottom = bound(std::max({p[0].y(), p[1].y(), p[2].y()}) + 0.5, camera.height - 1);
  for (int py = top; py <= bottom; ++py)
    for (int px = left; px <= right; ++px) {
      std::array<double, 3> w;
      for (int k = 0; k < 3; ++k) {
        const Vec3 &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
        w[k] = ((b.x() - a.x()) * (py + 0.5 - a.y()) - (b.y() - a.y()) * (px + 0.5 - a.x())) / area;
      }
      if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
      const double depth = 1.0 / (w[0] / p[0].z() + w[1] / p[1].z() + w[2] / p[2].z());
      const std::size_t at = px + std::size_t(camera.width) * py;
      if (depth >= canvas.depth[at]) continue;
      canvas.depth[at] = depth;
      canvas.color[at] = w[0] * lit[0] + w[1] * lit[1] + w[2] * lit[2];
    }
}

void draw_sheet(const Camera& camera, Canvas& canvas, const coupling::ShellView& view) {
  const std::vector<Vec3> normals = solid::vertex_normals(*view.mesh, *view.x);
  const std::vector<SheetColor> colors = sheet_colors(view);
  std::vector<Vec3> lit(colors.size());
  for (std::size_t i = 0; i < lit.size(); ++i) lit[i] = shade(normals[i]) * colors[i].reflected + colors[i].emitted;
  for (const Int3& t : view.mesh->triangles)
    draw_triangle(camera, canvas, {(*view.x)[t[0]], (*view.x)[t[1]], (*view.x)[t[2]]},
                  {lit[t[0]], lit[t[1]], lit[t[2]]});
}

/// Squares that face the eye, none smaller than a pixel.
void draw_embers(const Camera& camera, Canvas& canvas, const coupling::EmberView& view) {
  for (std::size_t n = 0; n < view.radius.size(); ++n) {
    const Vec3& x = (*view.x)[n];
    const double pixel = (x - camera.eye).dot(camera.forward) / camera.focal;
    const double half = std::max<double>(0.5 * std::sqrt(M_PI) * view.radius[n], 0.75 * pixel);
    const Vec3 right = half * camera.right, up = half * camera.up;
    const Vec3 color = ash_color() + glow_color(view.temperature[n]);
    draw_triangle(camera, canvas, {x - right - up, x + right - up, x + right + up}, {color, color, color});
    draw_triangle(camera, canvas, {x - right - up, x + right + up, x - right + up}, {color, color, color});
  }
}

/// Soft shoulder above 0.8, then the sRGB curve.
std::uint8_t encode(double v) {
  if (v > 0.8) v = 0.8 + 0.2 * std::tanh((v - 0.8) / 0.4);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(s, 0.0, 1.0)));
}

/// The colours as bytes, from a table fine enough that no dark shade is left out.
std::vector<std::uint8_t> develop(const std::vector<Vec3>& colors) {
  constexpr int kShades = 16384;
  constexpr double kBrightest = 2.0;  // encode() is within half a byte of its limit there
  std::array<std::uint8_t, kShades + 1> table;
  for (int n = 0; n <= kShades; ++n) table[n] = encode(n * kBrightest / kShades);
  std::vector<std::uint8_t> rgb(3 * colors.size());
  parallel_for(colors.size(), 4096, [&](std::size_t n) {
    for (int c = 0; c < 3; ++c)
      rgb[3 * n + c] = table[static_cast<int>(std::clamp(colors[n][c], 0.0, kBrightest) * (kShades / kBrightest))];
  });
  return rgb;
}

}  // namespace

void describe(ParameterVisitor& v, PreviewParams& p) {
  constexpr auto kAny = OnResume::may_change;
  v.flag({"write", "", any_value(), "previews/NNNN.png for every frame", kAny}, p.write);
  v.vector({"size", "pixels", between(16, 8192), "width and height", kAny}, p.size);
  v.vector({"from", "m", between(-1e5, 1e5), "where the eye is", kAny}, p.from);
  v.vector({"at", "m", between(-1e5, 1e5), "what it looks at; up is +z", kAny}, p.at);
  v.number({"view_angle", "deg", between(1, 150), "vertical", kAny}, p.view_angle);
  v.number(
      {"smoke_extinction", "m2/kg", between(0, 1e9), "how dark smoke looks; soot of flames has about 8000", kAny},
      p.smoke_extinction);
}

Picture draw_preview(const PreviewParams& p, const std::vector<coupling::ShellView>& shells,
                     const coupling::EmberView& embers, const std::vector<Obstacle>& obstacles,
                     const fluid::SmokeState* smoke, const fluid::SmokeParams* smoke_params) {
  const Camera camera(p);
  const std::size_t pixels = std::size_t(camera.width) * camera.height;
  Canvas canvas{std::vector<Vec3>(pixels), std::vector<double>(pixels, INFINITY)};
  for (std::size_t n = 0; n < pixels; ++n) {
    const double t = static_cast<double>(n / camera.width) / camera.height;
    canvas.color[n] = (1.0 - t) * kSkyTop + t * kSkyBottom;
  }
  for (const coupling::ShellView& view : shells) draw_sheet(camera, canvas, view);
  draw_embers(camera, canvas, embers);
  for (const Obstacle& obstacle : obstacles) draw_obstacle(camera, canvas, obstacle);
  if (smoke) draw_gas(p, camera, canvas, *smoke, *smoke_params);
  return {camera.width, camera.height, develop(canvas.color)};
}

std::vector<char> encode_png(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<char> bytes(size);
  const bool made = png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr) != 0;
  require(made, "", std::string("a preview could not be made into a PNG (") + image.message + ")",
          ExitCode::internal_fault);
  bytes.resize(size);
  return bytes;
}

}  // namespace wick::scenes
