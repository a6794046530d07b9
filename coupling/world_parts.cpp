#include "coupling/world_parts.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/noise.h"
#include "core/require.h"
#include "coupling/embers.h"
#include "solid/crossings.h"

namespace wick::coupling {

void check_world(const WorldParams& p) {
  require(!p.burning || p.diffusion, "/burning",
          "needs a diffusion section (burning is driven by the heat that diffuses)");
  require(!p.diffusion || !p.shells.empty(), "/diffusion",
          "needs at least one entry in shells (it works on sheets)");
  require(!(p.wind && p.smoke), "/wind",
          "cannot be combined with smoke (the gas itself is the air); remove one of the two");
  require(p.temperature_scale() >= 1.0, "/heat/reference_temperature",
          "must exceed the ambient temperature by at least 1 K (theta is measured between the two)");
  require(!p.shells.empty() || p.smoke, "/shells",
          "missing, and no smoke either (the scene has nothing to simulate)");
  const auto computed = [](const ShellSection& s) { return s.moves && s.motion.kind == MotionKind::none; };
  const auto driven = [](const ShellSection& s) { return s.motion.kind != MotionKind::none; };
  if (std::any_of(p.shells.begin(), p.shells.end(), driven) &&
      std::none_of(p.shells.begin(), p.shells.end(), computed)) {
    require(!p.wind, "/wind", "blows on no sheet (each is held, or moved by its motion) remove it");
    require(p.obstacles.empty() || p.smoke, "/obstacles",
            "meet nothing (each sheet is held, or moved by its motion, and there is no gas) remove them");
  }
  std::set<std::string> names;
  for (std::size_t n = 0; n < p.heat_sources.size(); ++n)
    require(p.heat_sources[n].kind == SourceKind::ball ||
                (p.heat_sources[n].upper - p.heat_sources[n].lower).minCoeff() > 0.0,
            "/heat_sources/" + std::to_string(n) + "/upper", "must exceed lower in every direction");
  for (std::size_t n = 0; n < p.shells.size(); ++n) {
    const std::string& name = p.shells[n].name;
    require(names.insert(name).second, "/shells/" + std::to_string(n) + "/name",
            "\"" + name + "\" is taken by an earlier shell; names must differ");
    require(
        name != embers_name || !sheds_embers(p), "/shells/" + std::to_string(n) + "/name",
        "\"" + name + "\" is the name of the pieces that burn off (their files would be replaced) choose another");
  }
  // Below a tenth of a millimetre transforms of volumes lose their scale, and so do float velocities in cells a
  // step.
  if (p.smoke)
    require(p.smoke->width / p.smoke->resolution[0] >= 1e-4, "/smoke/width",
            "makes cells smaller than 0.1 mm; widen the box or lower /smoke/resolution");
  if (p.smoke)
    for (int a = 0; a < 3; ++a)
      require(
          (p.smoke->sides[2 * a] == fluid::Side::periodic) == (p.smoke->sides[2 * a + 1] == fluid::Side::periodic),
          "/smoke/sides", "a periodic side needs a periodic opposite side");
}

namespace {

double mesh_file_bytes(const std::string& file, const WorldParams& p) {
  std::error_code error;  // a file that is not there is refused when it is read
  const auto size = std::filesystem::file_size(std::filesystem::path(p.directory) / file, error);
  return error ? 0.0 : static_cast<double>(size);
}

MemoryShare mesh_memory(const ShellSection& shell, const std::string& pointer, const WorldParams& p) {
  constexpr double kPerVertex = 2500.0;
  const MeshParams& mesh = shell.mesh;
  MemoryShare share{pointer + "/mesh/vertices", kPerVertex * estimated_vertices(shell, p), "use fewer vertices"};
  if (mesh.kind == MeshKind::icosphere || (mesh.kind == MeshKind::file && mesh.subdivisions > 0)) {
    share.pointer = pointer + "/mesh/subdivisions";
    share.advice = "lower it";
  } else if (mesh.kind == MeshKind::file) {
    share.pointer = pointer + "/mesh/file";
    share.advice = "use a coarser mesh";
  }
  return share;
}

}  // namespace

double estimated_vertices(const ShellSection& shell, const WorldParams& p) {
  const MeshParams& mesh = shell.mesh;
  if (mesh.kind == MeshKind::icosphere) return 10.0 * std::pow(4.0, mesh.subdivisions) + 2.0;
  if (mesh.kind != MeshKind::file) return double(mesh.vertices[0]) * mesh.vertices[1];
  // A vertex with its triangles takes 38 bytes of a binary PLY, more as text.
  constexpr double kFileBytesPerVertex = 38.0;
  return mesh_file_bytes(mesh.file, p) / kFileBytesPerVertex * std::pow(4.0, mesh.subdivisions);
}

std::vector<MemoryShare> world_memory(const WorldParams& p) {
  // Bytes a cell: state 36, walls 28, advection and solver work arrays about 160 (measured on the bundled scenes,
  // the densest of them a sheet in 128^3). A mesh of an obstacle is there as bytes, points and faces, twice.
  // Contact takes most of its bytes a vertex where a sheet falls into a heap.
  constexpr double kPerCell = 228.0, kProgram = 90e6, kPerFileByte = 5.0, kContactPerVertex = 6000.0;
  std::vector<MemoryShare> shares{{"", kProgram, ""}};
  if (p.smoke) {
    const Int3& n = p.smoke->resolution;
    shares.push_back({"/smoke/resolution", kPerCell * n[0] * n[1] * n[2], "lower the resolution"});
  }
  for (std::size_t n = 0; n < p.shells.size(); ++n) {
    const std::string pointer = "/shells/" + std::to_string(n);
    shares.push_back(mesh_memory(p.shells[n], pointer, p));
    if (p.contact) shares.back().bytes += kContactPerVertex * estimated_vertices(p.shells[n], p);
    const MotionTrack* track = p.shells[n].motion.track.get();
    if (!track) continue;
    MemoryShare share{pointer + "/motion/file", 0.0, "record fewer frames, or a coarser sheet"};
    for (const std::vector<Vec3>& x : track->x) share.bytes += double(x.size() * sizeof(Vec3));
    shares.push_back(share);
  }
  for (std::size_t n = 0; n < p.obstacles.size(); ++n)
    if (p.obstacles[n].kind == ObstacleKind::mesh)
      shares.push_back({"/obstacles/" + std::to_string(n) + "/file",
                        kPerFileByte * mesh_file_bytes(p.obstacles[n].file, p), "use a coarser mesh"});
  return shares;
}

std::vector<Vec3> wind_at(const WorldParams& p, const std::vector<Vec3>& x, double time) {
  if (!p.wind) return {};
  const WindParams& wind = *p.wind;
  const double speed = wind.velocity.norm();
  std::vector<Vec3> air(x.size(), wind.velocity);
  if (wind.gust == 0.0 || speed == 0.0) return air;
  // Four waves that travel with the wind, each twice as fast as the one before and half as strong.
  for (std::size_t i = 0; i < x.size(); ++i) {
    Vec3 gust = Vec3::Zero();
    for (std::uint64_t n = 0; n < 4; ++n) {
      const auto seed = static_cast<std::uint64_t>(wind.seed);
      const double frequency = 2.0 * M_PI * std::exp2(double(n)) / wind.gust_period;
      const Vec3 direction(hash_signed(seed, 5 * n), hash_signed(seed, 5 * n + 1), hash_signed(seed, 5 * n + 2));
      const double along = wind.velocity.dot(x[i]) / (speed * speed);
      const double phase = frequency * (time - along) + 2.0 * M_PI * hash_unit(seed, 5 * n + 3);
      gust += std::exp2(-double(n)) * std::sin(phase) * direction;
    }
    air[i] += wind.gust * speed * gust;
  }
  return air;
}

std::vector<std::string> sheets_outside(const std::vector<Sheet>& sheets, const fluid::Grid& grid) {
  const Vec3 low = grid.origin, high = grid.origin + grid.h * Vec3(grid.nx, grid.ny, grid.nz);
  std::vector<std::string> lines;
  for (const Sheet& sheet : sheets) {
    const auto out = [&](const Vec3& x) {
      return (x.array() < low.array()).any() || (x.array() > high.array()).any();
    };
    const auto count = std::count_if(sheet.state.x.begin(), sheet.state.x.end(), out);
    if (count > 0)
      lines.push_back(sheet.pointer + ": " + std::to_string(count) + " of " + std::to_string(sheet.state.x.size()) +
                      " vertices are outside the box of the gas at the start; what they give off is lost");
  }
  return lines;
}

std::vector<std::string> crossing_sheets(const std::vector<Sheet>& sheets) {
  std::vector<solid::PosedSheet> posed;
  for (const Sheet& sheet : sheets) posed.push_back({&sheet.mesh, &sheet.state.x});
  struct Place {
    solid::Crossing first{};
    std::size_t count = 0;
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Place> places;
  for (const solid::Crossing& c : solid::find_crossings(posed)) {
    Place& place = places[std::minmax(c.edge_sheet, c.triangle_sheet)];
    if (place.count++ == 0) place.first = c;
  }
  std::vector<std::string> lines;
  for (const auto& [pair, place] : places) {
    const Int2& edge = sheets[place.first.edge_sheet].mesh.edges[place.first.edge];
    const std::string other = pair.first == pair.second ? "itself" : sheets[pair.first].pointer;
    lines.push_back(sheets[pair.second].pointer + ": passes through " + other + " at the start (" +
                    std::to_string(place.count) + " times; the edge of the vertices " + std::to_string(edge[0]) +
                    " and " + std::to_string(edge[1]) + " of " + sheets[place.first.edge_sheet].pointer +
                    " meets the triangle " + std::to_string(place.first.triangle) + " of " +
                    sheets[place.first.triangle_sheet].pointer + ")");
  }
  return lines;
}

double fastest_in_box(const std::vector<Sheet>& sheets, const fluid::Grid& grid) {
  const Vec3 low = grid.origin - Vec3::Constant(grid.h);
  const Vec3 high = grid.origin + grid.h * Vec3(grid.nx + 1, grid.ny + 1, grid.nz + 1);
  double fastest = 0.0;
  for (const Sheet& sheet : sheets)
    for (std::size_t i = 0; i < sheet.state.x.size(); ++i) {
      const Vec3& x = sheet.state.x[i];
      const bool near = (x.array() > low.array()).all() && (x.array() < high.array()).all();
      if (near && sheet.mesh.component[i] >= 0) fastest = std::max(fastest, sheet.state.v[i].norm());
    }
  return fastest;
}

namespace {

/// Most distant from the pivot that a part of the obstacle within the box can be [m].
double reach_in_box(const Obstacle& obstacle, const fluid::Grid& grid) {
  double farthest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 share(corner & 1, corner >> 1 & 1, corner >> 2);
    const Vec3 x = grid.origin + grid.h * share.cwiseProduct(Vec3(grid.nx, grid.ny, grid.nz));
    farthest = std::max(farthest, (x - obstacle.pivot).norm());
  }
  if (const auto* ball = std::get_if<SphereShape>(&obstacle.shape)) return std::min(farthest, ball->radius);
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape))
    return std::min(farthest, 0.5 * (box->upper - box->lower).norm());
  return farthest;
}

}  // namespace

