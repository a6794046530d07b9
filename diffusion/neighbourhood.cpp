#include "diffusion/neighbourhood.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <queue>

#include "core/require.h"

namespace wick::diffusion {

namespace {

using Values = std::vector<double>;
using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Patches R/2 apart resolve the exponential decay of K over R to some per cent; hats overlap up to the next but
/// one.
constexpr double spacing_of_radius = 0.5, reach_of_spacing = 1.5;

/// Ways along the edges of a mesh are longer than straight ones by up to a third or so.
constexpr double way_of_reach = 1.4;

/// Vertices by distance along the edges from one of them.
struct Walk {
  const solid::ShellMesh& mesh;
  const SheetGraph& graph;
  Values distance = Values(graph.offset.size() - 1, INFINITY);
  std::vector<std::int32_t> reached = {};

  /// Fills `reached` with what is nearer than `limit`, nearest first.
  void from(std::int32_t start, double limit) {
    for (const std::int32_t i : reached) distance[i] = INFINITY;
    reached.clear();
    using Entry = std::pair<double, std::int32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    open.emplace(0.0, start);
    distance[start] = 0.0;
    while (!open.empty()) {
      const auto [d, i] = open.top();
      open.pop();
      if (d > distance[i]) continue;
      reached.push_back(i);
      for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
        const std::int32_t j = graph.column[k];
        const double through = d + mesh.rest_length[graph.entry_edge[k]];
        if (through >= limit || through >= distance[j]) continue;
        distance[j] = through;
        open.emplace(through, j);
      }
    }
  }
};

/// The cell of each vertex in a grid of about the given spacing that divides the box of its piece evenly, so that
/// no cell is cut short at its sides.
std::vector<Eigen::Vector3i> cells_of(const solid::ShellMesh& mesh, const SheetGraph& graph, const Values& area,
                                      double spacing) {
  constexpr double most = 1e6;  // cells along an axis
  std::vector<Eigen::Vector3i> cell(area.size(), Eigen::Vector3i::Zero());
  for (std::size_t g = 0; g < graph.components.count(); ++g) {
    const auto members = graph.components[g];
    Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
    for (const std::int32_t i : members)
      if (area[i] > 0.0) low = low.cwiseMin(mesh.rest[i]), high = high.cwiseMax(mesh.rest[i]);
    const Vec3 extent = (high - low).cwiseMax(1e-300);
    const Vec3 count = (extent / spacing).array().round().max(1.0).min(most);
    for (const std::int32_t i : members)
      if (area[i] > 0.0)
        cell[i] = (mesh.rest[i] - low)
                      .cwiseQuotient(extent)
                      .cwiseProduct(count)
                      .cwiseMin(count - Vec3::Constant(0.5))
                      .cast<int>();
  }
  return cell;
}

/// Where a patch has its peak, and the vertex next to it.
struct Seed {
  Vec3 middle;
  std::int32_t vertex;
};

/// One seed in the middle of each connected piece of the sheet in a cell, which hardly moves as the mesh is
/// refined. Slivers get none.
std::vector<Seed> seeds_by_cell(const solid::ShellMesh& mesh, const SheetGraph& graph, const Values& area,
                                double spacing) {
  const std::vector<Eigen::Vector3i> cell = cells_of(mesh, graph, area, spacing);
  std::vector<std::uint8_t> taken(area.size(), 0);
  std::vector<Seed> seeds;
  std::vector<std::int32_t> piece;
  for (std::size_t start = 0; start < area.size(); ++start) {
    if (taken[start] != 0 || area[start] <= 0.0) continue;
    piece.assign(1, static_cast<std::int32_t>(start));
    taken[start] = 1;
    double sum = 0.0;
    Vec3 moment = Vec3::Zero();
    for (std::size_t p = 0; p < piece.size(); ++p) {
      const std::int32_t i = piece[p];
      sum += area[i];
      moment += area[i] * mesh.rest[i];
      for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
        const std::int32_t j = graph.column[k];
        if (taken[j] != 0 || area[j] <= 0.0 || cell[j] != cell[i]) continue;
        taken[j] = 1;
        piece.push_back(j);
      }
    }
    if (sum < 0.25 * spacing * spacing) continue;
    const Vec3 middle = moment / sum;
    const auto nearest = std::min_element(piece.begin(), piece.end(), [&](std::int32_t i, std::int32_t j) {
      return (mesh.rest[i] - middle).squaredNorm() < (mesh.rest[j] - middle).squaredNorm();
    });
    seeds.push_back({middle, *nearest});
  }
  return seeds;
}

