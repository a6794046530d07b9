#pragma once
/// Movement that is given instead of computed: a recorded motion, or one of a few deformations in closed form. Only
/// the diffusion is solved on such a sheet, so that methods can be compared on the same deformation.
#include <memory>
#include <string>
#include <vector>

#include "solid/shell_mesh.h"

namespace wick {
class ParameterVisitor;
}

namespace wick::coupling {

/// Places of all vertices at ascending times.
struct MotionTrack {
  std::vector<double> time;          ///< F [s]
  std::vector<std::vector<Vec3>> x;  ///< F x V [m]
};

/// Shapes of a sheet with rest positions r, material coordinates in [0, 1]² after scaling to the sheet, middle m,
/// normal n, extent L (its longer side):
///   stretch   r + a (r - m) along the first material axis; a is a strain
///   dent      r + a exp(-|r - m|²/(2 w²)) n, w = wavelength
///   wave      r + a ξ sin(2π (ξ L/wavelength - t/period)) n: a flag that flutters from ξ = 0 to ξ = 1
///   star      four arms pulled outwards along the diagonals, |r - m| + a (|r - m|/L)² cos²(2φ) in the plane, and a
///             dent of depth a
///   crumple   r + a Σ 2^-o P(2^o r/wavelength) n, Perlin noise over four octaves
enum class MotionKind { none, stretch, dent, wave, star, crumple, recorded };

struct MotionParams {
  MotionKind kind = MotionKind::none;
  double amplitude = 0.03;                        ///< a: [m], of stretch [1]
  double wavelength = 1.0 / 3.0;                  ///< [m]
  double period = 0.0;                            ///< of wave [s]; 0: it stands still
  double ramp = 0.0;                              ///< the amplitude grows from 0 over this time [s]
  int seed = 1;                                   ///< of crumple
  std::string file = {};                          ///< of recorded
  std::shared_ptr<const MotionTrack> track = {};  ///< what `file` holds; not a parameter
};
void describe(ParameterVisitor& visitor, MotionParams& params);

/// Throws Refusal where the motion does not fit the mesh; `pointer` is that of the motion's section.
void require_motion_fits(const MotionParams& params, const solid::ShellMesh& mesh, const std::string& pointer);

/// Where the vertices of `mesh` are at time t (V). Recorded motions are linear between their times and stand still
/// before the first and after the last.
std::vector<Vec3> motion_at(const MotionParams& params, const solid::ShellMesh& mesh, double t);

}  // namespace wick::coupling
