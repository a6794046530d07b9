#pragma once
/// Pieces of a burning sheet that are too small to be a sheet any longer: particles that glow, drift with the air
/// and go out. They take their mass and heat from the sheet, and the air does not feel them.
#include <vector>

#include "core/obstacle.h"
#include "core/state.h"
#include "core/types.h"
#include "fluid/smoke.h"

namespace wick::coupling {

struct Sheet;
struct WorldParams;

struct EmberState {
  std::vector<Vec3> x, v;             ///< [m], [m/s]
  std::vector<double> mass;           ///< [kg]
  std::vector<double> area;           ///< of one face, as the piece had it [m2]
  std::vector<double> heat_capacity;  ///< [J per unit theta], of the virgin piece as its sheet counts it
  std::vector<double> theta;
  std::vector<double> age;       ///< [s]
  std::vector<std::int64_t> id;  ///< counts all embers of the run from 0
  std::int64_t next_id = 0;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] double total_mass() const;
  [[nodiscard]] double total_heat() const;
};
void visit(StateVisitor& visitor, EmberState& state);

/// Name of the embers among the meshes that are written.
inline constexpr const char* embers_name = "embers";

/// Whether a scene can have embers.
bool sheds_embers(const WorldParams& world);

/// Turns the parts of a sheet that no pin holds and that measure less than burning.ember_size² into embers: their
/// triangles leave the mesh, which is rebuilt. `push` as in ablate(). Returns how many.
std::size_t shed_embers(Sheet& sheet, const WorldParams& world, std::vector<Vec3>& push, EmberState& embers);

/// What left with embers that went out [kg], and what they gave off or took along [J].
struct EmberLoss {
  double mass = 0.0, heat = 0.0, radiated = 0.0;
};

/// Moves embers by dt under gravity and the drag of the air, which has velocity `air` at their places (one each, or
/// empty for still air), and lets them cool. Those older than burning.ember_life, in obstacles or out of the box of
/// the grid (null: no gas) go out.
EmberLoss step_embers(EmberState& embers, const WorldParams& world, const std::vector<Vec3>& air,
                      const std::vector<Obstacle>& obstacles, const fluid::Grid* grid, double dt);

/// Velocity of the gas at each place: linear between the faces, without regard for walls. Outside of the box that
/// of its nearest cell.
std::vector<Vec3> gas_velocity_at(const fluid::SmokeState& gas, const fluid::Grid& grid,
                                  const std::vector<Vec3>& x);

}  // namespace wick::coupling
