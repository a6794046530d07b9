#include <algorithm>
#include <cmath>

#include "solid/sheet_contact_impl.h"

namespace wick::solid {

namespace {

constexpr std::size_t kGrain = 2048;
/// Pairs are found for this many substeps ahead at most: farther, the many that never meet cost more than a search.
constexpr int kMostAhead = 20;
/// Triangles may go at least this part of the mean edge until pairs are found anew.
constexpr double kLeastReach = 0.05;
/// Of the drift that is foreseen: things get faster.
constexpr double kAheadMargin = 1.25;

Vec3 mean(const std::vector<Vec3>& values) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& v : values) sum += v;
  return sum / static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

Lanes lanes(const Vec3& v) {
  return Lanes{v.x(), v.y(), v.z(), 0.0};
}
/// Of the first three.
double square(const Lanes& v) {
  const Lanes s = v * v;
  return s[0] + s[1] + s[2];
}

}  // namespace

/// About the mean motion of each cluster in this substep: any would do.
void SheetContact::Impl::choose_drift(const std::vector<Row>& x) {
  parallel_for(mesh.cluster_count(), kClusterGrain, [&](std::size_t c) {
    Vec3 sum = Vec3::Zero();
    for (std::int32_t t = mesh.cluster_begin[c]; t < mesh.cluster_begin[c + 1]; ++t) {
      const std::int32_t v = mesh.triangles[t][0];
      sum += point(x[v]) - point(start[v]);
    }
    base.drift[c] = sum / (mesh.cluster_begin[c + 1] - mesh.cluster_begin[c]);
  });
}

/// How far a triangle is at the start of the substep from where it was searched, against its cluster.
double SheetContact::Impl::way_from_base(std::int32_t t) const {
  const Lanes drifted = lanes(base.drifted[mesh.cluster[t]]);
  double farthest2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Lanes corner = load_lanes(&base.corner[3 * t + k]);
    farthest2 = std::max(farthest2, square(load_lanes(&start[mesh.triangles[t][k]]) - corner - drifted));
  }
  return std::sqrt(farthest2);
}

/// How far triangles get against their clusters in this substep, and clusters against each other. Marks the
/// triangles that have come farther than they were searched for; true if there are any.
bool SheetContact::Impl::measure_ways(const std::vector<Row>& x) {
  parallel_for(x.size(), kGrain, [&](std::size_t i) {
    step[i] = {x[i].x - start[i].x, x[i].y - start[i].y, x[i].z - start[i].z, 0.0};
  });
  parallel_for(mesh.cluster_count(), kClusterGrain, [&](std::size_t c) {
    const Lanes drift = lanes(base.drift[c]);
    std::uint8_t any = 0;
    for (std::int32_t t = mesh.cluster_begin[c]; t < mesh.cluster_begin[c + 1]; ++t) {
      double way2 = 0.0;
      for (const std::int32_t v : mesh.triangles[t]) way2 = std::max(way2, square(load_lanes(&step[v]) - drift));
      way[t] = std::sqrt(way2);
      base.triangle_marked[t] = 0;
      if (base.travelled[t] + way[t] <= base.until[t]) continue;
      // What trembles has gone far and got nowhere.
      base.until[t] = base.travelled[t] + base.reach[t] - way_from_base(t);
      base.triangle_marked[t] = base.travelled[t] + way[t] > base.until[t] ? 1 : 0;
      any |= base.triangle_marked[t];
    }
    base.cluster_marked[c] = any;
  });
  parallel_for(clusters.size(), kGrain, [&](std::size_t k) {
    clusters[k].apart = (base.drift[clusters[k].first] - base.drift[clusters[k].second]).norm();
  });
  return std::any_of(base.cluster_marked.begin(), base.cluster_marked.end(), [](std::uint8_t m) { return m != 0; });
}

