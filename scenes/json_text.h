#pragma once
/// JSON as scene files need it: comments allowed, everything doubtful refused with the place where it stands.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace wick::scenes {

/// Parses one JSON text with // and /* */ comments. Throws Refusal (scene_invalid), with the pointer where one
/// is known and line and column where not: syntax, duplicate keys, numbers beyond double, more than 64 levels.
nlohmann::ordered_json parse_json(std::string_view text);

/// Applies one `--set /pointer=value`. `value` is read as JSON where it is JSON, as a string where it is not.
/// `null` removes a member of an object, as there is nothing else that it could be. Missing objects are created; a
/// missing array element is created when its index is the array's length.
void set_value(nlohmann::ordered_json& root, std::string_view assignment);

/// A string in quotes, control characters escaped: fit for a one-line message.
std::string in_quotes(std::string_view text);

/// Appends one token to a JSON pointer, escaped.
std::string pointer_to(const std::string& parent, std::string_view key);

}  // namespace wick::scenes
