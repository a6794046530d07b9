#include "core/parallel.h"
#include "fluid/multigrid_level.h"
#include "fluid/multigrid_wavefront.h"

namespace wick::fluid {

namespace {

constexpr int red = 0, black = 1;

void for_planes(const Level& level, FunctionRef<void(int)> body) {
  const std::size_t grain = level.large() ? 4 : level.layout.nz;
  parallel_chunks(level.layout.nz, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) body(static_cast<int>(k));
  });
}

/// Coarse plane whose fine planes are complete with fine plane k, or -1.
int completed_plane(const Level& fine, int k) {
  return (k & 1) == 1 || k == fine.layout.nz - 1 ? k / 2 : -1;
}

/// Two relaxations red-black from p = 0, and the coarse right-hand side, in one pass over the planes.
void descend(Level& fine, Level& coarse) {
  wavefront(fine.layout.nz, 5, fine.large(), [&](int stage, int k) {
    if (stage == 0) return relax_plane_from_zero(fine, red, k);
    if (stage < 4) return relax_plane(fine, stage == 2 ? red : black, k);
    if (const int K = completed_plane(fine, k); K >= 0) restrict_plane(fine, coarse, K, false);
  });
}

/// The coarse correction and two relaxations black-red, the adjoint of descend(), in one pass. Black cells need
/// no correction: the black relaxation that follows does not read them.
void ascend(Level& fine, const Level& coarse) {
  wavefront(fine.layout.nz, 5, fine.large(), [&](int stage, int k) {
    if (stage == 0) return prolong_plane(fine, coarse, k, red);
    relax_plane(fine, stage % 2 == 1 ? black : red, k);
  });
}

/// One relaxation of both colours with the rim as it was before: links across a periodic side lag behind,
/// forth and back alike, which keeps the cycle symmetric for even and odd numbers of cells.
void relax_lagged(Level& level, int first) {
  fill_rim(level, level.p);
  for (const int colour : {first, 1 - first}) for_planes(level, [&](int k) { relax_plane(level, colour, k); });
}

void descend_periodic(Level& fine, Level& coarse) {
  for (auto& p : fine.p) std::fill(p.begin(), p.end(), 0.0F);
  relax_lagged(fine, red);
  relax_lagged(fine, red);
  fill_rim(fine, fine.p);
  for_planes(coarse, [&](int K) { restrict_plane(fine, coarse, K, true); });
}

void ascend_periodic(Level& fine, const Level& coarse) {
  for_planes(fine, [&](int k) {
    prolong_plane(fine, coarse, k, red);
    prolong_plane(fine, coarse, k, black);
  });
  relax_lagged(fine, black);
  relax_lagged(fine, black);
}

}  // namespace

void v_cycle(std::vector<Level>& levels) {
  const std::size_t last = levels.size() - 1;
  for (std::size_t l = 0; l < last; ++l)
    levels[l].periodic ? descend_periodic(levels[l], levels[l + 1]) : descend(levels[l], levels[l + 1]);
  // The nodes of the single box of the last level are not linked: one division each solves it.
  relax_plane_from_zero(levels[last], red, 0);
  for (std::size_t l = last; l-- > 0;)
    levels[l].periodic ? ascend_periodic(levels[l], levels[l + 1]) : ascend(levels[l], levels[l + 1]);
}

}  // namespace wick::fluid
