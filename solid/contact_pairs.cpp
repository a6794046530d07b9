#include "solid/contact_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "core/parallel.h"
#include "solid/box_tree.h"

namespace wick::solid {

namespace {

/// An offset is at most this part of the shortest edge at a vertex.
constexpr double kOffsetPerEdge = 0.3;
/// Neighbours keep at most this part of their distance at rest: compression must not feel like contact.
constexpr double kRestShare = 0.5;
/// Nearer at rest than this part of what they keep is the same place.
constexpr double kSamePlace = 1e-6;
/// Drift of a pair of clusters that is searched for at least, in mean edges. More would watch many pairs that never
/// meet, which costs more than searching again.
constexpr double kLeastBudget = 0.1;
/// Of the room between clusters: nothing is nearer, boxes are rounded.
constexpr double kRoomShare = 0.9;
/// Of floats.
constexpr double kRounding = 1e-6;

void add_sheet(const ShellMesh& mesh, double half_thickness, std::int32_t sheet, ContactMesh& all,
               std::size_t& lowered) {
  const std::size_t first = all.vertex_count();
  std::vector<double> shortest(mesh.vertex_count(), INFINITY);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e)
    for (const std::int32_t v : mesh.edges[e]) shortest[v] = std::min(shortest[v], mesh.rest_length[e]);
  for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
    const double most = kOffsetPerEdge * shortest[i];
    lowered += half_thickness > most ? 1 : 0;
    all.rest.push_back(mesh.rest[i]);
    all.sheet.push_back(sheet);
    all.offset.push_back(std::min(half_thickness, most));
  }
  for (const Int3& t : mesh.triangles) {
    const auto shift = static_cast<std::int32_t>(first);
    all.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  }
}

/// Sorts the triangles by clusters of the rest shape, so that the order does not depend on when that is done.
void form_clusters(ContactMesh& all) {
  std::vector<Box> boxes(all.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (const std::int32_t v : all.triangles[t]) boxes[t].add(all.rest[v]);
  const BoxTree tree(boxes);
  std::vector<Int3> sorted;
  for (const std::int32_t t : tree.order()) sorted.push_back(all.triangles[t]);
  all.triangles.swap(sorted);
  tree.for_clusters(ContactMesh::kClusterSize, [&](std::size_t begin, std::size_t end) {
    double length = 0.0;
    for (std::size_t t = begin; t < end; ++t) {
      all.cluster.push_back(static_cast<std::int32_t>(all.cluster_begin.size()));
      const Int3& v = all.triangles[t];
      for (int k = 0; k < 3; ++k) length += (all.rest[v[k]] - all.rest[v[(k + 1) % 3]]).norm();
    }
    all.cluster_begin.push_back(static_cast<std::int32_t>(begin));
    all.mean_edge.push_back(length / (3.0 * static_cast<double>(end - begin)));
  });
  all.cluster_begin.push_back(static_cast<std::int32_t>(all.triangles.size()));
}

void choose_representatives(ContactMesh& all) {
  std::vector<std::uint8_t> answered(all.vertex_count(), 0);
  std::unordered_set<std::uint64_t> edges;
  edges.reserve(2 * all.triangles.size());
  for (const Int3& t : all.triangles) {
    unsigned own_vertices = 0, own_edges = 0;
    for (unsigned k = 0; k < 3; ++k) {
      const auto a = static_cast<std::uint64_t>(t[k]), b = static_cast<std::uint64_t>(t[(k + 1) % 3]);
      if (!answered[a]) answered[a] = 1, own_vertices |= 1U << k;
      if (edges.insert(std::min(a, b) << 32 | std::max(a, b)).second) own_edges |= 1U << k;
    }
    all.vertices.push_back(static_cast<std::uint8_t>(own_vertices));
    all.edges.push_back(static_cast<std::uint8_t>(own_edges));
  }
}

bool has(const Int3& t, std::int32_t v) {
  return t[0] == v || t[1] == v || t[2] == v;
}

Vec3 vector(const Lanes& p) {
  return {p[0], p[1], p[2]};
}

/// Whether the features are farther apart than `within` along the line through their middles.
bool far_along_middles(const std::array<Lanes, 4>& x, int split, double within) {
  const Lanes first = split == 1 ? x[0] : 0.5 * (x[0] + x[1]);
  const Lanes second = split == 1 ? (x[1] + x[2] + x[3]) / 3.0 : 0.5 * (x[2] + x[3]);
  const Lanes axis = first - second;
  const auto along = [&](const Lanes& p) {
    const Lanes products = axis * (p - x[0]);
    return products[0] + products[1] + products[2];
  };
  const double one = along(x[1]), two = along(x[2]), three = along(x[3]);
  const double low = split == 1 ? 0.0 : std::min(0.0, one);
  const double high = split == 1 ? std::max({one, two, three}) : std::max(two, three);
  const Lanes squares = axis * axis;
  const double gap = low - high;
  return gap > 0.0 && gap * gap > within * within * (squares[0] + squares[1] + squares[2]);
}

/// Low corner, and the high one with its sign turned, rounded outwards.
using Bounds = std::array<float, 6>;
Bounds rounded(const Box& box) {
  constexpr double kRelative = 1.0 / (1 << 23), kAbsolute = 1e-37;
  Bounds b;
  for (int k = 0; k < 3; ++k) {
    b[k] = static_cast<float>(box.low[k] - std::abs(box.low[k]) * kRelative - kAbsolute);
    b[k + 3] = static_cast<float>(-box.high[k] - std::abs(box.high[k]) * kRelative - kAbsolute);
  }
  return b;
}

}  // namespace

