#include "scenes/mesh_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace wick::scenes {

namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written little-endian");

void append(Bytes& bytes, const void* data, std::size_t size) {
  bytes.append(static_cast<const char*>(data), size);
}

void append_vector(Bytes& bytes, const Vec3& v) {
  const float values[3] = {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
  append(bytes, values, sizeof values);
}

std::string header(const coupling::ShellView& view) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\ncomment wick {}\nelement vertex {}\n",
                                 view.name, view.x->size());
  const auto floats = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) text += fmt::format("property float {}\n", name);
  };
  floats({"x", "y", "z", "nx", "ny", "nz", "vx", "vy", "vz"});
  if (view.mesh->has_chart()) floats({"s", "t"});
  for (const char* name : {"red", "green", "blue", "alpha"}) text += fmt::format("property uchar {}\n", name);
  for (const auto& [name, values] : view.values) floats({name.c_str()});
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      view.mesh->triangle_count());
  return text;
}

/// The named values of a view, or null.
const std::vector<float>* find(const coupling::ShellView& view, std::string_view name) {
  for (const auto& [key, values] : view.values)
    if (key == name) return &values;
  return nullptr;
}

Vec3 mix(const Vec3& a, const Vec3& b, double t) {
  return a + (b - a) * std::clamp(t, 0.0, 1.0);
}

}  // namespace

std::array<std::uint8_t, 4> burning_colour(double char_fraction, double saturation, double temperature) {
  const Vec3 paper(0.93, 0.91, 0.86), brown(0.40, 0.23, 0.10), black(0.035, 0.03, 0.03), ember(1.0, 0.48, 0.10);
  constexpr double brown_at = 0.3, black_at = 0.75;  // char fraction of the two turns, by eye
  const double c = std::clamp(char_fraction, 0.0, 1.0);
  Vec3 colour =
      c < brown_at ? mix(paper, brown, c / brown_at) : mix(brown, black, (c - brown_at) / (black_at - brown_at));
  colour *= 1.0 - 0.45 * std::clamp(saturation, 0.0, 1.0);  // wet paper reflects about half as much
  colour = mix(colour, ember, (temperature - 800.0) / 400.0);
  std::array<std::uint8_t, 4> bytes{0, 0, 0, 255};
  for (int i = 0; i < 3; ++i)
    bytes[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(colour[i], 0.0, 1.0)));
  return bytes;
}

Bytes shell_ply(const coupling::ShellView& view, UpAxis up_axis) {
  const std::size_t count = view.x->size();
  const std::vector<Vec3> normals = solid::vertex_normals(*view.mesh, *view.x);
  const std::vector<float>*charred = find(view, "char"), *wet = find(view, "saturation"),
        *hot = find(view, "temperature");
  const auto value = [](const std::vector<float>* values, std::size_t i) { return values ? (*values)[i] : 0.0F; };

  const std::string head = header(view);
  Bytes bytes;
  bytes.reserve(head.size() + count * (48 + 4 * view.values.size()) + 13 * view.mesh->triangle_count());
  append(bytes, head.data(), head.size());
  for (std::size_t i = 0; i < count; ++i) {
    append_vector(bytes, to_axes((*view.x)[i], up_axis));
    append_vector(bytes, to_axes(normals[i], up_axis));
    append_vector(bytes, to_axes((*view.v)[i], up_axis));
    if (view.mesh->has_chart()) {
      const float st[2] = {static_cast<float>(view.mesh->material[i].x()),
                           static_cast<float>(view.mesh->material[i].y())};
      append(bytes, st, sizeof st);
    }
    const auto colour = burning_colour(value(charred, i), value(wet, i), value(hot, i));
    append(bytes, colour.data(), colour.size());
    for (const auto& [name, values] : view.values) append(bytes, &values[i], sizeof(float));
  }
  for (const Int3& triangle : view.mesh->triangles) {
    bytes.push_back(3);
    append(bytes, triangle.data(), sizeof triangle);
  }
  return bytes;
}

}  // namespace wick::scenes
