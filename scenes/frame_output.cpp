#include "scenes/frame_output.h"

#include <chrono>

#include "scenes/checkpoint.h"
#include "scenes/mesh_output.h"
#include "scenes/motion_output.h"

namespace wick::scenes {

FrameOutput gather_outputs(const coupling::World& world, const Scene& scene, const RunFolder& folder,
                           const std::string& scene_sha256) {
  FrameOutput output;
  output.frame = world.frame();
  const fluid::SmokeState* smoke = world.smoke();
  if (smoke && scene.world.smoke && scene.output.volume.write) {
    output.volume_path = folder.volume(scene.output, world.frame());
    VolumeFrame volume;
    // Pressure is not written, so it is not copied.
    volume.state.velocity = smoke->velocity;
    volume.state.density = smoke->density;
    volume.state.temperature = smoke->temperature;
    volume.state.flame = smoke->flame;
    volume.grid = fluid::smoke_grid(*scene.world.smoke);
    volume.ambient_temperature = scene.world.smoke->ambient_temperature;
    volume.frame = file_number(scene.output, world.frame());
    volume.time = world.time();
    volume.fps = scene.fps;
    volume.scene_sha256 = scene_sha256;
    output.volume = std::move(volume);
  }
  if (scene.output.mesh.write)
    for (const coupling::ShellView& view : world.shells())
      output.files.emplace_back(folder.mesh(scene.output, view.name, world.frame()),
                                shell_ply(view, scene.output.up_axis));
  if (scene.output.mesh.write && coupling::sheds_embers(scene.world))
    output.files.emplace_back(folder.mesh(scene.output, coupling::embers_name, world.frame()),
                              ember_ply(world.embers(), scene.output.up_axis));
  if (scene.output.motion.write)
    for (const coupling::ShellView& view : world.shells())
      output.files.emplace_back(folder.motion_frame(scene.output, view.name, world.frame()),
                                motion_frame(view, world.frame(), world.time()));
  if (scene.output.preview.write) {
    output.preview_path = folder.preview(scene.output, world.frame());
    output.preview = draw_preview(scene.output.preview, world.shells(), world.embers(), world.obstacles(), smoke,
                                  scene.world.smoke ? &*scene.world.smoke : nullptr);
  }
  return output;
}

double write_outputs(const FrameOutput& output, const OutputParams& params, const RunFolder& folder,
                     Manifest& manifest) {
  const auto write = [&](const std::filesystem::path& path, const Bytes& bytes) {
    write_file(path, bytes);
    manifest.add(folder.root, path, output.frame, bytes);
  };
  if (output.volume) write(output.volume_path, smoke_vdb(*output.volume, params.volume, params.up_axis));
  for (const auto& [path, bytes] : output.files) write(path, bytes);
  if (output.preview) {
    const std::vector<char> png = encode_png(*output.preview);
    write(output.preview_path, Bytes(png.begin(), png.end()));
  }
  if (!output.metrics.empty()) {
    write_file(folder.metrics(), output.metrics);
    write_file(folder.manifest(), manifest.text());
  }
  const auto start = std::chrono::steady_clock::now();
  if (output.checkpoint.empty()) return 0.0;
  write_file(folder.checkpoints() / checkpoint_name(output.frame), output.checkpoint);
  prune_checkpoints(folder.checkpoints(), output.frame, params.checkpoint.keep);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace wick::scenes