ContactMesh join_sheets(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
                        std::size_t* lowered) {
  ContactMesh all;
  std::size_t count = 0;
  for (std::size_t s = 0; s < meshes.size(); ++s)
    add_sheet(*meshes[s], half_thickness[s], static_cast<std::int32_t>(s), all, count);
  form_clusters(all);
  choose_representatives(all);
  if (lowered != nullptr) *lowered = count;
  return all;
}

/// What one pair of clusters looks at.
struct PairFinder::Query {
  const ContactMesh& mesh;
  const ContactBase& base;
  ClusterPair& clusters;
  double stale;  ///< how far the clusters may have drifted since their shift was noted [m]

  void look(std::int32_t t, std::int32_t o) const;
  void try_pair(FeaturePair kind, const std::array<Lanes, 4>& x, const std::array<std::int32_t, 4>& v,
                const Int2& triangle) const;
};

/// All pairs of features for which two triangles answer.
void PairFinder::Query::look(std::int32_t t, std::int32_t o) const {
  const Int3 &s = mesh.triangles[t], &r = mesh.triangles[o];
  const Lanes by = {clusters.shift.x(), clusters.shift.y(), clusters.shift.z(), 0.0};
  Lanes a[3], b[3];
  for (int k = 0; k < 3; ++k)
    a[k] = load_lanes(&base.corner[3 * t + k]) + by, b[k] = load_lanes(&base.corner[3 * o + k]);
  for (int k = 0; k < 3; ++k) {
    if ((mesh.vertices[t] >> k & 1) != 0 && !has(r, s[k]))
      try_pair(FeaturePair::vertex_triangle, {a[k], b[0], b[1], b[2]}, {s[k], r[0], r[1], r[2]}, {t, o});
    if ((mesh.vertices[o] >> k & 1) != 0 && !has(s, r[k]))
      try_pair(FeaturePair::vertex_triangle, {b[k], a[0], a[1], a[2]}, {r[k], s[0], s[1], s[2]}, {o, t});
    if ((mesh.edges[t] >> k & 1) == 0) continue;
    const int k1 = (k + 1) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3;
      if ((mesh.edges[o] >> j & 1) == 0 || s[k] == r[j] || s[k] == r[j1] || s[k1] == r[j] || s[k1] == r[j1])
        continue;
      try_pair(FeaturePair::edge_edge, {a[k], a[k1], b[j], b[j1]}, {s[k], s[k1], r[j], r[j1]}, {t, o});
    }
  }
}

