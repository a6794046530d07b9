#include <numeric>
#include <span>

#include "core/parallel.h"
#include "fluid/multigrid_graph.h"

namespace wick::fluid {

namespace {

constexpr std::size_t grain = 128;
/// Area of a weak link from which its ends are more one than two: half the resistance is gas.
constexpr float strong = 0.5F;

/// Records made by one chunk of boxes, to be appended in the order of the chunks.
struct Batch {
  std::vector<Graph::Record> records;
  std::vector<Graph::Node> nodes;
  std::vector<Graph::Link> links;
  std::vector<std::int32_t> empties;
};

/// Groups the finer nodes of one coarse box.
class BoxSplitter {
 public:
  BoxSplitter(Graph& fine, const Graph& coarse) : fine_(fine), coarse_(coarse) {}

  void split(std::int32_t box, Batch& out) {
    gather_children(box);
    if (members_.empty()) {
      out.empties.push_back(box);
      return;
    }
    join_linked(box);
    number_groups();
    Graph::Record record{.box = box,
                         .node_begin = static_cast<std::uint32_t>(out.nodes.size()),
                         .node_count = static_cast<std::uint32_t>(groups_),
                         .child_local = {}};
    out.nodes.resize(out.nodes.size() + groups_);
    add_up(record, std::span(out.nodes).subspan(record.node_begin));
    out.records.push_back(record);
  }

 private:
  struct Member {
    std::int32_t box, local, q;
    std::int64_t node;  ///< -1: a finer box without record
  };

  void gather_children(std::int32_t box) {
    members_.clear();
    const Int3 at = coarse_.place(box);
    for (int q = 0; q < 8; ++q) {
      first_[q] = -1;
      const Int3 child = {2 * at[0] + (q & 1), 2 * at[1] + (q >> 1 & 1), 2 * at[2] + (q >> 2)};
      if (child[0] >= fine_.n[0] || child[1] >= fine_.n[1] || child[2] >= fine_.n[2]) continue;
      const std::int32_t b = fine_.box(child);
      if (fine_.state[b] == Graph::empty) continue;
      first_[q] = static_cast<int>(members_.size());
      if (fine_.state[b] == Graph::regular) {
        members_.push_back({b, 0, q, -1});
        continue;
      }
      const Graph::Record& record = fine_.records[fine_.state[b]];
      for (std::uint32_t m = 0; m < record.node_count; ++m)
        members_.push_back({b, static_cast<std::int32_t>(m), q, record.node_begin + m});
    }
    root_.resize(members_.size());
    std::iota(root_.begin(), root_.end(), 0);
  }

  int find(int m) {
    while (root_[m] != m) m = root_[m] = root_[root_[m]];
    return m;
  }

  /// Joins member m with the node (other, local) when that lies in the same coarse box.
  void join(int m, std::int32_t box, std::int32_t other, std::int32_t local) {
    const Int3 at = fine_.place(other);
    if (coarse_.box({at[0] / 2, at[1] / 2, at[2] / 2}) != box) return;
    const int q = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
    const int a = find(m), b = find(first_[q] + local);
    root_[std::max(a, b)] = std::min(a, b);
  }

  void join_linked(std::int32_t box) {
    for (int m = 0; m < static_cast<int>(members_.size()); ++m) {
      const Member& member = members_[m];
      if (member.node >= 0) {
        const Graph::Node& node = fine_.nodes[member.node];
        for (std::uint32_t l = node.link_begin; l < node.link_end; ++l)
          if (!fine_.links[l].weak || fine_.links[l].area >= strong)
            join(m, box, fine_.links[l].box, fine_.links[l].local);
        continue;
      }
      const Int3 at = fine_.place(member.box);
      for (int side = 0; side < 6; ++side)
        if (const std::int32_t other = fine_.beside(at, side); other >= 0) join(m, box, other, 0);
    }
  }

  /// Numbers the groups in the order of their first members, the largest one first of all.
  void number_groups() {
    group_.assign(members_.size(), 0);
    std::vector<float> volume;
    groups_ = 0;
    for (int m = 0; m < static_cast<int>(members_.size()); ++m) {
      const int r = find(m);
      group_[m] = r == m ? groups_++ : group_[r];
      volume.resize(groups_, 0.0F);
      volume[group_[m]] += member_volume(members_[m]);
    }
    const int largest = static_cast<int>(std::max_element(volume.begin(), volume.end()) - volume.begin());
    for (int& g : group_)
      if (g == 0 || g == largest) g = largest - g;
  }

