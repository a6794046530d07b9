#include "core/require.h"
#include "solid/mesh_file.h"
#include "solid/mesh_text.h"

namespace wick::solid {

namespace {

class ObjReader {
 public:
  explicit ObjReader(const std::string& name) : name_(name) {}

  TriangleSoup read(std::string_view text) {
    std::string joined;
    while (!text.empty()) {
      ++line_;
      std::string_view line = take_line(text);
      if (line.ends_with('\\')) {
        // A backslash continues the line; such lines are rare, so only they are copied.
        joined = line.substr(0, line.size() - 1);
        while (!text.empty()) {
          ++line_;
          const std::string_view more = take_line(text);
          const bool last = !more.ends_with('\\');
          joined += ' ';
          joined += more.substr(0, more.size() - (last ? 0 : 1));
          if (last) break;
        }
        line = joined;
      }
      read_line(line);
    }
    if (soup_.positions.empty()) fail("no vertex in the whole file (is it an OBJ file?)");
    finish_chart();
    return std::move(soup_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Refusal(ExitCode::scene_invalid, "", name_ + ": line " + std::to_string(line_) + ": " + what);
  }

  void read_line(std::string_view line) {
    const std::string_view keyword = take_word(line);
    if (keyword == "v") {
      const double x = number(line), y = number(line), z = number(line);
      soup_.positions.emplace_back(x, y, z);
    } else if (keyword == "vt") {
      const double u = number(line);
      std::string_view rest = line;
      texture_.emplace_back(u, take_word(rest).empty() ? 0.0 : number(line));
    } else if (keyword == "f") {
      read_face(line);
    }
  }

  double number(std::string_view& line) const {
    const std::string_view word = take_word(line);
    const auto value = to_number<double>(word);
    if (!value) fail("expected a number, found `" + std::string(word.substr(0, 40)) + "`");
    return *value;
  }

  /// Numbers count from 1, or backwards from the last one read when negative.
  int index(std::string_view word, std::size_t count, const char* what) const {
    const auto value = to_number<std::int64_t>(word);
    if (!value) fail("face " + std::to_string(face_) + ": `" + std::string(word.substr(0, 40)) + "` is no number");
    const std::int64_t i = *value < 0 ? static_cast<std::int64_t>(count) + *value : *value - 1;
    if (*value == 0 || i < 0 || i >= static_cast<std::int64_t>(count))
      fail("face " + std::to_string(face_) + " (counted from 0) names " + what + " " + std::to_string(*value) +
           " (there are " + std::to_string(count) + " before it)");
    return static_cast<int>(i);
  }

  void read_face(std::string_view line) {
    polygon_.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word.starts_with('#')) break;
      const std::size_t slash = word.find('/');
      const int vertex = index(word.substr(0, slash), soup_.positions.size(), "vertex");
      int texture = -1;
      if (slash != std::string_view::npos) {
        const std::string_view rest = word.substr(slash + 1);
        const std::string_view second = rest.substr(0, rest.find('/'));
        if (!second.empty()) texture = index(second, texture_.size(), "texture vertex");
      }
      note_texture(vertex, texture);
      polygon_.push_back(vertex);
    }
    if (polygon_.size() < 3) fail("face " + std::to_string(face_) + " has fewer than three corners");
    for (std::size_t k = 2; k < polygon_.size(); ++k)
      soup_.triangles.push_back({polygon_[0], polygon_[k - 1], polygon_[k]});
    ++face_;
  }

  /// A chart needs one texture value for each vertex.
  void note_texture(int vertex, int texture) {
    if (texture < 0) chart_ = false;
    if (!chart_) return;
    texture_of_.resize(soup_.positions.size(), -1);
    int& known = texture_of_[vertex];
    if (known >= 0 && texture_[known] != texture_[texture]) chart_ = false;
    known = texture;
  }

  void finish_chart() {
    if (!chart_ || texture_of_.empty()) return;
    texture_of_.resize(soup_.positions.size(), -1);
    for (const int t : texture_of_) soup_.material.push_back(t < 0 ? Vec2(0.0, 0.0) : texture_[t]);
    keep_material_if_isometric(soup_);
  }

  const std::string& name_;
  std::size_t line_ = 0, face_ = 0;
  TriangleSoup soup_;
  std::vector<Vec2> texture_;
  std::vector<int> texture_of_, polygon_;
  bool chart_ = true;
};

}  // namespace

TriangleSoup parse_obj(std::string_view text, const std::string& name) {
  require(text.size() < (std::size_t{1} << 36), "", name + ": larger than 64 GB (too large to read)");
  return ObjReader(name).read(text);
}

}  // namespace wick::solid
