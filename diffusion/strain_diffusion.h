#pragma once
/// The paper's solver: implicit diffusion on the deformed sheet, strain added on the front only, total
/// rescaled to a target [Kim & Lee 2017, Eqs (1)-(8)], with every ambiguity as a named option.
///
///   (8a)  (M + dt alpha Ls + dt K_loss + dt K_supply) u* = M u + dt K_supply u_src + f      supply, diffusion
///   (8b)  U* = sum M u*
///   (8c)  v = u* + C on the front u_min <= u* <= u_max, v = u* elsewhere
///   (8d-g) u = v * (sigma U* / sum M v), over the chosen scope, then the capacity
///
/// So as printed (order after). The default (order inside) is its limit for short steps, where C = dt kappa c and
/// r = 1 / (1 + toll): gain and toll are rates of the same implicit step, with the front that it begins with,
///   (M + dt alpha Ls + dt K_loss + dt K_supply + M toll) u = M u_old + M C + dt K_supply u_src + f,
///   toll = w K(M C / D),  D = K(M u_old w),  K the sum or the mean over the scope, w what pays: sum M C = sum M
///   toll u.
///
/// u is intensive (saturation, or temperature over ambient in units of the ignition range), M_i = amount that
/// vertex i holds at u = 1 [kg or J].
#include <memory>
#include <vector>

#include "core/report.h"
#include "diffusion/comparison_params.h"
#include "solid/shell_mesh.h"

