#pragma once
/// Reads PLY (ascii and both binary forms) and OBJ. Polygons are cut into fans; what is not geometry is skipped.
/// Broken files end in a Refusal that names the file and the line or element: scene_invalid, or input_missing
/// when there is no such file.
#include <string>
#include <string_view>

#include "solid/primitives.h"

namespace wick::solid {

/// Chooses the format by the first bytes. Texture coordinates become material coordinates only when they are
/// a chart in metres: one value for each vertex, and lengths that agree with the positions within 1 %.
TriangleSoup read_mesh_file(const std::string& path);

/// The same from memory; `name` is what messages call the file.
TriangleSoup parse_ply(std::string_view bytes, const std::string& name);
TriangleSoup parse_obj(std::string_view text, const std::string& name);

/// Empties soup.material unless it is a chart in metres of the positions, edge by edge within 1 %.
void keep_material_if_isometric(TriangleSoup& soup);

/// Removes the vertices that no triangle names; the others keep their order. Returns the new number of every
/// vertex, -1 where it is gone; empty where all stay.
std::vector<int> drop_loose_vertices(TriangleSoup& soup);

}  // namespace wick::solid
