#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "coupling/world.h"
#include "coupling/world_parts.h"
#include "fluid/smoke.h"
#include "scenes/disk_estimate.h"
#include "scenes/effective_scene.h"
#include "scenes/machine.h"
#include "scenes/preview_gas.h"
#include "scenes/run.h"

namespace wick::scenes {

namespace {

using coupling::MemoryShare;

/// What outputs hold beside the world: two copies of the fields that wait to be written, the sparse grids and
/// bytes of one file, and one checkpoint in the making (image and copy), in bytes a cell of gas.
constexpr double output_bytes_per_cell = 2 * 24 + 2 * 24 + 2 * 28;

/// The canvas of a preview (colour and depth), the picture, and its PNG as it is made, waits and is written.
constexpr double preview_bytes_per_pixel = 24 + 8 + 3 + 4 * 3;

/// Joining recorded motion holds the largest sheet's file twice, as the HDF5 library's image and as a copy of it.
double motion_memory(const Scene& scene) {
  double vertices = 0.0;
  for (const coupling::ShellSection& shell : scene.world.shells)
    vertices = std::max(vertices, coupling::estimated_vertices(shell, scene.world));
  return 2.0 * 24.0 * vertices * scene.frames;
}

std::vector<MemoryShare> memory_shares(const Scene& scene) {
  std::vector<MemoryShare> shares = coupling::World::estimate_memory(scene.world);
  if (scene.world.smoke) {
    const Int3& n = scene.world.smoke->resolution;
    shares.push_back({"/smoke/resolution", output_bytes_per_cell * n[0] * n[1] * n[2], "lower the resolution"});
  }
  if (scene.output.motion.write)
    shares.push_back({"/output/motion/write", motion_memory(scene), "record fewer frames, or a coarser sheet"});
  const Int2& size = scene.output.preview.size;
  if (scene.output.preview.write)
    shares.push_back({"/output/preview/size", preview_bytes_per_pixel * size[0] * size[1], "make it smaller"});
  if (scene.output.preview.write && scene.world.smoke) {
    const Int3& n = scene.world.smoke->resolution;
    shares.push_back(
        {"/smoke/resolution", preview_gas_bytes_per_cell * n[0] * n[1] * n[2], "lower the resolution"});
  }
  return shares;
}

std::uint64_t needed_memory(const Scene& scene) {
  double bytes = 0.0;
  for (const MemoryShare& share : memory_shares(scene)) bytes += share.bytes;
  return static_cast<std::uint64_t>(std::min(bytes, 1e18));
}

/// The parameter to change: of the section that asks for most, the one that asks for half of it or more, or else
/// the section as a whole.
MemoryShare largest_share(const Scene& scene) {
  MemoryShare program{"", 0.0, "free some of it"};
  std::map<std::string, MemoryShare> by_pointer, by_section;
  for (const MemoryShare& share : memory_shares(scene)) {
    if (share.pointer.empty()) {
      program.bytes += share.bytes;
      continue;
    }
    const std::string section = share.pointer.substr(0, share.pointer.find('/', 1));
    for (MemoryShare* sum : {&by_pointer[share.pointer], &by_section[section]}) {
      sum->bytes += share.bytes;
      sum->advice = share.advice;
    }
    by_pointer[share.pointer].pointer = share.pointer;
    by_section[section].pointer = section;
    by_section[section].advice = "use fewer or smaller ones";
  }
  const auto largest = [](const std::map<std::string, MemoryShare>& of, const std::string& within) {
    MemoryShare found;
    for (const auto& [pointer, share] : of)
      if (share.bytes > found.bytes && pointer.starts_with(within)) found = share;
    return found;
  };
  const MemoryShare section = largest(by_section, "");
  if (program.bytes >= section.bytes) return program;
  const MemoryShare one = largest(by_pointer, section.pointer + "/");
  return 2.0 * one.bytes >= section.bytes ? one : section;
}

void print_smoke(const fluid::SmokeParams& smoke) {
  const fluid::Grid grid = fluid::smoke_grid(smoke);
  fmt::print("smoke    {} x {} x {} cells of {:.4g} mm, box {:.4g} x {:.4g} x {:.4g} m\n", grid.nx, grid.ny,
             grid.nz, 1e3 * grid.h, grid.nx * grid.h, grid.ny * grid.h, grid.nz * grid.h);
}

}  // namespace

void require_memory(const Scene& scene) {
  const std::uint64_t needed = needed_memory(scene), available = available_memory();
  if (needed <= available) return;
  const MemoryShare largest = largest_share(scene);
  throw Refusal(ExitCode::refused, largest.pointer,
                fmt::format("needs about {} of memory, with all else {} (this machine has {} free) {}",
                            bytes_text(static_cast<std::uint64_t>(std::min(largest.bytes, 1e18))),
                            bytes_text(needed), bytes_text(available), largest.advice));
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
  for (const std::string& text : scene.warnings) fmt::print(stderr, "wick: warning: {}\n", text);
  for (const std::string& text : world.warnings()) fmt::print(stderr, "wick: warning: {}\n", text);
  const std::string shortage = disk_shortage(disk, scene, 0, folder);
  if (!shortage.empty()) fmt::print(stderr, "wick: warning: {}\n", shortage);
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
