#pragma once
/// Reading scene files. The reader is a visitor over the parameter list: keys are taken in the order of the
/// list, not of the file, because a preset listed first resets what comes after it.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/require.h"
#include "scenes/scene.h"

namespace wick::scenes {

/// Reads `path`, applies the `--set` assignments in order and checks everything that a scene can be wrong in.
/// Throws Refusal with the JSON pointer at fault.
Scene read_scene(const std::filesystem::path& path, const std::vector<std::string>& assignments = {});

/// The same for JSON that is already in memory; `directory` is where mesh and motion files are looked for; recorded
/// motions are read.
Scene scene_from_json(const nlohmann::ordered_json& json, const std::string& directory);

/// Fills one parameter struct from a JSON object through its describe(). Returns a warning for each parameter that
/// the object changes and that has no effect beside the others, with its pointer in front.
std::vector<std::string> read_parameters(const nlohmann::ordered_json& json,
                                         FunctionRef<void(ParameterVisitor&)> describe);

/// One line for the user: `file: /pointer: problem (why) suggestion`.
std::string format_refusal(const std::string& file, const Refusal& refusal);

/// The known word that `word` is most likely a misspelling of; empty where none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

}  // namespace wick::scenes