/// Whether clusters that are not paired may come near each other in this substep.
bool SheetContact::Impl::clusters_too_far() const {
  const Vec3 before = mean(base.drifted), now = mean(base.drift);
  for (std::size_t c = 0; c < mesh.cluster_count(); ++c) {
    const double gone = (base.drifted[c] - before).norm() + (base.drift[c] - now).norm();
    if (gone + finder.outgrown(c) > 0.5 * far) return true;
  }
  return false;
}

/// Marks the pairs of clusters that have drifted farther than they were searched for, or hold marked triangles.
/// True if there are any.
bool SheetContact::Impl::mark_pairs_out_of_budget() {
  parallel_for(clusters.size(), kGrain, [&](std::size_t k) {
    const ClusterPair& p = clusters[k];
    const double gone = (base.drifted[p.first] - base.drifted[p.second] - p.shift).norm() + p.apart;
    const bool out = p.first != p.second && gone > p.budget;
    const bool holds = base.cluster_marked[p.first] != 0 || base.cluster_marked[p.second] != 0;
    base.pair_marked[k] = out ? 2 : (holds ? 1 : 0);
  });
  return std::any_of(base.pair_marked.begin(), base.pair_marked.end(), [](std::uint8_t m) { return m != 0; });
}

/// Notes where the marked triangles are at the start of the substep, and how far they may go.
void SheetContact::Impl::rebase_marked() {
  parallel_for(mesh.cluster_count(), kClusterGrain, [&](std::size_t c) {
    if (base.cluster_marked[c] == 0) return;
    const double edge = mesh.mean_edge[c];
    for (std::int32_t t = mesh.cluster_begin[c]; t < mesh.cluster_begin[c + 1]; ++t) {
      if (base.triangle_marked[t] == 0) continue;
      for (int k = 0; k < 3; ++k) {
        const Vec3 p = point(start[mesh.triangles[t][k]]) - base.drifted[c];
        base.corner[3 * t + k] = {p.x(), p.y(), p.z(), 0.0};
      }
      const double wanted = std::clamp(base.ahead * way[t], kLeastReach * edge, params.reach * edge);
      base.reach[t] = std::max(wanted, kWayMargin * way[t]);
      base.until[t] = base.travelled[t] + base.reach[t];
    }
  });
  finder.place_boxes(base);
}

/// Everything anew, for clusters that drift as fast as in this substep.
void SheetContact::Impl::pair_clusters() {
  std::fill(base.drifted.begin(), base.drifted.end(), Vec3::Zero());
  std::fill(base.travelled.begin(), base.travelled.end(), 0.0);
  std::fill(base.triangle_marked.begin(), base.triangle_marked.end(), std::uint8_t{1});
  std::fill(base.cluster_marked.begin(), base.cluster_marked.end(), std::uint8_t{1});
  rebase_marked();
  const Vec3 common = mean(base.drift);
  double fastest = 0.0, longest = 0.0;
  for (const Vec3& d : base.drift) fastest = std::max(fastest, (d - common).norm());
  for (const double edge : mesh.mean_edge) longest = std::max(longest, edge);
  // Room for the triangles of a cluster to be searched anew a few times.
  far = 2.0 * (base.ahead * fastest + longest);
  near.clear();
  finder.pair_clusters(far, clusters);
  for (ClusterPair& c : clusters) c.apart = (base.drift[c.first] - base.drift[c.second]).norm();
  base.pair_marked.assign(clusters.size(), 2);
  found = true;
}

/// Ways of this substep, and pairs anew where those found do not suffice for them. True if some are new.
bool SheetContact::Impl::refresh(const std::vector<Row>& x) {
  base.ahead = kAheadMargin * std::min(substeps_left, kMostAhead);
  const bool out_of_reach = measure_ways(x);
  if (found && out_of_reach) rebase_marked();
  if (!found || clusters_too_far()) {
    pair_clusters();
    ++report.refreshes;
  } else if (!mark_pairs_out_of_budget()) {
    return false;
  }
  forget_near();
  finder.search(base, clusters);
  return true;
}

}  // namespace wick::solid
