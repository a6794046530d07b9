#pragma once
/// The front and the rescaling of the total [Kim 2017, Eqs 8c-8g], over the scopes that keep it from acting at a
/// distance.
#include <functional>
#include <span>
#include <vector>

#include "diffusion/overflow.h"
#include "diffusion/strain_diffusion.h"
#include "diffusion/sums.h"

namespace wick::diffusion {

/// How far each vertex belongs to the front: 1 where u_min + w <= u* <= u_max - w with w = front_ramp, falling
/// smoothly to 0 at u_min and u_max; 0 where no more than `virgin` of the material is left (null: all of it).
std::vector<double> front_band(const DiffusionParams& params, const std::vector<double>& u_star,
                               const std::vector<double>* fraction_left);

/// What a projection did.
struct Projection {
  double factor = 1.0;  ///< r
  double excess = 0.0;  ///< part of the target that the members cannot hold
};

/// Finds r >= 0 with Σ W min(cap, r v) = target over the members and applies it, exactly: the saturated set only
/// grows, so it is found in a finite number of passes. cap 0: none. All zero stays as it is.
Projection project_total(std::span<const std::int32_t> members, const std::vector<double>& weight, double target,
                         double cap, std::vector<double>& v);

/// Applies a symmetric K, near (A + R² L)^-1, to a right-hand side.
using Kernel = std::function<std::vector<double>(const std::vector<double>& rhs)>;

/// Takes the mean of C over each vertex's neighbourhood out again, in proportion to what the vertices hold:
///   v = u* + C;  D = K (M v w);  u_i = v_i - v_i w_i [K (M C / D)]_i,  so Σ M u = Σ M u*.
/// `c` is already weighted with the front; w = `taken`, the front (local_front) or 1 everywhere (local, empty).
/// Where a vertex cannot pay its share it is left with 0, and the rest is due around it in turn, for a few passes.
/// Returns the smallest factor applied.
double redistribute_locally(const std::vector<double>& mass, const std::vector<double>& c,
                            const std::vector<double>& taken, const Kernel& kernel, std::vector<double>& v);

/// Everything that the rescaling needs to know.
struct RescaleInput {
  const VertexGroups* components = nullptr;
  const VertexGroups* whole = nullptr;
  const std::vector<double>* mass = nullptr;    ///< M
  const std::vector<double>* weight = nullptr;  ///< M (area) or 1 (plain)
  const std::vector<double>* u_star = nullptr;
  const std::vector<double>* c = nullptr;       ///< weighted with the front
  const std::vector<double>* front = nullptr;   ///< 0 to 1
  const std::vector<double>* supply = nullptr;  ///< what each vertex was given this step, in units of the weight
  OverflowMap overflow;                         ///< asked by scopes that act near, where there is a capacity
  double capacity = 0.0;
  double dt = 0.0;
};

struct RescaleResult {
  double rescale = 1.0;  ///< smallest factor
  double created = 0.0;  ///< Σ of targets - U*, in units of the weight
  double excess = 0.0;   ///< in units of the weight
};

/// σ of one step: σ (per_step), σ^(dt/τ) (rate), 1 for influx, which scales the supply instead.
double step_sigma(const DiffusionParams& params, double dt);

/// Eqs (8c)-(8g): returns u in `u`, which enters as v = u* + C.
RescaleResult rescale(const DiffusionParams& params, const RescaleInput& input, const Kernel& kernel,
                      std::vector<double>& u);

}  // namespace wick::diffusion
