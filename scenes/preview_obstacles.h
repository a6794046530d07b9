#pragma once
/// Obstacles in a preview, whatever their shape: rays march along the signed distance that sheets collide with, so
/// the picture shows what the simulation meets.
#include "core/obstacle.h"
#include "scenes/preview_canvas.h"

namespace wick::scenes {

/// Draws what of the obstacle is in front of the canvas's depth. One that holds the eye is left out.
void draw_obstacle(const Camera& camera, Canvas& canvas, const Obstacle& obstacle);

}  // namespace wick::scenes
