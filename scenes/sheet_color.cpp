#include "scenes/sheet_color.h"

#include <algorithm>
#include <cmath>

namespace wick::scenes {

namespace {

const std::vector<float>* find_values(const coupling::ShellView& view, const std::string& name) {
  for (const auto& [key, values] : view.values)
    if (key == name) return &values;
  return nullptr;
}

/// Stops of the way from paper to char: share of the mass lost, linear RGB.
struct Stop {
  double at;
  Vec3 color;
};
const Stop kStops[] = {{0.0, Vec3(0.82, 0.79, 0.72)},     {0.06, Vec3(0.62, 0.45, 0.22)},
                       {0.2, Vec3(0.20, 0.09, 0.035)},    {0.45, Vec3(0.025, 0.018, 0.015)},
                       {0.85, Vec3(0.015, 0.014, 0.014)}, {1.0, Vec3(0.16, 0.155, 0.15)}};

Vec3 char_color(double lost) {
  lost = std::clamp(lost, 0.0, 1.0);
  for (std::size_t n = 1; n < std::size(kStops); ++n)
    if (lost <= kStops[n].at) {
      const double t = (lost - kStops[n - 1].at) / (kStops[n].at - kStops[n - 1].at);
      return (1.0 - t) * kStops[n - 1].color + t * kStops[n].color;
    }
  return kStops[std::size(kStops) - 1].color;
}

}  // namespace

Vec3 ash_color() {
  return char_color(0.85);
}

/// Red from the Draper point (798 K) on, orange and yellow as it gets hotter.
Vec3 glow_color(double kelvin) {
  const double t = std::clamp((kelvin - 798.0) / 500.0, 0.0, 2.0);
  return Vec3(1.6 * t, 0.55 * t * t, 0.08 * t * t * t);
}

std::vector<SheetColor> sheet_colors(const coupling::ShellView& view) {
  std::vector<SheetColor> colors(view.x->size(), {kStops[0].color, Vec3::Zero()});
  const std::vector<float>* lost = find_values(view, "char");
  const std::vector<float>* kelvin = find_values(view, "temperature");
  const std::vector<float>* wet = find_values(view, "saturation");
  for (std::size_t i = 0; i < colors.size(); ++i) {
    if (lost) colors[i].reflected = char_color((*lost)[i]);
    if (kelvin) colors[i].emitted = glow_color((*kelvin)[i]);
    if (wet) colors[i].reflected *= 1.0 - 0.55 * std::clamp<double>((*wet)[i], 0.0, 1.0);  // wet cloth is darker
  }
  return colors;
}

}  // namespace wick::scenes
