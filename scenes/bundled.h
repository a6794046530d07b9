#pragma once
/// The scenes that come with the program.
#include <filesystem>
#include <string>
#include <vector>

namespace wick::scenes {

/// Folder of the bundled scenes: share/wick/scenes beside an installed program, else the source tree's.
std::filesystem::path bundled_folder();
/// The scene files of a folder, by name.
std::vector<std::filesystem::path> scene_files(const std::filesystem::path& folder);
/// `name` as a path where such a file is, else the bundled scene of that name. Throws Refusal (input_missing)
/// naming the nearest bundled scene.
std::filesystem::path find_scene(const std::string& name);
/// One line a scene: name, frames, what is in it.
std::string list_of_scenes(const std::filesystem::path& folder);

}  // namespace wick::scenes
