#include "scenes/experiments/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/experiments/canvas.h"

namespace wick::scenes {

namespace {

Rgb mix(const std::vector<Rgb>& stops, double t) {
  const double at = std::clamp(t, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto k = std::min(stops.size() - 2, static_cast<std::size_t>(at));
  const double share = at - static_cast<double>(k);
  Rgb color;
  for (int c = 0; c < 3; ++c) color[c] = (1.0 - share) * stops[k][c] + share * stops[k + 1][c];
  return color;
}

Rgb scale_color(ColorScale scale, double t) {
  static const std::vector<Rgb> water = {{.96, .94, .88}, {.62, .79, .88}, {.26, .55, .80}, {.05, .24, .52}};
  static const std::vector<Rgb> fire = {
      {.96, .93, .85}, {.98, .78, .35}, {.87, .34, .10}, {.35, .06, .05}, {.08, .06, .06}};
  static const std::vector<Rgb> strain = {{.97, .97, .97}, {.74, .84, .70}, {.36, .62, .42}, {.07, .30, .22}};
  switch (scale) {
    case ColorScale::water:
      return mix(water, t);
    case ColorScale::fire:
      return mix(fire, t);
    case ColorScale::strain:
      break;
  }
  return mix(strain, t);
}

void draw_panel(Canvas2d& canvas, const SheetPanel& panel, const Vec2& corner, double size) {
  constexpr double margin = 8.0, title = 18.0;
  canvas.text(corner + Vec2(0.5 * size, 14.0), panel.title, 12.0, 0.5);
  Vec2 low = Vec2::Constant(INFINITY), high = -low;
  for (const Vec3& p : panel.coordinates) low = low.cwiseMin(p.head<2>()), high = high.cwiseMax(p.head<2>());
  const double scale = (size - 2.0 * margin) / std::max((high - low).maxCoeff(), 1e-12);
  const auto place = [&](const Vec3& p) {
    return Vec2(corner.x() + margin + scale * (p.x() - low.x()),
                corner.y() + title + margin + scale * (high.y() - p.y()));
  };
  const double range = panel.high > panel.low ? panel.high - panel.low : 1.0;
  for (const Int3& v : panel.mesh->triangles) {
    std::array<Vec2, 3> p;
    std::array<Rgb, 3> color;
    for (int k = 0; k < 3; ++k) {
      p[k] = place(panel.coordinates[v[k]]);
      color[k] = scale_color(panel.scale, (panel.values[v[k]] - panel.low) / range);
    }
    canvas.triangle(p, color);
  }
  for (const diffusion::FrontPiece& piece : panel.front.pieces) {
    std::vector<Vec2> points;
    for (const diffusion::FrontPoint& p : piece.points) points.push_back(place(p.position));
    canvas.line(points, piece.closed, {.75, .05, .05}, 1.4);
  }
}

/// Range of one axis, and the place of a value on it.
struct Axis {
  bool log = false;
  double low = INFINITY, high = -INFINITY;
  [[nodiscard]] bool takes(double v) const { return std::isfinite(v) && (!log || v > 0.0); }
  [[nodiscard]] double linear(double v) const { return log ? std::log10(v) : v; }
  void include(double v) {
    if (takes(v)) low = std::min(low, linear(v)), high = std::max(high, linear(v));
  }
  void settle() {
    if (!(low <= high)) low = 0.0, high = 1.0;
    const double pad = high > low ? 0.05 * (high - low) : 0.5;
    low -= pad;
    high += pad;
  }
  [[nodiscard]] double share(double v) const { return (linear(v) - low) / (high - low); }
  /// Round places for labels.
  [[nodiscard]] std::vector<double> ticks() const {
    const double raw = (high - low) / 5.0, power = std::pow(10.0, std::floor(std::log10(raw)));
    double step = power * (raw / power > 5.0 ? 10.0 : raw / power > 2.0 ? 5.0 : raw / power > 1.0 ? 2.0 : 1.0);
    if (log) step = std::max(1.0, std::round(step));
    std::vector<double> at;
    for (double v = std::ceil(low / step) * step; v <= high; v += step) at.push_back(v);
    return at;
  }
  [[nodiscard]] std::string label(double v) const {
    return log ? fmt::format("1e{}", std::lround(v))
               : fmt::format("{:.3g}", std::abs(v) < 1e-12 * (high - low) ? 0.0 : v);
  }
};

const std::vector<Rgb> series_colors = {{.80, .15, .10}, {.10, .35, .70}, {.15, .55, .25}, {.60, .30, .65},
                                        {.85, .55, .05}, {.25, .25, .25}, {.05, .60, .65}, {.55, .40, .25},
                                        {.95, .55, .65}, {.55, .70, .10}};

void draw_chart(Canvas2d& canvas, const Chart& chart, const Vec2& corner, double width, double height) {
  constexpr double left = 58.0, right = 14.0, top = 26.0, bottom = 44.0, key_row = 13.0;
  const Rgb grey = {.85, .85, .85}, dark = {.3, .3, .3};
  Axis x{.log = chart.log_x}, y{.log = chart.log_y};
  for (const Series& s : chart.series) {
    for (const double v : s.x) x.include(v);
    for (const double v : s.y) y.include(v);
  }
  x.settle();
  y.settle();
  // Room above the curves for the names of many; at most half of the chart.
  if (const double names = 12.0 + key_row * static_cast<double>(chart.series.size()), plot = height - top - bottom;
      chart.series.size() > 2)
    y.high += (y.high - y.low) * (names < 0.5 * plot ? names / (plot - names) : 1.0);
  const auto place = [&](double sx, double sy) {
    return Vec2(corner.x() + left + sx * (width - left - right),
                corner.y() + height - bottom - sy * (height - top - bottom));
  };
  canvas.text(corner + Vec2(0.5 * width, 16.0), chart.title, 13.0, 0.5);
  for (const double v : x.ticks()) {
    const double s = (v - x.low) / (x.high - x.low);
    canvas.line({place(s, 0.0), place(s, 1.0)}, false, grey, 0.8);
    canvas.text(place(s, 0.0) + Vec2(0.0, 14.0), x.label(v), 10.0, 0.5);
  }
  for (const double v : y.ticks()) {
    const double s = (v - y.low) / (y.high - y.low);
    canvas.line({place(0.0, s), place(1.0, s)}, false, grey, 0.8);
    canvas.text(place(0.0, s) + Vec2(-5.0, 3.5), y.label(v), 10.0, 1.0);
  }
  canvas.line({place(0, 0), place(1, 0), place(1, 1), place(0, 1)}, true, dark, 1.0);
  canvas.text(place(0.5, 0.0) + Vec2(0.0, 32.0), chart.x_label, 11.0, 0.5);
  canvas.text(Vec2(corner.x() + 13.0, place(0.0, 0.5).y()), chart.y_label, 11.0, 0.5, true);

  for (std::size_t n = 0; n < chart.series.size(); ++n) {
    const Series& s = chart.series[n];
    const Rgb& color = series_colors[n % series_colors.size()];
    std::vector<Vec2> points;
    for (std::size_t k = 0; k < std::min(s.x.size(), s.y.size()); ++k)
      if (x.takes(s.x[k]) && y.takes(s.y[k])) points.push_back(place(x.share(s.x[k]), y.share(s.y[k])));
    if (s.line) canvas.line(points, false, color, 1.6);
    if (!s.line || points.size() < 30)
      for (const Vec2& p : points) canvas.dot(p, color, 2.6);
    const Vec2 key = place(0.0, 1.0) + Vec2(8.0, 12.0 + key_row * static_cast<double>(n));
    canvas.line({key, key + Vec2(14.0, 0.0)}, false, color, 2.0);
    canvas.text(key + Vec2(18.0, 3.5), s.label, 10.0);
  }
}

}  // namespace

Picture draw_sheets(const std::vector<SheetPanel>& panels, int columns, int size) {
  const int count = static_cast<int>(panels.size()), rows = (count + columns - 1) / columns;
  const int row_height = size + 18;
  Canvas2d canvas(std::min(count, columns) * size, rows * row_height);
  for (int n = 0; n < count; ++n)
    draw_panel(canvas, panels[static_cast<std::size_t>(n)], Vec2(n % columns * size, n / columns * row_height),
               size);
  return canvas.picture();
}

Picture draw_charts(const std::vector<Chart>& charts, int width, int height) {
  Canvas2d canvas(width * static_cast<int>(charts.size()), height);
  for (std::size_t n = 0; n < charts.size(); ++n)
    draw_chart(canvas, charts[n], Vec2(static_cast<double>(n) * width, 0.0), width, height);
  return canvas.picture();
}

}  // namespace wick::scenes
