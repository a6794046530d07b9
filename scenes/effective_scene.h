#pragma once
/// The scene with every default written out, and the part of it that a resumed run must not change.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/function_ref.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// Every parameter of `scene`; reading it back gives the same scene.
nlohmann::ordered_json effective_json(const Scene& scene);

/// The parameters that describe() lists, as JSON.
nlohmann::ordered_json parameters_json(FunctionRef<void(ParameterVisitor&)> describe);

/// The effective scene as a file for the output folder: mesh files are named relative to `folder`, so that
/// the file can be run from there.
std::string effective_file(const Scene& scene, const std::filesystem::path& folder);

/// The mesh and motion files that the scene names, each with the pointer of the parameter that names it.
std::vector<std::pair<std::filesystem::path, std::string>> input_files(const Scene& scene);

/// What makes two runs the same run: all parameters that may not change on resume, and the content of the
/// mesh and motion files, as JSON text.
std::string scene_identity(const Scene& scene);

/// The name of the scene of that identity; empty where there is none.
std::string name_in_identity(const std::string& identity);

/// What two effective scenes of the same run set differently, each as "/pointer was one value, is another". Frames
/// are left out, as a run is asked for them anew each time, and names of files, of which the content counts.
/// Empty where one of the texts is no scene.
std::vector<std::string> changed_settings(const std::string& before, const std::string& now);

/// Names the first difference between two identities, for a message; empty where there is none.
std::string identity_difference(const std::string& before, const std::string& now);

}  // namespace wick::scenes
