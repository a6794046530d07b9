#include "scenes/experiments/front_numbers.h"

#include <algorithm>
#include <cmath>

#include "diffusion/front_shape.h"
#include "diffusion/rank_statistics.h"

namespace wick::scenes {

using diffusion::Front;

namespace {

constexpr double level = 0.5;

const std::vector<double>& strain_of(const std::vector<std::vector<double>>& c, std::size_t frame) {
  return c[std::min(frame, c.size() - 1)];
}

Front front_at(const SheetHistory& run, FrontOf of, std::size_t frame) {
  return diffusion::find_front(run.mesh, diffusion::front_coordinates(run.mesh), front_field(run.frames[frame], of),
                               level);
}

/// c of every vertex, averaged over the frames after `from` up to `to`.
std::vector<double> mean_strain(const std::vector<std::vector<double>>& c, std::size_t from, std::size_t to) {
  std::vector<double> mean = strain_of(c, to);
  for (std::size_t n = from + 1; n < to; ++n)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += strain_of(c, n)[i];
  for (double& value : mean) value /= static_cast<double>(std::max<std::size_t>(to - from, 1));
  return mean;
}

/// Curvature of a sampled front in the plane of the chart, over three samples to each side [1/m].
std::vector<double> curvature_of(const diffusion::SampledFront& s) {
  constexpr std::ptrdiff_t reach = 3;
  const auto n = static_cast<std::ptrdiff_t>(s.position.size());
  const auto at = [&](std::ptrdiff_t k) {
    return s.position[s.closed ? (k + n) % n : std::clamp<std::ptrdiff_t>(k, 0, n - 1)];
  };
  std::vector<double> curvature(s.position.size());
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    const Vec3 in = at(k) - at(k - reach), out = at(k + reach) - at(k);
    const double length = 0.5 * (in.norm() + out.norm());
    curvature[k] = length > 0.0 ? std::atan2(in.cross(out).z(), in.dot(out)) / length : 0.0;
  }
  return curvature;
}

/// What one station in time says of the front's samples.
struct Advance {
  std::vector<double> distance;  ///< from the old front [m]
  std::vector<double> strain;    ///< c, mean since the old front
  std::vector<double> source;    ///< distance from where the front began [m]
  std::vector<double> curvature;
};

Advance advance_of(const Front& before, const Front& now, const Front& first, const std::vector<double>& c,
                   double h) {
  Advance a;
  for (const diffusion::FrontPiece& piece : now.pieces) {
    if (before.pieces.empty() || piece.length() < 6.0 * h) continue;
    const std::vector<double>* fields[] = {&c};
    const diffusion::SampledFront samples = diffusion::sample(piece, h, fields);
    for (const Vec3& p : samples.position) {
      a.distance.push_back(diffusion::distance_to(before, p));
      a.source.push_back(diffusion::distance_to(first, p));
    }
    a.strain.insert(a.strain.end(), samples.field[0].begin(), samples.field[0].end());
    const std::vector<double> bend = curvature_of(samples);
    a.curvature.insert(a.curvature.end(), bend.begin(), bend.end());
  }
  return a;
}

/// Mean over the stations in time at which a front has moved.
struct AdvanceCorrelation {
  double raw = 0.0, partial = 0.0;
};

/// r_s: over about twenty stations in time, how far each place of the new front is from the old one, against c
/// there. Partial: with the distance from the source and the front's curvature partialled out. Both slow a front
/// down without any strain, and a held sheet is strained most beside its source; but bulges and curvature are also
/// what strain makes of a front, so that the partial number misses what has grown already.
AdvanceCorrelation correlate_advance(const SheetHistory& run, const std::vector<std::vector<double>>& c, FrontOf of,
                                     double h) {
  const std::size_t stride = std::max<std::size_t>(1, run.frames.size() / 20);
  AdvanceCorrelation sum;
  double count = 0.0;
  Front before, first;
  for (std::size_t n = 0; n < run.frames.size(); n += stride) {
    const Front now = front_at(run, of, n);
    if (first.pieces.empty()) first = now;
    const Advance a = advance_of(before, now, first, mean_strain(c, n - std::min(n, stride), n), h);
    double square = 0.0;
    for (const double d : a.distance) square += d * d;
    // Below a tenth of an edge an advance is only where the mesh happens to be cut.
    if (!a.distance.empty() && std::sqrt(square / static_cast<double>(a.distance.size())) > 0.1 * h) {
      const std::vector<double> controls[] = {a.source, a.curvature};
      sum.raw += diffusion::spearman(a.distance, a.strain);
      sum.partial += diffusion::partial_spearman(a.distance, a.strain, controls);
      count += 1.0;
    }
    before = now;
  }
  return count > 0.0 ? AdvanceCorrelation{sum.raw / count, sum.partial / count} : AdvanceCorrelation{};
}

Vec3 middle_of(const std::vector<Vec3>& x) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& p : x) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return 0.5 * (low + high);
}

}  // namespace

