#pragma once
/// How burning looks on a sheet: paper white through brown to black with char, glowing where it is hot.
#include <vector>

#include "coupling/world.h"

namespace wick::scenes {

struct SheetColor {
  Vec3 reflected;  ///< linear RGB, share of the light that comes back
  Vec3 emitted;    ///< linear RGB of the glow
};

/// One colour a vertex, from the `char`, `temperature` and `saturation` values that the sheet has.
std::vector<SheetColor> sheet_colors(const coupling::ShellView& view);

/// Linear RGB of char that has burnt out.
Vec3 ash_color();
/// Linear RGB of the glow at a temperature [K].
Vec3 glow_color(double kelvin);

}  // namespace wick::scenes
