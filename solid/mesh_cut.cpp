#include "solid/mesh_cut.h"

#include <algorithm>
#include <utility>

namespace wick::solid {

namespace {

/// An edge that the contour crosses, from its burnt end to the one that stays.
struct Crossed {
  std::int32_t minus, plus;
  double share;   ///< of the way from minus to plus at which the level is 0
  double length;  ///< at rest [m]
  [[nodiscard]] double from_minus() const { return share * length; }
  [[nodiscard]] double from_plus() const { return (1.0 - share) * length; }
};

/// A triangle of a vertex's star: the other corners in its sense, and whether they are joined to it by no other
/// one.
struct Fan {
  std::int32_t b, c;
  bool b_outer, c_outer;
};

double area(const Vec3& a, const Vec3& b, const Vec3& c) {
  return 0.5 * (b - a).cross(c - a).norm();
}

/// One pass over the triangles: signs, moves, births, pieces.
class Pass {
 public:
  Pass(CutSurface& surface, std::vector<double>& level, MeshCut& cut)
      : surface_(surface), level_(level), cut_(cut) {}

  /// Returns whether it changed anything.
  bool run() {
    find_signs();
    find_crossed();
    const std::size_t before = cut_.moved + cut_.born + cut_.removed + cut_.made;
    if (!crossed_.empty()) {
      find_stars();
      move_minus_ends();
      move_plus_ends();
      make_vertices();
    }
    cut_triangles();
    return cut_.moved + cut_.born + cut_.removed + cut_.made != before;
  }

 private:
  void find_signs();
  void find_crossed();
  void find_stars();
  void move_minus_ends();
  void move_plus_ends();
  void make_vertices();
  void cut_triangles();
  void add_pieces(const Int3& triangle);
  void add_piece(const Int3& piece);

  void move_onto_contour(std::int32_t vertex, std::vector<const Crossed*>& ways, bool from_minus);
  [[nodiscard]] bool fits(std::int32_t vertex, const Vec3& place) const;
  [[nodiscard]] bool on_rim(std::int32_t vertex) const;
  [[nodiscard]] std::vector<Fan> fan_that_stays(std::int32_t vertex) const;
  bool move(std::int32_t vertex, const Blend& blend, const Vec3& place);
  [[nodiscard]] std::int32_t born_on(std::int32_t minus, std::int32_t plus) const;

