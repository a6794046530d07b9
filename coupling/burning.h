#pragma once
/// Burning of a thin sheet: heat makes it lose mass, the lost mass feeds the flame and the smoke.
/// In the spirit of Jeong, Kim and Kim [2011] and Larboulette et al. [2013]; formulas are ours (README, "Burning").
///
///   theta = (T - T_amb)/(T_ref - T_amb),   d mu/dt = -k_b clamp((theta - theta_ign)/(1 - theta_ign), 0, 1),  mu >= mu_ash   (threshold)
///                                          d mu/dt = -A exp(-T_act/T) (mu - mu_ash)                                        (arrhenius)
#include <vector>

namespace wick {
class ParameterVisitor;
}

namespace wick::coupling {

enum class MassLoss { threshold, arrhenius };

struct BurningParams {
  MassLoss law = MassLoss::threshold;
  double reference_temperature = 1100.0; ///< T_ref, where theta = 1 [K]
  double ignition = 0.25;                ///< theta_ign
  double rate = 4.0;                     ///< k_b: fraction of the mass lost a second at theta = 1 [1/s]
  double pre_exponential = 1e6;          ///< A [1/s]
  double activation_temperature = 12000; ///< T_act [K]
  double ash = 0.08;                     ///< mu_ash: fraction that does not burn
  double removal = 0.12;                 ///< triangles whose three vertices have mu below this fall away as ash
  double heat_capacity = 1400.0;         ///< c of the sheet [J/(kg K)]
  double heat_yield = 1.5;               ///< eta_f H_c: heat kept by the sheet, in units of c (T_ref - T_amb) per burnt mass
  double gas_heat_yield = 6.0;           ///< heat given to the gas, same unit
  double smoke_yield = 0.15;             ///< y_s: smoke per burnt mass, the rest is unseen gas
  double loss = 0.4;                     ///< radiation and still air: rate at which theta decays [1/s]
  double convection = 20.0;              ///< h_conv between sheet and gas, per side [W/(m2 K)]
  double shrink = 0.8;                   ///< s_min: rest length of ash relative to virgin
  double weaken = 0.15;                  ///< e_min: stiffness of ash relative to virgin
  double curl = 0.5;                     ///< share of the shrinkage that differs between the two faces
  double curl_noise = 0.5;               ///< relative seeded variation of the curl
  int seed = 1;
};
void describe(ParameterVisitor& visitor, BurningParams& params);

}  // namespace wick::coupling
