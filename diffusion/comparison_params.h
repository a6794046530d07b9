#pragma once
/// Parameters of the models that the paper's method is compared with.

namespace wick {
class ParameterVisitor;
}

namespace wick::diffusion {

/// Gradient noise that stands for strain (Model::noise) or modulates it (Model::strain_noise) [Perlin 2002].
struct NoiseParams {
  double amplitude = 1.0;   ///< a
  double frequency = 16.0;  ///< f [1/m], in material coordinates
  double level = 0.003;     ///< c that noise of size 1 stands for in Model::noise
  int seed = 1;
};
void describe(ParameterVisitor& visitor, NoiseParams& params);

/// Darcy flow through the pores of the sheet [Lenaerts 2008]. k_c, a and β are the article's; the rest is chosen
/// here. Its η acts on the stress of the solid alone, so that it is asked for where the sheet is moved.
/// Thickness and porosity-weighted capacity are already in M.
struct PorousParams {
  double capillary = 15000.0;     ///< k_c [Pa]
  double exponent = 0.1;          ///< a
  double regularisation = 1e-3;   ///< ε of (1 - s + ε)^a, whose slope at s = 1 would be infinite for a < 1
  double pressure = 15000.0;      ///< k_p [Pa]
  double tait = 7.0;              ///< β
  double permeability = 1e-11;    ///< K [m2]
  double viscosity = 1e-3;        ///< μ [Pa s]
  double porosity = 0.8;          ///< φ0
  double density = 1000.0;        ///< ρ of the liquid [kg/m3]
  double relative = 1.0;          ///< n of kr = s^n
  double full = 1.0;              ///< u at which the pores of the rest shape are full
  double effective_stress = 0.0;  ///< η: share of the pore pressure that the membrane feels
};
void describe(ParameterVisitor& visitor, PorousParams& params);

/// Transfers along edges [Patkar 2013], with the values that the article of [Kim 2017] used; what each of them
/// means is inferred.
struct GravityTransportParams {
  double absorption = 0.1;             ///< α: share of what contact offers that is taken up
  double absorb_threshold = 0.002;     ///< t_absorb: offers below this (in u) are left
  double diffusion_rate = 0.005;       ///< k_d [1/s]
  double gravity_rate = 0.001;         ///< k'_d [1/s]
  double transport_threshold = 0.424;  ///< t_diff: only vertices above it pass anything on
  bool angle_only = false;             ///< the angle to gravity also multiplies the part of k_d
};
void describe(ParameterVisitor& visitor, GravityTransportParams& params);

}  // namespace wick::diffusion
