#pragma once
/// What is inside SheetContact. Included by sheet_contact*.cpp only.
#include <limits>

#include "core/parallel.h"
#include "solid/sheet_contact.h"

namespace wick::solid {

/// Which of the near pairs push, and when.
enum class PushRole : std::uint8_t { inside, rim, none };

/// A pair that is near in this substep: where it was closest at the start, along what it is pushed, and how hard it
/// has been.
struct NearPair {
  ContactPair* pair;
  Separation start, along;
  PushRole role;
  double keep;          ///< distance to restore in this substep [m]
  double pushed = 0.0;  ///< sum of corrections along the direction [m]
  double braked = 0.0;  ///< and across it, against sliding
};

/// Features so near that rounding decides on which side they are: they touch.
inline bool touch(double distance, const std::array<Vec3, 4>& x) {
  double largest = 0.0;
  for (const Vec3& p : x) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return distance <= 8.0 * std::numeric_limits<double>::epsilon() * largest;
}

/// Sets of vertices that move as one.
class Zones {
 public:
  explicit Zones(std::size_t count = 0) : parent_(count) { clear(); }
  void clear();
  std::int32_t find(std::int32_t v);
  void join(std::int32_t a, std::int32_t b);

 private:
  std::vector<std::int32_t> parent_;
};

/// Sums of ways over many substeps are as good as this.
inline constexpr double kSumRounding = 1.0 + 1e-9;
/// Pairs of clusters that one thread takes at a time.
inline constexpr std::size_t kClusterGrain = 16;

struct SheetContact::Impl {
  Impl(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
       const SheetContactParams& p);

  // contact_refresh.cpp: how far things move, and which pairs are watched.
  void choose_drift(const std::vector<Row>& x);
  [[nodiscard]] double way_from_base(std::int32_t t) const;
  bool measure_ways(const std::vector<Row>& x);
  bool refresh(const std::vector<Row>& x);
  [[nodiscard]] bool clusters_too_far() const;
  bool mark_pairs_out_of_budget();
  void rebase_marked();
  void pair_clusters();
  template <class Body>
  void for_pairs(Body&& body);

  // sheet_contact.cpp: what pushes pairs apart.
  [[nodiscard]] bool moves(const ContactPair& pair) const;
  void forget_near();
  void find_near(const std::vector<Row>& x);
  void sort_by_color();
  void push(NearPair& near, std::vector<Row>& x, std::vector<std::uint8_t>& touched) const;

  // sheet_contact_certify.cpp: proof that nothing passed through, and zones where there is none.
  [[nodiscard]] bool certain(const ContactPair& pair, const Separation& at_start, const std::vector<Row>& x) const;
  void find_uncertain(const std::vector<Row>& x, const std::vector<std::uint8_t>* marked);
  void push_uncertain(std::vector<Row>& x, std::vector<std::uint8_t>& touched);
  void give_up_held();
  void give_up(ContactPair& pair);
  void grow_zones();
  void join_all();
  void move_zones(std::vector<Row>& x, std::vector<std::uint8_t>& touched);
  void end_substep(const std::vector<Row>& x);

  SheetContactParams params;
  std::size_t lowered = 0;
  ContactMesh mesh;
  PairFinder finder;
  SheetContactReport report;

  std::vector<Row> start;  ///< certified positions at the start of the substep, and inverse masses
  std::vector<Row> step;   ///< way of each vertex in this substep [m]
  int substeps_left = 1;
  double most_recovery = 0.0;  ///< overlap that a substep takes out at most [m]

  // How far things have come, and get in this substep. Ways are added up, so that they bound the distance between
  // any two moments.
  ContactBase base;
  bool found = false;       ///< clusters are paired, for where things are now
  double far = 0.0;         ///< clusters that are not paired were farther apart [m]
  std::vector<double> way;  ///< of each triangle against its cluster in this substep [m]

  std::vector<ClusterPair> clusters;
  std::vector<NearPair> near;
  struct Range {
    std::size_t begin, end;
    bool one_by_one;  ///< its pairs may share vertices
  };
  std::vector<std::int32_t> push_order;           ///< places in `near`, colour after colour
  std::vector<Range> ranges;                      ///< of push_order, one after the other
  std::vector<std::vector<NearPair>> near_found;  ///< one a chunk
  std::vector<std::vector<ContactPair*>> uncertain_found;
  std::vector<ContactPair*> uncertain;  ///< pairs whose motion is not proven
  Zones zones;
  std::vector<std::uint8_t> in_zone;  ///< per vertex
  struct ZoneMotion {
    double mass = 0.0, held = 0.0;  ///< [kg], number of held vertices
    Vec3 moved = Vec3::Zero(), carried = Vec3::Zero();
  };
  std::vector<std::int32_t> zone_members;
  std::vector<ZoneMotion> zone_motion;  ///< at the vertex that stands for a zone
  bool any_given_up = false;
};

/// Calls body(chunk, pair, way before this substep, way after it, drift apart in it) for every pair, a chunk at a
/// time in parallel.
template <class Body>
void SheetContact::Impl::for_pairs(Body&& body) {
  parallel_chunks(clusters.size(), kClusterGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      for (ContactPair& pair : clusters[c].pairs) {
        const Int2& t = pair.triangle;
        const double before = base.travelled[t[0]] + base.travelled[t[1]] + clusters[c].drifted;
        body(begin / kClusterGrain, pair, before, before + way[t[0]] + way[t[1]] + clusters[c].apart,
             clusters[c].apart);
      }
  });
}

}  // namespace wick::solid
