#pragma once
/// Words and numbers of text mesh files, independent of the locale.
#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace wick::solid {

/// Takes the next word, and the blanks before it, off the front of the line; empty at its end.
inline std::string_view take_word(std::string_view& line) {
  constexpr std::string_view blanks = " \t\r\v\f\n";
  const std::size_t begin = std::min(line.find_first_not_of(blanks), line.size());
  const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// The whole word as a number, or nothing.
template <class T>
std::optional<T> to_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// Takes the next line off the front of the text, without its end.
inline std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

}  // namespace wick::solid
