#pragma once
/// Runs of a scene in memory, kept frame by frame: what an experiment measures.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "coupling/motion.h"
#include "scenes/scene.h"
#include "solid/shell_mesh.h"

namespace wick::scenes {

/// The first shell of a scene at the end of one frame.
struct SheetFrame {
  double time = 0.0;
  std::vector<double> u;               ///< V
  std::vector<double> left;            ///< fraction of the mass left, V; empty without burning
  std::vector<Vec3> x;                 ///< V [m]
  std::map<std::string, double> heat;  ///< flows of the heat ledger so far, and its stock as "stock" [J]
};

struct SheetHistory {
  solid::ShellMesh mesh;                  ///< as it was at the start
  std::vector<SheetFrame> frames;         ///< the initial state first
  double total_error = 0.0;               ///< largest relative closing error of the heat ledger
  std::map<std::string, double> seconds;  ///< by stage, over all frames
};

/// Steps the scene to its last frame, or to the first where `enough(frame)` is true.
SheetHistory replay(const Scene& scene, const std::function<bool(const SheetFrame&)>& enough = {});

/// c of Eq (4) as a density: ½ S averaged over the triangles around each vertex (V), of the shape x, with the
/// strain measure of the scene's diffusion.
std::vector<double> strain_density(const Scene& scene, const solid::ShellMesh& mesh, const std::vector<Vec3>& x);

/// strain_density of every frame, or of the first alone where the sheet does not move.
std::vector<std::vector<double>> strain_densities(const Scene& scene, const SheetHistory& history);

/// The motion of the scene's first shell under the shell solver, without diffusion and burning.
std::shared_ptr<const coupling::MotionTrack> record_track(Scene scene);

/// Number of the first frame in which the front of u (or of the char, 1 - left) at 0.5 has passed the given
/// fraction of the sheet; the last frame where none has.
enum class FrontOf { u, charred };
std::size_t frame_at_coverage(const SheetHistory& history, FrontOf of, double coverage);

/// The field that the front is found in.
std::vector<double> front_field(const SheetFrame& frame, FrontOf of);

}  // namespace wick::scenes