  [[nodiscard]] float member_volume(const Member& member) const {
    return member.node >= 0 ? fine_.nodes[member.node].volume : 1.0F;
  }

  void add_up(Graph::Record& record, std::span<Graph::Node> nodes) {
    for (Graph::Node& node : nodes) node.volume = 0.0F;
    const float children =
        static_cast<float>((fine_.halves[0] ? 2 : 1) * (fine_.halves[1] ? 2 : 1) * (fine_.halves[2] ? 2 : 1));
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const Member& member = members_[m];
      Graph::Node& node = nodes[group_[m]];
      const float volume = member_volume(member) / children;
      node.volume += volume;
      for (int a = 0; a < 3; ++a) {
        const float c = member.node >= 0 ? fine_.nodes[member.node].center[a] : 0.0F;
        node.center[a] += volume * (fine_.halves[a] ? 0.5F * c + ((member.q >> a & 1) ? 0.25F : -0.25F) : c);
      }
      const Int3 at = fine_.place(member.box);
      for (int side = 0; side < 6; ++side) {
        const float area =
            member.node >= 0 ? fine_.nodes[member.node].outside[side] : fine_.regular_outside(at, side);
        node.outside[side] += area * (fine_.halves[side / 2] ? 2.0F : 1.0F) / children;
      }
      if (member.node >= 0)
        fine_.nodes[member.node].parent = group_[m];
      else
        record.child_local[member.q] = group_[m];
    }
    for (Graph::Node& node : nodes)
      for (float& c : node.center) c /= node.volume;
  }

  Graph& fine_;
  const Graph& coarse_;
  std::vector<Member> members_;
  std::array<int, 8> first_{};
  std::vector<int> root_, group_;
  int groups_ = 0;
};

/// Adds up the links between the nodes of one box and those of the boxes beside it.
class Linker {
 public:
  Linker(const Graph& fine, const Graph& coarse) : fine_(fine), coarse_(coarse) {}

  void link(const Graph::Record& record, std::span<Graph::Node> nodes, std::vector<Graph::Link>& out) {
    const Int3 at = coarse_.place(record.box);
    found_.resize(std::max<std::size_t>(found_.size(), nodes.size()));
    for (auto& list : found_) list.clear();
    for (int q = 0; q < 8; ++q) {
      const Int3 child = {2 * at[0] + (q & 1), 2 * at[1] + (q >> 1 & 1), 2 * at[2] + (q >> 2)};
      if (child[0] < fine_.n[0] && child[1] < fine_.n[1] && child[2] < fine_.n[2])
        visit_child(record, fine_.box(child), q);
    }
    for (std::size_t m = 0; m < nodes.size(); ++m) finish(nodes[m], static_cast<std::int32_t>(m), out);
  }

 private:
  void visit_child(const Graph::Record& record, std::int32_t child, int q) {
    if (fine_.state[child] == Graph::empty) return;
    if (fine_.state[child] == Graph::regular) {
      const Int3 at = fine_.place(child);
      for (int side = 0; side < 6; ++side)
        if (const std::int32_t other = fine_.beside(at, side); other >= 0)
          add(record, record.child_local[q], other,
              {.box = other, .local = 0, .area = 1.0F, .weight = 1.0F, .side = std::uint8_t(side), .weak = false});
      return;
    }
    const Graph::Record& finer = fine_.records[fine_.state[child]];
    for (std::uint32_t m = 0; m < finer.node_count; ++m) {
      const Graph::Node& node = fine_.nodes[finer.node_begin + m];
      for (std::uint32_t l = node.link_begin; l < node.link_end; ++l) {
        const Graph::Link& link = fine_.links[l];
        add(record, node.parent, link.box, link);
      }
    }
  }