  CutSurface& surface_;
  std::vector<double>& level_;
  MeshCut& cut_;
  std::vector<std::int8_t> sign_;
  std::vector<Crossed> crossed_;       ///< by (minus, plus), each once
  std::vector<std::int32_t> born_;     ///< vertex on each crossed edge, -1: an end was moved instead
  std::vector<std::int32_t> star_of_;  ///< index of each vertex's star, -1: on no crossed edge
  std::vector<std::vector<std::int32_t>> stars_;
  std::vector<Int3> kept_;
};

void Pass::find_signs() {
  double largest = 0.0;
  for (const double l : level_) largest = std::max(largest, std::abs(l));
  const double zero = 1e-9 * largest;
  sign_.resize(level_.size());
  for (std::size_t i = 0; i < level_.size(); ++i)
    sign_[i] = static_cast<std::int8_t>(level_[i] > zero ? 1 : level_[i] < -zero ? -1 : 0);
}

void Pass::find_crossed() {
  for (const Int3& v : surface_.triangles)
    for (int k = 0; k < 3; ++k) {
      std::int32_t a = v[k], b = v[(k + 1) % 3];
      if (sign_[a] * sign_[b] >= 0) continue;
      if (sign_[a] > 0) std::swap(a, b);
      const double share = level_[a] / (level_[a] - level_[b]);
      crossed_.push_back({a, b, share, (surface_.rest[b] - surface_.rest[a]).norm()});
    }
  const auto ends = [](const Crossed& c) { return std::pair(c.minus, c.plus); };
  std::sort(crossed_.begin(), crossed_.end(),
            [&](const Crossed& a, const Crossed& b) { return ends(a) < ends(b); });
  crossed_.erase(std::unique(crossed_.begin(), crossed_.end(),
                             [&](const Crossed& a, const Crossed& b) { return ends(a) == ends(b); }),
                 crossed_.end());
}

/// Triangles around each end of a crossed edge.
void Pass::find_stars() {
  star_of_.assign(level_.size(), -1);
  for (const Crossed& c : crossed_)
    for (const std::int32_t end : {c.minus, c.plus})
      if (star_of_[end] < 0) {
        star_of_[end] = static_cast<std::int32_t>(stars_.size());
        stars_.emplace_back();
      }
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t)
    for (const std::int32_t vertex : surface_.triangles[t])
      if (star_of_[vertex] >= 0) stars_[star_of_[vertex]].push_back(static_cast<std::int32_t>(t));
}

/// Height of a triangle over its longest edge; 0.87 where it is equilateral.
double slimness(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest = std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
  return longest > 0.0 ? (b - a).cross(c - a).norm() / longest : 0.0;
}

/// Whether the triangles that stay around a vertex bear it at `place`: none turns over, shrinks to a tenth, or
/// becomes slimmer than 1 : 8 and than it was.
bool Pass::fits(std::int32_t vertex, const Vec3& place) const {
  constexpr double kLeast = 0.1, kSlimmest = 0.125;
  const Vec3& old = surface_.rest[vertex];
  for (const std::int32_t t : stars_[star_of_[vertex]]) {
    const Int3& v = surface_.triangles[t];
    const int k = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
    const std::int32_t b = v[(k + 1) % 3], c = v[(k + 2) % 3];
    if (sign_[b] <= 0 && sign_[c] <= 0) continue;
    const Vec3 &xb = surface_.rest[b], &xc = surface_.rest[c];
    const Vec3 before = (xb - old).cross(xc - old), after = (xb - place).cross(xc - place);
    if (after.dot(before) < kLeast * before.squaredNorm()) return false;
    if (slimness(place, xb, xc) < std::min(kSlimmest, slimness(old, xb, xc))) return false;
  }
  return true;
}

bool Pass::on_rim(std::int32_t vertex) const {
  std::vector<std::int32_t> neighbours;
  for (const std::int32_t t : stars_[star_of_[vertex]])
    for (const std::int32_t i : surface_.triangles[t])
      if (i != vertex) neighbours.push_back(i);
  std::sort(neighbours.begin(), neighbours.end());
  for (std::size_t n = 0; n < neighbours.size(); n += 2)
    if (n + 1 == neighbours.size() || neighbours[n] != neighbours[n + 1]) return true;
  return false;
}

/// Puts a vertex onto the contour along the first of `ways`, nearest first, that its triangles and what is on them
/// bear. One that none fits stays where it is and counts as being there.
void Pass::move_onto_contour(std::int32_t vertex, std::vector<const Crossed*>& ways, bool from_minus) {
  const auto distance = [&](const Crossed* c) { return from_minus ? c->from_minus() : c->from_plus(); };
  std::stable_sort(ways.begin(), ways.end(),
                   [&](const Crossed* a, const Crossed* b) { return distance(a) < distance(b); });
  sign_[vertex] = 0;
  for (const Crossed* way : ways) {
    const std::int32_t to = from_minus ? way->plus : way->minus;
    const double share = from_minus ? way->share : 1.0 - way->share;
    const Vec3 place = surface_.rest[vertex] + share * (surface_.rest[to] - surface_.rest[vertex]);
    if (distance(way) > surface_.snapping[vertex]) return;
    if (!fits(vertex, place)) continue;
    if (move(vertex, {vertex, vertex, to, share}, place)) return;
  }
}

std::vector<Fan> Pass::fan_that_stays(std::int32_t vertex) const {
  std::vector<Fan> fan;
  for (const std::int32_t t : stars_[star_of_[vertex]]) {
    const Int3& v = surface_.triangles[t];
    const int k = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
    const std::int32_t b = v[(k + 1) % 3], c = v[(k + 2) % 3];
    if (sign_[b] > 0 || sign_[c] > 0) fan.push_back({b, c, true, true});
  }
  for (Fan& one : fan)
    for (const Fan& other : fan) {
      one.b_outer = one.b_outer && other.c != one.b;
      one.c_outer = one.c_outer && other.b != one.c;
    }
  return fan;
}

/// What stays of a vertex's star loses the triangles between its old and its new place along its outer edges (or
/// gains them, where it moves outwards), with what is linear on them; the value at the new place follows from what
/// is then left. Does nothing where that would be less than the least or more than all values around.
bool Pass::move(std::int32_t vertex, const Blend& blend, const Vec3& place) {
  const std::vector<Fan> fan = fan_that_stays(vertex);
  const std::vector<Vec3>& x = surface_.rest;
  const Vec3& old = x[vertex];
  std::vector<double> values;
  for (std::size_t d = 0; d < surface_.density.size(); ++d) {
    const std::vector<double>& q = surface_.density[d];
    const double carried = q[blend.a] + blend.share * (q[blend.b] - q[blend.a]);
    double kept = 0.0, others = 0.0, weight = 0.0, most = q[vertex];
    for (const Fan& t : fan) {
      const Vec3 normal = (x[t.b] - old).cross(x[t.c] - old).normalized();
      kept += area(old, x[t.b], x[t.c]) * (q[vertex] + q[t.b] + q[t.c]) / 3.0;
      if (t.b_outer)
        kept -= 0.5 * (x[t.b] - old).cross(place - old).dot(normal) * (q[vertex] + q[t.b] + carried) / 3.0;
      if (t.c_outer)
        kept -= 0.5 * (place - old).cross(x[t.c] - old).dot(normal) * (q[vertex] + q[t.c] + carried) / 3.0;
      const double now = area(place, x[t.b], x[t.c]) / 3.0;
      others += now * (q[t.b] + q[t.c]);
      weight += now;
      most = std::max({most, q[t.b], q[t.c]});
    }
    values.push_back(weight > 0.0 ? (kept - others) / weight : carried);
    if (values.back() < surface_.least[d] || values.back() > most) return false;
  }
  for (std::size_t d = 0; d < values.size(); ++d) surface_.density[d][vertex] = values[d];
  surface_.rest[vertex] = place;
  level_[vertex] = 0.0;
  cut_.blends.push_back(blend);
  ++cut_.moved;
  return true;
}

/// Burnt ends near the contour, unless the other end of the shortest way is nearer. Those of the rim wait until the
/// way is worth it: moved by a hair at a time, they would wear the triangles behind them down to slivers.
void Pass::move_minus_ends() {
  std::vector<const Crossed*> ways;
  for (std::size_t first = 0, end = 0; first < crossed_.size(); first = end) {
    const std::int32_t vertex = crossed_[first].minus;
    ways.clear();
    const Crossed* nearest = &crossed_[first];
    for (end = first; end < crossed_.size() && crossed_[end].minus == vertex; ++end) {
      ways.push_back(&crossed_[end]);
      if (crossed_[end].from_minus() < nearest->from_minus()) nearest = &crossed_[end];
    }
    const bool other_end =
        nearest->from_plus() < nearest->from_minus() && nearest->from_plus() <= surface_.snapping[nearest->plus];
    constexpr double kWaits = 0.5;
    if (nearest->from_minus() <= kWaits * surface_.snapping[vertex] && on_rim(vertex))
      sign_[vertex] = 0;
    else if (nearest->from_minus() <= surface_.snapping[vertex] && !other_end)
      move_onto_contour(vertex, ways, true);
  }
}

/// Ends that stay and are near the contour, seen from burnt ends that have not been moved.
void Pass::move_plus_ends() {
  std::vector<const Crossed*> by_plus, ways;
  for (const Crossed& c : crossed_)
    if (sign_[c.minus] < 0) by_plus.push_back(&c);
  std::stable_sort(by_plus.begin(), by_plus.end(),
                   [](const Crossed* a, const Crossed* b) { return a->plus < b->plus; });
  for (std::size_t first = 0, end = 0; first < by_plus.size(); first = end) {
    const std::int32_t vertex = by_plus[first]->plus;
    ways.clear();
    double nearest = INFINITY;
    for (end = first; end < by_plus.size() && by_plus[end]->plus == vertex; ++end) {
      ways.push_back(by_plus[end]);
      nearest = std::min(nearest, by_plus[end]->from_plus());
    }
    if (nearest <= surface_.snapping[vertex]) move_onto_contour(vertex, ways, false);
  }
}

/// A vertex on each edge that is still crossed.
void Pass::make_vertices() {
  born_.assign(crossed_.size(), -1);
  for (std::size_t n = 0; n < crossed_.size(); ++n) {
    const Crossed& c = crossed_[n];
    if (sign_[c.minus] >= 0 || sign_[c.plus] <= 0) continue;
    const Blend blend{static_cast<std::int32_t>(surface_.rest.size()), c.minus, c.plus, c.share};
    born_[n] = blend.vertex;
    cut_.blends.push_back(blend);
    apply({blend}, surface_.rest);
    apply({blend}, surface_.snapping);
    for (std::vector<double>& density : surface_.density) apply({blend}, density);
    level_.push_back(0.0);
    sign_.push_back(0);
    ++cut_.born;
  }
}

std::int32_t Pass::born_on(std::int32_t minus, std::int32_t plus) const {
  const auto at = std::lower_bound(crossed_.begin(), crossed_.end(), std::pair(minus, plus),
                                   [](const Crossed& c, const std::pair<std::int32_t, std::int32_t>& ends) {
                                     return std::pair(c.minus, c.plus) < ends;
                                   });
  return born_[at - crossed_.begin()];
}

/// Pieces so thin that they have lost half of the digits of their area are left out.
void Pass::add_piece(const Int3& piece) {
  constexpr double kThinnest = 1e-7;
  if (slimness(surface_.rest[piece[0]], surface_.rest[piece[1]], surface_.rest[piece[2]]) <= kThinnest) return;
  kept_.push_back(piece);
  ++cut_.made;
}

/// What is left of a triangle with corners on both sides of the contour (methods 9.1).
void Pass::add_pieces(const Int3& v) {
  int minus = 0;
  for (const std::int32_t i : v) minus += sign_[i] < 0 ? 1 : 0;
  // Turned so that the corner that is alone on its side comes first.
  const int alone = minus == 2 ? 1 : -1;
  int first = 0;
  while (sign_[v[first]] != alone) ++first;
  const std::int32_t a = v[first], b = v[(first + 1) % 3], c = v[(first + 2) % 3];
  if (minus == 2) return add_piece({a, born_on(b, a), born_on(c, a)});
  if (sign_[c] == 0) return add_piece({born_on(a, b), b, c});
  if (sign_[b] == 0) return add_piece({b, c, born_on(a, c)});
  const std::int32_t ab = born_on(a, b), ac = born_on(a, c);
  const std::vector<Vec3>& x = surface_.rest;
  if ((x[ab] - x[c]).squaredNorm() < (x[b] - x[ac]).squaredNorm()) {
    add_piece({ab, b, c});
    add_piece({ab, c, ac});
  } else {
    add_piece({ab, b, ac});
    add_piece({b, c, ac});
  }
}

void Pass::cut_triangles() {
  kept_.reserve(surface_.triangles.size());
  for (const Int3& v : surface_.triangles) {
    bool plus = false, minus = false;
    for (const std::int32_t i : v) plus |= sign_[i] > 0, minus |= sign_[i] < 0;
    if (plus && !minus) {
      kept_.push_back(v);
      continue;
    }
    ++cut_.removed;
    if (plus) add_pieces(v);
  }
  surface_.triangles = std::move(kept_);
}

}  // namespace

MeshCut cut_below(CutSurface& surface, std::vector<double> level) {
  MeshCut cut;
  // Each pass leaves fewer places where the contour is far from every vertex; two do nearly always.
  constexpr int kMostPasses = 32;
  for (int n = 0; n < kMostPasses && Pass(surface, level, cut).run(); ++n) {
  }
  if (cut.any()) split_fans(surface, cut);
  return cut;
}

std::vector<double> edge_spacing(const std::vector<Vec3>& rest, const std::vector<Int2>& edges) {
  std::vector<double> sum(rest.size(), 0.0);
  std::vector<std::int32_t> count(rest.size(), 0);
  for (const auto& [a, b] : edges)
    for (const std::int32_t i : {a, b}) {
      sum[i] += (rest[a] - rest[b]).norm();
      ++count[i];
    }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] /= std::max(count[i], 1);
  return sum;
}

}  // namespace wick::solid
