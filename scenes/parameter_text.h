#pragma once
/// What the reader, the schema and the reference page say alike about parameters.
#include <string>
#include <string_view>

#include "core/parameters.h"

namespace wick::scenes {

/// More shells, sources or pins than any run could hold.
inline constexpr std::size_t longest_list = 100000;

[[nodiscard]] bool within(double value, const Range& range);
/// As in "> 0", "0 to 1", "any".
[[nodiscard]] std::string range_text(const Range& range);
/// The part of a range that an int can hold.
[[nodiscard]] Range integer_range(const Range& range);
/// The shortest decimal text that reads back as the same number.
[[nodiscard]] std::string number_text(double value);

/// Texts with the key `name` become file names: A-Z a-z 0-9 _ . - only, not beginning with a dot or a dash.
[[nodiscard]] bool is_name(const About& about);
[[nodiscard]] bool is_valid_name(std::string_view name);
extern const char* const name_pattern;
/// Throws Refusal where `name` is not valid.
void require_name(const std::string& name, const std::string& pointer);

}  // namespace wick::scenes
