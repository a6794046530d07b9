#pragma once
/// The world: every part that a scene names, stepped together. See World::step in world.cpp for the frame
/// as the data flows.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/function_ref.h"
#include "core/ledger.h"
#include "core/report.h"
#include "core/state.h"
#include "coupling/embers.h"
#include "coupling/world_params.h"
#include "fluid/smoke.h"
#include "solid/shell.h"

namespace wick::coupling {

/// What one frame did, for progress, metrics and the exit summary.
struct FrameReport {
  int frame = 0;
  double time = 0.0;  ///< [s] at the end of the frame
  int substeps = 0;
  double steps_foreseen = 1.0;                ///< when the frame began
  StageSeconds seconds;                       ///< by stage; "smoke" is the whole fluid stage
  std::map<std::string, SolveReport> solves;  ///< worst residual and summed iterations of the frame, by solver
  int unconverged_solves = 0;
  int squeezed_steps = 0;    ///< in which closed walls pushed more gas into the box than out of it
  int forced_contacts = 0;   ///< pairs that pins or driven sheets forced through each other
  int lengthened_steps = 0;  ///< steps that /coupling/max_substeps made longer than asked
  bool complete = true;      ///< false: step() was stopped between two substeps
};

/// One sheet as an output writer sees it. Pointers are valid until the next step.
struct ShellView {
  std::string name;
  const solid::ShellMesh* mesh;
  const std::vector<Vec3>* x;
  const std::vector<Vec3>* v;
  /// Named per-vertex values: temperature [K], saturation, char (1 - mu), u, C; only those that the scene has.
  std::vector<std::pair<std::string, std::vector<float>>> values;
  const solid::ShellMesh* original = nullptr;  ///< as built
};

/// Embers as an output writer sees them, one entry each. Pointers are valid until the next step.
struct EmberView {
  const std::vector<Vec3>* x = nullptr;
  const std::vector<Vec3>* v = nullptr;
  const std::vector<std::int64_t>* id = nullptr;  ///< counts all embers of the run from 0
  std::vector<float> temperature;                 ///< [K]
  std::vector<float> radius;                      ///< of a disc as large as the piece [m]
};

/// Memory that one parameter of a scene asks for.
struct MemoryShare {
  std::string pointer;  ///< empty: the program itself
  double bytes = 0.0;
  std::string advice;  ///< how to ask for less
};

class World {
 public:
  /// Builds only the parts that the scene names. Throws Refusal with the pointer of the parameter at fault.
  explicit World(const WorldParams& params);
  ~World();

  /// Advances by one frame of `dt` seconds, in as many substeps as the fastest part needs. `stop` is asked after
  /// each substep that does not end the frame: where it says yes the frame stays unfinished, which is part of the
  /// state, and the next call (of the same `dt`) goes on with it to the same bits.
  FrameReport step(
      double dt, FunctionRef<bool()> stop = [] { return false; });

  [[nodiscard]] int frame() const;  ///< 1 for the initial state
  [[nodiscard]] double time() const;
  /// What building it found worth saying, each with the pointer of its parameter in front.
  [[nodiscard]] const std::vector<std::string>& warnings() const;
  [[nodiscard]] std::vector<std::string> models() const;  ///< shell, diffusion, smoke, burning, ...
  [[nodiscard]] std::vector<ShellView> shells() const;
  [[nodiscard]] EmberView embers() const;
  [[nodiscard]] const std::vector<Obstacle>& obstacles() const;  ///< where they are now
  [[nodiscard]] const fluid::SmokeState* smoke() const;          ///< null without smoke
  [[nodiscard]] const std::map<std::string, Ledger>& ledgers() const;
  /// Per-shell scalars of metrics.h5 (/shell/<name>/<quantity>).
  [[nodiscard]] std::map<std::string, std::map<std::string, double>> shell_metrics() const;

  /// Walks everything that a restart needs. After a reader has walked it, call restored().
  void visit(StateVisitor& visitor);
  void restored();
  [[nodiscard]] std::uint64_t state_hash();

  /// What the world of these parameters will hold, before it is built.
  static std::vector<MemoryShare> estimate_memory(const WorldParams& params);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wick::coupling
