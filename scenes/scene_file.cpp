#include "scenes/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/parameters.h"
#include "scenes/atomic_file.h"
#include "scenes/json_text.h"
#include "scenes/motion_file.h"
#include "scenes/parameter_text.h"

namespace wick::scenes {

using Json = nlohmann::ordered_json;

namespace {

/// Geometry stays in mesh files, so no scene comes near this.
constexpr std::uint64_t largest_scene = 16 << 20;

const char* type_of(const Json& node) {
  if (node.is_number()) return "a number";
  if (node.is_boolean()) return node.get<bool>() ? "true" : "false";
  return node.is_string() ? "a string" : node.is_null() ? "null" : node.is_array() ? "an array" : "an object";
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t swap = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, swap});
    }
  }
  return row.back();
}

/// What a reader tells besides the values.
struct Remarks {
  std::vector<std::string>& warnings;
  const char* idle = nullptr;  ///< why the parameters that are being listed have no effect; null: they have
};

/// Reads one JSON object; every nested object has a reader of its own.
class ParameterReader final : public ParameterVisitor {
 public:
  ParameterReader(const Json& object, std::string pointer, const Remarks& remarks)
      : object_(object), pointer_(std::move(pointer)), remarks_(remarks) {
    require(object.is_object(), pointer_,
            fmt::format("expected an object, found {} (sections are written in braces)", type_of(object)));
  }

  void number(const About& about, double& value) override {
    if (const Json* node = take(about.key)) assign(about, value, real(*node, about.range, here(about.key)));
  }
  void integer(const About& about, int& value) override {
    if (const Json* node = take(about.key)) assign(about, value, whole(*node, about.range, here(about.key)));
  }
  void flag(const About& about, bool& value) override {
    const Json* node = take(about.key);
    if (!node) return;
    expect(node->is_boolean(), "true or false", *node, here(about.key));
    assign(about, value, node->get<bool>());
  }
  void text(const About& about, std::string& value) override {
    const Json* node = take(about.key);
    if (!node) return;
    expect(node->is_string(), "a string", *node, here(about.key));
    assign(about, value, node->get<std::string>());
    if (is_name(about)) require_name(value, here(about.key));
    require(value.find('\0') == std::string::npos, here(about.key), "holds a zero byte (no name or file can)");
  }
  void numbers(const About& about, std::span<double> values) override {
    const Json* node = fixed_array(about.key, values.size(), "numbers");
    std::vector<double> read(values.begin(), values.end());
    for (std::size_t i = 0; node && i < values.size(); ++i)
      read[i] = real((*node)[i], about.range, pointer_to(here(about.key), std::to_string(i)));
    assign_all(about, values, read);
  }
  void integers(const About& about, std::span<int> values) override {
    const Json* node = fixed_array(about.key, values.size(), "whole numbers");
    std::vector<int> read(values.begin(), values.end());
    for (std::size_t i = 0; node && i < values.size(); ++i)
      read[i] = whole((*node)[i], about.range, pointer_to(here(about.key), std::to_string(i)));
    assign_all(about, values, read);
  }
  void index_list(const About& about, std::vector<int>& values) override {
    const Json* node = take(about.key);
    if (!node) return;
    expect(node->is_array(), "an array of whole numbers", *node, here(about.key));
    values.clear();
    for (std::size_t i = 0; i < node->size(); ++i)
      values.push_back(whole((*node)[i], about.range, pointer_to(here(about.key), std::to_string(i))));
  }
  void choice_index(const About& about, int& value, std::span<const char* const> names) override {
    const Json* node = take(about.key);
    if (!node) return;
    expect(node->is_string(), "one of the names of a choice", *node, here(about.key));
    const std::vector<std::string> known(names.begin(), names.end());
    const auto found = std::find(known.begin(), known.end(), node->get_ref<const std::string&>());
    require(found != known.end(), here(about.key),
            fmt::format("{} is not a choice (there are {}) {}", in_quotes(node->get_ref<const std::string&>()),
                        fmt::join(known, ", "), suggestion(node->get<std::string>(), known)));
    assign(about, value, static_cast<int>(found - known.begin()));
  }
  void group(const char* key, const char*, FunctionRef<void(ParameterVisitor&)> describe) override {
    if (const Json* node = take(key)) read(*node, here(key), remarks_, describe);
  }
  void only(bool effective, const char* otherwise, FunctionRef<void()> list) override {
    const char* const outer = remarks_.idle;
    if (outer == nullptr && !effective) remarks_.idle = otherwise;
    list();
    remarks_.idle = outer;
  }
  void optional_group(const char* key, const char*, bool present, FunctionRef<void(bool)> engage,
                      FunctionRef<void(ParameterVisitor&)> describe) override {
    const Json* node = take(key);
    if (!node) return;
    require(!node->is_null(), here(key),
            "null is no section (it could mean none, or its defaults) leave the key out for none, or write {}");
    if (!present) engage(true);
    read(*node, here(key), remarks_, describe);
  }
  void group_list(const char* key, const char*, std::size_t, FunctionRef<void(std::size_t)> resize,
                  FunctionRef<void(ParameterVisitor&, std::size_t)> describe,
                  FunctionRef<void(ParameterVisitor&)>) override {
    const Json* node = take(key);
    if (!node) return;
    expect(node->is_array(), "an array of objects", *node, here(key));
    require(node->size() <= longest_list, here(key),
            fmt::format("{} elements (at most {} are allowed)", node->size(), longest_list));
    if (!node->empty()) remark(key);
    resize(node->size());
    for (std::size_t i = 0; i < node->size(); ++i)
      read((*node)[i], pointer_to(here(key), std::to_string(i)), {remarks_.warnings},
           [&](ParameterVisitor& v) { describe(v, i); });
  }

