#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/parallel.h"
#include "solid/sheet_contact_impl.h"

namespace wick::solid {

namespace {

/// Share of its distance, or of the thickness if that is less, that a pair must keep in a substep. Below the floor,
/// a part of the thickness, it must keep nearly all: distances must not fade to nothing over many substeps.
constexpr double kKeptShare = 0.2, kFloor = 1e-3, kKeptBelowFloor = 0.999;
/// Rounds of pushing before vertices are joined to zones, and of zones before all of them are joined.
constexpr int kPushRounds = 2, kZoneRounds = 40;
constexpr int kPushSweeps = 4;

double required_distance(double at_start, double thickness) {
  const double floor = kFloor * thickness, from = std::min(at_start, thickness);
  return from > floor ? std::max(kKeptShare * from, floor * kKeptBelowFloor) : kKeptBelowFloor * from;
}

}  // namespace

void Zones::clear() {
  std::iota(parent_.begin(), parent_.end(), 0);
}

std::int32_t Zones::find(std::int32_t v) {
  while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
  return v;
}

void Zones::join(std::int32_t a, std::int32_t b) {
  a = find(a), b = find(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

/// Whether the features keep their distance on the straight way from the start of the substep to x: a plane that
/// separates them at both ends does so in between. Features that touch from the start cannot cross any more.
bool SheetContact::Impl::certain(const ContactPair& pair, const Separation& at_start,
                                 const std::vector<Row>& x) const {
  const std::array<Vec3, 4> to = points(x, pair.vertex);
  if (touch(at_start.distance, to)) return true;
  const double least = required_distance(at_start.distance, pair.keep);
  if (gap_along(pair.kind, to, at_start.direction) >= least) return true;
  const Separation at_end = closest(pair.kind, to);
  if (!(at_end.distance >= least)) return false;
  const std::array<Vec3, 4> from = points(start, pair.vertex);
  if (gap_along(pair.kind, from, at_end.direction) >= least) return true;
  return stay_apart(pair.kind, from, to, 0.5 * least);
}

/// Checks the pairs with a marked vertex; null: all.
void SheetContact::Impl::find_uncertain(const std::vector<Row>& x, const std::vector<std::uint8_t>* marked) {
  uncertain_found.resize((clusters.size() + kClusterGrain - 1) / kClusterGrain);
  for (std::vector<ContactPair*>& here : uncertain_found) here.clear();
  for_pairs([&](std::size_t chunk, ContactPair& pair, double before, double after, double) {
    if (after * kSumRounding < pair.allowance || pair.given_up) return;
    if (marked != nullptr &&
        std::none_of(pair.vertex.begin(), pair.vertex.end(), [&](std::int32_t v) { return (*marked)[v] != 0; }))
      return;
    if (pair.near >= 0) {
      if (!certain(pair, near[pair.near].start, x)) uncertain_found[chunk].push_back(&pair);
      return;
    }
    const Separation at_start = closest(pair.kind, points(start, pair.vertex));
    pair.allowance = before + at_start.distance - pair.keep;
    if (after * kSumRounding >= pair.allowance && !certain(pair, at_start, x))
      uncertain_found[chunk].push_back(&pair);
  });
  uncertain.clear();
  for (const std::vector<ContactPair*>& here : uncertain_found)
    uncertain.insert(uncertain.end(), here.begin(), here.end());
}

/// Gives up the pairs at fault of which nothing can be moved.
void SheetContact::Impl::give_up_held() {
  std::erase_if(uncertain, [&](ContactPair* pair) {
    if (moves(*pair)) return false;
    give_up(*pair);
    return true;
  });
}

void SheetContact::Impl::give_up(ContactPair& pair) {
  pair.given_up = any_given_up = true;
  ++report.impossible;
}

/// The pairs at fault once more, one after the other.
void SheetContact::Impl::push_uncertain(std::vector<Row>& x, std::vector<std::uint8_t>& touched) {
  std::vector<NearPair> faulty;
  for (ContactPair* pair : uncertain) {
    const Separation at_start = closest(pair->kind, points(start, pair->vertex));
    faulty.push_back({pair, at_start, at_start, PushRole::inside, std::min(pair->keep, at_start.distance)});
  }
  for (int sweep = 0; sweep < kPushSweeps; ++sweep)
    for (NearPair& n : faulty) push(n, x, touched);
}

/// Joins the vertices of each pair at fault. A pair that moved as one already, but for what is held, cannot be
/// helped.
void SheetContact::Impl::grow_zones() {
  for (ContactPair* pair : uncertain)
    if (std::all_of(pair->vertex.begin(), pair->vertex.end(), [&](std::int32_t v) {
          return in_zone[v] != 0 && zones.find(v) == zones.find(pair->vertex[0]);
        }))
      give_up(*pair);
  for (const ContactPair* pair : uncertain)
    for (const std::int32_t v : pair->vertex) {
      zones.join(pair->vertex[0], v);
      in_zone[v] = 1;
    }
}

/// Each zone keeps its momentum, or follows what is held in it.
void SheetContact::Impl::move_zones(std::vector<Row>& x, std::vector<std::uint8_t>& touched) {
  zone_members.clear();
  for (std::size_t i = 0; i < x.size(); ++i)
    if (in_zone[i] != 0) zone_members.push_back(static_cast<std::int32_t>(i));
  zone_motion.resize(x.size());
  for (const std::int32_t i : zone_members) zone_motion[i] = {};
  for (const std::int32_t i : zone_members) {
    ZoneMotion& m = zone_motion[zones.find(i)];
    const Vec3 way_of_one = point(x[i]) - point(start[i]);
    if (x[i].w > 0.0)
      m.mass += 1.0 / x[i].w, m.moved += way_of_one / x[i].w;
    else
      m.held += 1.0, m.carried += way_of_one;
  }
  for (const std::int32_t i : zone_members) {
    if (!(x[i].w > 0.0)) continue;
    const ZoneMotion& m = zone_motion[zones.find(i)];
    const Vec3 to = point(start[i]) + (m.held > 0.0 ? Vec3(m.carried / m.held) : Vec3(m.moved / m.mass));
    x[i].x = to.x(), x[i].y = to.y(), x[i].z = to.z();
    touched[i] = 1;
  }
}

void SheetContact::certify(std::vector<Row>& x, std::vector<std::uint8_t>& touched) {
  Impl& s = *impl_;
  bool zoned = false;
  std::vector<std::uint8_t> moved(x.size(), 0);
  for (int round = 0;; ++round) {
    const bool anew = s.refresh(x);
    s.find_uncertain(x, round == 0 || anew ? nullptr : &moved);
    s.give_up_held();
    if (s.uncertain.empty()) break;
    ++s.report.rounds;
    std::fill(moved.begin(), moved.end(), std::uint8_t{0});
    for (const ContactPair* pair : s.uncertain)
      for (const std::int32_t v : pair->vertex) moved[v] = 1;
    if (round < kPushRounds) {
      s.push_uncertain(x, moved);
    } else {
      if (!std::exchange(zoned, true)) {
        s.zones.clear();
        std::fill(s.in_zone.begin(), s.in_zone.end(), std::uint8_t{0});
      }
      if (round >= kPushRounds + kZoneRounds) s.join_all();
      s.grow_zones();
      s.move_zones(x, moved);
    }
    for (std::size_t i = 0; i < x.size(); ++i) touched[i] |= moved[i];
  }
  if (zoned)
    for (std::size_t i = 0; i < x.size(); ++i) s.report.stopped += s.in_zone[i] != 0 && x[i].w > 0.0 ? 1 : 0;
  s.end_substep(x);
}

void SheetContact::Impl::join_all() {
  for (const Int3& t : mesh.triangles)
    for (const std::int32_t v : t) zones.join(mesh.triangles[0][0], v), in_zone[v] = 1;
}

/// The end of this substep is the start of the next; pins do not change within a step.
void SheetContact::Impl::end_substep(const std::vector<Row>& x) {
  start = x;
  --substeps_left;
  if (std::exchange(any_given_up, false))
    for (ClusterPair& c : clusters)
      for (ContactPair& pair : c.pairs) pair.given_up = false;
  for (std::size_t c = 0; c < base.drift.size(); ++c) base.drifted[c] += base.drift[c];
  for (std::size_t t = 0; t < way.size(); ++t) base.travelled[t] += way[t];
  for (ClusterPair& c : clusters) c.drifted += c.apart;
}

}  // namespace wick::solid
