#include "fluid/multigrid_install.h"

#include "core/parallel.h"

namespace wick::fluid {

namespace {

constexpr int span_width = 8;  ///< numbers m: one vector of floats, or two

/// Weight slot of the face of a box on a side.
float& face_slot(Level& level, const Int3& at, int side) {
  Int3 owner = at;
  owner[side / 2] += side % 2;
  return level.weight[side / 2][Layout::colour(owner[0], owner[1], owner[2])]
                     [level.layout.place(owner[0], owner[1], owner[2])];
}

/// Whether a box writes the slot of its face on a side: lower faces are its own, upper ones belong to the
/// box behind unless that box stands for itself with the regular value, or there is none.
bool writes_slot(const Graph& graph, const Int3& at, int side) {
  if (side % 2 == 0 || at[side / 2] == graph.n[side / 2] - 1) return true;
  return graph.state[graph.beside(at, side)] == Graph::regular;
}

void restore(Level& level, const Graph& graph, const std::vector<std::int32_t>& boxes) {
  for (const std::int32_t b : boxes) {
    const Int3 at = graph.place(b);
    for (int side = 0; side < 6; ++side) face_slot(level, at, side) = 1.0F;
    level.diagonal[Layout::colour(at[0], at[1], at[2])][level.layout.place(at[0], at[1], at[2])] =
        level.regular_diagonal(at[0], at[1], at[2]);
  }
}

float node_diagonal(const Graph& graph, const Int3& at, const Graph::Node& node) {
  float sum = graph.outside_weight(at, node);
  for (std::uint32_t l = node.link_begin; l < node.link_end; ++l) sum += graph.links[l].weight;
  // A node without links is a closed part of its own. On coarse levels its b is rounding noise, which must not
  // feed the free constant: p is kept at 0. A single cell has b = 0 exactly.
  return sum > 0.0F ? sum : graph.finest ? 1.0F : 1e30F;
}

void write_weights(const Graph& graph, Level& level, const Int3& at, const Graph::Node* node) {
  std::array<float, 6> weight{};
  if (node != nullptr)
    for (std::uint32_t l = node->link_begin; l < node->link_end; ++l)
      if (graph.links[l].local == 0) weight[graph.links[l].side] = graph.links[l].weight;
  for (int side = 0; side < 6; ++side)
    if (writes_slot(graph, at, side)) face_slot(level, at, side) = weight[side];
  level.diagonal[Layout::colour(at[0], at[1], at[2])][level.layout.place(at[0], at[1], at[2])] =
      node != nullptr ? node_diagonal(graph, at, *node) : 1.0F;
}

void write_spans(const Graph& graph, Level& level, const std::vector<std::int32_t>& boxes) {
  const Layout& layout = level.layout;
  const int blocks = (layout.half() + span_width - 1) / span_width;
  std::vector<std::uint8_t> marked(layout.rows() * blocks, 0), row_marked(layout.rows(), 0);
  for (const std::int32_t b : boxes) {
    const Int3 at = graph.place(b);
    const std::size_t row = layout.row_index(at[1], at[2]);
    row_marked[row] = 1;
    marked[row * blocks + at[0] / 2 / span_width] = 1;
  }
  level.spans.clear();
  for (std::size_t row = 0; row < layout.rows(); ++row) {
    level.span_begin[row] = static_cast<std::uint32_t>(level.spans.size());
    if (row_marked[row] == 0) continue;
    for (int block = 0; block < blocks; ++block) {
      if (marked[row * blocks + block] == 0) continue;
      const auto begin = static_cast<std::uint16_t>(block * span_width);
      const auto end = static_cast<std::uint16_t>(begin + span_width);
      if (level.spans.size() > level.span_begin[row] && level.spans.back().end == begin)
        level.spans.back().end = end;
      else
        level.spans.push_back({begin, end});
    }
  }
  level.span_begin[layout.rows()] = static_cast<std::uint32_t>(level.spans.size());
}

/// Gives each node its place: the first of a box on the grid, the others behind it.
void place_nodes(const Graph& graph, Level& level, std::vector<std::uint32_t>& places) {
  places.resize(graph.nodes.size());
  std::array<std::size_t, 2> size = {level.layout.size(), level.layout.size()};
  for (const Graph::Record& record : graph.records) {
    const Int3 at = graph.place(record.box);
    places[record.node_begin] = static_cast<std::uint32_t>(level.layout.place(at[0], at[1], at[2]));
    for (std::uint32_t m = 1; m < record.node_count; ++m)
      places[record.node_begin + m] = static_cast<std::uint32_t>(size[Layout::colour(at[0], at[1], at[2])]++);
  }
  for (int c = 0; c < 2; ++c) {
    level.p[c].resize(size[c], 0.0F);
    level.b[c].resize(size[c], 0.0F);
  }
}

/// Sorts `items` by key (plane, or plane and colour) into runs that begin at `begin`.
template <class Item>
void sort_into_runs(const std::vector<std::uint32_t>& keys, std::vector<Item>& items,
                    std::vector<std::uint32_t>& begin) {
  std::fill(begin.begin(), begin.end(), 0);
  for (const std::uint32_t key : keys) ++begin[key + 1];
  for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  std::vector<Item> sorted(items.size());
  for (std::size_t n = 0; n < items.size(); ++n) sorted[next[keys[n]]++] = items[n];
  items.swap(sorted);
}

/// Place of the node at the end of a link, in the array of the other colour; Level::none: no such place.
std::uint32_t link_place(const Graph& graph, const Level& level, const std::vector<std::uint32_t>& places,
                         const Int3& from, bool from_grid, const Graph::Link& link) {
  Int3 to = from;
  to[link.side / 2] += link.side % 2 == 0 ? -1 : 1;
  const Int3 at = graph.place(link.box);
  const bool wrapped = to != at;
  // Grid nodes see each other through the rim, like the rows do.
  if (link.local == 0 && (!wrapped || from_grid))
    return static_cast<std::uint32_t>(level.layout.place(to[0], to[1], to[2]));
  // Around an odd number of boxes both ends have one colour: the preconditioner does without such links.
  if (Layout::colour(at[0], at[1], at[2]) == Layout::colour(from[0], from[1], from[2])) return Level::none;
  const std::int64_t node = graph.node_of(link.box, link.local);
  return node >= 0 ? places[node] : static_cast<std::uint32_t>(level.layout.place(at[0], at[1], at[2]));
}

void write_specials(const Graph& graph, Level& level, const std::vector<std::uint32_t>& places) {
  level.specials.clear();
  level.links.clear();
  std::vector<std::uint32_t> keys;
  for (const Graph::Record& record : graph.records) {
    const Int3 at = graph.place(record.box);
    for (std::uint32_t n = record.node_begin; n < record.node_begin + record.node_count; ++n) {
      const Graph::Node& node = graph.nodes[n];
      if (!node.special) continue;
      Level::Special special{.at = places[n],
                             .link_begin = static_cast<std::uint32_t>(level.links.size()),
                             .link_end = 0,
                             .diagonal = node_diagonal(graph, at, node)};
      for (std::uint32_t l = node.link_begin; l < node.link_end; ++l) {
        const std::uint32_t place = link_place(graph, level, places, at, n == record.node_begin, graph.links[l]);
        if (place != Level::none) level.links.push_back({place, graph.links[l].weight});
      }
      special.link_end = static_cast<std::uint32_t>(level.links.size());
      level.specials.push_back(special);
      keys.push_back(2 * at[2] + Layout::colour(at[0], at[1], at[2]));
    }
  }
  sort_into_runs(keys, level.specials, level.special_begin);
}

/// Writes the transfer lists of one coarse box.
class TransferWriter {
 public:
  TransferWriter(const Graph& fine_graph, const Installed& fine_installed, Level& fine, const Graph& coarse_graph,
                 const Installed& coarse_installed, Level& coarse)
      : fine_graph_(fine_graph),
        fine_installed_(fine_installed),
        fine_(fine),
        coarse_graph_(coarse_graph),
        coarse_installed_(coarse_installed),
        coarse_(coarse),
        special_at_(fine_graph.nodes.size(), -1) {
    index_specials();
    fine_.adoptions.clear();
    coarse_.gathers.clear();
    coarse_.children.clear();
    for (const Graph::Record& record : coarse_graph.records) write(record);
    sort_into_runs(gather_keys_, coarse_.gathers, coarse_.gather_begin);
    sort_into_runs(adoption_keys_, fine_.adoptions, fine_.adoption_begin);
  }

