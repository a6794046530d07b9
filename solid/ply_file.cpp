#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "core/require.h"
#include "solid/mesh_file.h"
#include "solid/mesh_text.h"

namespace wick::solid {

namespace {

enum class Kind { i8, u8, i16, u16, i32, u32, f32, f64 };
constexpr std::size_t kSize[] = {1, 1, 2, 2, 4, 4, 4, 8};

std::optional<Kind> kind_of(std::string_view word) {
  constexpr std::pair<std::string_view, Kind> names[] = {
      {"char", Kind::i8},   {"int8", Kind::i8},     {"uchar", Kind::u8},   {"uint8", Kind::u8},
      {"short", Kind::i16}, {"int16", Kind::i16},   {"ushort", Kind::u16}, {"uint16", Kind::u16},
      {"int", Kind::i32},   {"int32", Kind::i32},   {"uint", Kind::u32},   {"uint32", Kind::u32},
      {"float", Kind::f32}, {"float32", Kind::f32}, {"double", Kind::f64}, {"float64", Kind::f64}};
  for (const auto& [name, kind] : names)
    if (word == name) return kind;
  return std::nullopt;
}

struct Property {
  std::string name;
  Kind value = Kind::f32;
  std::optional<Kind> count;  ///< of a list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

/// Every number of the file goes through a double: exact for all of the types of a PLY file.
template <class T>
double as_double(const char* bytes, bool swap) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (swap) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return static_cast<double>(value);
}

class PlyReader {
 public:
  PlyReader(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  TriangleSoup read() {
    read_header();
    for (const Element& element : elements_) read_element(element);
    if (soup_.positions.empty()) fail("no vertices");
    check_indices();
    keep_material_if_isometric(soup_);
    return std::move(soup_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const std::string where = reading_ ? reading_->name + " " + std::to_string(row_) + " (counted from 0)"
                                       : "line " + std::to_string(line_);
    throw Refusal(ExitCode::scene_invalid, "", name_ + ": " + where + ": " + what);
  }

  void read_header() {
    for (;;) {
      if (rest_.empty()) fail("the file ends inside its header");
      ++line_;
      std::string_view line = take_line(rest_);
      const std::string_view keyword = take_word(line);
      if (keyword == "end_header") break;
      if (keyword == "format")
        read_format(take_word(line));
      else if (keyword == "element")
        read_element_line(line);
      else if (keyword == "property")
        read_property_line(line);
      else if (keyword != "ply" && keyword != "comment" && keyword != "obj_info" && !keyword.empty())
        fail("unknown header line `" + std::string(keyword.substr(0, 40)) + "`");
    }
    if (!has_format_) fail("the header has no `format` line");
  }

  void read_format(std::string_view word) {
    has_format_ = true;
    ascii_ = word == "ascii";
    if (!ascii_ && word != "binary_little_endian" && word != "binary_big_endian")
      fail("unknown format `" + std::string(word.substr(0, 40)) + "`");
    swap_ = (word == "binary_big_endian") != (std::endian::native == std::endian::big);
  }

  void read_element_line(std::string_view line) {
    Element& element = elements_.emplace_back();
    element.name = take_word(line);
    const auto count = to_number<std::uint64_t>(take_word(line));
    if (!count) fail("element `" + element.name.substr(0, 40) + "` has no count");
    element.count = *count;
  }

  void read_property_line(std::string_view line) {
    if (elements_.empty()) fail("a property before any element");
    Property property;
    std::string_view word = take_word(line);
    if (word == "list") {
      property.count = kind_of(take_word(line));
      if (!property.count || *property.count >= Kind::f32) fail("a list needs an integer type for its length");
      word = take_word(line);
    }
    const auto kind = kind_of(word);
    if (!kind) fail("unknown property type `" + std::string(word.substr(0, 40)) + "`");
    property.value = *kind;
    property.name = take_word(line);
    elements_.back().properties.push_back(std::move(property));
  }

  /// A count that the bytes left cannot hold is a lie; believing it would ask for any amount of memory.
  void check_count(const Element& element) const {
    std::size_t least = 0;
    for (const Property& p : element.properties) least += ascii_ ? 2 : kSize[int(p.count.value_or(p.value))];
    // The last number of an ascii file needs no blank behind it.
    if (least > 0 && element.count > (rest_.size() + 1) / least)
      fail("element `" + element.name + "` claims " + std::to_string(element.count) + " rows (the " +
           std::to_string(rest_.size()) + " bytes left cannot hold them)");
    if (element.count > std::size_t{std::numeric_limits<std::int32_t>::max()} && least > 0)
      fail("element `" + element.name + "` has more rows than 32 bits can number");
  }

  void read_element(const Element& element) {
    check_count(element);
    if (element.properties.empty()) return;
    const bool vertices = element.name == "vertex", faces = element.name == "face";
    const auto column = [&](std::initializer_list<std::string_view> names) {
      for (std::size_t k = 0; k < element.properties.size(); ++k)
        for (const std::string_view name : names)
          if (element.properties[k].name == name && !element.properties[k].count) return static_cast<int>(k);
      return -1;
    };
    const int x = column({"x"}), y = column({"y"}), z = column({"z"});
    const int u = column({"u", "s", "texture_u"}), v = column({"v", "t", "texture_v"});
    if (vertices && (x < 0 || y < 0 || z < 0)) fail("vertices have no x, y and z");
    std::vector<double> row(element.properties.size());
    reading_ = &element;
    if (faces) face_element_ = &element;
    for (std::size_t i = 0; i < element.count; ++i) {
      row_ = i;
      for (std::size_t k = 0; k < element.properties.size(); ++k)
        row[k] = read_property(element.properties[k], faces);
      if (!vertices) continue;
      soup_.positions.emplace_back(row[x], row[y], row[z]);
      if (u >= 0 && v >= 0) soup_.material.emplace_back(row[u], row[v]);
    }
    reading_ = nullptr;
  }

  /// A scalar, or the length of a list. The list of a face becomes a fan of triangles.
  double read_property(const Property& property, bool of_face) {
    if (!property.count) return number(property.value);
    const double length = number(*property.count);
    if (!(length >= 0.0 && length <= static_cast<double>(rest_.size()))) fail("a list longer than the file");
    const auto count = static_cast<std::size_t>(length);
    const bool corners = of_face && (property.name == "vertex_indices" || property.name == "vertex_index");
    if (corners && count < 3) fail("has fewer than three corners");
    int first = 0, last = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double value = number(property.value);
      if (!corners) continue;
      if (!(value >= 0.0 && value <= std::numeric_limits<int>::max()) || value != static_cast<int>(value))
        fail("a corner that is no vertex number");
      const int corner = static_cast<int>(value);
      if (k == 0) first = corner;
      if (k >= 2) {
        soup_.triangles.push_back({first, last, corner});
        face_of_.push_back(row_);
      }
      last = corner;
    }
    return length;
  }

  double number(Kind kind) {
    if (ascii_) {
      const std::string_view word = take_word(rest_);
      if (word.empty()) fail("the file ends too early");
      const auto value = to_number<double>(word);
      if (!value) fail("expected a number, found `" + std::string(word.substr(0, 40)) + "`");
      return *value;
    }
    const std::size_t size = kSize[static_cast<int>(kind)];
    if (rest_.size() < size) fail("the file ends too early");
    const char* bytes = rest_.data();
    rest_.remove_prefix(size);
    switch (kind) {
      case Kind::i8:
        return as_double<std::int8_t>(bytes, swap_);
      case Kind::u8:
        return as_double<std::uint8_t>(bytes, swap_);
      case Kind::i16:
        return as_double<std::int16_t>(bytes, swap_);
      case Kind::u16:
        return as_double<std::uint16_t>(bytes, swap_);
      case Kind::i32:
        return as_double<std::int32_t>(bytes, swap_);
      case Kind::u32:
        return as_double<std::uint32_t>(bytes, swap_);
      case Kind::f32:
        return as_double<float>(bytes, swap_);
      case Kind::f64:
        return as_double<double>(bytes, swap_);
    }
    return 0.0;
  }

  void check_indices() {
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t)
      for (const int i : soup_.triangles[t])
        if (i >= static_cast<std::int64_t>(soup_.positions.size())) {
          reading_ = face_element_;
          row_ = face_of_[t];
          fail("names vertex " + std::to_string(i) + " (there are " + std::to_string(soup_.positions.size()) + ")");
        }
  }

  std::string_view rest_;
  const std::string& name_;
  std::size_t line_ = 0;
  const Element *reading_ = nullptr, *face_element_ = nullptr;
  std::size_t row_ = 0;  ///< of the element being read
  bool has_format_ = false, ascii_ = true, swap_ = false;
  std::vector<Element> elements_;
  TriangleSoup soup_;
  std::vector<std::size_t> face_of_;  ///< per triangle
};

}  // namespace

TriangleSoup parse_ply(std::string_view bytes, const std::string& name) {
  return PlyReader(bytes, name).read();
}

}  // namespace wick::solid
