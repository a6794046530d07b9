#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "scenes/parameter_text.h"
#include "scenes/reference.h"
#include "scenes/scene.h"

namespace wick::scenes {

using Json = nlohmann::ordered_json;

namespace {

Json object_schema(FunctionRef<void(ParameterVisitor&)> describe);

void add_range(Json& schema, const Range& range) {
  if (std::isfinite(range.min)) schema[range.above ? "exclusiveMinimum" : "minimum"] = range.min;
  if (std::isfinite(range.max)) schema["maximum"] = range.max;
}

Json number_schema(const Range& range) {
  Json schema = {{"type", "number"}};
  add_range(schema, range);
  return schema;
}

Json integer_schema(const Range& range) {
  Json schema = {{"type", "integer"}};
  add_range(schema, integer_range(range));
  return schema;
}

Json array_schema(Json items, std::size_t least, std::size_t most) {
  Json schema = {{"type", "array"}, {"items", std::move(items)}};
  if (least > 0) schema["minItems"] = least;
  if (most != std::numeric_limits<std::size_t>::max()) schema["maxItems"] = most;
  return schema;
}

class SchemaWriter final : public ParameterVisitor {
 public:
  Json take() {
    return {{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties_)}};
  }

  void number(const About& about, double& value) override { put(about, number_schema(about.range), value); }
  void integer(const About& about, int& value) override { put(about, integer_schema(about.range), value); }
  void flag(const About& about, bool& value) override { put(about, {{"type", "boolean"}}, value); }
  void text(const About& about, std::string& value) override {
    Json schema = {{"type", "string"}};
    if (is_name(about)) schema["pattern"] = name_pattern;
    put(about, std::move(schema), value);
  }
  void numbers(const About& about, std::span<double> values) override {
    put(about, array_schema(number_schema(about.range), values.size(), values.size()),
        std::vector<double>(values.begin(), values.end()));
  }
  void integers(const About& about, std::span<int> values) override {
    put(about, array_schema(integer_schema(about.range), values.size(), values.size()),
        std::vector<int>(values.begin(), values.end()));
  }
  void index_list(const About& about, std::vector<int>& values) override {
    put(about, array_schema(integer_schema(about.range), 0, std::numeric_limits<std::size_t>::max()), values);
  }
  void choice_index(const About& about, int& value, std::span<const char* const> names) override {
    const std::vector<std::string> choices(names.begin(), names.end());
    put(about, {{"enum", choices}}, choices[static_cast<std::size_t>(value)]);
  }
  void group(const char* key, const char* doc, FunctionRef<void(ParameterVisitor&)> describe) override {
    properties_[key] = object_schema(describe);
    properties_[key]["description"] = doc;
  }
  void optional_group(const char* key, const char* doc, bool, FunctionRef<void(bool)>,
                      FunctionRef<void(ParameterVisitor&)> describe) override {
    properties_[key] = object_schema(describe);
    properties_[key]["description"] = doc;
  }
  void group_list(const char* key, const char* doc, std::size_t, FunctionRef<void(std::size_t)>,
                  FunctionRef<void(ParameterVisitor&, std::size_t)>,
                  FunctionRef<void(ParameterVisitor&)> describe_default) override {
    properties_[key] = array_schema(object_schema(describe_default), 0, longest_list);
    properties_[key]["description"] = doc;
  }

 private:
  template <class T>
  void put(const About& about, Json schema, const T& value) {
    const std::string_view unit = about.unit;
    schema["description"] = unit.empty() ? about.doc : fmt::format("{} [{}]", about.doc, unit);
    schema["default"] = value;
    properties_[about.key] = std::move(schema);
  }

  Json properties_ = Json::object();
};

Json object_schema(FunctionRef<void(ParameterVisitor&)> describe) {
  SchemaWriter writer;
  describe(writer);
  return writer.take();
}

}  // namespace

Json schema_of(FunctionRef<void(ParameterVisitor&)> describe) {
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "wick scene"}};
  schema.update(object_schema(describe));
  return schema;
}

Json scene_schema() {
  Scene scene;
  return schema_of([&](ParameterVisitor& v) { describe(v, scene); });
}

}  // namespace wick::scenes