double fastest_in_box(const std::vector<Obstacle>& obstacles, const fluid::Grid& grid, double dt) {
  const Vec3 extent = grid.h * Vec3(grid.nx, grid.ny, grid.nz), center = grid.origin + 0.5 * extent;
  double fastest = 0.0;
  for (const Obstacle& obstacle : obstacles) {
    const double speed = obstacle.velocity.norm() + obstacle.spin.norm() * reach_in_box(obstacle, grid);
    if (speed > fastest && sample_distance(obstacle, center).distance < 0.5 * extent.norm() + grid.h + speed * dt)
      fastest = speed;
  }
  return fastest;
}

std::vector<double> inverse_masses(const std::vector<Sheet>& sheets, double t) {
  std::vector<double> inverse;
  for (const Sheet& sheet : sheets) {
    const std::size_t first = inverse.size();
    for (const double mass : sheet.inputs.mass) inverse.push_back(mass > 0.0 && sheet.free() ? 1.0 / mass : 0.0);
    for (const std::int32_t vertex : pins_at(sheet, t).vertex) inverse[first + vertex] = 0.0;
  }
  return inverse;
}

void note_solve(FrameReport& report, const std::string& solver, const SolveReport& solve) {
  SolveReport& sum = report.solves[solver];
  sum.iterations += solve.iterations;
  sum.residual_before = std::max(sum.residual_before, solve.residual_before);
  sum.residual_after = std::max(sum.residual_after, solve.residual_after);
  sum.seconds += solve.seconds;
  sum.converged = sum.converged && solve.converged;
  if (!solve.converged) ++report.unconverged_solves;
}