namespace wick::diffusion {

enum class Preset { burning, wetting, literal };
/// How u moves over the sheet: the paper's method, and what it is compared with.
enum class Model {
  isotropic,             ///< no strain; also the diffusion of burning shells in [Jeong 2011]
  strain_constrained,    ///< Eq (8)
  strain_unconstrained,  ///< Eq (7): C everywhere, no rescaling
  porous,                ///< capillary, pore pressure, Darcy flow [Lenaerts 2008]
  diffuse_gravity,       ///< saturation differences and gravity along the edges [Patkar 2013]
  noise,                 ///< Eq (8) with noise in place of strain
  strain_noise,          ///< Eq (8) with strain times noise
  tensor                 ///< a diffusion tensor that follows the principal stretches
};
enum class Operator { cotan, umbrella, graph };
enum class Metric { rest, current };
enum class Measure { invariant, orthotropic };
enum class Reference { original, current };
enum class Gain { density, literal };
enum class Order { inside, after };  // C and its toll through the solve (8a), or after it (8c-8g)
enum class SigmaMode { rate, per_step, influx };
enum class Total { area, plain };
enum class Scope { global, component, front, local, local_front };
/// Whether the rescaling acts within scope_radius only.
inline bool is_local(Scope scope) {
  return scope == Scope::local || scope == Scope::local_front;
}

struct DiffusionParams {
  Preset preset = Preset::burning;
  Model model = Model::strain_constrained;
  Operator discretisation = Operator::cotan;
  double umbrella_factor = 2.0;  ///< 1: literal Eq (3), whose mean diffusivity is alpha/2; 2: nominal alpha
  bool clamp_weights = true;     ///< cotan weights below 0 become 0: keeps the maximum principle on obtuse meshes
  Metric metric = Metric::rest;
  double alpha = 2.5e-3;    ///< diffusivity [m2/s]
  int sharpness = 0;        ///< m of the porous-medium flux div((m+1) u^m grad u); 0 linear, 2 sharp
  int picard = 3;           ///< sweeps per step when sharpness > 0
  double tolerance = 1e-8;  ///< relative residual of the linear solves
  // strain
  Measure measure = Measure::invariant;
  Reference reference = Reference::original;
  bool tension_only = false;
  double delta = 0.0;  ///< weakening: lambda = 1/(1+delta)
  Gain gain_form = Gain::density;
  double gain = 500.0;        ///< kappa: rate of u per unit c [1/s] (density), or per m2 and step (literal)
  double bending_gain = 0.0;  ///< lambda_b h_b^2 of S_b = lambda_b h_b^2 (kappa_1 + kappa_2 - H_0)^2 [m2]; 0: off
  // front
  double u_min = 0.05, u_max = 0.6;
  double front_ramp = 0.0;  ///< range of u over which the front sets in above u_min and fades below u_max; 0: hard
  double virgin = 0.3;      ///< the band takes only vertices whose fraction left (mu) exceeds this; 0: all
  Order order = Order::inside;
  // rescale
  Scope scope = Scope::front;
  double scope_radius = 0.05;  ///< R of local and local_front [m]
  double sigma = 1.0;
  SigmaMode sigma_mode = SigmaMode::rate;
  double sigma_tau = 1.0;  ///< [s]
  Total total = Total::area;
  double capacity = 0.0;  ///< cap on u; 0: none
  // comparison models
  NoiseParams noise;
  PorousParams porous;
  GravityTransportParams gravity_transport;
  double tensor_gain = 2.0;  ///< k_t of D = alpha (I + k_t (U - I)), U the right stretch
};
/// The forms and defaults of one preset. Rule for the gain: kappa = 0.4 Pi/(c_mean t) with c_mean the mean of c
/// under the expected load, t half the time of the run and Pi the strength (0.1 invisible, 1-3 visible, 10-30
/// strong).
///   burning  front scope over unburnt cells, kappa c = 1.5 /s at c = 0.003 (Pi = 3)
///   wetting  local front scope of 5 cm, sigma on the influx, kappa c = 4 /s at c = 0.003 (Pi = 10)
///   literal  the article as printed: depends on time step and mesh
DiffusionParams make_preset(Preset preset);
/// Lists the preset first; choosing one resets every other field to that preset before they are read.
void describe(ParameterVisitor& visitor, DiffusionParams& params);

/// One scalar on one sheet, as the world hands it over. Spans may be empty where a default is named.
struct DiffusionInput {
  const solid::ShellMesh* mesh = nullptr;             ///< alive triangles
  const std::vector<Vec3>* x = nullptr;               ///< current positions
  const std::vector<double>* rest_scale = nullptr;    ///< per triangle, for Reference::current; null: 1
  const std::vector<double>* mass = nullptr;          ///< M_i; 0 for orphans
  const std::vector<double>* loss = nullptr;          ///< implicit loss K_i [M units / s]; null: none
  const std::vector<double>* supply_rate = nullptr;   ///< Robin supply k_i [M units / s]; null: none
  const std::vector<double>* supply_value = nullptr;  ///< u_src,i towards which supply_rate pulls
  const std::vector<double>* amount = nullptr;  ///< explicit f_i, amount added this step [M units]; null: none
  const std::vector<double>* fraction_left = nullptr;  ///< mu_i for `virgin`; null: 1
  double capacity = 0.0;                               ///< cap on u; 0: none
  Vec3 gravity = Vec3::Zero();                         ///< [m/s2], for the models that it drives
};

struct DiffusionReport {
  double before = 0.0;        ///< sum M u on entry
  double supplied = 0.0;      ///< by supply and amount (either sign)
  double lost = 0.0;          ///< by loss (>= 0 for u >= 0)
  double sigma_source = 0.0;  ///< (sigma_eff - 1) U*, or its counterpart in other modes; includes `drift`
  double drift = 0.0;         ///< part of it that operators and totals not weighted by M create (0 for cotan, area)
  double excess = 0.0;        ///< refused by the capacity: returned to the caller, no longer on the sheet
  double after = 0.0;         ///< sum M u on return = before + supplied - lost + sigma_source - excess
  double strain_added = 0.0;  ///< sum M C on the front before rescaling
  double rescale = 1.0;       ///< r, the smallest factor used
  std::size_t front_vertices = 0;
  std::size_t misjudged = 0;  ///< vertices of pieces that were taken as printed, the step being too long for them
  SolveReport solve;
  double seconds_solve = 0.0, seconds_strain = 0.0;
};

/// Keeps matrix pattern, factors and scratch of one topology alive.
class DiffusionSolver {
 public:
  explicit DiffusionSolver(const DiffusionParams& params);
  ~DiffusionSolver();
  DiffusionSolver(DiffusionSolver&&) noexcept;
  DiffusionSolver& operator=(DiffusionSolver&&) noexcept;

  /// Advances u (V) by dt.
  DiffusionReport step(std::vector<double>& u, const DiffusionInput& input, double dt);

  /// C_i of the last step before diffusion and masking with the front, and S per triangle: for output and metrics
  /// (filled for the isotropic model as well, which does not use them).
  [[nodiscard]] const std::vector<double>& strain_vertex() const;
  [[nodiscard]] const std::vector<double>& strain_triangle() const;
  /// Amount that supply and `amount` gave each vertex in the last step [M units]; sums to
  /// DiffusionReport::supplied.
  [[nodiscard]] const std::vector<double>& supplied_vertex() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::diffusion