 private:
  struct Fine {
    Level::Child child;
    std::int32_t parent;
    int plane;
    bool on_grid;
  };

  /// Number among the sorted specials of each of the fine graph's nodes.
  void index_specials() {
    std::array<std::vector<std::int32_t>, 2> by_place;
    for (int c = 0; c < 2; ++c) by_place[c].assign(fine_.specials.empty() ? 0 : fine_.p[c].size(), -1);
    for (int key = 0; key < 2 * fine_.layout.nz; ++key)
      for (std::uint32_t s = fine_.special_begin[key]; s < fine_.special_begin[key + 1]; ++s)
        by_place[key % 2][fine_.specials[s].at] = static_cast<std::int32_t>(s);
    for (const Graph::Record& record : fine_graph_.records) {
      const Int3 at = fine_graph_.place(record.box);
      for (std::uint32_t n = record.node_begin; n < record.node_begin + record.node_count; ++n)
        if (fine_graph_.nodes[n].special)
          special_at_[n] = by_place[Layout::colour(at[0], at[1], at[2])][fine_installed_.places[n]];
    }
  }

  void write(const Graph::Record& record) {
    collect(record);
    const bool plain = record.node_count == 1 && std::all_of(members_.begin(), members_.end(),
                                                             [](const Fine& m) { return m.child.special < 0; });
    if (plain) return;
    const Int3 at = coarse_graph_.place(record.box);
    const auto colour = static_cast<std::uint8_t>(Layout::colour(at[0], at[1], at[2]));
    for (std::uint32_t m = 0; m < record.node_count; ++m) {
      Level::Gather gather{.at = coarse_installed_.places[record.node_begin + m],
                           .child_begin = static_cast<std::uint32_t>(coarse_.children.size()),
                           .child_end = 0,
                           .colour = colour};
      for (const Fine& member : members_)
        if (member.parent == static_cast<std::int32_t>(m)) coarse_.children.push_back(member.child);
      gather.child_end = static_cast<std::uint32_t>(coarse_.children.size());
      coarse_.gathers.push_back(gather);
      gather_keys_.push_back(at[2]);
    }
    for (const Fine& member : members_) {
      if (member.on_grid && member.parent == 0) continue;
      fine_.adoptions.push_back(
          {.at = member.child.at,
           .parent = coarse_installed_.places[record.node_begin + member.parent],
           .wrong_parent = member.on_grid ? coarse_installed_.places[record.node_begin] : Level::none,
           .parent_colour = colour});
      adoption_keys_.push_back(2 * member.plane + member.child.colour);
    }
  }

