#include "coupling/world_params.h"

namespace wick::coupling {

namespace {
constexpr const char* kMeshKinds[] = {"rectangle", "icosphere", "cylinder", "file"};
constexpr const char* kLattices[] = {"staggered", "grid", "union_jack"};
constexpr const char* kEdges[] = {"none", "-x", "+x", "-y", "+y"};
constexpr const char* kObstacleKinds[] = {"sphere", "box", "plane", "mesh"};
constexpr const char* kSourceKinds[] = {"ball", "box"};
constexpr const char* kSchemes[] = {"simultaneous", "partitioned"};
constexpr double kFar = 1e5;     // [m] positions beyond it lose the digits that a millimetre needs
constexpr double kFast = 1e4;    // [m/s]
constexpr double kNever = 1e30;  // [s]
}  // namespace

Mat3 rotation(const Vec3& degrees) {
  const Vec3 angle = degrees * (M_PI / 180.0);
  return (Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
          Eigen::AngleAxisd(angle.x(), Vec3::UnitX()))
      .toRotationMatrix();
}

void describe(ParameterVisitor& v, MeshParams& p) {
  v.choice({"kind", "", any_value(), "rectangle, icosphere, cylinder (an open tube), or file"}, p.kind, kMeshKinds);
  v.only(p.kind == MeshKind::file, "kind is not file", [&] {
    v.text({"file", "", any_value(), "PLY or OBJ beside the scene; read when kind is file"}, p.file);
  });
  v.only(p.kind == MeshKind::rectangle, "kind is not rectangle", [&] {
    v.choice({"lattice", "", any_value(),
              "rectangle: staggered is isotropic for diffusion and bending, the others are not"},
             p.lattice, kLattices);
  });
  v.only(p.kind == MeshKind::rectangle || p.kind == MeshKind::cylinder, "kind is not rectangle or cylinder", [&] {
    v.vector({"vertices", "1", between(2, 20000), "rectangle: vertices along x and y; cylinder: around and along"},
             p.vertices);
    v.vector({"size", "m", between(1e-5, kFar), "rectangle: extents along x and y; cylinder: radius and height"},
             p.size);
  });
  v.only(p.kind == MeshKind::icosphere, "kind is not icosphere", [&] {
    v.number({"radius", "m", between(1e-5, kFar), "icosphere"}, p.radius);
  });
  v.only(p.kind == MeshKind::icosphere || p.kind == MeshKind::file, "kind is not icosphere or file", [&] {
    v.integer(
        {"subdivisions", "1", between(0, 9), "icosphere: level; file: times that each triangle is cut in four"},
        p.subdivisions);
  });
  v.vector({"position", "m", between(-kFar, kFar), "where the mesh's own origin goes"}, p.position);
  v.vector({"rotation", "deg", between(-3600, 3600), "about x, then y, then z, before the move"}, p.rotation);
  v.number({"scale", "1", between(1e-6, 1e6), "before rotation"}, p.scale);
  v.number({"wrinkle", "m", between(0, 1e3),
            "amplitude of smooth seeded out-of-plane noise at the start; breaks symmetry"},
           p.wrinkle);
  v.only(p.wrinkle > 0.0, "wrinkle is 0", [&] {
    v.integer({"seed", "", between(0, 2147483647), "of the wrinkles"}, p.seed);
  });
}

void describe(ParameterVisitor& v, PinParams& p) {
  v.index_list({"vertices", "1", at_least(0), "vertex numbers to hold"}, p.vertices);
  v.vector({"point", "m", between(-kFar, kFar), "holds vertices within radius of this point at the start"},
           p.point);
  v.number({"radius", "m", between(0, kFar), "0: point is not used"}, p.radius);
  v.choice({"edge", "", any_value(), "holds one side of a rectangle, named in its own x and y"}, p.edge, kEdges);
  v.vector({"velocity", "m/s", between(-kFast, kFast), "of the held vertices until stop_time"}, p.velocity);
  v.only(!p.velocity.isZero(), "velocity is 0", [&] {
    v.number({"stop_time", "s", between(0, kNever), "when the pin stops moving"}, p.stop_time);
  });
  v.number({"release_time", "s", between(0, kNever), "when the pin lets go"}, p.release_time);
}

void describe(ParameterVisitor& v, TearingParams& p) {
  v.number({"strain", "1", above_up_to(0, 100),
            "largest principal strain that the sheet bears; paper 0.03, cotton 0.15", OnResume::may_change},
           p.strain);
  v.number({"scatter", "1", between(0, 0.9), "flaws: by so much strain lies above or below from vertex to vertex"},
           p.scatter);
  v.number({"char_strength", "1", between(1e-3, 1),
            "share of strain that ash bears; falls with the square of the loss", OnResume::may_change},
           p.char_strength);
  v.integer({"checks", "1", between(1, 1000),
             "looks for tears per 1/60 s; a tear runs one edge from one look to the next"},
            p.checks);
  v.integer({"seed", "", between(0, 2147483647), "of the flaws"}, p.seed);
}

void describe(ParameterVisitor& v, ShellSection& p) {
  v.text({"name", "", any_value(), "names the output files; letters, digits, _ . -"}, p.name);
  v.nested("mesh", "where the sheet comes from and how it is placed", p.mesh);
  v.nested("material", "thickness, stiffness, damping", p.material);
  v.list("pins", "vertices that do not move freely", p.pins);
  v.vector({"velocity", "m/s", between(-kFast, kFast), "at the start"}, p.velocity);
  v.flag({"moves", "", any_value(), "false: held in place, and no shell solver is built"}, p.moves);
  v.nested("motion", "movement that is given instead of computed; not with pins, velocity or wrinkles", p.motion);
  v.section("tearing", "the sheet parts where it is stretched too far", p.tearing);
}

void describe(ParameterVisitor& v, Keyframe& p) {
  v.number({"time", "s", between(0, 1e9), "when"}, p.time);
  v.vector({"position", "m", between(-kFar, kFar), "of its middle, relative to the shape as given"}, p.position);
  v.vector({"rotation", "deg", between(-1e6, 1e6), "about its middle: about x, y, z in that order"}, p.rotation);
}

void describe(ParameterVisitor& v, ObstacleParams& p) {
  v.text({"name", "", any_value(), "letters, digits, _ . -"}, p.name);
  v.choice({"kind", "", any_value(), "sphere, box, plane, or mesh (a closed PLY or OBJ)"}, p.kind, kObstacleKinds);
  v.only(p.kind != ObstacleKind::box, "kind is box", [&] {
    v.vector({"center", "m", between(-kFar, kFar), "sphere, mesh: where it is; plane: a point of it"}, p.center);
  });
  v.only(p.kind == ObstacleKind::sphere, "kind is not sphere", [&] {
    v.number({"radius", "m", above_up_to(0, kFar), "sphere"}, p.radius);
  });
  v.only(p.kind == ObstacleKind::box, "kind is not box", [&] {
    v.vector({"lower", "m", between(-kFar, kFar), "box"}, p.lower);
    v.vector({"upper", "m", between(-kFar, kFar), "box"}, p.upper);
  });
  v.only(p.kind == ObstacleKind::plane, "kind is not plane", [&] {
    v.vector({"normal", "1", between(-1, 1), "plane: points out of the solid"}, p.normal);
  });
  v.only(p.kind == ObstacleKind::mesh, "kind is not mesh", [&] {
    v.text({"file", "", any_value(), "mesh: beside the scene"}, p.file);
    v.number({"scale", "1", between(1e-6, 1e6), "mesh"}, p.scale);
    v.number({"spacing", "m", between(1e-6, kFar),
              "mesh: of its sampled signed distance; its parts need two to be kept"},
             p.spacing);
  });
  v.number({"friction", "1", between(0, 100), "Coulomb coefficient, static and kinetic"}, p.friction);
  v.vector({"velocity", "m/s", between(-kFast, kFast), "rigid translation"}, p.velocity);
  v.list("keyframes",
         "instead of a velocity: where it is at times that follow each other; between them it goes straight",
         p.keyframes);
}

void describe(ParameterVisitor& v, HeatSourceParams& p) {
  v.choice({"kind", "", any_value(), "region that is heated: ball, or box along the axes"}, p.kind, kSourceKinds);
  v.only(p.kind == SourceKind::ball, "kind is not ball", [&] {
    v.vector({"center", "m", between(-kFar, kFar), "ball: its middle at time 0"}, p.center);
    v.number({"radius", "m", above_up_to(0, kFar), "ball"}, p.radius);
  });
  v.only(p.kind == SourceKind::box, "kind is not box", [&] {
    v.vector({"lower", "m", between(-kFar, kFar), "box: its lower corner at time 0"}, p.lower);
    v.vector({"upper", "m", between(-kFar, kFar), "box: its upper corner at time 0"}, p.upper);
  });
  v.vector({"velocity", "m/s", between(-kFast, kFast), "of the region"}, p.velocity);
  v.number({"temperature", "K", between(0, 20000), "towards which sheets inside are pulled"}, p.temperature);
  v.number({"rate", "1/s", between(0, 1e9), "at which a sheet inside takes that temperature; 0: the gas only"},
           p.rate);
  v.number({"gas_power", "W", between(0, 1e12), "heat given to the gas"}, p.gas_power);
  v.number({"gas_smoke", "kg/s", between(0, 1e3), "smoke given to the gas"}, p.gas_smoke);
  v.number({"start", "s", between(0, kNever), "when it begins"}, p.start);
  v.number({"stop", "s", between(0, kNever), "when it ends"}, p.stop);
}

void describe(ParameterVisitor& v, WindParams& p) {
  v.vector({"velocity", "m/s", between(-kFast, kFast), "of the air around sheets that are in no gas grid"},
           p.velocity);
  v.number({"gust", "1", between(0, 10), "relative amplitude of smooth gusts"}, p.gust);
  v.only(p.gust > 0.0, "gust is 0", [&] {
    v.number({"gust_period", "s", above_up_to(0, 1e6), "of the slowest gust"}, p.gust_period);
    v.integer({"seed", "", between(0, 2147483647), "of the gusts"}, p.seed);
  });
}

void describe(ParameterVisitor& v, ContactParams& p) {
  describe(v, p.sheets);
  v.flag({"allow_crossings", "", any_value(),
          "start with sheets that pass through themselves or each other: what is crossed stays so"},
         p.allow_crossings);
}

void describe(ParameterVisitor& v, CouplingParams& p) {
  v.choice(
      {"scheme", "", any_value(),
       "simultaneous: pressure and sheet momentum in one solve [Chentanez 2006]; partitioned: one after the other"},
      p.scheme, kSchemes);
  v.only(p.scheme == CouplingScheme::partitioned, "scheme is not partitioned", [&] {
    v.number(
        {"relaxation", "1", between(0, 1),
         "partitioned: share of the newest gas force in the force on a sheet; 0: m/(m + rho l) from the sheet's "
         "mass an "
         "area and half size; too large: the run stops as a runaway, too small: the gas pushes late",
         OnResume::may_change},
        p.relaxation);
  });
  v.number({"max_step", "s", above_up_to(0, 1e4), "longest step of the world; shorter ones follow from the flow",
            OnResume::may_change},
           p.max_step);
  v.number({"sheet_cells", "1", between(0.01, 1e6),
            "cells of the gas grid that a sheet or obstacle may cross in one step", OnResume::may_change},
           p.sheet_cells);
  v.integer(
      {"max_substeps", "1", between(1, 1000000),
       "a frame; steps that would need more are lengthened and counted, or end a partitioned run as a runaway",
       OnResume::may_change},
      p.max_substeps);
}

void describe(ParameterVisitor& v, WorldParams& p) {
  v.vector({"gravity", "m/s2", between(-1e4, 1e4), "acceleration of everything", OnResume::may_change}, p.gravity);
  v.list("shells", "thin sheets", p.shells);
  v.list("obstacles", "rigid bodies", p.obstacles);
  v.section("contact",
            "sheets do not pass through themselves and each other, all in as many substeps as the one that asks "
            "for most; "
            "absent: they do",
            p.contact);
  v.section("smoke", "gas that carries smoke and heat; absent: no gas is simulated", p.smoke);
  v.section("diffusion", "heat on the sheets; absent: sheets carry none", p.diffusion);
  v.only(p.diffusion.has_value(), "there is no diffusion section",
         [&] { v.nested("heat", "sheets as carriers of heat; used with a diffusion section", p.heat); });
  v.section("burning", "mass loss by heat; needs a diffusion section", p.burning);
  v.only(p.diffusion || p.smoke, "there is neither diffusion nor smoke to heat",
         [&] { v.list("heat_sources", "regions that heat sheets and gas", p.heat_sources); });
  v.section("wind", "moving air around sheets; not with a smoke section", p.wind);
  v.nested("coupling", "how gas and sheets are stepped together", p.coupling);
}

}  // namespace wick::coupling
