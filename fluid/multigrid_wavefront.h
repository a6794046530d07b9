#pragma once
#include "core/function_ref.h"

namespace wick::fluid {

/// Runs body(stage, plane) for all stages and planes in an order in which stage s of plane k follows stage
/// s - 1 of planes k - 1, k and k + 1, and precedes stage s + 1 of those: what fused red and black passes
/// need. Each thread goes once through its own planes with all stages (a trapezoid), so that they stay in
/// its cache; the wedges where trapezoids meet follow. A stage may read what the stage before wrote in the
/// neighbouring planes, but not what its own stage wrote there: the result then depends on neither the
/// order nor the number of threads.
void wavefront(int planes, int stages, bool parallel, FunctionRef<void(int stage, int plane)> body);

}  // namespace wick::fluid
