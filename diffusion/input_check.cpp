#include "diffusion/input_check.h"

#include <cmath>
#include <limits>
#include <string>

#include "core/require.h"
#include "diffusion/sums.h"

namespace wick::diffusion {

namespace {

/// Refuses values that are not finite, or below `least`, before they reach a solver.
void require_values(const double* values, std::size_t count, double least, const char* what) {
  const double worst = parallel_max(count, chunk, 0.0, [&](std::size_t begin, std::size_t end) {
    bool bad = false;
    for (std::size_t i = begin; i < end; ++i)
      bad |= !(std::abs(values[i]) <= std::numeric_limits<double>::max() && values[i] >= least);
    return bad ? 1.0 : 0.0;
  });
  if (worst > 0.0)
    throw Refusal(ExitCode::numerical_failure, "/diffusion",
                  std::string("diffusion was given a bad ") + what +
                      " (not finite, or negative) reduce the time step or the loads");
}

}  // namespace

void require_input(const std::vector<double>& u, const DiffusionInput& in, double dt) {
  constexpr double any = -1e300;
  const std::size_t n = in.mesh->vertex_count();
  if (u.size() != n || in.x->size() != n || in.mass->size() != n || !(dt >= 0.0))
    throw Refusal(ExitCode::internal_fault, "/diffusion",
                  "diffusion was given fields of the wrong size or a negative time step");
  require_values(u.data(), n, any, "u");
  require_values(n > 0 ? in.x->front().data() : nullptr, 3 * n, any, "position");
  require_values(in.gravity.data(), 3, any, "gravity");
  require_values(in.mass->data(), n, 0.0, "mass");
  if (in.loss != nullptr) require_values(in.loss->data(), n, 0.0, "loss");
  if (in.supply_rate != nullptr) require_values(in.supply_rate->data(), n, 0.0, "supply rate");
  if (in.supply_value != nullptr) require_values(in.supply_value->data(), n, 0.0, "supply value");
  if (in.amount != nullptr) require_values(in.amount->data(), n, any, "amount");
}

}  // namespace wick::diffusion
