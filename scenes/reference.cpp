#include "scenes/reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/require.h"
#include "scenes/json_text.h"
#include "scenes/parameter_text.h"
#include "scenes/scene.h"
#include "scenes/scene_file.h"

namespace wick::scenes {

using Json = nlohmann::ordered_json;

namespace {

/// Lists every parameter once; of lists and absent sections, a default element.
class RowCollector final : public ParameterVisitor {
 public:
  RowCollector(std::vector<ParameterRow>& rows, std::string parent) : rows_(rows), parent_(std::move(parent)) {}

  void number(const About& about, double& value) override {
    add(about, "number", number_text(value), range_text(about.range));
  }
  void integer(const About& about, int& value) override {
    add(about, "integer", std::to_string(value), range_text(about.range));
  }
  void flag(const About& about, bool& value) override { add(about, "flag", value ? "true" : "false", ""); }
  void text(const About& about, std::string& value) override { add(about, "text", Json(value).dump(), ""); }
  void numbers(const About& about, std::span<double> values) override {
    std::vector<std::string> texts;
    for (const double value : values) texts.push_back(number_text(value));
    add(about, fmt::format("number[{}]", values.size()), fmt::format("[{}]", fmt::join(texts, ", ")),
        range_text(about.range));
  }
  void integers(const About& about, std::span<int> values) override {
    add(about, fmt::format("integer[{}]", values.size()), fmt::format("[{}]", fmt::join(values, ", ")),
        range_text(about.range));
  }
  void index_list(const About& about, std::vector<int>& values) override {
    add(about, "integer[]", fmt::format("[{}]", fmt::join(values, ", ")), range_text(about.range));
  }
  void choice_index(const About& about, int& value, std::span<const char* const> names) override {
    add(about, "choice", fmt::format("\"{}\"", names[static_cast<std::size_t>(value)]),
        fmt::format("{}", fmt::join(names, ", ")));
  }
  void group(const char* key, const char* doc, FunctionRef<void(ParameterVisitor&)> describe) override {
    section(pointer_to(parent_, key), "section", doc, describe);
  }
  void optional_group(const char* key, const char* doc, bool, FunctionRef<void(bool)>,
                      FunctionRef<void(ParameterVisitor&)> describe) override {
    section(pointer_to(parent_, key), "optional section", doc, describe);
  }
  void group_list(const char* key, const char* doc, std::size_t, FunctionRef<void(std::size_t)>,
                  FunctionRef<void(ParameterVisitor&, std::size_t)>,
                  FunctionRef<void(ParameterVisitor&)> describe_default) override {
    section(pointer_to(parent_, key) + "/*", "list of sections", doc, describe_default);
  }

 private:
  void add(const About& about, const std::string& type, const std::string& value, const std::string& range) {
    rows_.push_back({pointer_to(parent_, about.key), type, about.unit, value, range, about.doc,
                     about.on_resume == OnResume::may_change});
  }
  void section(const std::string& pointer, const char* type, const char* doc,
               FunctionRef<void(ParameterVisitor&)> describe) {
    rows_.push_back({pointer, type, "", "", "", doc, false});
    RowCollector inner(rows_, pointer);
    describe(inner);
  }

