#pragma once
/// Pictures of experiments: sheets side by side in their material coordinates with the front drawn, and line
/// charts.
#include <functional>
#include <string>
#include <vector>

#include "diffusion/front.h"
#include "scenes/preview.h"
#include "solid/shell_mesh.h"

namespace wick::scenes {

/// Maps [0, 1] to linear steps of perceived brightness: dry paper to deep blue, or cold to glowing.
enum class ColorScale { water, fire, strain };

/// One sheet, seen from above.
struct SheetPanel {
  std::string title;
  const solid::ShellMesh* mesh = nullptr;
  std::vector<Vec3> coordinates;  ///< V; x and y are drawn
  std::vector<double> values;     ///< V
  double low = 0.0, high = 1.0;   ///< values that get the ends of the scale
  ColorScale scale = ColorScale::water;
  diffusion::Front front;  ///< drawn as a line; may be empty
};

/// Panels in rows of `columns`, each `size` pixels wide.
Picture draw_sheets(const std::vector<SheetPanel>& panels, int columns, int size = 260);

/// One curve of a chart.
struct Series {
  std::string label;
  std::vector<double> x, y;
  bool line = true;  ///< false: markers only
};

struct Chart {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
};

/// Charts side by side. Points that are not finite, or not positive on a logarithmic axis, are left out.
Picture draw_charts(const std::vector<Chart>& charts, int width = 420, int height = 320);

}  // namespace wick::scenes
