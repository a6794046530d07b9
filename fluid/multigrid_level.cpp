#include "fluid/multigrid_level.h"

#include "core/parallel.h"

namespace wick::fluid {

Level::Level(const Graph& graph) : layout(graph.n), wraps(graph.wraps), periodic(wraps[0] || wraps[1] || wraps[2]) {
  // The missing neighbour takes 1 from the diagonal; p = 0 on the face, half a cell away, adds 2.
  for (int a = 0; a < 3; ++a)
    for (int e = 0; e < 2; ++e)
      end_term[a][e] = wraps[a] ? 0.0F : graph.open[2 * a + e] ? 2.0F * graph.stiffness[a] - 1.0F : -1.0F;
  for (auto& w : weight) w = make_coloured<float>(layout, 1.0F);
  diagonal = make_coloured<float>(layout, 1.0F);
  p = make_coloured<float>(layout, 0.0F);
  b = make_coloured<float>(layout, 0.0F);
  for (int k = 0; k < layout.nz; ++k)
    for (int j = 0; j < layout.ny; ++j)
      for (int i = 0; i < layout.nx; ++i)
        diagonal[Layout::colour(i, j, k)][layout.place(i, j, k)] = regular_diagonal(i, j, k);
  span_begin.assign(layout.rows() + 1, 0);
  special_begin.assign(2 * layout.nz + 1, 0);
  gather_begin.assign(layout.nz + 1, 0);
  adoption_begin.assign(2 * layout.nz + 1, 0);
}

namespace {

float row_diagonal(const Level& level, int j, int k) {
  float d = 6.0F;
  if (j == 0) d += level.end_term[1][0];
  if (j == level.layout.ny - 1) d += level.end_term[1][1];
  if (k == 0) d += level.end_term[2][0];
  if (k == level.layout.nz - 1) d += level.end_term[2][1];
  return d;
}

/// The six neighbours of cell m of a row, or the weights of the faces to them.
template <class T>
struct Six {
  const T *left, *right, *front, *back, *below, *above;
};

template <class T>
Six<T> neighbours(const Layout& layout, const T* other, int o, std::ptrdiff_t row) {
  return {other + row - 1 + o,
          other + row + o,
          other + row - layout.row_stride,
          other + row + layout.row_stride,
          other + row - layout.plane_stride,
          other + row + layout.plane_stride};
}

Six<float> face_weights(const Level& level, int colour, int o, std::ptrdiff_t row) {
  const auto& [wx, wy, wz] = level.weight;
  return {wx[colour].data() + row, wx[1 - colour].data() + row + o,
          wy[colour].data() + row, wy[1 - colour].data() + row + level.layout.row_stride,
          wz[colour].data() + row, wz[1 - colour].data() + row + level.layout.plane_stride};
}

/// Calls regular(begin, end) and walled(begin, end) on the pieces of a row.
template <class Regular, class Walled>
void for_pieces(const Level& level, int j, int k, int count, Regular&& regular, Walled&& walled) {
  const std::size_t row = level.layout.row_index(j, k);
  int done = 0;
  for (std::uint32_t s = level.span_begin[row]; s < level.span_begin[row + 1]; ++s) {
    const int begin = std::min<int>(level.spans[s].begin, count), end = std::min<int>(level.spans[s].end, count);
    if (done < begin) regular(done, begin);
    if (begin < end) walled(begin, end);
    done = end;
  }
  if (done < count) regular(done, count);
}

/// Calls fix(m, term) for the first and the last cell of the row if they are in [begin, end) and of this colour.
template <class Fix>
void for_row_ends(const Level& level, int o, int begin, int end, Fix&& fix) {
  const int last_i = level.layout.nx - 1;
  const bool has_first = o == 0 && begin == 0 && end > 0;
  const int last = last_i >> 1;
  const bool has_last = (last_i & 1) == o && begin <= last && last < end;
  const float low = level.end_term[0][0], high = level.end_term[0][1];
  if (last_i == 0 && has_first) return fix(0, low + high);
  if (has_first) fix(0, low);
  if (has_last) fix(last, high);
}

void relax_regular(float* __restrict p, const float* __restrict b, const Six<float>& q, float inverse, int begin,
                   int end) {
  const float* __restrict l = q.left, * __restrict r = q.right, * __restrict f = q.front, * __restrict k = q.back, * __restrict d = q.below, * __restrict u = q.above;
  for (int m = begin; m < end; ++m) p[m] = (b[m] + ((l[m] + r[m]) + (f[m] + k[m]) + (d[m] + u[m]))) * inverse;
}

template <class T>
inline T weighted_sum(const Six<T>& q, const Six<float>& w, std::ptrdiff_t m) {
  return (T(w.left[m]) * q.left[m] + T(w.right[m]) * q.right[m]) +
         (T(w.front[m]) * q.front[m] + T(w.back[m]) * q.back[m]) +
         (T(w.below[m]) * q.below[m] + T(w.above[m]) * q.above[m]);
}

void relax_walled(float* __restrict p, const float* __restrict b, const float* __restrict diagonal,
                  const Six<float> q, const Six<float> w, int begin, int end) {
  for (int m = begin; m < end; ++m) p[m] = (b[m] + weighted_sum(q, w, m)) / diagonal[m];
}

float linked_sum(const Level& level, const Level::Special& special, const std::vector<float>& other) {
  float sum = 0.0F;
  for (std::uint32_t l = special.link_begin; l < special.link_end; ++l)
    sum += level.links[l].weight * other[level.links[l].at];
  return sum;
}

/// b - A p of one node by its links or by the weights around its cell.
float node_residual(const Level& level, const Level::Child& node) {
  const float* p = level.p[node.colour].data();
  const auto& other = level.p[1 - node.colour];
  const float b = level.b[node.colour][node.at];
  if (node.special >= 0) {
    const Level::Special& special = level.specials[node.special];
    return b - special.diagonal * p[node.at] + linked_sum(level, special, other);
  }
  const Six<float> q = neighbours(level.layout, other.data(), node.offset, node.at);
  const Six<float> w = face_weights(level, node.colour, node.offset, node.at);
  return b - level.diagonal[node.colour][node.at] * p[node.at] + weighted_sum(q, w, 0);
}

/// sum[m] += residual, m < count, of one row.
void add_row_residual(const Level& level, int colour, int j, int k, float* __restrict sum) {
  const Layout& layout = level.layout;
  const int o = Layout::offset(colour, j, k);
  const std::ptrdiff_t row = layout.row(j, k);
  const float* __restrict p = level.p[colour].data() + row;
  const float* __restrict b = level.b[colour].data() + row;
  const float* __restrict diagonal = level.diagonal[colour].data() + row;
  const Six<float> q = neighbours(layout, level.p[1 - colour].data(), o, row);
  const Six<float> w = face_weights(level, colour, o, row);
  const float d = row_diagonal(level, j, k);
  for_pieces(
      level, j, k, layout.count(o),
      [&](int begin, int end) {
        for (int m = begin; m < end; ++m)
          sum[m] +=
              b[m] - d * p[m] + ((q.left[m] + q.right[m]) + (q.front[m] + q.back[m]) + (q.below[m] + q.above[m]));
        for_row_ends(level, o, begin, end, [&](int m, float term) { sum[m] -= term * p[m]; });
      },
      [&](int begin, int end) {
        for (int m = begin; m < end; ++m) sum[m] += b[m] - diagonal[m] * p[m] + weighted_sum(q, w, m);
      });
}

/// Work space of one row, a thread.
float* row_buffer(int count) {
  thread_local std::vector<float> buffer;
  if (buffer.size() < std::size_t(count)) buffer.resize(count);
  return buffer.data();
}

}  // namespace

float Level::regular_diagonal(int i, int j, int k) const {
  float d = row_diagonal(*this, j, k);
  if (i == 0) d += end_term[0][0];
  if (i == layout.nx - 1) d += end_term[0][1];
  // A lone cell in a closed box has no neighbour: its pressure is free, and kept at 0.
  return d > 0.0F ? d : 1.0F;
}

void relax_plane(Level& level, int colour, int k) {
  const Layout& layout = level.layout;
  for (int j = 0; j < layout.ny; ++j) {
    const int o = Layout::offset(colour, j, k);
    const std::ptrdiff_t row = layout.row(j, k);
    float* p = level.p[colour].data() + row;
    const float* b = level.b[colour].data() + row;
    const Six<float> q = neighbours(layout, level.p[1 - colour].data(), o, row);
    const float d = row_diagonal(level, j, k);
    for_pieces(
        level, j, k, layout.count(o),
        [&](int begin, int end) {
          const float inverse = 1.0F / d;
          relax_regular(p, b, q, inverse, begin, end);
          for_row_ends(level, o, begin, end, [&](int m, float term) {
            const float sum =
                b[m] + ((q.left[m] + q.right[m]) + (q.front[m] + q.back[m]) + (q.below[m] + q.above[m]));
            p[m] = d + term > 0.0F ? sum / (d + term) : 0.0F;
          });
        },
        [&](int begin, int end) {
          relax_walled(p, b, level.diagonal[colour].data() + row, q, face_weights(level, colour, o, row), begin,
                       end);
        });
  }
  for (std::uint32_t s = level.special_begin[2 * k + colour]; s < level.special_begin[2 * k + colour + 1]; ++s) {
    const Level::Special& special = level.specials[s];
    level.p[colour][special.at] =
        (level.b[colour][special.at] + linked_sum(level, special, level.p[1 - colour])) / special.diagonal;
  }
}

void relax_plane_from_zero(Level& level, int colour, int k) {
  const Layout& layout = level.layout;
  for (int j = 0; j < layout.ny; ++j) {
    const int o = Layout::offset(colour, j, k);
    const std::ptrdiff_t row = layout.row(j, k);
    float* __restrict p = level.p[colour].data() + row;
    const float* __restrict b = level.b[colour].data() + row;
    const float* __restrict diagonal = level.diagonal[colour].data() + row;
    const float d = row_diagonal(level, j, k);
    for_pieces(
        level, j, k, layout.count(o),
        [&](int begin, int end) {
          const float inverse = 1.0F / d;
          for (int m = begin; m < end; ++m) p[m] = b[m] * inverse;
          for_row_ends(level, o, begin, end,
                       [&](int m, float term) { p[m] = d + term > 0.0F ? b[m] / (d + term) : 0.0F; });
        },
        [&](int begin, int end) {
          for (int m = begin; m < end; ++m) p[m] = b[m] / diagonal[m];
        });
  }
  for (std::uint32_t s = level.special_begin[2 * k + colour]; s < level.special_begin[2 * k + colour + 1]; ++s) {
    const Level::Special& special = level.specials[s];
    level.p[colour][special.at] = level.b[colour][special.at] / special.diagonal;
  }
}

void restrict_plane(const Level& fine, Level& coarse, int K, bool both_colours) {
  const Layout &f = fine.layout, &c = coarse.layout;
  float* sum = row_buffer(f.half());
  for (int J = 0; J < c.ny; ++J) {
    std::fill_n(sum, f.half(), 0.0F);
    for (int k = 2 * K; k < std::min(2 * K + 2, f.nz); ++k)
      for (int j = 2 * J; j < std::min(2 * J + 2, f.ny); ++j)
        for (int colour = 0; colour < (both_colours ? 2 : 1); ++colour) add_row_residual(fine, colour, j, k, sum);
    // Cell I of the coarse row holds number m = I of both fine colours; deal them out by coarse colour.
    for (int o = 0; o < 2; ++o) {
      float* __restrict b = coarse.b[Layout::offset(o, J, K)].data() + c.row(J, K);
      const float* __restrict s = sum + o;
      for (int M = 0; M < c.count(o); ++M) b[M] = coarse.restriction * s[2 * M];
    }
  }
  for (std::uint32_t g = coarse.gather_begin[K]; g < coarse.gather_begin[K + 1]; ++g) {
    const Level::Gather& gather = coarse.gathers[g];
    float total = 0.0F;
    for (std::uint32_t n = gather.child_begin; n < gather.child_end; ++n)
      if (both_colours || coarse.children[n].colour == 0) total += node_residual(fine, coarse.children[n]);
    coarse.b[gather.colour][gather.at] = coarse.restriction * total;
  }
}

void prolong_plane(Level& fine, const Level& coarse, int k, int colour) {
  const Layout &f = fine.layout, &c = coarse.layout;
  float* correction = row_buffer(f.half() + 1);
  const int K = k / 2;
  for (int J = 0; J < c.ny; ++J) {
    for (int o = 0; o < 2; ++o) {
      const float* __restrict P = coarse.p[Layout::offset(o, J, K)].data() + c.row(J, K);
      float* __restrict s = correction + o;
      for (int M = 0; M < c.count(o); ++M) s[2 * M] = P[M];
    }
    for (int j = 2 * J; j < std::min(2 * J + 2, f.ny); ++j) {
      const int count = f.count(Layout::offset(colour, j, k));
      float* __restrict p = fine.p[colour].data() + f.row(j, k);
      const float* __restrict s = correction;
      for (int m = 0; m < count; ++m) p[m] += s[m];
    }
  }
  for (std::uint32_t n = fine.adoption_begin[2 * k + colour]; n < fine.adoption_begin[2 * k + colour + 1]; ++n) {
    const Level::Adoption& adoption = fine.adoptions[n];
    const auto& P = coarse.p[adoption.parent_colour];
    const float wrong = adoption.wrong_parent == Level::none ? 0.0F : P[adoption.wrong_parent];
    fine.p[colour][adoption.at] += P[adoption.parent] - wrong;
  }
}

template <class T>
void fill_rim(const Level& level, Coloured<T>& field) {
  const Layout& layout = level.layout;
  const auto row_length = layout.half();
  if (level.wraps[0])
    for (int k = 0; k < layout.nz; ++k)
      for (int j = 0; j < layout.ny; ++j)
        for (const auto& [to, from] : {std::pair{-1, layout.nx - 1}, std::pair{layout.nx, 0}})
          field[Layout::colour(to, j, k)][layout.place(to, j, k)] =
              field[Layout::colour(from, j, k)][layout.place(from, j, k)];
  // A row that moves by an odd number of rows changes colour and keeps its offset.
  const auto copy_row = [&](int j, int k, int from_j, int from_k) {
    const int moved = (j - from_j + k - from_k) & 1;
    for (int c = 0; c < 2; ++c)
      std::copy_n(field[c ^ moved].data() + layout.row(from_j, from_k), row_length,
                  field[c].data() + layout.row(j, k));
  };
  if (level.wraps[1])
    for (int k = 0; k < layout.nz; ++k) {
      copy_row(-1, k, layout.ny - 1, k);
      copy_row(layout.ny, k, 0, k);
    }
  if (level.wraps[2])
    for (int j = 0; j < layout.ny; ++j) {
      copy_row(j, -1, j, layout.nz - 1);
      copy_row(j, layout.nz, j, 0);
    }
}
template void fill_rim(const Level&, Coloured<float>&);
template void fill_rim(const Level&, Coloured<double>&);

template <class T>
void apply_row(const Level& level, const Coloured<T>& field, int colour, int j, int k, double* __restrict out) {
  const Layout& layout = level.layout;
  const int o = Layout::offset(colour, j, k);
  const std::ptrdiff_t row = layout.row(j, k);
  const T* __restrict p = field[colour].data() + row;
  const float* __restrict diagonal = level.diagonal[colour].data() + row;
  const Six<T> q = neighbours(layout, field[1 - colour].data(), o, row);
  const Six<float> w = face_weights(level, colour, o, row);
  const double d = row_diagonal(level, j, k);
  for_pieces(
      level, j, k, layout.count(o),
      [&](int begin, int end) {
        for (int m = begin; m < end; ++m)
          out[m] = d * double(p[m]) -
                   ((double(q.left[m]) + double(q.right[m])) + (double(q.front[m]) + double(q.back[m])) +
                    (double(q.below[m]) + double(q.above[m])));
        for_row_ends(level, o, begin, end, [&](int m, float term) { out[m] += double(term) * double(p[m]); });
      },
      [&](int begin, int end) {
        for (int m = begin; m < end; ++m) {
          const double sum = (double(w.left[m]) * double(q.left[m]) + double(w.right[m]) * double(q.right[m])) +
                             (double(w.front[m]) * double(q.front[m]) + double(w.back[m]) * double(q.back[m])) +
                             (double(w.below[m]) * double(q.below[m]) + double(w.above[m]) * double(q.above[m]));
          out[m] = double(diagonal[m]) * double(p[m]) - sum;
        }
      });
}
template void apply_row(const Level&, const Coloured<float>&, int, int, int, double*);
template void apply_row(const Level&, const Coloured<double>&, int, int, int, double*);

}  // namespace wick::fluid
