#pragma once
/// Tearing: where a sheet is stretched beyond its strength it parts along its edges. In the spirit of O'Brien and
/// Hodgins [1999]: a vertex is split by the plane across its largest principal strain, triangles go whole to one
/// side.
#include "solid/mesh_cut.h"
#include "solid/shell_mesh.h"

namespace wick::solid {

/// Largest principal strain at one vertex and its direction, of the Biot strain U - 1 on the rest shape. It is a
/// mean over the triangles of its neighbours too: one sweep of coloured Gauss-Seidel leaves a pattern of the
/// colours in the strain of single triangles (30 % at the default damping, 10 % in this mean).
struct VertexStrain {
  double strain = 0.0;
  Vec3 direction = Vec3::Zero();  ///< unit length, in the rest shape
};

/// Of every vertex of `mesh` at positions x (V); rest lengths are multiplied by rest_scale (T).
std::vector<VertexStrain> vertex_strains(const ShellMesh& mesh, const std::vector<Vec3>& x,
                                         const std::vector<double>& rest_scale);

/// Splits vertices that are strained beyond `strength` (V; strain at which each parts), the most overstrained first
/// and none within two edges of another: what a tear relieves is to be computed anew. Triangles change in place,
/// vertices are made by the blends that are returned (copies of old ones).
MeshCut tear(const ShellMesh& mesh, const std::vector<VertexStrain>& strains, const std::vector<double>& strength,
             std::vector<Int3>& triangles);

}  // namespace wick::solid
