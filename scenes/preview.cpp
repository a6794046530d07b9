#include "scenes/preview.h"

#include <png.h>

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/parameters.h"
#include "core/require.h"
#include "scenes/preview_canvas.h"
#include "scenes/preview_obstacles.h"
#include "scenes/sheet_color.h"

namespace wick::scenes {

namespace {

const Vec3 kSkyTop(0.30, 0.34, 0.40), kSkyBottom(0.62, 0.62, 0.60);
const Vec3 kSmokeColor(0.75, 0.73, 0.70);

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

/// The eight cells around a place and their trilinear weights; built once for all fields.
struct Stencil {
  std::array<std::size_t, 8> cell;
  std::array<float, 8> weight;

  /// `q` is in cells, the centre of cell (0,0,0) is 0.
  Stencil(const fluid::Grid& g, const Vec3& q) {
    const int n[3] = {g.nx, g.ny, g.nz};
    int low[3], high[3];
    double f[3];
    for (int a = 0; a < 3; ++a) {
      const double c = std::clamp(q[a], 0.0, n[a] - 1.0);
      low[a] = static_cast<int>(c);
      high[a] = std::min(low[a] + 1, n[a] - 1);
      f[a] = c - low[a];
    }
    for (int corner = 0; corner < 8; ++corner) {
      const bool x = corner & 1, y = corner & 2, z = corner & 4;
      cell[corner] = g.cell(x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
      weight[corner] = static_cast<float>((x ? f[0] : 1 - f[0]) * (y ? f[1] : 1 - f[1]) * (z ? f[2] : 1 - f[2]));
    }
  }
  [[nodiscard]] double sample(const fluid::CellField& field) const {
    float value = 0.0F;
    for (int corner = 0; corner < 8; ++corner) value += weight[corner] * field[cell[corner]];
    return value;
  }
};

/// Which blocks of 8^3 cells, or their neighbours, hold anything to see: rays leap over the others.
class Occupancy {
 public:
  static constexpr int kBlock = 8;

  Occupancy(const fluid::Grid& g, const fluid::SmokeState& gas, double least_density)
      : nx_((g.nx + kBlock - 1) / kBlock),
        ny_((g.ny + kBlock - 1) / kBlock),
        nz_((g.nz + kBlock - 1) / kBlock),
        seen_(std::size_t(nx_) * ny_ * nz_, 0) {
    for (int k = 0; k < g.nz; ++k)
      for (int j = 0; j < g.ny; ++j)
        for (int i = 0; i < g.nx; ++i) {
          const std::size_t c = g.cell(i, j, k);
          // A sample mixes neighbouring cells, so a cell shows up to one cell beyond its own block.
          if (gas.density[c] > least_density || gas.flame[c] > 1e-3F) mark(i, j, k);
        }
  }
  [[nodiscard]] bool at(const Vec3& q) const {
    const auto block = [](double v, int n) { return std::clamp(static_cast<int>(v) / kBlock, 0, n - 1); };
    return seen_[block(q.x(), nx_) +
                 std::size_t(nx_) * (block(q.y(), ny_) + std::size_t(ny_) * block(q.z(), nz_))] != 0;
  }

 private:
  void mark(int i, int j, int k) {
    for (int z = std::max(k - 1, 0) / kBlock; z <= std::min((k + 1) / kBlock, nz_ - 1); ++z)
      for (int y = std::max(j - 1, 0) / kBlock; y <= std::min((j + 1) / kBlock, ny_ - 1); ++y)
        for (int x = std::max(i - 1, 0) / kBlock; x <= std::min((i + 1) / kBlock, nx_ - 1); ++x)
          seen_[x + std::size_t(nx_) * (y + std::size_t(ny_) * z)] = 1;
  }
  int nx_, ny_, nz_;
  std::vector<std::uint8_t> seen_;
};

/// Optical depth from every cell straight up to the top of the box: how much light the smoke above leaves.
fluid::CellField shadow_depth(const fluid::Grid& g, const fluid::CellField& density, double extinction) {
  fluid::CellField shadow(g.cells(), 0.0F);
  parallel_for(static_cast<std::size_t>(g.ny), 4, [&](std::size_t j) {
    for (int k = g.nz - 2; k >= 0; --k)
      for (int i = 0; i < g.nx; ++i) {
        const std::size_t c = g.cell(i, static_cast<int>(j), k), above = g.cell(i, static_cast<int>(j), k + 1);
        shadow[c] = shadow[above] + static_cast<float>(extinction * g.h) * density[above];
      }
  });
  return shadow;
}

/// Distances at which a ray enters and leaves the box; empty when leave <= enter.
std::pair<double, double> clip_to_box(const fluid::Grid& g, const Vec3& eye, const Vec3& ray) {
  const Vec3 high = g.origin + g.h * Vec3(g.nx, g.ny, g.nz);
  double enter = 0.0, leave = INFINITY;
  for (int a = 0; a < 3; ++a) {
    const double one = (g.origin[a] - eye[a]) / ray[a], two = (high[a] - eye[a]) / ray[a];
    enter = std::max(enter, std::min(one, two));
    leave = std::min(leave, std::max(one, two));
  }
  return {enter, leave};
}

/// Yellow core to red rim.
Vec3 flame_color(double flame) {
  return Vec3(1.0, 0.22 + 0.42 * flame, 0.03 + 0.12 * flame * flame);
}

/// Light that one ray gathers in the gas between t and leave, and how much of what lies behind shows through.
struct Gathered {
  Vec3 light = Vec3::Zero();
  double clear = 1.0;
};

class GasPainter {
 public:
  GasPainter(const PreviewParams& p, const fluid::SmokeState& gas, const fluid::SmokeParams& params)
      : grid_(fluid::smoke_grid(params)),
        gas_(gas),
        extinction_(p.smoke_extinction),
        shadow_(shadow_depth(grid_, gas.density, p.smoke_extinction)),
        // Less than a thousandth of the light over ten cells is not worth a sample.
        occupancy_(grid_, gas, 1e-4 / (std::max(p.smoke_extinction, 1e-9) * grid_.h)) {}