/// Hats of the patches: one around each seed, and more where vertices are further than `spacing` from all of them.
Sparse build_hats(const solid::ShellMesh& mesh, const SheetGraph& graph, const Values& area, double spacing) {
  const double reach = reach_of_spacing * spacing;
  Values nearest(area.size(), INFINITY), sum(area.size(), 0.0);
  Walk walk{.mesh = mesh, .graph = graph};
  Triplets entries;
  int patches = 0;
  const auto add_patch = [&](const Seed& seed) {
    // Ways along the edges tell what hangs together, straight ones how far it is: they do not depend on the mesh.
    walk.from(seed.vertex, way_of_reach * reach);
    for (const std::int32_t j : walk.reached) {
      const double q = j == seed.vertex ? 0.0 : (mesh.rest[j] - seed.middle).norm() / reach;
      if (q >= 1.0) continue;
      const double hat = (1.0 - q * q) * (1.0 - q * q);
      nearest[j] = std::min(nearest[j], q * reach);
      sum[j] += hat;
      entries.emplace_back(j, patches, hat);
    }
    ++patches;
  };
  for (const Seed& seed : seeds_by_cell(mesh, graph, area, spacing)) add_patch(seed);
  for (std::size_t i = 0; i < area.size(); ++i)
    if (area[i] > 0.0 && nearest[i] >= spacing) add_patch({mesh.rest[i], static_cast<std::int32_t>(i)});
  Sparse hats(static_cast<Eigen::Index>(area.size()), patches);
  hats.setFromTriplets(entries.begin(), entries.end());
  parallel_for(area.size(), chunk, [&](std::size_t i) {
    for (int k = hats.outerIndexPtr()[i]; k < hats.outerIndexPtr()[i + 1]; ++k) hats.valuePtr()[k] /= sum[i];
  });
  return hats;
}

/// A + R² L.
Sparse build_matrix(const SheetGraph& graph, const SheetOperator& op, double squared_radius) {
  const auto n = static_cast<Eigen::Index>(op.storage.size());
  Sparse matrix(n, n);
  matrix.reserve(n + static_cast<Eigen::Index>(graph.column.size()));
  Triplets entries;
  for (std::size_t i = 0; i < op.storage.size(); ++i) {
    double diagonal = op.storage[i];
    for (std::int32_t k = graph.offset[i]; k < graph.offset[i + 1]; ++k) {
      const double flux = squared_radius * op.edge[graph.entry_edge[k]];
      diagonal += flux;
      entries.emplace_back(static_cast<int>(i), graph.column[k], -flux);
    }
    entries.emplace_back(static_cast<int>(i), static_cast<int>(i), diagonal);
  }
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Twice the largest distance from the first vertex.
double extent_of(const std::vector<Vec3>& x) {
  return 2.0 * parallel_max(x.size(), chunk, 0.0, [&](std::size_t begin, std::size_t end) {
           double most = 0.0;
           for (std::size_t i = begin; i < end; ++i) most = std::max(most, (x[i] - x[0]).norm());
           return most;
         });
}

/// y = S x, row by row.
template <class In, class Out>
void multiply(const Sparse& s, const In& x, Out& y) {
  parallel_for(static_cast<std::size_t>(s.rows()), chunk / 4, [&](std::size_t i) {
    double sum = 0.0;
    for (int k = s.outerIndexPtr()[i]; k < s.outerIndexPtr()[i + 1]; ++k)
      sum += s.valuePtr()[k] * x[s.innerIndexPtr()[k]];
    y[static_cast<std::ptrdiff_t>(i)] = sum;
  });
}

}  // namespace

struct Neighbourhood::Impl {
  Sparse hats, gather;  ///< P and Pᵀ
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
};

Neighbourhood::Neighbourhood(const solid::ShellMesh& mesh, const SheetGraph& graph, const SheetOperator& op,
                             double radius)
    : impl_(std::make_unique<Impl>()) {
  // Ten times the sheet's extent is the mean of all of it; more would only cost digits.
  const double bounded = std::min(radius, 10.0 * extent_of(mesh.rest));
  impl_->hats = build_hats(mesh, graph, op.storage, spacing_of_radius * bounded);
  impl_->gather = impl_->hats.transpose();
  if (impl_->hats.cols() == 0) return;
  const Eigen::SparseMatrix<double> coarse =
      impl_->gather * build_matrix(graph, op, bounded * bounded) * impl_->hats;
  impl_->factor.compute(coarse);
  require(impl_->factor.info() == Eigen::Success, "/diffusion/scope_radius",
          "the neighbourhoods could not be factorised (their matrix has lost its digits) reduce it",
          ExitCode::numerical_failure);
}

Neighbourhood::~Neighbourhood() = default;

std::size_t Neighbourhood::patches() const {
  return static_cast<std::size_t>(impl_->hats.cols());
}

std::vector<double> Neighbourhood::average(const std::vector<double>& rhs) const {
  Values result(rhs.size(), 0.0);
  if (patches() == 0) return result;
  Eigen::VectorXd amount(impl_->hats.cols());
  multiply(impl_->gather, rhs, amount);
  const Eigen::VectorXd density = impl_->factor.solve(amount);
  multiply(impl_->hats, density, result);
  return result;
}

}  // namespace wick::diffusion
