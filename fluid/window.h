#pragma once
/// The part of the box that has to be stepped: a box of cells around all smoke, heat, motion, sources and
/// walls, with a margin, in whole blocks, so that it seldom changes.
///
/// Where the window ends inside the box its sides let air through at p = 0 but carry neither smoke nor heat:
/// what a step could bring there is below the thresholds of window.cpp.
#include <optional>

#include "fluid/smoke.h"

namespace wick::fluid {

struct Window {
  Int3 low = {0, 0, 0};
  Int3 high = {0, 0, 0};  ///< one past the last cell

  [[nodiscard]] int size(int axis) const { return high[axis] - low[axis]; }
  [[nodiscard]] std::size_t cells() const { return std::size_t(size(0)) * size(1) * size(2); }
  friend bool operator==(const Window&, const Window&) = default;
};

/// The window for a step that begins at `state`, whose own window it keeps, grows or shrinks; nothing when the
/// whole box should be stepped.
std::optional<Window> choose_window(const SmokeState& state, const SmokeParams& params, const SmokeSources& sources,
                                    const Walls& walls);

/// The parameters of the window as a box of its own.
SmokeParams window_params(const SmokeParams& params, const Window& window);

SmokeState crop(const SmokeState& state, const Grid& grid, const Window& window);
/// Writes a stepped window back; velocity outside it is still.
void paste(const SmokeState& part, const Grid& grid, const Window& window, SmokeState& state);
Walls crop(const Walls& walls, const Grid& grid, const Window& window);
SmokeSources crop(const SmokeSources& sources, const Grid& grid, const Window& window);
MovableWalls crop(const MovableWalls& movable, const Grid& grid, const Window& window);

}  // namespace wick::fluid
