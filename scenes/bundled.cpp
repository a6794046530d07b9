#include "scenes/bundled.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/require.h"
#include "scenes/machine.h"
#include "scenes/scene_file.h"
#include "scenes/version.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

std::string counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string contents(const Scene& scene) {
  std::string text = counted(static_cast<std::size_t>(scene.frames), "frame");
  if (!scene.world.shells.empty()) text += fmt::format(", {}", counted(scene.world.shells.size(), "shell"));
  if (scene.world.smoke) {
    const Int3& n = scene.world.smoke->resolution;
    text += fmt::format(", smoke {}x{}x{}", n[0], n[1], n[2]);
  }
  if (scene.world.diffusion) text += ", diffusion";
  if (scene.world.burning) text += ", burning";
  return text;
}

}  // namespace

fs::path bundled_folder() {
  const fs::path installed = fs::path(program_folder()).parent_path() / "share/wick/scenes";
  std::error_code error;
  return fs::is_directory(installed, error) ? installed : fs::path(source_scenes);
}

std::vector<fs::path> scene_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".json") files.push_back(it->path());
  std::sort(files.begin(), files.end());
  return files;
}

fs::path find_scene(const std::string& name) {
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  if (fs::exists(name, error)) throw Refusal(ExitCode::input_missing, "", "not a file");
  std::vector<std::string> known;
  for (const fs::path& file : scene_files(bundled_folder())) {
    known.push_back(file.stem().string());
    if (name == known.back() || name == file.filename()) return file;
  }
  const std::string near = nearest(fs::path(name).stem().string(), known);
  throw Refusal(ExitCode::input_missing, "",
                near.empty()
                    ? "no such file, and no bundled scene of that name (see `wick list`)"
                    : fmt::format("no such file, and no bundled scene of that name (see `wick list`) did you "
                                  "mean {}?",
                                  near));
}

std::string list_of_scenes(const fs::path& folder) {
  std::string text;
  for (const fs::path& file : scene_files(folder)) {
    std::string what;
    try {
      what = contents(read_scene(file));
    } catch (const Refusal& refusal) {
      what = "not valid: " + format_refusal("", refusal);
    }
    text += fmt::format("{:<28}{}\n", file.stem().string(), what);
  }
  return text;
}

}  // namespace wick::scenes
