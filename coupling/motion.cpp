#include "coupling/motion.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "core/parameters.h"
#include "core/require.h"
#include "diffusion/perlin.h"

namespace wick::coupling {

namespace {

constexpr const char* kMotionKinds[] = {"none", "stretch", "dent", "wave", "star", "crumple", "recorded"};

/// Lower corner and extents of the material chart.
struct Chart {
  Vec2 low = Vec2::Constant(INFINITY), high = -low;
  explicit Chart(const solid::ShellMesh& mesh) {
    for (const Vec2& m : mesh.material) low = low.cwiseMin(m), high = high.cwiseMax(m);
  }
  [[nodiscard]] double extent() const { return (high - low).maxCoeff(); }
};

/// In-plane directions of the chart in the rest shape: least squares would give the same on a flat sheet.
Mat32 chart_axes(const solid::ShellMesh& mesh) {
  const Int3& v = mesh.triangles.front();
  Mat32 rest;
  rest << mesh.rest[v[1]] - mesh.rest[v[0]], mesh.rest[v[2]] - mesh.rest[v[0]];
  Mat2 chart;
  chart << mesh.material[v[1]] - mesh.material[v[0]], mesh.material[v[2]] - mesh.material[v[0]];
  return rest * chart.inverse();
}

/// Perlin noise over four octaves, each half as high and half as wide as the one before.
double octaves(const Vec3& p, int seed) {
  double sum = 0.0;
  for (int o = 0; o < 4; ++o)
    sum += std::exp2(-o) * diffusion::perlin(std::exp2(o) * p, static_cast<std::uint64_t>(seed) + 1000 * o);
  return sum;
}

std::vector<Vec3> crumpled(const MotionParams& p, const solid::ShellMesh& mesh, double amplitude) {
  const std::vector<Vec3> normal = solid::vertex_normals(mesh, mesh.rest);
  std::vector<Vec3> x = mesh.rest;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 at = mesh.has_chart() ? Vec3(mesh.material[i].x(), mesh.material[i].y(), 0.0) : mesh.rest[i];
    // The lattice of the noise lies askew to the sheet, and off its plane: Perlin noise vanishes on the lattice.
    const Vec3 askew(0.8 * at.x() - 0.6 * at.y(), 0.6 * at.x() + 0.8 * at.y(), at.z() + 0.37 * p.wavelength);
    x[i] += amplitude * octaves(askew / p.wavelength, p.seed) * normal[i];
  }
  return x;
}

/// Displacement of the material point m of a flat chart: two components in the plane, one along the normal.
Vec3 chart_displacement(const MotionParams& p, const Chart& chart, const Vec2& m, double amplitude, double t) {
  const Vec2 from_middle = m - 0.5 * (chart.low + chart.high);
  const double r = from_middle.norm(), extent = chart.extent();
  const double dent = std::exp(-0.5 * r * r / (p.wavelength * p.wavelength));
  switch (p.kind) {
    case MotionKind::stretch:
      return {amplitude * from_middle.x(), 0.0, 0.0};
    case MotionKind::dent:
      return {0.0, 0.0, amplitude * dent};
    case MotionKind::wave: {
      const double along = (m.x() - chart.low.x()) / extent, turns = p.period > 0.0 ? t / p.period : 0.0;
      return {0.0, 0.0, amplitude * along * std::sin(2.0 * M_PI * (along * extent / p.wavelength - turns))};
    }
    case MotionKind::star: {
      if (r <= 0.0) return {0.0, 0.0, amplitude * dent};
      const double phi = std::atan2(from_middle.y(), from_middle.x()), arms = std::sin(2.0 * phi);
      const Vec2 outward = amplitude * (r / extent) * (r / extent) * arms * arms * from_middle / r;
      return {outward.x(), outward.y(), amplitude * dent};
    }
    default:
      return Vec3::Zero();
  }
}

/// Refuses a track of another number of vertices, of other triangles or of another rest shape.
void require_same_sheet(const MotionTrack& track, const solid::ShellMesh& mesh, const std::string& pointer) {
  for (const std::vector<Vec3>& x : track.x)
    require(x.size() == mesh.vertex_count(), pointer,
            "is of a sheet with " + std::to_string(x.size()) + " vertices (this one has " +
                std::to_string(mesh.vertex_count()) + ") take the mesh that was recorded");
  require(track.triangles.empty() || track.triangles == mesh.triangles, pointer,
          "is of a sheet with other triangles (the vertices would be joined otherwise) take the mesh that was "
          "recorded");
  // Another compiler may round the placement of the mesh otherwise, by far less than this; a shape that differs by
  // less has the same strains to 1e-7 and better.
  Eigen::AlignedBox3d box;
  for (const Vec3& r : mesh.rest) box.extend(r);
  const double rounding = 1e-9 * (box.diagonal().norm() + box.center().norm());
  for (std::size_t i = 0; i < track.rest.size(); ++i)
    require((track.rest[i] - mesh.rest[i]).norm() <= rounding, pointer,
            "is of a sheet of another rest shape (vertex " + std::to_string(i) + " is " +
                number_text((track.rest[i] - mesh.rest[i]).norm()) + " m away) take the mesh that was recorded");
}

std::vector<Vec3> replayed(const MotionTrack& track, double t) {
  const auto after = std::upper_bound(track.time.begin(), track.time.end(), t) - track.time.begin();
  if (after == 0) return track.x.front();
  if (after == static_cast<std::ptrdiff_t>(track.time.size())) return track.x.back();
  const std::vector<Vec3>&a = track.x[after - 1], &b = track.x[after];
  const double share = (t - track.time[after - 1]) / (track.time[after] - track.time[after - 1]);
  // At a recorded time the places are those of the record, to the sign of zeros.
  if (share <= 0.0) return a;
  std::vector<Vec3> x(a.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = (1.0 - share) * a[i] + share * b[i];
  return x;
}

}  // namespace

void describe(ParameterVisitor& v, MotionParams& p) {
  v.choice(
      {"kind", "", any_value(),
       "none: the shell solver moves the sheet; else it is moved as told, nothing can push it, and its rest shape "
       "stays where it burns"},
      p.kind, kMotionKinds);
  const bool formed = p.kind != MotionKind::none && p.kind != MotionKind::recorded;
  v.only(formed, "kind is none or recorded", [&] {
    v.number({"amplitude", "m (stretch: 1)", between(-1e3, 1e3),
              "a: height of dent, wave and crumple, pull of star, strain of stretch"},
             p.amplitude);
  });
  v.only(formed && p.kind != MotionKind::stretch, "kind has no wavelength", [&] {
    v.number(
        {"wavelength", "m", above_up_to(0, 1e6), "of wave and of the widest octave of crumple; width of dents"},
        p.wavelength);
  });
  v.only(p.kind == MotionKind::wave, "kind is not wave", [&] {
    v.number({"period", "s", between(0, 1e6), "of wave; 0: it stands still"}, p.period);
  });
  v.only(formed, "kind is none or recorded", [&] {
    v.number({"ramp", "s", between(0, 1e6), "time over which the amplitude grows from 0; 0: it is there at once"},
             p.ramp);
  });
  v.only(p.kind == MotionKind::crumple, "kind is not crumple", [&] {
    v.integer({"seed", "", between(0, 2147483647), "of crumple"}, p.seed);
  });
  v.only(p.kind == MotionKind::recorded, "kind is not recorded", [&] {
    v.text(
        {"file", "", any_value(),
         "recorded: motion file beside the scene, as /output/motion writes; HDF5 with /time (F), /x (F x V x 3)"},
        p.file);
  });
}

void require_motion_fits(const MotionParams& p, const solid::ShellMesh& mesh, const std::string& pointer) {
  if (p.kind == MotionKind::none) return;
  if (p.kind != MotionKind::recorded) {
    require(mesh.has_chart() || p.kind == MotionKind::crumple, pointer + "/kind",
            "needs a rectangle (the mesh has no material coordinates); only crumple and recorded work on any mesh");
    return;
  }
  require(p.track != nullptr && !p.track->time.empty(), pointer + "/file",
          "missing (kind is \"recorded\"); name a motion file beside the scene");
  require_same_sheet(*p.track, mesh, pointer + "/file");
}

std::vector<Vec3> motion_at(const MotionParams& p, const solid::ShellMesh& mesh, double t) {
  if (p.kind == MotionKind::none) return mesh.rest;
  if (p.kind == MotionKind::recorded) return replayed(*p.track, t);
  const double amplitude = p.amplitude * (p.ramp > 0.0 ? std::clamp(t / p.ramp, 0.0, 1.0) : 1.0);
  if (p.kind == MotionKind::crumple) return crumpled(p, mesh, amplitude);

  const Chart chart(mesh);
  const Mat32 axes = chart_axes(mesh);
  const Vec3 normal = Vec3(axes.col(0)).cross(Vec3(axes.col(1))).normalized();
  std::vector<Vec3> x = mesh.rest;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 d = chart_displacement(p, chart, mesh.material[i], amplitude, t);
    x[i] += axes * d.head<2>() + d.z() * normal;
  }
  return x;
}

}  // namespace wick::coupling
