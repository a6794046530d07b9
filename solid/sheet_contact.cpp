#include "solid/sheet_contact.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/parallel.h"
#include "core/parameters.h"
#include "solid/coloring.h"
#include "solid/sheet_contact_impl.h"

namespace wick::solid {

namespace {

constexpr std::size_t kNearGrain = 256;
/// Overlap from before the substep is taken out at this speed at most [m/s], and by at most this part of the
/// thickness a substep. Less, and stacks sink: they rest on the overlap that each substep leaves and the next takes
/// out.
constexpr double kRecoverySpeed = 0.3, kRecovery = 0.3;
/// No vertex is moved by more than this times what its pair lacks: beside a held one it would be a lever.
constexpr double kMostLever = 2.0;

}  // namespace

void describe(ParameterVisitor& v, SheetContactParams& p) {
  constexpr auto may = OnResume::may_change;
  v.number(
      {"thickness", "m", at_least(0.0),
       "kept between the middles of two layers; 0: the thickness of the material. Lowered where the edges of a "
       "mesh are shorter than that allows",
       may},
      p.thickness);
  v.number({"friction", "1", between(0.0, 100.0), "Coulomb coefficient of layers that rest on each other", may},
           p.friction);
  v.number({"kinetic_friction", "1", between(0.0, 100.0), "Coulomb coefficient of layers that slide", may},
           p.kinetic_friction);
  v.integer({"sweeps", "1", between(1, 1000), "over all contacts a substep; too few: stacks are soft", may},
            p.sweeps);
  v.number(
      {"reach", "1", between(0.01, 10.0),
       "of the mean edge: the way that a vertex may go until pairs are searched anew; cost, not accuracy", may},
      p.reach);
}

SheetContact::Impl::Impl(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
                         const SheetContactParams& p)
    : params(p), mesh(join_sheets(meshes, half_thickness, &lowered)), finder(mesh), zones(mesh.vertex_count()) {
  const std::size_t triangles = mesh.triangles.size(), clusters_count = mesh.cluster_count();
  base.travelled.resize(triangles);
  base.until.resize(triangles);
  base.triangle_marked.resize(triangles);
  way.resize(triangles);
  step.resize(mesh.vertex_count());
  base.corner.resize(3 * triangles);
  base.reach.resize(triangles);
  base.drifted.assign(clusters_count, Vec3::Zero());
  base.drift.assign(clusters_count, Vec3::Zero());
  base.cluster_marked.resize(clusters_count);
  in_zone.resize(mesh.vertex_count());
}

/// Nothing can be done about features that are held or driven both.
bool SheetContact::Impl::moves(const ContactPair& pair) const {
  double mobility = 0.0;
  for (const std::int32_t v : pair.vertex) mobility += start[v].w;
  return mobility > 0.0;
}

namespace {

/// Whether the features are closest inside of both, and not at a rim.
bool is_inside(const Separation& s) {
  return std::all_of(s.weight.begin(), s.weight.end(), [](double w) { return w != 0.0; });
}

/// The direction of the start is safe, since layers cannot swap along it. At a rim it is slanted, and what slides
/// past would run into it like into a bump: there the closest points at the end count, if they are on the same
/// side.
Separation way_to_push(const ContactPair& pair, const Separation& at_start, const std::vector<Row>& x) {
  if (is_inside(at_start) || pair.kind == FeaturePair::edge_edge) return at_start;
  const Separation at_end = closest(pair.kind, points(x, pair.vertex));
  return at_end.direction.dot(at_start.direction) > 0.0 ? at_end : at_start;
}

/// Many pairs share a rim at which they are closest: the vertex and the triangle that answers for the rim push, the
/// others do not.
PushRole role_of(const ContactMesh& mesh, const ContactPair& pair, const Separation& s) {
  if (is_inside(s)) return PushRole::inside;
  if (pair.kind == FeaturePair::edge_edge) return PushRole::none;
  const std::uint8_t vertices = mesh.vertices[pair.triangle[1]], edges = mesh.edges[pair.triangle[1]];
  for (unsigned k = 0; k < 3; ++k) {
    const bool here = s.weight[1 + k] != 0.0, next = s.weight[1 + (k + 1) % 3] != 0.0;
    const bool before = s.weight[1 + (k + 2) % 3] != 0.0;
    if (here && next) return (edges >> k & 1) != 0 ? PushRole::rim : PushRole::none;
    if (here && !before) return (vertices >> k & 1) != 0 ? PushRole::rim : PushRole::none;
  }
  return PushRole::none;
}

}  // namespace

void SheetContact::Impl::forget_near() {
  for (const NearPair& n : near) n.pair->near = -1;
  near.clear();
}

/// The pairs whose distance may be less than they keep.
void SheetContact::Impl::find_near(const std::vector<Row>& x) {
  forget_near();
  near_found.resize((clusters.size() + kClusterGrain - 1) / kClusterGrain);
  for (std::vector<NearPair>& here : near_found) here.clear();
  for_pairs([&](std::size_t chunk, ContactPair& pair, double before, double after, double apart) {
    if (after * kSumRounding < pair.allowance || !moves(pair)) return;
    const std::array<Vec3, 4> from = points(start, pair.vertex);
    const Separation s = closest(pair.kind, from);
    pair.allowance = before + s.distance - pair.keep;
    // From what moves in this substep alone, so that which pairs are near does not depend on the steps before.
    if (way[pair.triangle[0]] + way[pair.triangle[1]] + apart < s.distance - pair.keep) return;
    const Separation along = way_to_push(pair, s, x);
    const bool touches = touch(s.distance, from);
    const double recovered = s.distance + std::min(kRecovery * pair.keep, most_recovery);
    near_found[chunk].push_back(
        {&pair, s, along, touches ? PushRole::none : role_of(mesh, pair, along), std::min(pair.keep, recovered)});
  });
  for (const std::vector<NearPair>& here : near_found) near.insert(near.end(), here.begin(), here.end());
  for (std::size_t k = 0; k < near.size(); ++k) near[k].pair->near = static_cast<std::int32_t>(k);
}

/// Contacts of one colour share no vertex. Those inside of both features come first: they push straight apart, and
/// what is closest at a rim then mostly lacks nothing; pushed before, it would lean on the sheet like on a bump.
void SheetContact::Impl::sort_by_color() {
  push_order.clear();
  ranges.clear();
  for (const PushRole role : {PushRole::inside, PushRole::rim}) {
    std::vector<std::int32_t> of_role, vertices;
    for (std::size_t k = 0; k < near.size(); ++k) {
      if (near[k].role != role) continue;
      of_role.push_back(static_cast<std::int32_t>(k));
      vertices.insert(vertices.end(), near[k].pair->vertex.begin(), near[k].pair->vertex.end());
    }
    const Coloring coloring = color_constraints(vertices, 4, mesh.vertex_count());
    std::array<std::size_t, kMostColors + 2> place{};
    for (const std::int32_t c : coloring.color) ++place[c + 1];
    const std::size_t begin = push_order.size();
    for (int c = 0; c <= kMostColors; ++c) {
      if (place[c + 1] > 0) ranges.push_back({begin + place[c], begin + place[c] + place[c + 1], c == kLeftOver});
      place[c + 1] += place[c];
    }
    push_order.resize(begin + of_role.size());
    for (std::size_t k = 0; k < of_role.size(); ++k) push_order[begin + place[coloring.color[k]]++] = of_role[k];
  }
  report.contacts = push_order.size();
}

/// A unilateral constraint C = n . sum w x - keep >= 0 with a fixed direction, and friction against the sliding of
/// the substep as far as the push allows.
void SheetContact::Impl::push(NearPair& n, std::vector<Row>& x, std::vector<std::uint8_t>& touched) const {
  const std::array<std::int32_t, 4>& v = n.pair->vertex;
  const std::array<double, 4>& b = n.along.weight;
  const Vec3& direction = n.along.direction;
  Vec3 between = Vec3::Zero(), slid = Vec3::Zero();
  double mobility = 0.0, lever = 0.0;
  for (int k = 0; k < 4; ++k) {
    between += b[k] * (point(x[v[k]]) - point(x[v[0]]));
    slid += b[k] * (point(x[v[k]]) - point(start[v[k]]));
    mobility += x[v[k]].w * b[k] * b[k];
    lever = std::max(lever, x[v[k]].w * std::abs(b[k]));
  }
  const double lack = n.keep - direction.dot(between);
  if (!(lack > 0.0) || !(mobility > 0.0)) return;
  const double strength = std::min(1.0 / mobility, kMostLever / lever);
  n.pushed += lack;
  const Vec3 sliding = slid - direction * direction.dot(slid);
  const double length = sliding.norm();
  // Stick, or slide; what earlier sweeps have braked counts.
  const bool sticks = length + n.braked <= params.friction * n.pushed;
  const double brake = sticks ? length : std::clamp(params.kinetic_friction * n.pushed - n.braked, 0.0, length);
  n.braked += brake;
  Vec3 change = lack * direction;
  if (length > 0.0) change -= (brake / length) * sliding;
  change *= strength;
  for (int k = 0; k < 4; ++k) {
    Row& r = x[v[k]];
    if (!(r.w > 0.0) || b[k] == 0.0) continue;
    const double share = r.w * b[k];
    r.x += share * change.x();
    r.y += share * change.y();
    r.z += share * change.z();
    touched[v[k]] = 1;
  }
}

SheetContact::SheetContact(std::span<const ShellMesh* const> meshes, std::span<const double> half_thickness,
                           const SheetContactParams& params)
    : impl_(std::make_unique<Impl>(meshes, half_thickness, params)) {}
SheetContact::~SheetContact() = default;
SheetContact::SheetContact(SheetContact&&) noexcept = default;
SheetContact& SheetContact::operator=(SheetContact&&) noexcept = default;

void SheetContact::begin_step(const std::vector<Row>& x, double dt, int substeps) {
  assert(x.size() == impl_->mesh.vertex_count());
  const auto same_place = [](const Row& a, const Row& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  impl_->found &= std::equal(x.begin(), x.end(), impl_->start.begin(), impl_->start.end(), same_place);
  impl_->start = x;
  impl_->substeps_left = substeps;
  impl_->most_recovery = kRecoverySpeed * dt / substeps;
  impl_->report = {};
}

void SheetContact::push_apart(std::vector<Row>& x, std::vector<std::uint8_t>& touched) {
  Impl& s = *impl_;
  s.choose_drift(x);
  s.refresh(x);
  s.find_near(x);
  s.sort_by_color();
  for (int sweep = 0; sweep < s.params.sweeps; ++sweep)
    for (const Impl::Range& range : s.ranges) {
      const std::size_t count = range.end - range.begin;
      parallel_for(count, range.one_by_one ? count : kNearGrain,
                   [&](std::size_t k) { s.push(s.near[s.push_order[range.begin + k]], x, touched); });
    }
}

SheetContactReport SheetContact::report() const {
  SheetContactReport report = impl_->report;
  for (const ClusterPair& c : impl_->clusters) report.pairs += c.pairs.size();
  return report;
}

std::size_t SheetContact::lowered() const {
  return impl_->lowered;
}

}  // namespace wick::solid
