#pragma once
/// Which features of sheets may come near each other: vertices and triangles, edges and edges, of all sheets in one
/// numbering. Triangles are searched in clusters that each move nearly as one, so that what matters is how clusters
/// move against each other, and not how fast a sheet flies.
#include <cstdint>
#include <span>
#include <vector>

#include "solid/lanes.h"
#include "solid/proximity.h"
#include "solid/shell_mesh.h"

namespace wick::solid {

inline Vec3 point(const Row& r) {
  return {r.x, r.y, r.z};
}
inline std::array<Vec3, 4> points(const std::vector<Row>& x, const std::array<std::int32_t, 4>& v) {
  return {point(x[v[0]]), point(x[v[1]]), point(x[v[2]]), point(x[v[3]])};
}

/// All sheets as one: vertices of the first, then of the second, and so on; triangles cluster after cluster.
struct ContactMesh {
  /// Triangles of a cluster: few enough to move nearly as one, enough to search side by side.
  static constexpr std::size_t kClusterSize = 64;
  std::vector<Int3> triangles;
  std::vector<std::int32_t> cluster;        ///< of each triangle
  std::vector<std::int32_t> cluster_begin;  ///< first triangle of each cluster, and one more
  std::vector<double> mean_edge;            ///< of each cluster [m]
  std::vector<Vec3> rest;                   ///< [m]
  std::vector<std::int32_t> sheet;          ///< of each vertex
  std::vector<double> offset;               ///< of each vertex, kept on either side of the sheet [m]
  std::vector<std::uint8_t> vertices;       ///< per triangle: which of its corners it answers for, one bit each
  std::vector<std::uint8_t> edges;          ///< and which of its edges (k, k + 1) [representatives, Curtis 2008]

  [[nodiscard]] std::size_t vertex_count() const { return rest.size(); }
  [[nodiscard]] std::size_t cluster_count() const { return mean_edge.size(); }
};
/// `half_thickness` [m] is lowered where the edges of a mesh are short against it: features that are neighbours
/// must fit beside each other. `lowered`, unless null, tells at how many vertices.
ContactMesh join_sheets(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
                        std::size_t* lowered = nullptr);

/// Two features without a common vertex.
struct ContactPair {
  std::array<std::int32_t, 4> vertex;
  std::array<std::int32_t, 2> triangle;  ///< that hold the two features
  FeaturePair kind;
  bool given_up = false;   ///< in this substep: what is held forces it
  std::int32_t near = -1;  ///< its place among the near pairs of this substep; -1: none
  double keep;             ///< distance that contact restores [m]
  double allowance;        ///< ways of its triangles and clusters until it may be nearer than that [m]
};
/// Two clusters, or twice the same, and what they hold near each other.
struct ClusterPair {
  std::int32_t first, second;
  Vec3 shift = Vec3::Zero();  ///< drift of the first less that of the second when they were searched [m]
  double budget = 0.0;        ///< how far they may drift against each other until pairs are missing [m]
  double drifted = 0.0;       ///< sum of their drifts against each other so far [m]
  double apart = 0.0;         ///< and in this substep [m]
  std::vector<ContactPair> pairs = {};
};

/// What is searched for the substep that is under way, over its ways: contacts change them yet.
inline constexpr double kWayMargin = 2.0;

/// Where triangles were when they were searched, and how far they may go until they must be searched anew.
struct ContactBase {
  std::vector<Row> corner;        ///< three a triangle, less the drift of the cluster so far
  std::vector<double> reach;      ///< of each triangle against its cluster [m]
  std::vector<double> travelled;  ///< the way of each triangle against its cluster so far, not only since then [m]
  std::vector<double> until;      ///< the way at which each triangle must be searched anew [m]
  std::vector<Vec3> drifted;      ///< of each cluster, since clusters were paired [m]
  std::vector<Vec3> drift;        ///< in this substep [m]
  double ahead = 1.0;             ///< substeps like this one for which pairs are found
  // What is to be searched anew: triangles, the clusters that hold one, and pairs of clusters (1: only their marked
  // triangles, 2: all).
  std::vector<std::uint8_t> triangle_marked, cluster_marked, pair_marked;
};

/// Keeps the pairs that are nearer than their `keep`, the reaches of both triangles and the budget of their
/// clusters together. Orders do not depend on the number of threads.
class PairFinder {
 public:
  explicit PairFinder(const ContactMesh& mesh) : mesh_(mesh) {}

  /// Grown boxes of the marked triangles.
  void place_boxes(const ContactBase& base);
  /// All pairs of clusters whose boxes are nearer than `far` [m], without their pairs.
  void pair_clusters(double far, std::vector<ClusterPair>& clusters);
  /// How far the box of a cluster, which carries it along, reaches out of where it was when clusters were paired
  /// [m].
  [[nodiscard]] double outgrown(std::size_t cluster) const;
  /// Searches the marked pairs of clusters anew.
  void search(const ContactBase& base, std::vector<ClusterPair>& clusters) const;

 private:
  struct Query;
  /// Of the triangles of a cluster, each number side by side.
  using ClusterBoxes = std::array<std::array<float, ContactMesh::kClusterSize>, 6>;
  using Bounds = std::array<float, 6>;
  using Hits = std::array<std::uint8_t, ContactMesh::kClusterSize>;
  void find_hits(std::int32_t cluster, const Bounds& across, std::int32_t of, std::int32_t triangle,
                 Hits& hits) const;
  void choose_budget(const ContactBase& base, ClusterPair& clusters) const;
  void search_one(const ContactBase& base, ClusterPair& clusters, bool all) const;

  const ContactMesh& mesh_;
  std::vector<ClusterBoxes> boxes_;  ///< low corners, and high ones with their sign turned
  std::vector<Bounds> around_;       ///< per cluster, the same
  std::vector<Bounds> paired_;       ///< and when clusters were paired
};

}  // namespace wick::solid
