#include "solid/constraints.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "solid/bending.h"
#include "solid/coloring.h"

namespace wick::solid {

namespace {

/// Groups that one thread takes at a time: some 10 us of work, far above the cost of handing it out.
constexpr std::size_t kGrain = 256;
/// Below these a stiffness or a rest length counts as this: what has burnt to nothing must not divide by zero.
constexpr double kLeastStiffness = 1e-9, kLeastScale = 1e-3;
/// Keeps α̃ and its products inside the range of a double.
constexpr double kLargestSoftness = 1e100;

double softness(double compliance, double stiffness_scale, double h) {
  return std::min(compliance / (std::max(stiffness_scale, kLeastStiffness) * h * h), kLargestSoftness);
}

/// Packs the elements of each colour, four at a time; those without a colour go one by one.
template <class Group>
void pack(const std::vector<std::int32_t>& elements, const std::vector<std::int32_t>& color,
          ColoredGroups<Group>& out) {
  out = {};
  std::vector<std::size_t> offset(kMostColors + 2, 0);
  for (const std::int32_t e : elements) ++offset[color[e] + 1];
  for (std::size_t c = 1; c < offset.size(); ++c) offset[c] += offset[c - 1];
  std::vector<std::int32_t> sorted(elements.size());
  std::vector<std::size_t> next(offset.begin(), offset.end() - 1);
  for (const std::int32_t e : elements) sorted[next[color[e]]++] = e;
  for (int c = 0; c <= kMostColors; ++c) {
    if (offset[c] == offset[c + 1]) continue;
    const std::size_t stride = c == kLeftOver ? 1 : kLanes, begin = out.element.size();
    for (std::size_t i = offset[c]; i < offset[c + 1]; i += stride) {
      auto& lanes = out.element.emplace_back();
      for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = k < stride && i + k < offset[c + 1] ? sorted[i + k] : -1;
    }
    out.colors.push_back({begin, out.element.size(), c == kLeftOver});
  }
  out.groups.resize(out.element.size());
}

template <class Group, class Body>
void sweep(const ColoredGroups<Group>& set, Body&& project) {
  for (const auto& color : set.colors) {
    const std::size_t count = color.end - color.begin;
    parallel_chunks(count, color.one_by_one ? count : kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t g = begin; g < end; ++g) project(set.groups[color.begin + g]);
    });
  }
}

template <class Group, std::size_t N>
void set_vertices(Group& group, int lane, const std::array<std::int32_t, N>& vertex) {
  for (std::size_t k = 0; k < N; ++k) group.vertex[k][lane] = vertex[k];
}

}  // namespace

ConstraintSet::ConstraintSet(const ShellMesh& mesh, const ShellParams& params)
    : law_(membrane_law(params)),
      nobody_(static_cast<std::int32_t>(mesh.vertex_count())),
      rest_edges_(mesh.inverse_rest_edges),
      rest_area_(mesh.rest_area) {
  // Triangles are coloured once.
  std::vector<std::int32_t> vertices(3 * mesh.triangle_count()), all(mesh.triangle_count());
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    std::copy_n(mesh.triangles[t].begin(), 3, vertices.begin() + 3 * t);
    all[t] = static_cast<std::int32_t>(t);
  }
  pack(all, color_constraints(vertices, 3, mesh.vertex_count()).color, triangles_);
  for (std::size_t g = 0; g < triangles_.groups.size(); ++g)
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int32_t t = triangles_.element[g][lane];
      set_vertices<TriangleGroup, 3>(triangles_.groups[g], lane,
                                     t < 0 ? std::array{nobody_, nobody_, nobody_} : mesh.triangles[t]);
    }

  // Hinges are coloured once, and packed whenever one of them gains or loses a rest angle.
  const std::vector<double> stiffness = hinge_stiffness(mesh, flexural_rigidity(params));
  vertices.resize(4 * mesh.hinges.size());
  hinges_.resize(mesh.hinges.size());
  for (std::size_t i = 0; i < mesh.hinges.size(); ++i) {
    const Hinge& hinge = mesh.hinges[i];
    const auto& v = hinge.vertex;
    const auto K = isometric_weights(mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]], mesh.rest[v[3]]);
    hinges_[i] = {v,
                  hinge.triangle,
                  {K[1], K[2], K[3]},
                  hinge_area(mesh, i) / (3.0 * stiffness[i]),
                  (mesh.rest[v[1]] - mesh.rest[v[0]]).norm()};
    std::copy_n(v.begin(), 4, vertices.begin() + 4 * i);
  }
  hinge_color_ = color_constraints(vertices, 4, mesh.vertex_count()).color;
}

