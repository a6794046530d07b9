#pragma once
/// Recording the movement of the sheets. Every frame leaves a small file of its own, motion/frames/<shell>.0001.h5,
/// written, entered in the manifest and verified on resume as volumes and meshes are; when the last frame is there
/// they are joined into motion/<shell>.h5. So recording costs the same in every frame, a kill costs the frames
/// since the last checkpoint and nothing else, and the joined file depends only on the frames, not on how often the
/// run was interrupted. The price is that positions are on the disk twice.
#include <vector>

#include "coupling/world.h"
#include "scenes/manifest.h"
#include "scenes/run_folder.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// The bytes of one frame's file: /frame /time /x (V x 3).
Bytes motion_frame(const coupling::ShellView& shell, int frame, double time);

/// Writes motion/<shell>.h5 of all frames up to the world's, where the scene asks for it and the manifest does not
/// say that it has been done. Frames whose file is missing or damaged are left out, and returned.
std::vector<DamagedOutput> join_motion(const coupling::World& world, const Scene& scene, const RunFolder& folder,
                                       Manifest& manifest);

}  // namespace wick::scenes