  std::vector<ParameterRow>& rows_;
  std::string parent_;
};

bool is_section(const ParameterRow& row) {
  return row.type.ends_with("section") || row.type.ends_with("sections");
}

/// Pointers are asked for as they stand in a scene: /shells/0/name means /shells/*/name.
std::string with_stars(const std::string& pointer) {
  std::string result;
  for (std::size_t begin = 1; begin < pointer.size();) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    const std::string token = pointer.substr(begin, end - begin);
    const bool index =
        !token.empty() && std::all_of(token.begin(), token.end(), [](char c) { return c >= '0' && c <= '9'; });
    result += '/';
    result += index ? "*" : token;
    begin = end + 1;
  }
  return result;
}

bool is_at_or_below(const std::string& pointer, const std::string& root) {
  return pointer == root || pointer.starts_with(root + '/');
}

std::string resume_text(const ParameterRow& row) {
  return is_section(row) ? "" : row.may_change_on_resume ? "may change" : "fixed";
}

std::string columns(const std::vector<ParameterRow>& rows) {
  std::vector<std::array<std::string, 6>> cells = {{"pointer", "type", "unit", "default", "range", "on resume"}};
  for (const ParameterRow& row : rows)
    cells.push_back({row.pointer, row.type, row.unit, row.default_value, row.range, resume_text(row)});
  std::array<std::size_t, 6> width{};
  for (const auto& line : cells)
    for (std::size_t c = 0; c < line.size(); ++c) width[c] = std::max(width[c], line[c].size());
  std::string text;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (std::size_t c = 0; c < cells[r].size(); ++c) text += fmt::format("{:<{}}  ", cells[r][c], width[c]);
    text += r == 0 ? "meaning" : rows[r - 1].doc;
    text += '\n';
  }
  return text;
}

std::string markdown_cell(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c;
  }
  return result;
}

std::string section_of(const std::string& pointer) {
  return pointer.substr(0, pointer.rfind('/'));
}

}  // namespace

std::vector<ParameterRow> parameter_rows(FunctionRef<void(ParameterVisitor&)> describe) {
  std::vector<ParameterRow> rows;
  RowCollector collector(rows, "");
  describe(collector);
  return rows;
}

std::vector<ParameterRow> scene_rows() {
  Scene scene;
  return parameter_rows([&](ParameterVisitor& v) { describe(v, scene); });
}

std::string explain(const std::string& pointer) {
  std::vector<ParameterRow> rows = scene_rows();
  std::vector<std::string> known;
  for (const ParameterRow& row : rows) {
    known.push_back(row.pointer);
    if (row.type == "list of sections") known.push_back(section_of(row.pointer));
  }
  const std::string root =
      with_stars(pointer.starts_with('/') || pointer.empty() ? pointer : fmt::format("/{}", pointer));
  if (root.empty()) return columns(rows);
  std::erase_if(rows, [&](const ParameterRow& row) { return !is_at_or_below(row.pointer, root); });
  const std::string near = nearest(root, known);
  require(!rows.empty(), "",
          fmt::format("no parameter {} (pointers look like /smoke/resolution) {}", in_quotes(pointer),
                      near.empty() ? "see `wick explain`" : fmt::format("did you mean {}?", near)),
          ExitCode::command_line);
  return columns(rows);
}

std::string reference_page() {
  std::string page =
      "# Parameters\n\nEvery parameter of a scene file. `wick explain --markdown` writes this page from the list "
      "that "
      "the\nprogram itself reads; `wick explain /pointer` shows one part of it. SI units throughout. `*` stands "
      "for\nthe "
      "index of a list element. A parameter marked *may change* can differ when a run is resumed.\n";
  const auto table = [&](const std::vector<ParameterRow>& rows, const std::string& section) {
    page +=
        "\n| parameter | type | unit | default | range | on resume | meaning |\n|---|---|---|---|---|---|---|\n";
    for (const ParameterRow& row : rows) {
      if (is_section(row) || section_of(row.pointer) != section) continue;
      page += fmt::format("| `{}` | {} | {} | `{}` | {} | {} | {} |\n", row.pointer, row.type, row.unit,
                          row.default_value, markdown_cell(row.range), resume_text(row), markdown_cell(row.doc));
    }
  };
  const std::vector<ParameterRow> rows = scene_rows();
  table(rows, "");
  for (const ParameterRow& row : rows) {
    if (!is_section(row)) continue;
    page += fmt::format("\n## `{}`\n\n{} ({}).\n", row.pointer, row.doc, row.type);
    const bool any = std::any_of(rows.begin(), rows.end(), [&](const ParameterRow& other) {
      return !is_section(other) && section_of(other.pointer) == row.pointer;
    });
    if (any) table(rows, row.pointer);
  }
  return page;
}

}  // namespace wick::scenes