  static void read(const Json& node, const std::string& pointer, const Remarks& remarks,
                   FunctionRef<void(ParameterVisitor&)> describe) {
    ParameterReader reader(node, pointer, remarks);
    describe(reader);
    reader.require_all_known();
  }

 private:
  [[nodiscard]] std::string here(const char* key) const { return pointer_to(pointer_, key); }

  /// Warns of `key` where it has no effect.
  void remark(const char* key) {
    if (remarks_.idle == nullptr) return;
    remarks_.warnings.push_back(fmt::format("{}: has no effect ({})", here(key), remarks_.idle));
  }
  /// What an effective scene repeats, the defaults of parameters without effect, is no cause for a warning.
  template <class T>
  void assign(const About& about, T& value, T read) {
    if (!(read == value)) remark(about.key);
    value = std::move(read);
  }
  template <class T>
  void assign_all(const About& about, std::span<T> values, const std::vector<T>& read) {
    if (!std::equal(read.begin(), read.end(), values.begin())) remark(about.key);
    std::copy(read.begin(), read.end(), values.begin());
  }

  /// The value of `key` if the file has one; either way the key is known from now on.
  const Json* take(const char* key) {
    known_.emplace_back(key);
    const auto found = object_.find(key);
    return found == object_.end() ? nullptr : &*found;
  }
  const Json* fixed_array(const char* key, std::size_t size, const char* of) {
    const Json* node = take(key);
    if (!node) return nullptr;
    const std::string what = fmt::format("an array of {} {}", size, of);
    expect(node->is_array(), what.c_str(), *node, here(key));
    require(node->size() == size, here(key), fmt::format("{} elements (it must be {})", node->size(), what));
    return node;
  }
  static void expect(bool right, const char* wanted, const Json& node, const std::string& pointer) {
    if (right) return;
    const std::string value = node.is_number() || node.is_string() ? fmt::format(" {}", quoted_value(node)) : "";
    throw Refusal(ExitCode::scene_invalid, pointer,
                  fmt::format("expected {}, found {}{} (wrong type)", wanted, type_of(node), value));
  }
  static std::string quoted_value(const Json& node) {
    return node.is_string() ? in_quotes(node.get_ref<const std::string&>()) : node.dump();
  }
  static double real(const Json& node, const Range& range, const std::string& pointer) {
    expect(node.is_number(), "a number", node, pointer);
    const double value = node.get<double>();
    require(std::isfinite(value) && within(value, range), pointer,
            fmt::format("{} is out of range (allowed: {})", node.dump(), range_text(range)));
    return value;
  }
  static int whole(const Json& node, const Range& range, const std::string& pointer) {
    expect(node.is_number(), "a whole number", node, pointer);
    const double value = node.get<double>();
    require(std::isfinite(value) && value == std::floor(value), pointer,
            fmt::format("expected a whole number, found {} (wrong type)", node.dump()));
    const Range allowed = integer_range(range);
    require(within(value, allowed), pointer,
            fmt::format("{} is out of range (allowed: {})", node.dump(), range_text(allowed)));
    return static_cast<int>(value);
  }
  static std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
    const std::string near = nearest(word, known);
    return near.empty() ? "see `wick explain`" : fmt::format("did you mean {}?", in_quotes(near));
  }
  void require_all_known() const {
    for (const auto& [key, value] : object_.items()) {
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      throw Refusal(
          ExitCode::scene_invalid, pointer_to(pointer_, key.substr(0, 80)),
          fmt::format("unknown key (this section has {}) {}", fmt::join(known_, ", "), suggestion(key, known_)));
    }
  }

  const Json& object_;
  std::string pointer_;
  Remarks remarks_;
  std::vector<std::string> known_;
};

}  // namespace

std::string nearest(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t smallest = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = word.size() > 100 ? word.size() : edit_distance(word, candidate);
    if (distance < smallest) {
      smallest = distance;
      best = candidate;
    }
  }
  // A word that shares less than half of its letters is no misspelling.
  return smallest <= std::max<std::size_t>(2, best.size() / 2) ? best : "";
}

std::vector<std::string> read_parameters(const Json& json, FunctionRef<void(ParameterVisitor&)> describe) {
  std::vector<std::string> warnings;
  ParameterReader::read(json, "", {warnings}, describe);
  return warnings;
}

Scene scene_from_json(const Json& json, const std::string& directory) {
  Scene scene;
  scene.warnings = read_parameters(json, [&](ParameterVisitor& v) { describe(v, scene); });
  scene.world.directory = directory;
  require_valid(scene);
  read_motions(scene);
  return scene;
}

Scene read_scene(const std::filesystem::path& path, const std::vector<std::string>& assignments) {
  const Bytes bytes = read_file(path, largest_scene);
  Json json = parse_json(bytes);
  for (const std::string& assignment : assignments) set_value(json, assignment);
  const std::filesystem::path parent = path.parent_path();
  if (json.is_object() && !json.contains("name")) {
    const std::string stem = path.stem().string();
    if (is_valid_name(stem)) json["name"] = stem;
  }
  return scene_from_json(json, parent.empty() ? "." : parent.string());
}

std::string format_refusal(const std::string& file, const Refusal& refusal) {
  std::string line;
  if (!file.empty()) line += file + ": ";
  if (!refusal.pointer().empty()) line += refusal.pointer() + ": ";
  for (const char c : std::string_view(refusal.what())) line += c == '\n' ? ' ' : c;
  return line;
}

}  // namespace wick::scenes