  /// All finer nodes in the box with their places.
  void collect(const Graph::Record& record) {
    members_.clear();
    const Int3 at = coarse_graph_.place(record.box);
    for (int q = 0; q < 8; ++q) {
      const Int3 c = {2 * at[0] + (q & 1), 2 * at[1] + (q >> 1 & 1), 2 * at[2] + (q >> 2)};
      if (c[0] >= fine_graph_.n[0] || c[1] >= fine_graph_.n[1] || c[2] >= fine_graph_.n[2]) continue;
      const std::int32_t state = fine_graph_.state[fine_graph_.box(c)];
      if (state == Graph::empty) continue;
      const int colour = Layout::colour(c[0], c[1], c[2]);
      const auto add = [&](std::uint32_t place, std::int32_t special, std::int32_t parent, bool on_grid) {
        members_.push_back({{place, special, static_cast<std::uint8_t>(colour),
                             static_cast<std::uint8_t>(Layout::offset(colour, c[1], c[2]))},
                            parent,
                            c[2],
                            on_grid});
      };
      if (state == Graph::regular) {
        add(static_cast<std::uint32_t>(fine_.layout.place(c[0], c[1], c[2])), -1, record.child_local[q], true);
        continue;
      }
      const Graph::Record& finer = fine_graph_.records[state];
      for (std::uint32_t m = 0; m < finer.node_count; ++m) {
        const std::uint32_t n = finer.node_begin + m;
        add(fine_installed_.places[n], special_at_[n], fine_graph_.nodes[n].parent, m == 0);
      }
    }
  }

  const Graph& fine_graph_;
  const Installed& fine_installed_;
  Level& fine_;
  const Graph& coarse_graph_;
  const Installed& coarse_installed_;
  Level& coarse_;
  std::vector<std::int32_t> special_at_;
  std::vector<Fine> members_;
  std::vector<std::uint32_t> gather_keys_, adoption_keys_;
};

}  // namespace

void install_level(const Graph& graph, Level& level, Installed& installed) {
  restore(level, graph, installed.boxes);
  place_nodes(graph, level, installed.places);
  installed.boxes.clear();
  for (const Graph::Record& record : graph.records) installed.boxes.push_back(record.box);
  parallel_for(graph.records.size(), 1024, [&](std::size_t r) {
    const Graph::Record& record = graph.records[r];
    write_weights(graph, level, graph.place(record.box), &graph.nodes[record.node_begin]);
  });
  for (const std::int32_t b : graph.empties) {
    write_weights(graph, level, graph.place(b), nullptr);
    installed.boxes.push_back(b);
  }
  write_spans(graph, level, installed.boxes);
  write_specials(graph, level, installed.places);
}

void install_transfer(const Graph& fine_graph, const Installed& fine_installed, Level& fine,
                      const Graph& coarse_graph, const Installed& coarse_installed, Level& coarse) {
  TransferWriter(fine_graph, fine_installed, fine, coarse_graph, coarse_installed, coarse);
}

}  // namespace wick::fluid