void PairFinder::Query::try_pair(FeaturePair kind, const std::array<Lanes, 4>& x,
                                 const std::array<std::int32_t, 4>& v, const Int2& triangle) const {
  const int split = first_count(kind);
  double offset[2] = {INFINITY, INFINITY};
  for (int k = 0; k < 4; ++k) offset[k < split ? 0 : 1] = std::min(offset[k < split ? 0 : 1], mesh.offset[v[k]]);
  double keep = offset[0] + offset[1];
  const double within = base.reach[triangle[0]] + base.reach[triangle[1]] + clusters.budget + keep;
  // Cheap first: how far apart their boxes are along the axes. The last of the lanes is none.
  Lanes low[2] = {x[0], smaller(x[2], x[3])}, high[2] = {x[0], larger(x[2], x[3])};
  low[split == 1] = smaller(low[split == 1], x[1]);
  high[split == 1] = larger(high[split == 1], x[1]);
  constexpr double kNoAxis = std::numeric_limits<double>::infinity();
  const Lanes gap = larger(low[0] - high[1], low[1] - high[0]), most = {within, within, within, kNoAxis};
  if (any_greater(gap, most) || far_along_middles(x, split, within)) return;
  const double distance = closest(kind, {vector(x[0]), vector(x[1]), vector(x[2]), vector(x[3])}).distance;
  if (!(distance < within)) return;
  if (mesh.sheet[v[0]] == mesh.sheet[v[3]]) {
    const std::array<Vec3, 4> at_rest = {mesh.rest[v[0]], mesh.rest[v[1]], mesh.rest[v[2]], mesh.rest[v[3]]};
    const double apart = closest(kind, at_rest).distance;
    // The lips of a tear lie upon each other at rest, and are no neighbours any more.
    if (apart > kSamePlace * keep) keep = std::min(keep, kRestShare * apart);
  }
  // What has not been marked has moved since it was noted, by no more than its reach and the budget.
  double allowance = distance - keep + clusters.drifted - stale;
  for (const int t : triangle)
    allowance += base.travelled[t] - (base.triangle_marked[t] != 0 ? 0.0 : base.reach[t]);
  clusters.pairs.push_back({v, triangle, kind, false, -1, keep, allowance});
}

/// Boxes are seen from their clusters, which carry them along.
void PairFinder::place_boxes(const ContactBase& base) {
  boxes_.resize(mesh_.cluster_count());
  around_.resize(mesh_.cluster_count());
  parallel_for(mesh_.cluster_count(), 8, [&](std::size_t c) {
    if (base.cluster_marked[c] == 0) return;
    const std::int32_t first = mesh_.cluster_begin[c], size = mesh_.cluster_begin[c + 1] - first;
    for (std::int32_t t = first; t < first + size; ++t) {
      if (base.triangle_marked[t] == 0) continue;
      Box box;
      double by = 0.0;
      for (int k = 0; k < 3; ++k) {
        box.add(point(base.corner[3 * t + k]));
        by = std::max(by, mesh_.offset[mesh_.triangles[t][k]]);
      }
      box.grow(by + base.reach[t]);
      const Bounds bounds = rounded(box);
      for (int k = 0; k < 6; ++k) boxes_[c][k][t - first] = bounds[k];
    }
    for (int k = 0; k < 6; ++k)
      around_[c][k] = *std::min_element(boxes_[c][k].begin(), boxes_[c][k].begin() + size);
  });
}

double PairFinder::outgrown(std::size_t cluster) const {
  float most = 0.0F;
  for (int k = 0; k < 6; ++k) most = std::max(most, paired_[cluster][k] - around_[cluster][k]);
  return most;
}

void PairFinder::pair_clusters(double far, std::vector<ClusterPair>& clusters) {
  paired_ = around_;
  std::vector<Box> boxes(around_.size());
  for (std::size_t c = 0; c < boxes.size(); ++c)
    for (int k = 0; k < 3; ++k) boxes[c].low[k] = around_[c][k], boxes[c].high[k] = -around_[c][k + 3];
  const BoxTree tree(boxes);
  clusters.clear();
  std::vector<std::int32_t> near;
  for (std::size_t c = 0; c < boxes.size(); ++c) {
    Box query = boxes[c];
    query.grow(far);
    near.clear();
    tree.for_overlaps(query, [&](std::int32_t other) {
      if (other >= static_cast<std::int32_t>(c)) near.push_back(other);
    });
    std::sort(near.begin(), near.end());
    for (const std::int32_t other : near) clusters.push_back({static_cast<std::int32_t>(c), other});
  }
}

/// Somewhat farther than the clusters drift against each other in this substep; all of the room between them where
/// there is some, which costs nothing.
void PairFinder::choose_budget(const ContactBase& base, ClusterPair& pair) const {
  const std::int32_t a = pair.first, b = pair.second;
  pair.shift = base.drifted[a] - base.drifted[b];
  pair.budget = 0.0;
  if (a == b) return;
  const double edge = std::min(mesh_.mean_edge[a], mesh_.mean_edge[b]);
  const double drift = (base.drift[a] - base.drift[b]).norm();
  double room = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double above = around_[a][k] + pair.shift[k] + around_[b][k + 3];
    const double below = around_[b][k] - pair.shift[k] + around_[a][k + 3];
    room = std::max({room, above, below});
  }
  pair.budget = std::max({kLeastBudget * edge, kWayMargin * drift, kRoomShare * room});
}