double sheet_width(const solid::ShellMesh& mesh) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec2& m : mesh.material) low = std::min(low, m.x()), high = std::max(high, m.x());
  return high - low;
}

double mean_edge(const solid::ShellMesh& mesh) {
  double sum = 0.0;
  for (const double l : mesh.rest_length) sum += l;
  return sum / static_cast<double>(mesh.rest_length.size());
}

FrontNumbers measure_front(const SheetHistory& run, const SheetHistory& isotropic,
                           const std::vector<std::vector<double>>& c, const FrontQuestion& question) {
  const double h = mean_edge(run.mesh), least = 6.0 * h;
  const std::size_t frame = frame_at_coverage(run, question.of, question.coverage);
  const Front front = front_at(run, question.of, frame);
  const std::size_t same = frame_at_coverage(isotropic, question.of, question.coverage);
  const Front plain = front_at(isotropic, question.of, same);
  FrontNumbers n;
  n.covered = front.covered();
  n.tortuosity =
      question.band ? diffusion::band_tortuosity(front, sheet_width(run.mesh)) : diffusion::blob_tortuosity(front);
  n.fine_roughness = diffusion::fine_roughness(front, least);
  n.relative_roughness = diffusion::relative_roughness(front, least);
  n.departure = front.area > 0.0 ? diffusion::departure(front, plain) / std::sqrt(front.area) : 0.0;
  n.dimension = diffusion::box_dimension(front, 2.0 * h, std::max(front.length() / 8.0, 4.0 * h)).dimension;
  n.pieces = static_cast<double>(front.count(least));
  n.curvature_power = diffusion::fine_curvature_power(front, sheet_width(run.mesh) / 16.0, h, least);
  n.covered_at_end = front_at(run, question.of, run.frames.size() - 1).covered();
  n.anisotropy = diffusion::radial_harmonic(front, middle_of(diffusion::front_coordinates(run.mesh)), 4);
  // Both are read at the same coverage, so that only the shape differs.
  n.displacement = diffusion::displacement_correlation(run.frames[frame].u, isotropic.frames[same].u,
                                                       diffusion::smoothed(run.mesh, strain_of(c, frame), 0.04));
  n.front_displacement = diffusion::displacement_correlation(
      front_field(run.frames[frame], question.of), front_field(isotropic.frames[same], question.of),
      diffusion::smoothed(run.mesh, strain_of(c, frame), 0.04));
  std::vector<double> virgin = isotropic.frames[same].u;
  const auto burnt = [](const SheetFrame& f, std::size_t i) { return !f.left.empty() && f.left[i] < 0.99; };
  for (std::size_t i = 0; i < virgin.size(); ++i)
    if (burnt(run.frames[frame], i) || burnt(isotropic.frames[same], i)) virgin[i] = -1.0;  // outside 0.15 .. 0.85
  n.ahead = diffusion::displacement_correlation(run.frames[frame].u, virgin,
                                                diffusion::smoothed(run.mesh, strain_of(c, frame), 0.04));
  const AdvanceCorrelation advance = correlate_advance(run, c, question.of, h);
  n.advance = advance.raw;
  n.advance_partial = advance.partial;
  return n;
}

SheetPanel front_panel(const std::string& title, const SheetHistory& run, const FrontQuestion& question,
                       ColorScale scale) {
  const SheetFrame& frame = run.frames[frame_at_coverage(run, question.of, question.coverage)];
  const std::vector<Vec3> x = diffusion::front_coordinates(run.mesh);
  const std::vector<double> shown = front_field(frame, question.of);
  return {title, &run.mesh, x, shown, 0.0, 1.0, scale, diffusion::find_front(run.mesh, x, shown, level)};
}

std::vector<double> MethodNumbers::of(double FrontNumbers::*number) const {
  std::vector<double> values;
  for (const FrontNumbers& n : seeds) values.push_back(n.*number);
  return values;
}

Table numbers_table(const std::string& name, const std::vector<MethodNumbers>& methods) {
  Table table{.name = name,
              .columns = {"method", "seed", "A", "P", "Rq4", "Rq", "Rd", "Df", "nc", "rG", "rG_unburnt", "rG_front",
                          "r_s", "r_s_partial", "curvature_power", "A_end", "AI4"},
              .rows = {}};
  for (const MethodNumbers& m : methods)
    for (std::size_t s = 0; s < m.seeds.size(); ++s) {
      const FrontNumbers& n = m.seeds[s];
      table.add({m.label, std::to_string(s + 1)},
                {n.covered, n.tortuosity, n.fine_roughness, n.relative_roughness, n.departure, n.dimension,
                 n.pieces, n.displacement, n.ahead, n.front_displacement, n.advance, n.advance_partial,
                 n.curvature_power, n.covered_at_end, n.anisotropy});
    }
  return table;
}

}  // namespace wick::scenes
