#pragma once
/// Burning of a thin sheet: heat makes it lose mass; the lost mass heats the sheet and the gas and becomes smoke.
/// In the spirit of Jeong, Kim and Kim [2011] and Larboulette et al. [2013]; the formulas are our own.
///
///   theta = (T - T_amb)/(T_ref - T_amb)
///   threshold:  d mu/dt = -k_b clamp((theta - theta_ign)/(1 - theta_ign), 0, 1)   while mu > mu_ash
///   arrhenius:  d mu/dt = -A exp(-T_act/T) (mu - mu_ash)
///
/// mu is the fraction of the sheet's mass that is left at a vertex; both laws are integrated exactly in mu for
/// the theta of the step.
#include <cstdint>
#include <vector>

#include "solid/shell.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::coupling {

/// What a sheet is as a carrier of heat; used by every scene with a diffusion section.
struct SheetHeatParams {
  double ambient_temperature = 293.15;    ///< T_amb where there is no gas grid [K]; with one, the gas's is used
  double reference_temperature = 1100.0;  ///< T_ref, where theta = 1 [K]
  double heat_capacity = 1400.0;          ///< c of the sheet [J/(kg K)]
  double loss = 0.4;                      ///< radiation and unresolved air: rate at which theta decays [1/s]
  double convection = 20.0;               ///< h_conv between sheet and gas, per side [W/(m2 K)]
};
void describe(ParameterVisitor& visitor, SheetHeatParams& params);

enum class MassLoss { threshold, arrhenius };
/// How ash leaves a sheet: along the contour of `removal`, or in whole triangles.
enum class BurntRim { cut, whole };

struct BurningParams {
  MassLoss law = MassLoss::threshold;
  double ignition = 0.2;                  ///< theta_ign [-]
  double rate = 4.0;                      ///< k_b: fraction of the mass lost a second at theta = 1 [1/s]
  double pre_exponential = 1e6;           ///< A [1/s]
  double activation_temperature = 12000;  ///< T_act [K]
  double ash = 0.08;                      ///< mu_ash: fraction that does not burn
  double removal = 0.12;                  ///< mu_abl: what has less of its mass left falls away as ash
  BurntRim rim = BurntRim::cut;
  double rim_snap = 0.3;     ///< see CutSurface::snapping, as a share of the edges
  double ember_size = 0.01;  ///< free pieces of less than its square become embers [m]; 0: never
  double ember_life = 4.0;   ///< until an ember goes out [s]
  double sheet_heat = 1.6;   ///< eta_f: heat kept by the sheet per burnt mass, in units of c (T_ref - T_amb)
  double gas_heat = 2.0;     ///< heat given to the gas per burnt mass, same unit
  double flame_temperature = 2300.0;  ///< adiabatic, of the fuel in air: burning heats gas no further [K]
  double smoke_yield = 0.15;          ///< y_s: smoke per burnt mass; the rest is unseen gas
  double flame_rate = 0.5;            ///< loss of mass that shows as a full flame, as a fraction a second [1/s]
  double shrink = 0.8;                ///< s_min: rest length of ash relative to virgin
  double weaken = 0.15;               ///< e_min: stiffness of ash relative to virgin
  double curl = 1.0;                  ///< rest curvature of a fully burnt place is curl / curl_radius
  double curl_radius = 0.03;          ///< [m]
  double curl_noise = 0.5;  ///< share of the curl's direction that is seeded noise instead of the hotter side
  int seed = 1;
};
void describe(ParameterVisitor& visitor, BurningParams& params);

/// Burning state of one sheet, V each.
struct BurningState {
  std::vector<double> fraction_left;  ///< mu, 1 = virgin
  std::vector<double> curl;           ///< signed share of the mass lost with the +side hotter, in [-1, 1]
};
void visit(StateVisitor& visitor, BurningState& state);
BurningState make_burning_state(std::size_t vertices);

/// How far a place has burnt that has mu of its mass left: 0 virgin, 1 ash.
double burnt(double mu, const BurningParams& params);

/// Lets every vertex lose mass for dt at the given theta (V). Returns the fraction lost, V.
/// `hotter_side` (V, in [-1, 1]; + when the side that the normal points to is hotter) steers the curl.
std::vector<double> lose_mass(BurningState& state, const BurningParams& params, const std::vector<double>& theta,
                              const std::vector<double>& hotter_side, double ambient_temperature,
                              double reference_temperature, double dt);

/// Writes what burning does to the mechanics into `inputs`: mass, shrunk rest lengths, weakened stiffness, curl.
/// `base` holds the virgin inputs of the same mesh, `areal_mass` rho t [kg/m2].
void reshape(solid::ShellInputs& inputs, const solid::ShellInputs& base, const solid::ShellMesh& mesh,
             const BurningState& state, const BurningParams& params, double areal_mass);

/// keep[t] = 0 for triangles whose three vertices have burnt below params.removal.
std::vector<std::uint8_t> unburnt_triangles(const solid::ShellMesh& mesh, const BurningState& state,
                                            const BurningParams& params);

}  // namespace wick::coupling