void ConstraintSet::update(const ShellInputs& inputs, double h) {
  const bool new_h = h != known_h_, new_scale = inputs.rest_scale != known_.rest_scale;
  const bool new_stiffness = inputs.stiffness_scale != known_.stiffness_scale;
  const bool new_angle = inputs.rest_angle != known_.rest_angle;
  if (new_angle || known_h_ == 0.0) sort_hinges(inputs);
  if (new_h || new_scale || new_stiffness || inputs.membrane_factor != known_.membrane_factor)
    update_triangles(inputs, h);
  if (new_h || new_scale || new_stiffness || new_angle) update_hinges(inputs, h);
  known_ = inputs;
  known_h_ = h;
}

void ConstraintSet::update_triangles(const ShellInputs& inputs, double h) {
  parallel_for(triangles_.groups.size(), kGrain, [&](std::size_t g) {
    TriangleGroup& group = triangles_.groups[g];
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int32_t t = triangles_.element[g][lane];
      const double scale = t < 0 ? 1.0 : std::max(inputs.rest_scale[t], kLeastScale);
      const Mat2 B = (t < 0 ? Mat2(Mat2::Identity()) : rest_edges_[t]) / scale;
      group.b10[lane] = B(0, 0);
      group.b11[lane] = B(0, 1);
      group.b20[lane] = B(1, 0);
      group.b21[lane] = B(1, 1);
      group.softness[lane] = t < 0 ? 1.0
                                   : softness(1.0 / (rest_area_[t] * scale * scale),
                                              inputs.stiffness_scale[t] * inputs.membrane_factor, h);
    }
  });
}

void ConstraintSet::sort_hinges(const ShellInputs& inputs) {
  const auto same_kind = [](double a, double b) { return (a == 0.0) == (b == 0.0); };
  const bool unchanged =
      known_h_ != 0.0 && std::equal(inputs.rest_angle.begin(), inputs.rest_angle.end(), known_.rest_angle.begin(),
                                    known_.rest_angle.end(), same_kind);
  if (unchanged) return;
  std::vector<std::int32_t> flat, bent;
  for (std::size_t i = 0; i < hinges_.size(); ++i)
    (inputs.rest_angle[i] == 0.0 ? flat : bent).push_back(static_cast<std::int32_t>(i));
  pack(flat, hinge_color_, flat_);
  pack(bent, hinge_color_, bent_);
}

