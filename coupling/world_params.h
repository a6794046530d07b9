#pragma once
/// Everything that a scene may say about the simulated world, section by section.
#include <optional>
#include <string>
#include <vector>

#include "core/obstacle.h"
#include "core/parameters.h"
#include "coupling/burning.h"
#include "coupling/motion.h"
#include "diffusion/strain_diffusion.h"
#include "fluid/smoke.h"
#include "solid/primitives.h"
#include "solid/sheet_contact.h"
#include "solid/shell.h"

namespace wick::coupling {

/// Turns about x, y, z, in that order.
Mat3 rotation(const Vec3& degrees);

enum class MeshKind { rectangle, icosphere, cylinder, file };

/// Where a sheet comes from and how it is placed: scaled, rotated about x, y, z in that order, then moved.
struct MeshParams {
  MeshKind kind = MeshKind::rectangle;
  std::string file = {};  ///< PLY or OBJ beside the scene
  solid::Lattice lattice = solid::Lattice::staggered;
  Int2 vertices = {93, 107};     ///< rectangle: along x and y
  Vec2 size = Vec2(1.0, 1.0);    ///< rectangle: extents; cylinder: radius, height [m]
  double radius = 0.5;           ///< icosphere [m]
  int subdivisions = 0;          ///< icosphere level, or loops of 1:4 subdivision of a file
  Vec3 position = Vec3::Zero();  ///< [m]
  Vec3 rotation = Vec3::Zero();  ///< [degrees]
  double scale = 1.0;
  double wrinkle = 0.0;  ///< amplitude of seeded out-of-plane noise at the start [m]
  int seed = 1;
};
void describe(ParameterVisitor& visitor, MeshParams& params);

enum class PinEdge { none, lower_x, upper_x, lower_y, upper_y };

/// Holds vertices: those within `radius` of `point` (rest shape, placed), or listed, or on a rectangle's edge.
struct PinParams {
  std::vector<int> vertices = {};
  Vec3 point = Vec3::Zero();
  double radius = 0.0;           ///< [m]; 0: `point` not used
  PinEdge edge = PinEdge::none;  ///< chooses -x, +x, -y, +y side of the material rectangle; 0: none
  Vec3 velocity = Vec3::Zero();  ///< of the pin while it moves [m/s]
  double stop_time = 0.0;        ///< the pin moves until then [s]
  double release_time = 1e30;    ///< the pin lets go then [s]
};
void describe(ParameterVisitor& visitor, PinParams& params);

/// Where and when a sheet tears; see solid/tear.h.
struct TearingParams {
  double strain = 0.05;        ///< largest principal strain that the virgin sheet bears
  double scatter = 0.1;        ///< flaws: by so much the strain at a vertex lies above or below, at most
  double char_strength = 0.2;  ///< share of the strain that ash bears
  int checks = 8;              ///< looks for tears per 1/60 s: a tear runs one edge from one look to the next
  int seed = 1;                ///< of the flaws
};
void describe(ParameterVisitor& visitor, TearingParams& params);

struct ShellSection {
  std::string name = "sheet";
  MeshParams mesh;
  solid::ShellParams material;
  std::vector<PinParams> pins = {};
  Vec3 velocity = Vec3::Zero();  ///< at the start [m/s]
  bool moves = true;             ///< false: held in place, the shell solver is not built
  MotionParams motion;  ///< given movement: the shell solver is not built either; pins, velocity, moves and
                        ///< wrinkles are refused beside it
  std::optional<TearingParams> tearing = {};
};
void describe(ParameterVisitor& visitor, ShellSection& params);

/// Where an obstacle is at one time.
struct Keyframe {
  double time = 0.0;             ///< [s]
  Vec3 position = Vec3::Zero();  ///< of its middle, relative to the shape as given [m]
  Vec3 rotation = Vec3::Zero();  ///< about its middle: about x, y, z in that order [degrees]
};
void describe(ParameterVisitor& visitor, Keyframe& keyframe);

enum class ObstacleKind { sphere, box, plane, mesh };
struct ObstacleParams {
  std::string name = "obstacle";
  ObstacleKind kind = ObstacleKind::sphere;
  Vec3 center = Vec3::Zero();                                      ///< sphere, plane: a point of it [m]
  double radius = 0.1;                                             ///< sphere [m]
  Vec3 lower = Vec3::Constant(-0.1), upper = Vec3::Constant(0.1);  ///< box [m]
  Vec3 normal = Vec3(0, 0, 1);                                     ///< plane
  std::string file = {};                                           ///< mesh: closed PLY or OBJ
  double scale = 1.0;                                              ///< mesh
  double spacing = 0.01;                                           ///< mesh: of the sampled distance [m]
  double friction = 0.3;
  Vec3 velocity = Vec3::Zero();          ///< [m/s]
  std::vector<Keyframe> keyframes = {};  ///< instead of a velocity
};
void describe(ParameterVisitor& visitor, ObstacleParams& params);

/// Heats sheets and gas inside a ball or a box that may move.
enum class SourceKind { ball, box };
struct HeatSourceParams {
  SourceKind kind = SourceKind::ball;
  Vec3 center = Vec3::Zero();                                        ///< ball [m]
  double radius = 0.05;                                              ///< ball [m]
  Vec3 lower = Vec3::Constant(-0.05), upper = Vec3::Constant(0.05);  ///< box [m]
  Vec3 velocity = Vec3::Zero();                                      ///< [m/s]
  double temperature = 1200.0;                                       ///< of the source [K]
  double rate = 20.0;              ///< at which a sheet inside takes that temperature [1/s]
  double gas_power = 0.0;          ///< heat given to the gas [W]
  double gas_smoke = 0.0;          ///< smoke given to the gas [kg/s]
  double start = 0.0, stop = 1.0;  ///< [s]
};
void describe(ParameterVisitor& visitor, HeatSourceParams& params);

struct WindParams {
  Vec3 velocity = Vec3::Zero();  ///< [m/s], seen by the drag of sheets where there is no gas grid
  double gust = 0.0;             ///< relative amplitude of seeded gusts
  double gust_period = 1.0;      ///< [s]
  int seed = 1;
};
void describe(ParameterVisitor& visitor, WindParams& params);

/// Contact of sheets with themselves and each other.
struct ContactParams {
  solid::SheetContactParams sheets;
  bool allow_crossings = false;  ///< start with sheets that pass through each other; they stay so
};
void describe(ParameterVisitor& visitor, ContactParams& params);

/// How the gas and the sheets push each other.
enum class CouplingScheme { simultaneous, partitioned };

struct CouplingParams {
  CouplingScheme scheme = CouplingScheme::simultaneous;
  double relaxation = 0.0;  ///< partitioned: share of a step's gas force in the force that a sheet gets; 0: see
                            ///< relax_push()
  double max_step = 1.0 / 30.0;  ///< longest step of the world [s]; shorter ones follow from the flow
  double sheet_cells = 2.0;      ///< cells of the gas grid that a sheet or obstacle may cross in one step
  int max_substeps = 256;        ///< a frame; beyond it steps get longer than asked and are counted
};
void describe(ParameterVisitor& visitor, CouplingParams& params);

struct WorldParams {
  CouplingParams coupling;
  Vec3 gravity = Vec3(0, 0, -9.81);  ///< [m/s2]
  std::vector<ShellSection> shells;
  std::vector<ObstacleParams> obstacles;
  std::optional<ContactParams> contact;
  std::optional<fluid::SmokeParams> smoke;
  std::optional<diffusion::DiffusionParams> diffusion;
  SheetHeatParams heat;  ///< of sheets that carry heat, i.e. with a diffusion section
  std::optional<BurningParams> burning;
  std::vector<HeatSourceParams> heat_sources;
  std::optional<WindParams> wind;
  std::string directory = {};  ///< of the scene file: mesh files are looked for here; not a parameter

  [[nodiscard]] double ambient_temperature() const {  ///< T_amb [K]: with a gas, the gas's is used
    return smoke ? smoke->ambient_temperature : heat.ambient_temperature;
  }
  [[nodiscard]] double temperature_scale() const {  ///< T_ref - T_amb: kelvin per unit theta
    return heat.reference_temperature - ambient_temperature();
  }
};
void describe(ParameterVisitor& visitor, WorldParams& params);

}  // namespace wick::coupling
