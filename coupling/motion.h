#pragma once
/// Movement that is given instead of computed: a recorded motion, or one of a few deformations in closed form. No
/// shell solver is built for such a sheet, so that methods of diffusion can be compared on the same deformation. To
/// the gas it is a moving wall of infinite mass. Where it burns it loses mass and triangles, but its rest shape
/// stays: char that shrank would change the strain without moving the sheet.
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
  std::vector<Vec3> rest = {};       ///< V [m], of the sheet that was recorded; empty where it is not known
  std::vector<Int3> triangles = {};  ///< likewise
};

/// Shapes of a sheet with rest positions r [m] and material coordinates X [m], both from the mesh. M is the middle
/// of the box around all X, L its longer side, d = X - M with length |d| and direction φ, w the wavelength, n the
/// normal of the rest shape. Displacements in the plane are given in the material axes. At time t the amplitude is
/// a times min(t/ramp, 1).
///   stretch   a d_x along the first material axis; a is a strain: S = (a + a²/2)² everywhere [Kim 2017, Eq 5]
///   dent      a exp(-|d|²/(2 w²)) n
///   wave      a ξ sin(2π (ξ L/w - t/period)) n with ξ = (X_x - min X_x)/L: a flag that flutters, held at ξ = 0
///   star      a (|d|/L)² sin²(2φ) outwards in the plane: four arms along the diagonals; and the dent of `dent`
///   crumple   a Σ 2^-o P(2^o X'/w) n, Perlin noise of octaves o = 0 to 3 on a lattice askew to the sheet
///             (X' is X turned, r turned where the mesh has no X); never higher than 15/8 a max|P|
enum class MotionKind { none, stretch, dent, wave, star, crumple, recorded };

struct MotionParams {
  MotionKind kind = MotionKind::none;
  double amplitude = 0.03;                        ///< a: [m], of stretch [1]
  double wavelength = 1.0 / 3.0;                  ///< [m]
  double period = 0.0;                            ///< of wave [s]; 0: it stands still
  double ramp = 0.0;                              ///< the amplitude grows from 0 over this time [s]
  int seed = 1;                                   ///< of crumple
  std::string file = {};                          ///< of recorded
  std::shared_ptr<const MotionTrack> track = {};  ///< what `file` holds, read before the world; not a parameter
};
void describe(ParameterVisitor& visitor, MotionParams& params);

/// Throws Refusal where the motion does not fit the mesh: number of vertices, and rest shape and triangles where
/// the track knows them. `pointer` is that of the motion's section.
void require_motion_fits(const MotionParams& params, const solid::ShellMesh& mesh, const std::string& pointer);

/// Where the vertices of `mesh` are at time t (V). Recorded motions are linear between their times and stand still
/// before the first and after the last.
std::vector<Vec3> motion_at(const MotionParams& params, const solid::ShellMesh& mesh, double t);

}  // namespace wick::coupling
