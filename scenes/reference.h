#pragma once
/// What the parameter list says of itself: `wick explain`, `wick schema` and docs/parameters.md.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/function_ref.h"
#include "core/parameters.h"

namespace wick::scenes {

/// One line of the reference. List elements are named by *, as in /shells/*/name.
struct ParameterRow {
  std::string pointer;
  std::string type;  ///< number, integer, flag, text, choice, number[3], section, list, ...
  std::string unit;
  std::string default_value;  ///< as JSON; empty for sections
  std::string range;
  std::string doc;
  bool may_change_on_resume = false;
};

std::vector<ParameterRow> parameter_rows(FunctionRef<void(ParameterVisitor&)> describe);
/// All parameters of a scene.
std::vector<ParameterRow> scene_rows();

/// The table of all parameters at or below `pointer` (empty: all), as text in columns. Throws Refusal
/// (command_line) naming the nearest pointer where there is none.
std::string explain(const std::string& pointer);
/// The same as a page of tables, one a section.
std::string reference_page();

/// JSON Schema (draft 07) of what describe() lists; unknown keys are not allowed.
nlohmann::ordered_json schema_of(FunctionRef<void(ParameterVisitor&)> describe);
nlohmann::ordered_json scene_schema();

}  // namespace wick::scenes
