#pragma once
/// One sheet of the world: its mesh as it is now, and everything that it carries.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coupling/burning.h"
#include "coupling/rasterize.h"
#include "coupling/world_params.h"
#include "diffusion/strain_diffusion.h"
#include "solid/primitives.h"
#include "solid/shell.h"

namespace wick::coupling {

/// Vertices held by one entry of `pins`, and where they were at the start.
struct PinSet {
  PinParams params;
  std::vector<std::int32_t> vertices;
  std::vector<Vec3> start;  ///< [m]
};

/// What the last step did to the sheet, for metrics.
struct SheetReport {
  solid::ShellStepReport shell;
  diffusion::DiffusionReport diffusion;
};

struct Sheet {
  std::string name;
  std::string pointer;  ///< of its section, for messages
  ShellSection params;
  double areal_mass = 0.0;  ///< rho t [kg/m2]

  solid::ShellMesh original;     ///< as built
  std::vector<int> file_number;  ///< of the vertices of a mesh file, see FileMesh; empty: as built
  solid::ShellMesh mesh;         ///< as it is now; the vertices of the original come first
  std::vector<double> snapping;  ///< of cuts, see CutSurface, V; empty without burning
  solid::ShellState state;
  solid::ShellInputs base, inputs;  ///< virgin, and as burning has left them
  std::vector<PinSet> pins;

  std::vector<double> unswollen;      ///< rest_scale of the inputs without what pore pressure adds; empty: the same
  std::vector<double> theta;          ///< (T - T_amb)/(T_ref - T_amb), V; empty without diffusion
  std::vector<double> heat_capacity;  ///< [J per unit theta], V
  std::vector<double> strain_added;   ///< C of the last diffusion, V; empty where it had none
  BurningState burning;               ///< empty without burning
  std::vector<Vec3> gas_force;        ///< of the partitioned scheme, relaxed [N], V; empty in the other
  std::vector<Vec3> seen_x;           ///< where the gas last saw the sheet, scratch of one step; empty: not yet

  std::unique_ptr<solid::ShellSolver> shell;              ///< null for a held sheet
  std::unique_ptr<diffusion::DiffusionSolver> diffusion;  ///< null without diffusion
  SheetReport report;

  /// Moved as its section tells instead of by the shell solver.
  [[nodiscard]] bool driven() const { return params.motion.kind != MotionKind::none; }
  /// Moved by the shell solver.
  [[nodiscard]] bool free() const { return params.moves && !driven(); }
  /// Rest lengths relative to the virgin ones, as the strain and the pores are measured against them.
  [[nodiscard]] const std::vector<double>& rest_scale() const {
    return unswollen.empty() ? inputs.rest_scale : unswollen;
  }
  [[nodiscard]] SheetSurface surface() const { return {&mesh, &state.x, &state.v}; }
};

/// A mesh file without the vertices that no triangle names.
struct FileMesh {
  solid::TriangleSoup soup;
  std::vector<int> number;  ///< of each vertex of the file in `soup`, -1 where it is gone; empty: as in the file
};
/// Reads a mesh file that the scene names at `pointer`, and adds a warning with the count of vertices left out.
FileMesh read_mesh_beside_scene(const WorldParams& world, const std::string& file, const std::string& pointer,
                                std::vector<std::string>& warnings);

/// Builds the sheet of one section. Throws Refusal with the pointer of the parameter at fault; what is worth saying
/// and no fault is added to `warnings`, each with its pointer in front.
Sheet build_sheet(const ShellSection& params, const std::string& pointer, const WorldParams& world,
                  std::vector<std::string>& warnings);

/// Rebuilds solvers, inputs and what the mesh derives after the sheet's triangles and places at rest have changed
/// (or have been read from a checkpoint).
void rebuild_topology(Sheet& sheet, const WorldParams& world);

/// Where the pins hold their vertices at time t; pins that have let go hold none.
solid::Pins pins_at(const Sheet& sheet, double t);

/// Masses, rest lengths, stiffness and curl as burning has left them; masses alone where no shell solver moves the
/// sheet: a shape that is given has the strain of its virgin rest shape. Rest lengths swell with the pore pressure
/// of the porous model as far as its effective stress says.
void refresh_inputs(Sheet& sheet, const WorldParams& world);

/// Puts a driven sheet where its motion is at time t, dt after the last one.
void follow_motion(Sheet& sheet, double t, double dt);

void visit(StateVisitor& visitor, Sheet& sheet);

}  // namespace wick::coupling
