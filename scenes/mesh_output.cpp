#include "scenes/mesh_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "scenes/sheet_color.h"

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

/// The vertices that a triangle still names, in their order.
std::vector<std::int32_t> living_vertices(const solid::ShellMesh& mesh) {
  std::vector<std::int32_t> living;
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i)
    if (mesh.incident_offset[i + 1] > mesh.incident_offset[i]) living.push_back(static_cast<std::int32_t>(i));
  return living;
}

std::string header(const coupling::ShellView& view, std::size_t vertices) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\ncomment wick {}\nelement vertex {}\n",
                                 view.name, vertices);
  const auto floats = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) text += fmt::format("property float {}\n", name);
  };
  floats({"x", "y", "z", "nx", "ny", "nz", "vx", "vy", "vz"});
  if (view.mesh->has_chart()) floats({"s", "t"});
  for (const char* name : {"red", "green", "blue", "alpha"}) text += fmt::format("property uchar {}\n", name);
  for (const auto& [name, values] : view.values) floats({name.c_str()});
  text += "property int id\n";
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                      view.mesh->triangle_count());
  return text;
}

/// Linear light to an sRGB byte [IEC 61966-2-1].
std::uint8_t srgb_byte(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * s));
}

}  // namespace

Bytes shell_ply(const coupling::ShellView& view, UpAxis up_axis) {
  const std::vector<std::int32_t> living = living_vertices(*view.mesh);
  const std::vector<Vec3> normals = solid::vertex_normals(*view.mesh, *view.x);
  const std::vector<SheetColor> colors = sheet_colors(view);
  const std::string head = header(view, living.size());
  std::vector<std::int32_t> place(view.x->size(), -1);
  Bytes bytes;
  bytes.reserve(head.size() + living.size() * (52 + 4 * view.values.size()) + 13 * view.mesh->triangle_count());
  append(bytes, head.data(), head.size());
  for (std::size_t k = 0; k < living.size(); ++k) {
    const auto i = static_cast<std::size_t>(living[k]);
    place[i] = static_cast<std::int32_t>(k);
    append_vector(bytes, to_axes((*view.x)[i], up_axis));
    append_vector(bytes, to_axes(normals[i], up_axis));
    append_vector(bytes, to_axes((*view.v)[i], up_axis));
    if (view.mesh->has_chart()) {
      const float st[2] = {static_cast<float>(view.mesh->material[i].x()),
                           static_cast<float>(view.mesh->material[i].y())};
      append(bytes, st, sizeof st);
    }
    std::array<std::uint8_t, 4> rgba{0, 0, 0, 255};
    for (int c = 0; c < 3; ++c) rgba[c] = srgb_byte(colors[i].reflected[c] + colors[i].emitted[c]);
    append(bytes, rgba.data(), rgba.size());
    for (const auto& [name, values] : view.values) append(bytes, &values[i], sizeof(float));
    append(bytes, &living[k], sizeof living[k]);
  }
  for (const Int3& triangle : view.mesh->triangles) {
    bytes.push_back(3);
    for (const std::int32_t i : triangle) append(bytes, &place[i], sizeof place[i]);
  }
  return bytes;
}

Bytes ember_ply(const coupling::EmberView& view, UpAxis up_axis) {
  std::string head = fmt::format("ply\nformat binary_little_endian 1.0\ncomment wick {}\nelement vertex {}\n",
                                 coupling::embers_name, view.x->size());
  for (const char* name : {"x", "y", "z", "vx", "vy", "vz", "radius", "temperature"})
    head += fmt::format("property float {}\n", name);
  for (const char* name : {"red", "green", "blue", "alpha"}) head += fmt::format("property uchar {}\n", name);
  head += "property int id\nend_header\n";
  Bytes bytes(head.begin(), head.end());
  for (std::size_t n = 0; n < view.x->size(); ++n) {
    append_vector(bytes, to_axes((*view.x)[n], up_axis));
    append_vector(bytes, to_axes((*view.v)[n], up_axis));
    append(bytes, &view.radius[n], sizeof(float));
    append(bytes, &view.temperature[n], sizeof(float));
    const Vec3 color = ash_color() + glow_color(view.temperature[n]);
    const std::array<std::uint8_t, 4> rgba{srgb_byte(color[0]), srgb_byte(color[1]), srgb_byte(color[2]), 255};
    append(bytes, rgba.data(), rgba.size());
    const auto id = static_cast<std::int32_t>((*view.id)[n]);
    append(bytes, &id, sizeof id);
  }
  return bytes;
}

}  // namespace wick::scenes