  [[nodiscard]] Gathered march(const Vec3& eye, const Vec3& ray, double behind) const {
    constexpr double kFlameGlow = 14.0;  // radiance per metre of full flame
    Gathered gathered;
    auto [t, leave] = clip_to_box(grid_, eye, ray);
    leave = std::min(leave, behind);
    const double length = 0.8 * grid_.h, step = length / ray.norm();
    for (t += 0.5 * step; t < leave && gathered.clear > 0.005; t += step) {
      const Vec3 q = (eye + t * ray - grid_.origin) / grid_.h - Vec3::Constant(0.5);
      if (!occupancy_.at(q)) continue;
      const Stencil stencil(grid_, q);
      const double density = stencil.sample(gas_.density), flame = stencil.sample(gas_.flame);
      if (density <= 0.0 && flame <= 1e-3) continue;
      const double pass = std::exp(-extinction_ * std::max(density, 0.0) * length);
      const double lit = 0.35 + 0.65 * std::exp(-0.5 * stencil.sample(shadow_));
      gathered.light +=
          gathered.clear * ((1.0 - pass) * lit * kSmokeColor + length * kFlameGlow * flame * flame_color(flame));
      gathered.clear *= pass;
    }
    return gathered;
  }

 private:
  fluid::Grid grid_;
  const fluid::SmokeState& gas_;
  double extinction_;
  fluid::CellField shadow_;
  Occupancy occupancy_;
};

void draw_gas(const PreviewParams& p, const Camera& camera, Canvas& canvas, const fluid::SmokeState& gas,
              const fluid::SmokeParams& params) {
  const GasPainter painter(p, gas, params);
  parallel_for(static_cast<std::size_t>(camera.height), 4, [&](std::size_t row) {
    for (int px = 0; px < camera.width; ++px) {
      const std::size_t at = px + std::size_t(camera.width) * row;
      const Gathered gathered = painter.march(camera.eye, camera.ray(px, static_cast<int>(row)), canvas.depth[at]);
      canvas.color[at] = gathered.clear * canvas.color[at] + gathered.light;
    }
  });
}

/// Soft shoulder above 0.8, then the sRGB curve.
std::uint8_t encode(double v) {
  v = std::max(v, 0.0);
  if (v > 0.8) v = 0.8 + 0.2 * std::tanh((v - 0.8) / 0.4);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(s, 0.0, 1.0)));
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
                     const std::vector<Obstacle>& obstacles, const fluid::SmokeState* smoke,
                     const fluid::SmokeParams* smoke_params) {
  const Camera camera(p);
  const std::size_t pixels = std::size_t(camera.width) * camera.height;
  Canvas canvas{std::vector<Vec3>(pixels), std::vector<double>(pixels, INFINITY)};
  for (std::size_t n = 0; n < pixels; ++n) {
    const double t = static_cast<double>(n / camera.width) / camera.height;
    canvas.color[n] = (1.0 - t) * kSkyTop + t * kSkyBottom;
  }
  for (const coupling::ShellView& view : shells) draw_sheet(camera, canvas, view);
  for (const Obstacle& obstacle : obstacles) draw_obstacle(camera, canvas, obstacle);
  if (smoke) draw_gas(p, camera, canvas, *smoke, *smoke_params);
  Picture picture{camera.width, camera.height, std::vector<std::uint8_t>(3 * pixels)};
  for (std::size_t n = 0; n < pixels; ++n)
    for (int c = 0; c < 3; ++c) picture.rgb[3 * n + c] = encode(canvas.color[n][c]);
  return picture;
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
