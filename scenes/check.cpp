#include <fmt/format.h>

#include <algorithm>

#include "coupling/sources.h"
#include "coupling/world.h"
#include "fluid/smoke.h"
#include "scenes/disk_estimate.h"
#include "scenes/effective_scene.h"
#include "scenes/machine.h"
#include "scenes/run.h"

namespace wick::scenes {

namespace {

/// What outputs hold beside the world: two copies of the fields that wait to be written, the sparse grids and
/// bytes of one file, and one checkpoint in the making (image and copy), in bytes a cell of gas.
constexpr std::uint64_t output_bytes_per_cell = 2 * 24 + 2 * 24 + 2 * 28;

/// Joining recorded motion holds the largest sheet's file twice, as the HDF5 library's image and as a copy of it.
std::uint64_t motion_memory(const Scene& scene) {
  double vertices = 0.0;
  if (scene.output.motion.write)
    for (const coupling::ShellSection& shell : scene.world.shells)
      vertices = std::max(vertices, coupling::estimated_vertices(shell, scene.world));
  return static_cast<std::uint64_t>(std::min(2.0 * 24.0 * vertices * scene.frames, 1e18));
}

std::uint64_t needed_memory(const Scene& scene) {
  std::uint64_t bytes = coupling::World::estimate_bytes(scene.world) + motion_memory(scene);
  if (scene.world.smoke) {
    const Int3& n = scene.world.smoke->resolution;
    bytes += output_bytes_per_cell * static_cast<std::uint64_t>(n[0]) * n[1] * n[2];
  }
  return bytes;
}

void print_smoke(const fluid::SmokeParams& smoke) {
  const fluid::Grid grid = fluid::smoke_grid(smoke);
  fmt::print("smoke    {} x {} x {} cells of {:.4g} mm, box {:.4g} x {:.4g} x {:.4g} m\n", grid.nx, grid.ny,
             grid.nz, 1e3 * grid.h, grid.nx * grid.h, grid.ny * grid.h, grid.nz * grid.h);
}

}  // namespace

void require_memory(const Scene& scene) {
  const std::uint64_t needed = needed_memory(scene), available = available_memory();
  const auto have = [&](const char* pointer, const char* advice) {
    require(needed <= available, pointer,
            fmt::format("needs about {} of memory (this machine has {} free) {}", bytes_text(needed),
                        bytes_text(available), advice),
            ExitCode::refused);
  };
  if (2 * motion_memory(scene) > needed) have("/output/motion/write", "record fewer frames, or a coarser sheet");
  have(scene.world.smoke ? "/smoke/resolution" : "/shells", "lower the resolution");
}

void check_scene(const RunOptions& options) {
  const Scene scene = load_scene(options);
  require_memory(scene);
  static_cast<void>(scene_identity(scene));  // reads the mesh files
  coupling::World world(scene.world);
  const DiskEstimate disk = estimate_disk(world, scene);
  const std::filesystem::path folder = output_folder(options, scene);
  require_disk(disk, folder);
  if (options.quiet) return;
  fmt::print("scene    {}: {} frames at {:.4g} a second, {:.4g} s\n", scene.name, scene.frames, scene.fps,
             (scene.frames - 1) / scene.fps);
  fmt::print("models   {}\n", fmt::join(world.models(), ", "));
  for (const coupling::ShellView& shell : world.shells())
    fmt::print("shell    {}: {} vertices, {} triangles\n", shell.name, shell.mesh->vertex_count(),
               shell.mesh->triangle_count());
  if (scene.world.smoke) print_smoke(*scene.world.smoke);
  fmt::print("memory   about {} of {} free\n", bytes_text(needed_memory(scene)), bytes_text(available_memory()));
  fmt::print("disk     at most {} a frame and {} in all, of {} free\n", bytes_text(disk.frame),
             bytes_text(disk.all), bytes_text(free_disk(folder)));
  fmt::print("the scene is valid\n");
}

}  // namespace wick::scenes