void add_shown_values(ShellView& view, const Sheet& sheet, double ambient, double kelvin) {
  const auto add = [&](const char* name, const std::vector<double>& values, double scale, double offset) {
    std::vector<float> shown(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) shown[i] = static_cast<float>(offset + scale * values[i]);
    view.values.emplace_back(name, std::move(shown));
  };
  if (!sheet.theta.empty()) {
    add("temperature", sheet.theta, kelvin, ambient);
    add("u", sheet.theta, 1.0, 0.0);
    if (sheet.strain_added.size() == sheet.theta.size())
      add("C", sheet.strain_added, 1.0, 0.0);
    else
      view.values.emplace_back("C", std::vector<float>(sheet.theta.size(), 0.0F));
  }
  if (!sheet.burning.fraction_left.empty()) add("char", sheet.burning.fraction_left, -1.0, 1.0);
}

namespace {

/// Largest strain of edges none of whose ends has begun to burn: ash shrinks and loses its stiffness by design.
double largest_unburnt_stretch(const Sheet& sheet) {
  const std::vector<double>& left = sheet.burning.fraction_left;
  double largest = -1.0;
  for (std::size_t e = 0; e < sheet.mesh.edges.size(); ++e) {
    const auto& [a, b] = sheet.mesh.edges[e];
    if (!left.empty() && std::min(left[a], left[b]) < 1.0) continue;
    largest = std::max(largest, (sheet.state.x[a] - sheet.state.x[b]).norm() / sheet.mesh.rest_length[e] - 1.0);
  }
  return largest;
}

}  // namespace

