#include "diffusion/front_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <set>

#include "diffusion/rank_statistics.h"

namespace wick::diffusion {

namespace {

/// Sample k of a piece that goes on beyond its ends: round and round when closed, reflected in its end points when
/// open.
Vec3 extended(const SampledFront& s, std::ptrdiff_t k) {
  const auto n = static_cast<std::ptrdiff_t>(s.position.size());
  if (s.closed) return s.position[static_cast<std::size_t>(((k % n) + n) % n)];
  Vec3 offset = Vec3::Zero();
  double sign = 1.0;
  while (k < 0 || k >= n) {
    const std::ptrdiff_t end = k < 0 ? 0 : n - 1;
    offset += sign * 2.0 * s.position[static_cast<std::size_t>(end)];
    sign = -sign;
    k = 2 * end - k;
  }
  return offset + sign * s.position[static_cast<std::size_t>(k)];
}

/// Mean square distance of one piece from its Gaussian low-pass.
double squared_roughness(const FrontPiece& piece, double sigma) {
  // Ten samples a standard deviation: the trapezoid sum of a Gaussian is then exact to rounding.
  const SampledFront s = sample(piece, 0.1 * sigma);
  if (s.position.size() < 3 || s.step <= 0.0) return 0.0;
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(5.0 * sigma / s.step));
  std::vector<double> weight;
  double total = 0.0;
  for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
    const double distance = static_cast<double>(k) * s.step / sigma;
    weight.push_back(std::exp(-0.5 * distance * distance));
    total += weight.back();
  }
  double sum = 0.0;
  for (std::size_t n = 0; n < s.position.size(); ++n) {
    Vec3 mean = Vec3::Zero();
    for (std::ptrdiff_t k = -reach; k <= reach; ++k)
      mean += weight[static_cast<std::size_t>(k + reach)] * extended(s, static_cast<std::ptrdiff_t>(n) + k);
    sum += (s.position[n] - mean / total).squaredNorm();
  }
  return sum / static_cast<double>(s.position.size());
}

/// Length-weighted mean over the pieces that are long enough.
template <class Measure>
double mean_over_pieces(const Front& front, double least_length, Measure&& measure) {
  double sum = 0.0, length = 0.0;
  for (const FrontPiece& piece : front.pieces) {
    const double l = piece.length();
    if (l < least_length || l <= 0.0) continue;
    sum += l * measure(piece, l);
    length += l;
  }
  return length > 0.0 ? sum / length : 0.0;
}

/// Boxes of a lattice that the front touches.
std::size_t boxes_touched(const Front& front, double size, const Vec3& shift) {
  std::set<std::array<std::int64_t, 3>> boxes;
  for (const FrontPiece& piece : front.pieces) {
    // Eight samples a box: what a corner cut shorter than that hides is below the scatter of the count.
    for (const Vec3& p : sample(piece, 0.125 * size).position) {
      const Vec3 cell = (p + shift) / size;
      boxes.insert({std::int64_t(std::floor(cell.x())), std::int64_t(std::floor(cell.y())),
                    std::int64_t(std::floor(cell.z()))});
    }
  }
  return boxes.size();
}

/// Signed turning per length at the samples of a piece: that of the curve seen along its own mean normal would need
/// a chart; on a curved sheet the unsigned angle between segments is signed by the side it turns to.
std::vector<double> curvatures(const SampledFront& s) {
  std::vector<double> kappa;
  const std::size_t n = s.position.size();
  Vec3 reference = Vec3::Zero();
  const std::size_t begin = s.closed ? 0 : 1, end = s.closed ? n : n - 1;
  for (std::size_t k = begin; k < end; ++k) {
    const Vec3 before = s.position[k] - s.position[(k + n - 1) % n],
               after = s.position[(k + 1) % n] - s.position[k];
    const Vec3 turn = before.cross(after);
    if (reference.squaredNorm() == 0.0) reference = turn;
    const double angle = std::atan2(turn.norm(), before.dot(after));
    kappa.push_back((turn.dot(reference) < 0.0 ? -angle : angle) / s.step);
  }
  return kappa;
}

/// Power of a signal at wavelengths below `wavelength`: its mean square less that of the longer waves, in the
/// cosine basis (open) or the Fourier basis (closed).
double power_below(const std::vector<double>& signal, double step, double wavelength, bool closed) {
  const auto n = static_cast<double>(signal.size());
  if (signal.empty()) return 0.0;
  double power = 0.0;
  for (const double value : signal) power += value * value / n;
  const double length = n * step;
  const double turns = closed ? 1.0 : 0.5;  // of the first wave over the length
  for (int k = 0; turns * k * wavelength <= length; ++k) {
    std::complex<double> sum = 0.0;
    for (std::size_t j = 0; j < signal.size(); ++j) {
      const double phase = 2.0 * M_PI * turns * k * (static_cast<double>(j) + 0.5) / n;
      sum += signal[j] * (closed ? std::polar(1.0, phase) : std::complex<double>(std::cos(phase)));
    }
    power -= (k == 0 ? 1.0 : 2.0) * std::norm(sum / n);
  }
  return std::max(power, 0.0);
}

}  // namespace

