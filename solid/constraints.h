#pragma once
/// The constraints of one mesh, coloured and packed in groups of four lanes, colour after colour.
#include <vector>

#include "solid/membrane.h"

namespace wick::solid {

struct alignas(32) TriangleGroup {
  double b10[kLanes], b11[kLanes], b20[kLanes], b21[kLanes];  ///< rest edges, with the rest scale [1/m]
  double softness[kLanes];                                    ///< 1/(A h² stiffness scale) [1/(m² s²)]
  std::int32_t vertex[3][kLanes];
};
struct alignas(32) FlatHingeGroup {
  double k1[kLanes], k2[kLanes], k3[kLanes];
  double softness[kLanes];  ///< (A₀+A₁)/(3 k h²)
  std::int32_t vertex[4][kLanes];
};
struct alignas(32) BentHingeGroup {
  double rest_angle[kLanes];
  double softness[kLanes];  ///< (A₀+A₁)/(3 k |e|² h²)
  std::int32_t vertex[4][kLanes];
};

/// Groups in the order of their colours. Lanes without a constraint act on a vertex beyond the last one, whose
/// inverse mass is zero.
template <class Group>
struct ColoredGroups {
  struct Range {
    std::size_t begin, end;
    bool one_by_one;  ///< groups of this range may share vertices
  };
  std::vector<Group> groups;
  std::vector<std::array<std::int32_t, kLanes>> element;  ///< which triangle or hinge a lane holds; -1: none
  std::vector<Range> colors;
};

class ConstraintSet {
 public:
  ConstraintSet(const ShellMesh& mesh, const ShellParams& params);

  /// Brings rest shapes and stiffnesses up to date for substeps of length h; cheap when nothing has changed.
  void update(const ShellInputs& inputs, double h);

  /// One sweep over the hinges that are flat at rest, on y = x + γ (x − xⁿ).
  void project_flat_hinges(std::vector<Row>& y, double gamma) const;
  /// One sweep over the other hinges, then the triangles, on x.
  void project_bent_hinges_and_triangles(std::vector<Row>& x, const std::vector<Row>& previous, double gamma) const;

  [[nodiscard]] bool has_flat_hinges() const { return !flat_.groups.empty(); }
  [[nodiscard]] std::size_t color_count() const {
    return triangles_.colors.size() + flat_.colors.size() + bent_.colors.size();
  }

 private:
  struct HingeRest {
    std::array<std::int32_t, 4> vertex;
    std::array<std::int32_t, 2> triangle;
    std::array<double, 3> weight;  ///< K of vertices 1 to 3
    double compliance;             ///< (A₀+A₁)/(3 k) [m²/(N m)]
    double length;                 ///< |e| at rest [m]
  };
  void update_triangles(const ShellInputs& inputs, double h);
  void sort_hinges(const ShellInputs& inputs);
  void update_hinges(const ShellInputs& inputs, double h);

  MembraneLaw law_;
  std::int32_t nobody_;  ///< the vertex beyond the last
  std::vector<Mat2> rest_edges_;
  std::vector<double> rest_area_;
  std::vector<HingeRest> hinges_;
  std::vector<std::int32_t> hinge_color_;
  ColoredGroups<TriangleGroup> triangles_;
  ColoredGroups<FlatHingeGroup> flat_;
  ColoredGroups<BentHingeGroup> bent_;
  ShellInputs known_;  ///< what the groups were made for
  double known_h_ = 0.0;
};

}  // namespace wick::solid