std::map<std::string, double> sheet_metrics(const Sheet& sheet) {
  std::map<std::string, double> m;
  double area = 0.0, mass = 0.0, hottest = 0.0, charred = 0.0;
  for (const double a : sheet.mesh.rest_area) area += a;
  for (const double kg : sheet.inputs.mass) mass += kg;
  std::int32_t last = -1;
  for (const std::int32_t part : sheet.mesh.component) last = std::max(last, part);
  m["parts"] = last + 1.0;
  m["triangles"] = static_cast<double>(sheet.mesh.triangle_count());
  m["area"] = area;
  m["mass"] = mass;
  if (sheet.shell) {
    m["max_stretch"] = sheet.report.shell.max_stretch;
    m["max_stretch_unburnt"] = largest_unburnt_stretch(sheet);
    m["max_speed"] = sheet.report.shell.max_speed;
    m["contacts"] = static_cast<double>(sheet.report.shell.contacts);
  }
  if (!sheet.theta.empty()) {
    for (std::size_t i = 0; i < sheet.theta.size(); ++i)
      if (sheet.mesh.vertex_area[i] > 0.0) hottest = std::max(hottest, sheet.theta[i]);
    m["theta_max"] = hottest;
    m["front_vertices"] = static_cast<double>(sheet.report.diffusion.front_vertices);
    m["strain_added"] = sheet.report.diffusion.strain_added;
    m["rescale"] = sheet.report.diffusion.rescale;
    m["misjudged"] = static_cast<double>(sheet.report.diffusion.misjudged);
  }
  for (std::size_t i = 0; i < sheet.burning.fraction_left.size(); ++i)
    charred += (1.0 - sheet.burning.fraction_left[i]) * sheet.mesh.vertex_area[i];
  if (!sheet.burning.fraction_left.empty()) m["char_mean"] = area > 0.0 ? charred / area : 1.0;
  return m;
}

}  // namespace wick::coupling
