#pragma once
/// Gas in previews: rays march through smoke that scatters the light from above and through flame that glows.
#include "fluid/smoke.h"
#include "scenes/preview_canvas.h"

namespace wick::scenes {

/// Puts smoke and flame in front of what the canvas shows, up to the depth of every pixel.
void draw_gas(const PreviewParams& preview, const Camera& camera, Canvas& canvas, const fluid::SmokeState& gas,
              const fluid::SmokeParams& params);

/// Bytes a cell of gas that draw_gas holds at most.
inline constexpr double preview_gas_bytes_per_cell = 4 + 16;

}  // namespace wick::scenes