void ConstraintSet::update_hinges(const ShellInputs& inputs, double h) {
  const std::array<std::int32_t, 4> none = {nobody_, nobody_, nobody_, nobody_};
  const auto stiffness = [&](const HingeRest& hinge) {
    return 0.5 * (inputs.stiffness_scale[hinge.triangle[0]] + inputs.stiffness_scale[hinge.triangle[1]]);
  };
  parallel_for(flat_.groups.size(), kGrain, [&](std::size_t g) {
    FlatHingeGroup& group = flat_.groups[g];
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int32_t i = flat_.element[g][lane];
      group.k1[lane] = i < 0 ? 0.0 : hinges_[i].weight[0];
      group.k2[lane] = i < 0 ? 0.0 : hinges_[i].weight[1];
      group.k3[lane] = i < 0 ? 0.0 : hinges_[i].weight[2];
      group.softness[lane] = 1.0;
      set_vertices(group, lane, i < 0 ? none : hinges_[i].vertex);
      if (i < 0) continue;
      // The cotangents do not change when the rest shape shrinks as a whole; the areas do.
      const auto& t = hinges_[i].triangle;
      const double scale = std::max(0.5 * (inputs.rest_scale[t[0]] + inputs.rest_scale[t[1]]), kLeastScale);
      group.softness[lane] = softness(hinges_[i].compliance * scale * scale, stiffness(hinges_[i]), h);
    }
  });
  parallel_for(bent_.groups.size(), kGrain, [&](std::size_t g) {
    BentHingeGroup& group = bent_.groups[g];
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::int32_t i = bent_.element[g][lane];
      group.rest_angle[lane] = i < 0 ? 0.0 : std::remainder(inputs.rest_angle[i], 6.283185307179586);
      group.softness[lane] = 1.0;
      set_vertices(group, lane, i < 0 ? none : hinges_[i].vertex);
      if (i < 0) continue;
      const double length2 = hinges_[i].length * hinges_[i].length;
      group.softness[lane] = softness(hinges_[i].compliance / length2, stiffness(hinges_[i]), h);
    }
  });
}

void ConstraintSet::project_flat_hinges(std::vector<Row>& y, double gamma) const {
  Row* rows = y.data();
  sweep(flat_, [rows, gamma](const FlatHingeGroup& g) {
    Vertex<Lanes> v0 = gather(rows, g.vertex[0]), v1 = gather(rows, g.vertex[1]);
    Vertex<Lanes> v2 = gather(rows, g.vertex[2]), v3 = gather(rows, g.vertex[3]);
    project_flat_hinge(load_lanes(g.k1), load_lanes(g.k2), load_lanes(g.k3), load_lanes(g.softness), 1.0 + gamma,
                       v0, v1, v2, v3);
    scatter(rows, g.vertex[0], v0);
    scatter(rows, g.vertex[1], v1);
    scatter(rows, g.vertex[2], v2);
    scatter(rows, g.vertex[3], v3);
  });
}

void ConstraintSet::project_bent_hinges_and_triangles(std::vector<Row>& x, const std::vector<Row>& previous,
                                                      double gamma) const {
  Row* rows = x.data();
  const Row* old = previous.data();
  sweep(bent_, [rows, old, gamma](const BentHingeGroup& g) {
    std::array<Vertex<Lanes>, 4> v;
    std::array<Triple<Lanes>, 4> before;
    for (int k = 0; k < 4; ++k) {
      v[k] = gather(rows, g.vertex[k]);
      before[k] = gather(old, g.vertex[k]).p;
    }
    project_bent_hinge(load_lanes(g.rest_angle), load_lanes(g.softness), gamma, v, before);
    for (int k = 0; k < 4; ++k) scatter(rows, g.vertex[k], v[k]);
  });
  sweep(triangles_, [rows, old, gamma, law = law_](const TriangleGroup& g) {
    Vertex<Lanes> v0 = gather(rows, g.vertex[0]), v1 = gather(rows, g.vertex[1]), v2 = gather(rows, g.vertex[2]);
    const RestEdges<Lanes> b = {load_lanes(g.b10), load_lanes(g.b11), load_lanes(g.b20), load_lanes(g.b21)};
    project_triangle(b, load_lanes(g.softness), law, gamma, v0, v1, v2, gather(old, g.vertex[0]).p,
                     gather(old, g.vertex[1]).p, gather(old, g.vertex[2]).p);
    scatter(rows, g.vertex[0], v0);
    scatter(rows, g.vertex[1], v1);
    scatter(rows, g.vertex[2], v2);
  });
}

}  // namespace wick::solid
