#include "scenes/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "core/require.h"

namespace wick::scenes {

using Json = nlohmann::ordered_json;

namespace {

/// Deeper than any scene; what is deeper is damage or malice.
constexpr std::size_t max_depth = 64;

/// Follows the parser through the text so that every error can say where it stands.
class Track {
 public:
  void enter(bool is_object) {
    require(levels_.size() < max_depth, pointer(),
            fmt::format("nested more than {} levels deep (no scene is)", max_depth));
    levels_.push_back({is_object, "", 0, {}});
  }
  void leave() {
    if (!levels_.empty()) levels_.pop_back();
    finish_value();
  }
  void key(const std::string& name) {
    Level& level = levels_.back();
    level.key = name;
    require(level.seen.insert(name).second, pointer(),
            "the same key twice in one object (only one of the two could count) remove one");
  }
  void finish_value() {
    if (!levels_.empty() && !levels_.back().is_object) ++levels_.back().index;
  }
  [[nodiscard]] std::string pointer() const {
    std::string result;
    for (const Level& level : levels_) {
      if (level.is_object && level.seen.empty()) break;
      result = pointer_to(result, level.is_object ? level.key : std::to_string(level.index));
    }
    return result;
  }

 private:
  struct Level {
    bool is_object;
    std::string key;
    std::size_t index;
    std::set<std::string> seen;
  };
  std::vector<Level> levels_;
};

std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return fmt::format("line {}, column {}", line, before.size() - start + 1);
}

/// What the parser complains of, without its own prefix and on one line.
std::string reason_of(const std::exception& error) {
  std::string_view what = error.what();
  if (const auto end = what.find("] "); end != std::string_view::npos) what.remove_prefix(end + 2);
  if (const auto end = what.find(": "); what.starts_with("parse error at") && end != std::string_view::npos)
    what.remove_prefix(end + 2);
  std::string text;
  for (const char c : what.substr(0, 200)) text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return text;
}

/// Hears the parser and refuses what is no scene.
class Examiner final : public nlohmann::json_sax<Json> {
 public:
  explicit Examiner(std::string_view text) : text_(text) {}
  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return track_.enter(true), true; }
  bool start_array(std::size_t) override { return track_.enter(false), true; }
  bool end_object() override { return track_.leave(), true; }
  bool end_array() override { return track_.leave(), true; }
  bool key(string_t& name) override { return track_.key(name), true; }
  bool parse_error(std::size_t position, const std::string&, const Json::exception& error) override {
    const bool range = dynamic_cast<const Json::out_of_range*>(&error) != nullptr;
    throw Refusal(ExitCode::scene_invalid, track_.pointer(),
                  range ? fmt::format("a number out of range ({}) numbers must be finite", reason_of(error))
                        : fmt::format("not JSON at {} ({})", line_and_column(text_, position), reason_of(error)));
  }

 private:
  bool value() { return track_.finish_value(), true; }

  std::string_view text_;
  Track track_;
};

/// The element of an array that `token` names; its length names a new last element.
Json& element(Json& array, std::string_view token, const std::string& pointer) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), index);
  const bool whole = error == std::errc{} && end == token.data() + token.size();
  require(whole && index <= array.size(), pointer,
          fmt::format("no such element (the array has {}) use an index from 0 to {}; the last one adds an element",
                      array.size(), array.size()),
          ExitCode::command_line);
  if (index == array.size()) array.push_back(Json());
  return array[index];
}

bool is_index(std::string_view token) {
  return !token.empty() && std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::string unescape(std::string token) {
  for (const auto& [from, to] : {std::pair{"~1", "/"}, std::pair{"~0", "~"}})
    for (std::size_t at = token.find(from); at != std::string::npos; at = token.find(from, at + 1))
      token.replace(at, 2, to);
  return token;
}

}  // namespace

Json parse_json(std::string_view text) {
  // First a pass that builds nothing and refuses with a pointer, then one that builds: a parser that is asked to
  // call back while it builds looks through a whole array at the end of each of its elements.
  Examiner examiner(text);
  Json::sax_parse(text.begin(), text.end(), &examiner, Json::input_format_t::json, true, true);
  return Json::parse(text.begin(), text.end(), nullptr, true, true);
}

void set_value(Json& root, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string text(assignment.substr(0, std::min(equals, assignment.size())));
  require(equals != std::string_view::npos && text.starts_with('/'), "",
          fmt::format("--set {} is not /pointer=value (as in --set /frames=24)", in_quotes(assignment)),
          ExitCode::command_line);
  const std::string_view value = assignment.substr(equals + 1);
  const bool removal = value == "null";
  Json *node = &root, *object = nullptr;
  std::string pointer, key;
  for (std::size_t begin = 1; begin <= text.size();) {
    const std::size_t end = std::min(text.find('/', begin), text.size());
    const std::string token = unescape(text.substr(begin, end - begin));
    require(!token.empty(), pointer,
            fmt::format("--set {} has an empty step in its pointer", in_quotes(assignment)),
            ExitCode::command_line);
    pointer = pointer_to(pointer, token);
    if (node->is_null()) *node = is_index(token) ? Json::array() : Json::object();
    require(node->is_structured(), pointer, "--set looks inside a value that is no object or array",
            ExitCode::command_line);
    if (removal && node->is_object() && !node->contains(token)) return;
    object = node->is_object() ? node : nullptr;
    key = token;
    node = node->is_array() ? &element(*node, token, pointer) : &(*node)[token];
    begin = end + 1;
  }
  if (removal && object != nullptr) {
    object->erase(key);
    return;
  }
  try {
    *node = parse_json(value);
  } catch (const Refusal&) {
    // A word without quotes is meant as a string; what looks like an object or array is not.
    if (value.starts_with('{') || value.starts_with('[')) throw;
    *node = std::string(value);
  }
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 80;
  std::string shown =
      Json(std::string(text.substr(0, longest))).dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > longest) shown.insert(shown.size() - 1, "...");
  return shown;
}

std::string pointer_to(const std::string& parent, std::string_view key) {
  std::string result = parent + '/';
  for (const char c : key) {
    if (c == '~')
      result += "~0";
    else if (c == '/')
      result += "~1";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return result;
}

}  // namespace wick::scenes
