#pragma once
/// Small pictures of a frame, made on the CPU while the scene runs: enough to judge a fire without a renderer.
/// Sheets and obstacles are drawn with a depth buffer, gas by marching rays through density and flame.
#include <cstdint>
#include <string>
#include <vector>

#include "coupling/world.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::scenes {

struct PreviewParams {
  bool write = false;
  Int2 size = {480, 640};            ///< width, height [pixels]
  Vec3 from = Vec3(0.5, -2.2, 0.8);  ///< eye [m]
  Vec3 at = Vec3(0.5, 0.5, 0.65);    ///< looked at [m]
  double view_angle = 34.0;          ///< vertical [degrees]
  double smoke_extinction = 3000.0;  ///< [m2/kg]; soot of flames has about 8000
};
void describe(ParameterVisitor& visitor, PreviewParams& params);

/// RGB, top row first.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Draws the world as it is. `smoke` is null for a scene without gas.
Picture draw_preview(const PreviewParams& params, const std::vector<coupling::ShellView>& shells,
                     const coupling::EmberView& embers, const std::vector<Obstacle>& obstacles,
                     const fluid::SmokeState* smoke, const fluid::SmokeParams* smoke_params);

/// The picture as the bytes of a PNG file.
std::vector<char> encode_png(const Picture& picture);

}  // namespace wick::scenes
