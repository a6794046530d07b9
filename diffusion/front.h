#pragma once
/// The diffusion front as a curve on the sheet: the isocontour u = level, by marching triangles [Lorensen 1987].
/// Coordinates are those of the rest shape (or the material chart), so that mere deformation does not count.
#include <cstdint>
#include <span>
#include <vector>

#include "solid/shell_mesh.h"

namespace wick::diffusion {

/// A point of the front: it lies on the edge from vertex a to vertex b, at (1 - t) a + t b.
struct FrontPoint {
  Vec3 position;
  std::int32_t a = 0, b = 0;
  double t = 0.0;
  /// Value of a vertex field there.
  [[nodiscard]] double value(const std::vector<double>& field) const { return (1.0 - t) * field[a] + t * field[b]; }
};

/// One connected piece, with u >= level on its left as the triangles' normals look at the reader.
struct FrontPiece {
  std::vector<FrontPoint> points;  ///< a closed piece does not repeat its first point
  bool closed = false;
  [[nodiscard]] double length() const;
};

struct Front {
  std::vector<FrontPiece> pieces;  ///< in the order of the edges they begin on
  double area = 0.0;               ///< of the part with u >= level, u linear in each triangle [m²]
  double sheet_area = 0.0;         ///< of all triangles [m²]
  [[nodiscard]] double length() const;
  /// Pieces at least this long.
  [[nodiscard]] std::size_t count(double least_length) const;
  /// A: fraction of the sheet that the front has passed.
  [[nodiscard]] double covered() const { return sheet_area > 0.0 ? area / sheet_area : 0.0; }
};

/// The shape in which fronts are measured: material coordinates at z = 0 where the sheet has a chart, else the
/// rest positions (V, [m]).
std::vector<Vec3> front_coordinates(const solid::ShellMesh& mesh);

/// The front of u (V) in the coordinates x (V). Vertices at exactly `level` count as passed.
Front find_front(const solid::ShellMesh& mesh, const std::vector<Vec3>& x, const std::vector<double>& u,
                 double level = 0.5);

/// Distance from p to the nearest point of the front; infinite where it has no pieces.
double distance_to(const Front& front, const Vec3& p);

/// A piece sampled at equal steps of arc length. `field` are values of vertex fields at the samples, in the order
/// asked.
struct SampledFront {
  std::vector<Vec3> position;
  std::vector<std::vector<double>> field;
  double step = 0.0;  ///< arc length between samples [m]
  bool closed = false;
};

/// At least 3 samples, about `spacing` apart.
SampledFront sample(const FrontPiece& piece, double spacing,
                    std::span<const std::vector<double>* const> fields = {});

}  // namespace wick::diffusion