double blob_tortuosity(const Front& front) {
  return front.area > 0.0 ? front.length() / (2.0 * std::sqrt(M_PI * front.area)) : 0.0;
}

double band_tortuosity(const Front& front, double width) {
  return front.length() / width;
}

double roughness(const Front& front, double sigma, double least_length) {
  return std::sqrt(mean_over_pieces(
      front, least_length, [&](const FrontPiece& piece, double) { return squared_roughness(piece, sigma); }));
}

double relative_roughness(const Front& front, double least_length) {
  if (front.area <= 0.0) return 0.0;
  const double square = mean_over_pieces(front, least_length, [](const FrontPiece& piece, double length) {
    return squared_roughness(piece, length / 8.0);
  });
  return std::sqrt(square / front.area);
}

double departure(const Front& front, const Front& other) {
  double sum = 0.0, count = 0.0;
  for (const FrontPiece& piece : front.pieces)
    for (const FrontPoint& p : piece.points) {
      const double d = distance_to(other, p.position);
      sum += d * d;
      count += 1.0;
    }
  return count > 0.0 ? std::sqrt(sum / count) : std::numeric_limits<double>::infinity();
}

BoxDimension box_dimension(const Front& front, double finest, double coarsest) {
  constexpr int scales = 8, shifts = 4;
  std::vector<double> log_size, log_count;
  for (int n = 0; n < scales; ++n) {
    const double size = finest * std::pow(coarsest / finest, n / double(scales - 1));
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (int k = 0; k < shifts; ++k)
      least = std::min(least, boxes_touched(front, size, Vec3::Constant(size * k / double(shifts))));
    if (least == 0) return {};
    log_size.push_back(std::log(1.0 / size));
    log_count.push_back(std::log(static_cast<double>(least)));
  }
  const LineFit fit = fit_line(log_size, log_count);
  return {fit.slope, fit.r_squared};
}

double fine_curvature_power(const Front& front, double wavelength, double spacing, double least_length) {
  return mean_over_pieces(front, least_length, [&](const FrontPiece& piece, double) {
    const SampledFront s = sample(piece, spacing);
    return power_below(curvatures(s), s.step, wavelength, s.closed);
  });
}

double radial_harmonic(const Front& front, const Vec3& center, int m) {
  std::complex<double> mean = 0.0, harmonic = 0.0;
  for (const FrontPiece& piece : front.pieces) {
    const std::size_t n = piece.points.size();
    for (std::size_t k = 0; k + 1 < n + (piece.closed ? 1 : 0); ++k) {
      // Signed steps of the angle: where the front goes back, what it swept twice is taken away again.
      const Vec3 p = piece.points[k].position - center, q = piece.points[(k + 1) % n].position - center;
      const double step = std::atan2(p.x() * q.y() - p.y() * q.x(), p.x() * q.x() + p.y() * q.y());
      const double radius = 0.5 * (p.head<2>().norm() + q.head<2>().norm());
      const double angle = std::atan2(p.y(), p.x()) + 0.5 * step;
      mean += radius * step;
      harmonic += std::polar(radius * step, -m * angle);
    }
  }
  return std::abs(mean) > 0.0 ? 2.0 * std::abs(harmonic) / std::abs(mean) : 0.0;
}

double second_moment_anisotropy(const solid::ShellMesh& mesh, const std::vector<Vec3>& x,
                                const std::vector<double>& u) {
  double total = 0.0;
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    total += mesh.vertex_area[i] * u[i];
    center += mesh.vertex_area[i] * u[i] * x[i];
  }
  if (total <= 0.0) return 0.0;
  center /= total;
  Mat3 moment = Mat3::Zero();
  for (std::size_t i = 0; i < u.size(); ++i)
    moment += mesh.vertex_area[i] * u[i] / total * (x[i] - center) * (x[i] - center).transpose();
  const Vec3 values = Eigen::SelfAdjointEigenSolver<Mat3>(moment).eigenvalues();
  return values[2] > 0.0 ? 1.0 - std::sqrt(std::max(values[1], 0.0) / values[2]) : 0.0;
}

}  // namespace wick::diffusion
