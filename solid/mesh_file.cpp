#include "solid/mesh_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/require.h"

namespace wick::solid {

namespace {

std::string read_bytes(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  require(!error && std::filesystem::exists(status), "", path + ": no such file", ExitCode::input_missing);
  require(std::filesystem::is_regular_file(status), "", path + ": not a regular file", ExitCode::input_missing);
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  require(!error && file.good(), "", path + ": cannot be opened for reading", ExitCode::input_missing);
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

}  // namespace

TriangleSoup read_mesh_file(const std::string& path) {
  const std::string bytes = read_bytes(path);
  const bool ply = bytes.starts_with("ply\n") || bytes.starts_with("ply\r");
  require(ply || !path.ends_with(".ply"), "", path + ": line 1: does not begin with `ply` (so it is no PLY file)");
  return ply ? parse_ply(bytes, path) : parse_obj(bytes, path);
}

void keep_material_if_isometric(TriangleSoup& soup) {
  if (soup.material.empty()) return;
  constexpr double tolerance = 0.01;
  bool isometric = soup.material.size() == soup.positions.size();
  for (std::size_t t = 0; t < soup.triangles.size() && isometric; ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = soup.triangles[t][k], b = soup.triangles[t][(k + 1) % 3];
      const double length = (soup.positions[a] - soup.positions[b]).norm();
      const double material = (soup.material[a] - soup.material[b]).norm();
      isometric = isometric && std::abs(material - length) <= tolerance * length;
    }
  if (!isometric) soup.material.clear();
}

std::vector<int> drop_loose_vertices(TriangleSoup& soup) {
  std::vector<int> number(soup.positions.size(), -1);
  for (const Int3& t : soup.triangles)
    for (const int i : t) number[i] = 0;
  int kept = 0;
  for (int& n : number)
    if (n == 0) n = kept++;
  if (kept == static_cast<int>(number.size())) return {};
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    soup.positions[number[i]] = soup.positions[i];
    if (!soup.material.empty()) soup.material[number[i]] = soup.material[i];
  }
  soup.positions.resize(kept);
  if (!soup.material.empty()) soup.material.resize(kept);
  for (Int3& t : soup.triangles)
    for (int& i : t) i = number[i];
  return number;
}

}  // namespace wick::solid
