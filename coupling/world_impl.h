#pragma once
/// What is inside the world: its state, and what is kept alive between steps. Included by world*.cpp only.
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "coupling/embers.h"
#include "coupling/exchange.h"
#include "coupling/heat_sources.h"
#include "coupling/rasterize.h"
#include "coupling/sheet.h"
#include "coupling/world.h"
#include "coupling/world_parts.h"

namespace wick::coupling {

struct World::Impl {
  explicit Impl(const WorldParams& p);

  // One substep, in the order of the data flow.
  void substep(double dt, FrameReport& report);
  void move_gas(double dt, FrameReport& report);
  void relax_push();
  void exchange(double dt);
  void diffuse(double dt, FrameReport& report);
  void react(double dt);
  void shed_ash();
  void move_embers(double dt);
  void move_sheets(double dt, FrameReport& report);
  void move_sheet(std::size_t s, double end, double dt);
  void move_sheets_together(double end, double dt, FrameReport& report);
  void aim_obstacles(double t, double dt);
  void see_sheets();
  void hand_over();
  void audit();
  void visit_unfinished(StateVisitor& visitor);

  void look_for_crossings();
  double longest_step(double left) const;
  std::vector<SheetSurface> surfaces() const;
  void begin_ledgers();

  WorldParams params;
  std::vector<std::string> warnings;      ///< of building it
  double ambient = 293.15, kelvin = 1.0;  ///< T_amb, and T_ref - T_amb [K]

  // State.
  int frame = 1;
  double time = 0.0;
  std::vector<Sheet> sheets;
  std::vector<Obstacle> obstacles;
  std::optional<fluid::SmokeState> gas;
  EmberState embers;
  std::map<std::string, Ledger> ledgers;
  std::optional<double> frame_end;  ///< of the frame that a stop left unfinished [s]
  FrameReport unfinished;           ///< what that frame did so far

  // Kept alive between steps, rebuilt from params and state.
  std::unique_ptr<fluid::SmokeSolver> gas_solver;
  std::unique_ptr<Raster> raster;
  std::unique_ptr<solid::SheetContact> contact;  ///< null without such a section, or until sheets move next

  // Handed from stage to stage within a substep.
  std::vector<Pose> seen_obstacles;                  ///< where the gas last saw them; empty: not yet
  std::vector<std::vector<VertexStencil>> stencils;  ///< per sheet
  std::vector<std::vector<Vec3>> push;               ///< per sheet: force of the gas [N]
  std::vector<std::vector<double>> heat_in;          ///< per sheet: heat from the gas [J]
  std::vector<std::vector<double>> hotter_side;      ///< per sheet
};

}  // namespace wick::coupling
