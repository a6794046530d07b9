#include "scenes/effective_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/parameters.h"
#include "core/require.h"
#include "core/state.h"
#include "scenes/atomic_file.h"
#include "scenes/json_text.h"
#include "scenes/machine.h"

namespace wick::scenes {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

enum class Selection { all, fixed_on_resume };

class JsonWriter final : public ParameterVisitor {
 public:
  explicit JsonWriter(Selection selection) : selection_(selection) {}
  Json take() { return std::move(object_); }

  void number(const About& about, double& value) override { put(about, value); }
  void integer(const About& about, int& value) override { put(about, value); }
  void flag(const About& about, bool& value) override { put(about, value); }
  void text(const About& about, std::string& value) override { put(about, value); }
  void numbers(const About& about, std::span<double> values) override {
    put(about, std::vector<double>(values.begin(), values.end()));
  }
  void integers(const About& about, std::span<int> values) override {
    put(about, std::vector<int>(values.begin(), values.end()));
  }
  void index_list(const About& about, std::vector<int>& values) override { put(about, values); }
  void choice_index(const About& about, int& value, std::span<const char* const> names) override {
    put(about, std::string(names[static_cast<std::size_t>(value)]));
  }
  void group(const char* key, const char*, FunctionRef<void(ParameterVisitor&)> describe) override {
    object_[key] = inner(describe);
  }
  void optional_group(const char* key, const char*, bool present, FunctionRef<void(bool)>,
                      FunctionRef<void(ParameterVisitor&)> describe) override {
    if (present) object_[key] = inner(describe);
  }
  void group_list(const char* key, const char*, std::size_t count, FunctionRef<void(std::size_t)>,
                  FunctionRef<void(ParameterVisitor&, std::size_t)> describe,
                  FunctionRef<void(ParameterVisitor&)>) override {
    Json array = Json::array();
    for (std::size_t i = 0; i < count; ++i) array.push_back(inner([&](ParameterVisitor& v) { describe(v, i); }));
    object_[key] = std::move(array);
  }

 private:
  template <class T>
  void put(const About& about, const T& value) {
    if (selection_ == Selection::all || about.on_resume == OnResume::fixed) object_[about.key] = value;
  }
  Json inner(FunctionRef<void(ParameterVisitor&)> describe) const {
    JsonWriter writer(selection_);
    describe(writer);
    return writer.take();
  }

  Selection selection_;
  Json object_ = Json::object();
};

Json json_of(const Scene& scene, Selection selection) {
  // Visitors take references that they may write through; a writer of JSON does not, but the list asks for it.
  Scene copy = scene;
  JsonWriter writer(selection);
  describe(writer, copy);
  return writer.take();
}

/// Calls `visit` with each non-empty text whose key is `file`, the mesh and motion files of the scene, and with its
/// pointer.
void for_each_file(Json& node, const std::string& pointer,
                   FunctionRef<void(Json& file, const std::string& pointer)> visit) {
  if (!node.is_structured()) return;
  for (auto& [key, value] : node.items()) {
    const std::string here = pointer_to(pointer, key);
    if (key == "file" && value.is_string() && !value.get_ref<const std::string&>().empty())
      visit(value, here);
    else
      for_each_file(value, here, visit);
  }
}

/// The content of a mesh or motion file; refusals name the parameter that named the file.
Bytes read_input(const fs::path& path, const std::string& pointer) {
  try {
    return read_file(path, available_memory() / 2);
  } catch (const Refusal& refusal) {
    throw Refusal(refusal.code(), pointer, refusal.what());
  }
}

}  // namespace

Json effective_json(const Scene& scene) {
  return json_of(scene, Selection::all);
}

Json parameters_json(FunctionRef<void(ParameterVisitor&)> describe) {
  JsonWriter writer(Selection::all);
  describe(writer);
  return writer.take();
}

std::string effective_file(const Scene& scene, const fs::path& folder) {
  Json json = effective_json(scene);
  for_each_file(json, "", [&](Json& file, const std::string&) {
    const fs::path path = file.get<std::string>();
    if (path.is_absolute()) return;
    std::error_code error;
    const fs::path relative = fs::relative(fs::path(scene.world.directory) / path, folder, error);
    if (!error && !relative.empty()) file = relative.string();
  });
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::pair<fs::path, std::string>> input_files(const Scene& scene) {
  std::vector<std::pair<fs::path, std::string>> files;
  Json json = effective_json(scene);
  for_each_file(json, "", [&](Json& file, const std::string& pointer) {
    files.emplace_back(fs::path(scene.world.directory) / file.get<std::string>(), pointer);
  });
  return files;
}

std::string scene_identity(const Scene& scene) {
  Json json = json_of(scene, Selection::fixed_on_resume);
  for_each_file(json, "", [&](Json& file, const std::string& pointer) {
    const Bytes bytes = read_input(fs::path(scene.world.directory) / file.get<std::string>(), pointer);
    file = fmt::format("content {:016x}", hash_bytes(bytes.data(), bytes.size()));
  });
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string name_in_identity(const std::string& identity) {
  const auto json = nlohmann::json::parse(identity, nullptr, false);
  return json.is_object() && json.contains("name") && json["name"].is_string() ? json["name"] : "";
}

std::vector<std::string> changed_settings(const std::string& before, const std::string& now) {
  const auto flat = [](const std::string& text) {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    return json.is_object() ? json.flatten() : nlohmann::json::object();
  };
  const nlohmann::json old_scene = flat(before), new_scene = flat(now);
  std::vector<std::string> changed;
  for (const auto& [pointer, value] : new_scene.items()) {
    const auto old_value = old_scene.find(pointer);
    if (old_value == old_scene.end() || *old_value == value) continue;
    if (pointer == "/frames" || pointer.ends_with("/file")) continue;
    changed.push_back(fmt::format("{} was {}, is {}", pointer, old_value->dump(), value.dump()));
  }
  return changed;
}

std::string identity_difference(const std::string& before, const std::string& now) {
  const auto parse = [](const std::string& text) { return nlohmann::json::parse(text, nullptr, false); };
  const nlohmann::json old_scene = parse(before), new_scene = parse(now);
  if (old_scene == new_scene) return "";
  if (old_scene.is_discarded() || new_scene.is_discarded()) return "the whole scene";
  const auto patch = nlohmann::json::diff(new_scene, old_scene);
  std::string pointer = patch.at(0).at("path").get<std::string>();
  if (pointer.ends_with("/-")) pointer.resize(pointer.size() - 2);  // an element more or less: the list is shown
  const auto shown = [&](const nlohmann::json& scene) {
    const nlohmann::json::json_pointer at(pointer);
    if (!scene.contains(at)) return std::string("absent");
    const std::string text = scene.at(at).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    return text.size() > 60 ? text.substr(0, 60) + "..." : text;
  };
  return fmt::format("{} was {}, is {}", pointer, shown(old_scene), shown(new_scene));
}

}  // namespace wick::scenes
