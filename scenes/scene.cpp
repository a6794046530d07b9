#include "scenes/scene.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/parameters.h"
#include "core/require.h"

namespace wick::scenes {

namespace {

constexpr const char* precision_names[] = {"half", "float"};
constexpr const char* up_axis_names[] = {"z", "y"};
constexpr const char* velocity_unit_names[] = {"second", "frame"};
constexpr OnResume may_change = OnResume::may_change;

}  // namespace

void describe(ParameterVisitor& v, GridNames& p) {
  v.text({"density", "", {}, "name of the smoke density grid [kg/m3]", may_change}, p.density);
  v.text({"temperature", "", {}, "name of the temperature grid, absolute [K]", may_change}, p.temperature);
  v.text({"flame", "", {}, "name of the flame grid, 0 to 1", may_change}, p.flame);
  v.text({"velocity",
          "",
          {},
          "name of the velocity grid; vel is the one that Blender, Houdini and Arnold all find",
          may_change},
         p.velocity);
}

void describe(ParameterVisitor& v, ClipParams& p) {
  v.number(
      {"density", "kg/m3", at_least(0), "thinner smoke is not stored; too high: plumes end abruptly", may_change},
      p.density);
  v.number({"temperature", "K", at_least(0), "gas closer to ambient than this is not stored", may_change},
           p.temperature);
  v.number({"flame", "1", at_least(0), "weaker flame is not stored", may_change}, p.flame);
  v.number(
      {"velocity", "m/s", at_least(0), "slower gas is not stored; too high: motion blur ends abruptly", may_change},
      p.velocity);
}

void describe(ParameterVisitor& v, VolumeParams& p) {
  v.flag({"write", "", {}, "write volumes/smoke.####.vdb of scenes with smoke", may_change}, p.write);
  v.choice({"precision", "", {}, "16-bit half or 32-bit float values; half rounds 1500 K to 0.5 K", may_change},
           p.precision, precision_names);
  v.choice(
      {"velocity_unit", "", {}, "velocities in m/s, or in m per frame for renderers that take no unit", may_change},
      p.velocity_unit, velocity_unit_names);
  v.nested("names", "names of the grids", p.names);
  v.nested("clip", "values nearer to the background than these are not stored", p.clip);
}

void describe(ParameterVisitor& v, MeshOutputParams& p) {
  v.flag({"write", "", {}, "write meshes/<shell>.####.ply", may_change}, p.write);
}

void describe(ParameterVisitor& v, MotionOutputParams& p) {
  v.flag({"write", "", {}, "write motion/<shell>.h5 at the end, from a file a frame; may not change on the way"},
         p.write);
}

void describe(ParameterVisitor& v, CheckpointParams& p) {
  v.integer({"every", "frames", between(0, 1000000),
             "frames from one checkpoint to the next; 0: only on a signal and at the end", may_change},
            p.every);
  v.integer({"keep", "1", between(2, 1000), "how many of the last checkpoints stay on the disk", may_change},
            p.keep);
}

void describe(ParameterVisitor& v, OutputParams& p) {
  v.choice({"up_axis", "", {}, "axis that points up in every output; y turns volumes and meshes together"},
           p.up_axis, up_axis_names);
  v.integer({"frame_start", "1", between(0, 1000000), "number in the file names of the initial state"},
            p.frame_start);
  v.integer({"frame_padding", "1", between(1, 9), "digits of the frame number in file names"}, p.frame_padding);
  v.nested("volume", "OpenVDB files of the smoke", p.volume);
  v.nested("mesh", "PLY files of the sheets", p.mesh);
  v.nested("motion", "recorded movement of the sheets, for shells/*/motion of another run", p.motion);
  v.nested("preview", "pictures of the frames", p.preview);
  v.nested("checkpoint", "files from which an interrupted run goes on", p.checkpoint);
}

void describe(ParameterVisitor& v, Scene& scene) {
  v.text({"name", "", {}, "name of the scene and of its default output folder: A-Z a-z 0-9 _ . -"}, scene.name);
  v.integer({"frames", "1", between(1, 10000000), "frames to compute, the initial state included", may_change},
            scene.frames);
  v.number({"fps", "1/s", between(1e-3, 1e6), "frames a second of simulated time"}, scene.fps);
  describe(v, scene.world);
  v.nested("output", "what is written", scene.output);
}

namespace {

/// A step may not be longer than max_step, nor a frame have more steps than max_substeps.
void require_enough_steps(const Scene& scene) {
  const coupling::CouplingParams& coupling = scene.world.coupling;
  const double least = std::ceil(1.0 / scene.fps / coupling.max_step * (1.0 - 1e-9));
  require(least <= coupling.max_substeps, "/fps",
          fmt::format("a frame of {:.4g} s takes {:.0f} steps or more of /coupling/max_step, {:.4g} s "
                      "(/coupling/max_substeps allows {}) raise that, or take more frames a second",
                      1.0 / scene.fps, least, coupling.max_step, coupling.max_substeps));
}

/// A recorded motion has the same vertices in every frame.
void require_lasting_vertices(const Scene& scene) {
  if (!scene.output.motion.write) return;
  for (std::size_t n = 0; n < scene.world.shells.size(); ++n)
    require(!scene.world.shells[n].tearing, "/output/motion/write",
            fmt::format("cannot record sheets that tear (vertices come); remove /shells/{}/tearing", n));
  if (!scene.world.burning) return;
  const coupling::BurningParams& burning = *scene.world.burning;
  require(
      burning.removal <= burning.ash || burning.rim == coupling::BurntRim::whole, "/output/motion/write",
      "cannot record sheets whose mesh is cut as they burn (vertices come and go); set /burning/rim to \"whole\", "
      "or /burning/removal to 0");
}

}  // namespace

void require_valid(const Scene& scene) {
  require_enough_steps(scene);
  require_lasting_vertices(scene);
  std::set<std::string> grids;
  const GridNames& names = scene.output.volume.names;
  const std::pair<const char*, const std::string*> entries[] = {{"density", &names.density},
                                                                {"temperature", &names.temperature},
                                                                {"flame", &names.flame},
                                                                {"velocity", &names.velocity}};
  for (const auto& [key, name] : entries) {
    const std::string pointer = fmt::format("/output/volume/names/{}", key);
    require(!name->empty(), pointer, "an empty name (renderers find grids by name)");
    require(grids.insert(*name).second, pointer,
            fmt::format("\"{}\" names two grids (a renderer would see one) give each a name of its own", *name));
  }
}

}  // namespace wick::scenes
