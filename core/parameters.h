#pragma once
/// Every parameter is listed once, in the describe() of its Params struct. Reading a scene, --set,
/// error messages, `wick explain`, the JSON Schema, the effective scene and the reference page are all
/// visitors over that one list. This header knows nothing of JSON.
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/function_ref.h"
#include "core/types.h"

namespace wick {

/// Whether a run that continues from a checkpoint may change the value.
enum class OnResume { fixed, may_change };

/// Closed range of allowed values; an exclusive lower end is told by `above`.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above = false;  ///< true: value > min instead of value >= min
};
inline Range at_least(double min) {
  return {min, std::numeric_limits<double>::infinity(), false};
}
inline Range above(double min) {
  return {min, std::numeric_limits<double>::infinity(), true};
}
inline Range between(double min, double max) {
  return {min, max, false};
}
inline Range above_up_to(double min, double max) {
  return {min, max, true};
}
inline Range any_value() {
  return {};
}

/// What a parameter is, besides its value. `unit` is "1" for pure numbers, "" for things without a unit.
struct About {
  const char* key;
  const char* unit;
  Range range;
  const char* doc;  ///< one line: meaning, symbol, source, symptom of a bad value
  OnResume on_resume = OnResume::fixed;
};

class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;

  virtual void number(const About& about, double& value) = 0;
  virtual void integer(const About& about, int& value) = 0;
  virtual void flag(const About& about, bool& value) = 0;
  virtual void text(const About& about, std::string& value) = 0;
  /// `range` holds for every component.
  virtual void numbers(const About& about, std::span<double> values) = 0;
  virtual void integers(const About& about, std::span<int> values) = 0;
  virtual void index_list(const About& about, std::vector<int>& values) = 0;
  /// `value` is the position of the chosen name in `names`.
  virtual void choice_index(const About& about, int& value, std::span<const char* const> names) = 0;

  /// Lists parameters that have an effect only where `effective`, as told by the parameters before them;
  /// `otherwise` says why they have none ("kind is not ball"). Readers warn of those that are set all the same.
  virtual void only(bool /*effective*/, const char* /*otherwise*/, FunctionRef<void()> list) { list(); }

  /// A JSON object. `names` in error messages become /key/...
  virtual void group(const char* key, const char* doc, FunctionRef<void(ParameterVisitor&)> describe) = 0;
  /// An object that may be absent. engage(true) makes it exist with its defaults.
  virtual void optional_group(const char* key, const char* doc, bool present, FunctionRef<void(bool)> engage,
                              FunctionRef<void(ParameterVisitor&)> describe) = 0;
  /// An array of objects. resize(n) makes n default elements; describe(v, i) lists element i.
  /// Visitors that show defaults resize a copy: `describe_default` lists a default element.
  virtual void group_list(const char* key, const char* doc, std::size_t count,
                          FunctionRef<void(std::size_t)> resize,
                          FunctionRef<void(ParameterVisitor&, std::size_t)> describe,
                          FunctionRef<void(ParameterVisitor&)> describe_default) = 0;

  void vector(const About& about, Vec3& value) { numbers(about, std::span<double>(value.data(), 3)); }
  void vector(const About& about, Vec2& value) { numbers(about, std::span<double>(value.data(), 2)); }
  void vector(const About& about, Int3& value) { integers(about, value); }
  void vector(const About& about, Int2& value) { integers(about, value); }

  /// One of an enum whose values are 0, 1, 2, ... in the order of `names`.
  template <class E>
  void choice(const About& about, E& value, std::span<const char* const> names) {
    int index = static_cast<int>(value);
    choice_index(about, index, names);
    value = static_cast<E>(index);
  }
  /// A nested struct with its own free describe(ParameterVisitor&, T&).
  template <class T>
  void nested(const char* key, const char* doc, T& value) {
    group(key, doc, [&](ParameterVisitor& v) { describe(v, value); });
  }
  template <class T>
  void section(const char* key, const char* doc, std::optional<T>& value) {
    optional_group(
        key, doc, value.has_value(),
        [&](bool present) { present ? static_cast<void>(value.emplace()) : value.reset(); },
        [&](ParameterVisitor& v) {
          if (value) return describe(v, *value);
          T defaults{};
          describe(v, defaults);
        });
  }
  template <class T>
  void list(const char* key, const char* doc, std::vector<T>& values) {
    group_list(
        key, doc, values.size(), [&](std::size_t count) { values.assign(count, T{}); },
        [&](ParameterVisitor& v, std::size_t i) { describe(v, values[i]); },
        [&](ParameterVisitor& v) {
          T defaults{};
          describe(v, defaults);
        });
  }
};

}  // namespace wick