  /// Adds a finer link that leads from node `local` of the record to the finer box `other`.
  void add(const Graph::Record& record, std::int32_t local, std::int32_t other, const Graph::Link& finer) {
    const Int3 at = fine_.place(other);
    const std::int32_t parent = coarse_.box({at[0] / 2, at[1] / 2, at[2] / 2});
    if (parent == record.box) return;
    std::int32_t parent_local = 0;
    if (const std::int64_t node = fine_.node_of(other, finer.local); node >= 0)
      parent_local = fine_.nodes[node].parent;
    else if (coarse_.state[parent] >= 0) {
      const int q = (at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2;
      parent_local = coarse_.records[coarse_.state[parent]].child_local[q];
    }
    // A film that resists less than gas (a > 1) is felt along it, where areas add up as they do for gas.
    float area = finer.weak && finer.area < 1.0F ? 2.0F * finer.area / (1.0F + finer.area) : finer.area;
    for (int a = 0; a < 3; ++a)
      if (a != finer.side / 2 && fine_.halves[a]) area *= 0.5F;
    for (Graph::Link& link : found_[local])
      if (link.side == finer.side && link.box == parent && link.local == parent_local) {
        link.area += area;
        link.weak = link.weak && finer.weak;
        return;
      }
    found_[local].push_back({.box = parent,
                             .local = parent_local,
                             .area = area,
                             .weight = 0.0F,
                             .side = finer.side,
                             .weak = finer.weak});
  }

  void finish(Graph::Node& node, std::int32_t local, std::vector<Graph::Link>& out) {
    node.link_begin = static_cast<std::uint32_t>(out.size());
    node.special = local > 0;
    for (Graph::Link& link : found_[local]) {
      const std::int64_t other = coarse_.node_of(link.box, link.local);
      const int a = link.side / 2;
      const float other_center = other >= 0 ? coarse_.nodes[other].center[a] : 0.0F;
      const float ahead = link.side % 2 == 0 ? node.center[a] - other_center : other_center - node.center[a];
      // Linked nodes hold neighbouring finer boxes, so their middles are half a box apart or more when
      // both are compact; bent ones may come closer, and the bound keeps their link finite.
      link.weight = link.area / std::clamp(1.0F + ahead, 0.5F, 2.0F);
      node.special = node.special || link.local > 0;
      out.push_back(link);
    }
    node.link_end = static_cast<std::uint32_t>(out.size());
  }

  const Graph& fine_;
  const Graph& coarse_;
  std::vector<std::vector<Graph::Link>> found_;
};

void append_split(Graph& fine, Graph& coarse, const std::vector<std::int32_t>& boxes) {
  std::vector<Batch> batches((boxes.size() + grain - 1) / grain);
  parallel_chunks(boxes.size(), grain, [&](std::size_t begin, std::size_t end) {
    BoxSplitter splitter(fine, coarse);
    for (std::size_t b = begin; b < end; ++b) splitter.split(boxes[b], batches[begin / grain]);
  });
  for (const Batch& batch : batches) {
    const auto shift = static_cast<std::uint32_t>(coarse.nodes.size());
    for (Graph::Record record : batch.records) {
      record.node_begin += shift;
      coarse.state[record.box] = static_cast<std::int32_t>(coarse.records.size());
      coarse.records.push_back(record);
    }
    coarse.nodes.insert(coarse.nodes.end(), batch.nodes.begin(), batch.nodes.end());
    for (const std::int32_t b : batch.empties) {
      coarse.state[b] = Graph::empty;
      coarse.empties.push_back(b);
    }
  }
}

/// Boxes that hold a touched finer box, and boxes that stick out of the fluid at its upper ends.
std::vector<std::int32_t> touched_boxes(const Graph& fine, const Graph& coarse) {
  std::vector<std::int32_t> boxes;
  std::vector<bool> seen(coarse.state.size(), false);
  const auto add = [&](std::int32_t b) {
    if (!seen[b]) boxes.push_back(b);
    seen[b] = true;
  };
  const auto add_parent = [&](std::int32_t b) {
    const Int3 at = fine.place(b);
    add(coarse.box({at[0] / 2, at[1] / 2, at[2] / 2}));
  };
  for (const Graph::Record& record : fine.records) add_parent(record.box);
  for (const std::int32_t b : fine.empties) add_parent(b);
  for (int a = 0; a < 3; ++a) {
    if (!fine.halves[a] || coarse.extent[a] == static_cast<float>(coarse.n[a])) continue;
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (int i = 0; i < coarse.n[b]; ++i)
      for (int j = 0; j < coarse.n[c]; ++j) {
        Int3 at{};
        at[a] = coarse.n[a] - 1, at[b] = i, at[c] = j;
        add(coarse.box(at));
      }
  }
  std::sort(boxes.begin(), boxes.end());
  return boxes;
}

/// Regular boxes beside a box that is not a single full node: their links differ.
std::vector<std::int32_t> boxes_beside_odd_ones(const Graph& coarse) {
  std::vector<std::int32_t> boxes;
  for (const Graph::Record& record : coarse.records) {
    const Graph::Node& node = coarse.nodes[record.node_begin];
    if (record.node_count == 1 && node.volume == 1.0F) continue;
    const Int3 at = coarse.place(record.box);
    for (int side = 0; side < 6; ++side)
      if (const std::int32_t other = coarse.beside(at, side); other >= 0 && coarse.state[other] == Graph::regular)
        boxes.push_back(other);
  }
  std::sort(boxes.begin(), boxes.end());
  boxes.erase(std::unique(boxes.begin(), boxes.end()), boxes.end());
  return boxes;
}

void link_records(const Graph& fine, Graph& coarse) {
  std::vector<std::vector<Graph::Link>> links((coarse.records.size() + grain - 1) / grain);
  parallel_chunks(coarse.records.size(), grain, [&](std::size_t begin, std::size_t end) {
    Linker linker(fine, coarse);
    for (std::size_t r = begin; r < end; ++r) {
      const Graph::Record& record = coarse.records[r];
      linker.link(record, std::span(coarse.nodes).subspan(record.node_begin, record.node_count),
                  links[begin / grain]);
    }
  });
  for (std::size_t chunk = 0; chunk < links.size(); ++chunk) {
    const auto shift = static_cast<std::uint32_t>(coarse.links.size());
    coarse.links.insert(coarse.links.end(), links[chunk].begin(), links[chunk].end());
    for (std::size_t r = chunk * grain; r < std::min(coarse.records.size(), (chunk + 1) * grain); ++r)
      for (std::uint32_t m = 0; m < coarse.records[r].node_count; ++m) {
        coarse.nodes[coarse.records[r].node_begin + m].link_begin += shift;
        coarse.nodes[coarse.records[r].node_begin + m].link_end += shift;
      }
  }
}

/// True when a box equals one that no wall touches, its finer boxes included.
bool trivial(const Graph& fine, const Graph& coarse, const Graph::Record& record) {
  const Graph::Node& node = coarse.nodes[record.node_begin];
  if (record.node_count != 1 || node.special || node.volume != 1.0F) return false;
  const Int3 at = coarse.place(record.box);
  int expected = 0;
  for (int side = 0; side < 6; ++side) {
    if (coarse.beside(at, side) >= 0) ++expected;
    if (node.outside[side] != coarse.regular_outside(at, side)) return false;
  }
  if (static_cast<int>(node.link_end - node.link_begin) != expected) return false;
  for (std::uint32_t l = node.link_begin; l < node.link_end; ++l)
    if (coarse.links[l].weight != 1.0F || coarse.links[l].area != 1.0F) return false;
  for (int q = 0; q < 8; ++q) {
    const Int3 child = {2 * at[0] + (q & 1), 2 * at[1] + (q >> 1 & 1), 2 * at[2] + (q >> 2)};
    if (child[0] >= fine.n[0] || child[1] >= fine.n[1] || child[2] >= fine.n[2]) continue;
    const std::int32_t state = fine.state[fine.box(child)];
    if (state < 0) continue;
    const Graph::Record& finer = fine.records[state];
    if (finer.node_count > 1 || fine.nodes[finer.node_begin].special) return false;
  }
  return true;
}

void forget_trivial(const Graph& fine, Graph& coarse) {
  std::vector<std::uint8_t> drop(coarse.records.size(), 0);
  parallel_for(coarse.records.size(), grain,
               [&](std::size_t r) { drop[r] = trivial(fine, coarse, coarse.records[r]) ? 1 : 0; });
  std::size_t kept = 0;
  for (std::size_t r = 0; r < coarse.records.size(); ++r) {
    const Graph::Record record = coarse.records[r];
    coarse.state[record.box] = drop[r] ? Graph::regular : static_cast<std::int32_t>(kept);
    if (!drop[r]) coarse.records[kept++] = record;
  }
  coarse.records.resize(kept);
}

}  // namespace

void build_coarser(Graph& fine, Graph& coarse) {
  coarse.clear();
  append_split(fine, coarse, touched_boxes(fine, coarse));
  append_split(fine, coarse, boxes_beside_odd_ones(coarse));
  link_records(fine, coarse);
  forget_trivial(fine, coarse);
}

}  // namespace wick::fluid