/// The triangles of a cluster whose boxes overlap one of another cluster; a box overlaps another if none of its
/// numbers is above that of the other, seen `across`.
void PairFinder::find_hits(std::int32_t cluster, const Bounds& across, std::int32_t of, std::int32_t triangle,
                           Hits& hits) const {
  const ClusterBoxes &theirs = boxes_[cluster], &mine = boxes_[of];
  Bounds seen;
  bool meets = true;
  for (int k = 0; k < 6; ++k) {
    seen[k] = across[k] - mine[(k + 3) % 6][triangle];
    meets &= around_[cluster][k] <= seen[k];
  }
  if (!meets) {
    hits.fill(0);
    return;
  }
  const auto below = [&](int k, std::size_t o) { return static_cast<unsigned>(theirs[k][o] <= seen[k]); };
  for (std::size_t o = 0; o < hits.size(); ++o)
    hits[o] = static_cast<std::uint8_t>(below(0, o) & below(1, o) & below(2, o) & below(3, o) & below(4, o) &
                                        below(5, o));
}

/// Triangles of one cluster against those of the other side by side, each pair of them once: all, or those with a
/// marked one.
void PairFinder::search_one(const ContactBase& base, ClusterPair& clusters, bool all) const {
  const std::int32_t a = clusters.first, b = clusters.second;
  const std::int32_t first = mesh_.cluster_begin[a], second = mesh_.cluster_begin[b];
  const std::int32_t first_size = mesh_.cluster_begin[a + 1] - first;
  const std::int32_t second_size = mesh_.cluster_begin[b + 1] - second;
  // Seen from the first cluster, and from the second.
  Bounds forth, back;
  const double by = clusters.budget + kRounding * (clusters.budget + clusters.shift.norm());
  for (int k = 0; k < 3; ++k) {
    forth[k] = back[k + 3] = static_cast<float>(by + clusters.shift[k]);
    forth[k + 3] = back[k] = static_cast<float>(by - clusters.shift[k]);
  }
  bool touch = true;
  for (int k = 0; k < 6; ++k) touch &= around_[b][k] <= forth[k] - around_[a][(k + 3) % 6];
  if (!touch) return;
  const Query query{mesh_, base, clusters, all ? 0.0 : clusters.budget};
  const auto marked = [&](std::int32_t t) { return all || base.triangle_marked[t] != 0; };
  Hits hits;
  for (std::int32_t t = 0; t < first_size; ++t) {
    if (!marked(first + t)) continue;
    find_hits(b, forth, a, t, hits);
    for (std::int32_t o = 0; o < second_size; ++o) {
      if (hits[o] == 0 || (a == b && (o == t || (o < t && marked(second + o))))) continue;
      // In one cluster the lesser number first, so that a pair looks the same whichever of them is searched.
      const bool swapped = a == b && o < t;
      query.look(swapped ? second + o : first + t, swapped ? first + t : second + o);
    }
  }
  for (std::int32_t o = 0; o < second_size && a != b && !all; ++o) {
    if (!marked(second + o)) continue;
    find_hits(a, back, b, o, hits);
    for (std::int32_t t = 0; t < first_size; ++t)
      if (hits[t] != 0 && !marked(first + t)) query.look(first + t, second + o);
  }
}

void PairFinder::search(const ContactBase& base, std::vector<ClusterPair>& clusters) const {
  parallel_for(clusters.size(), 4, [&](std::size_t k) {
    ClusterPair& pair = clusters[k];
    const bool all = base.pair_marked[k] == 2;
    if (base.pair_marked[k] == 0) return;
    if (all) {
      pair.pairs.clear();
      choose_budget(base, pair);
    } else {
      std::erase_if(pair.pairs, [&](const ContactPair& p) {
        return base.triangle_marked[p.triangle[0]] != 0 || base.triangle_marked[p.triangle[1]] != 0;
      });
    }
    const std::size_t kept = pair.pairs.size();
    search_one(base, pair, all);
    if (all || pair.pairs.size() == kept) return;
    // In the order of the triangles, as if all had been searched: it must not depend on when which of them were.
    std::stable_sort(pair.pairs.begin(), pair.pairs.end(), [](const ContactPair& p, const ContactPair& q) {
      return std::minmax(p.triangle[0], p.triangle[1]) < std::minmax(q.triangle[0], q.triangle[1]);
    });
  });
}

}  // namespace wick::solid
