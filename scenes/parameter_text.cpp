#include "scenes/parameter_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/require.h"
#include "scenes/json_text.h"

namespace wick::scenes {

namespace {

constexpr std::size_t longest_name = 64;

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

}  // namespace

const char* const name_pattern = "^[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}$";

bool within(double value, const Range& range) {
  return value <= range.max && (range.above ? value > range.min : value >= range.min);
}

std::string number_text(double value) {
  if (std::isfinite(value) && value == std::floor(value) && std::abs(value) < 1e7)
    return fmt::format("{:.0f}", value);
  return fmt::format("{}", value);
}

std::string range_text(const Range& range) {
  const bool below = std::isfinite(range.min), over = std::isfinite(range.max);
  if (!below && !over) return "any";
  if (!over) return fmt::format("{} {}", range.above ? ">" : ">=", number_text(range.min));
  if (!below) return fmt::format("<= {}", number_text(range.max));
  if (range.above) return fmt::format("above {} to {}", number_text(range.min), number_text(range.max));
  return fmt::format("{} to {}", number_text(range.min), number_text(range.max));
}

Range integer_range(const Range& range) {
  constexpr double lowest = std::numeric_limits<int>::min(), highest = std::numeric_limits<int>::max();
  if (range.min < lowest) return {lowest, std::min(range.max, highest), false};
  return {range.min, std::min(range.max, highest), range.above};
}

bool is_name(const About& about) {
  return std::string_view(about.key) == "name";
}

bool is_valid_name(std::string_view name) {
  if (name.empty() || name.size() > longest_name || name.front() == '.' || name.front() == '-') return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return is_letter_or_digit(c) || c == '_' || c == '.' || c == '-'; });
}

void require_name(const std::string& name, const std::string& pointer) {
  require(
      is_valid_name(name), pointer,
      fmt::format("{} cannot be a name (it becomes a file name) use 1 to {} of A-Z a-z 0-9 _ . - and begin with a "
                  "letter, digit or _",
                  in_quotes(name), longest_name));
}

}  // namespace wick::scenes
