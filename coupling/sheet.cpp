#include "coupling/sheet.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/noise.h"
#include "core/number_text.h"
#include "core/require.h"
#include "diffusion/porous.h"
#include "solid/mesh_cut.h"
#include "solid/mesh_file.h"
#include "solid/primitives.h"

namespace wick::coupling {

namespace {

/// What the machine could hand out now [bytes].
std::uint64_t available_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// Refusals of the mesh readers know no scene: they get the pointer of the parameter that named the file.
template <class Make>
auto with_pointer(const std::string& pointer, Make&& make) {
  try {
    return make();
  } catch (const Refusal& refusal) {
    throw Refusal(refusal.code(), refusal.pointer().empty() ? pointer : refusal.pointer(), refusal.what());
  }
}

std::string beside_scene(const WorldParams& world, const std::string& file) {
  return (std::filesystem::path(world.directory) / file).string();
}

/// Refuses a file that is empty, out of all scale, or more than memory bears once it is subdivided.
void require_bearable(const solid::TriangleSoup& soup, const MeshParams& p, const std::string& pointer) {
  require(!soup.triangles.empty(), pointer + "/file", "has no triangles");
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& x : soup.positions) low = low.cwiseMin(p.scale * x), high = high.cwiseMax(p.scale * x);
  // Beyond these a sheet is smaller than a grain of dust, or loses the digits that a millimetre needs.
  constexpr double kSmallest = 1e-6, kFar = 1e6;
  require((high - low).norm() >= kSmallest && high.cwiseAbs().cwiseMax(low.cwiseAbs()).maxCoeff() <= kFar,
          pointer + "/scale",
          "makes a sheet of " + number_text((high - low).norm()) + " m (1e-6 to 1e6 m can be simulated)");
  constexpr double kBytesPerTriangle = 2000.0, kMost = 200e9;
  const double bytes =
      kBytesPerTriangle * static_cast<double>(soup.triangles.size()) * std::pow(4.0, p.subdivisions);
  const bool refined = p.subdivisions > 0;
  require(bytes <= std::min(kMost, static_cast<double>(available_memory())),
          pointer + (refined ? "/subdivisions" : "/file"),
          "would need about " + std::to_string(static_cast<long long>(bytes / 1e9)) + " GB; " +
              (refined ? "lower it" : "use a coarser mesh"),
          ExitCode::refused);
}

FileMesh make_mesh(const MeshParams& p, const std::string& pointer, const WorldParams& world,
                   std::vector<std::string>& warnings) {
  switch (p.kind) {
    case MeshKind::rectangle:
      return with_pointer(pointer + "/vertices", [&] {
        return FileMesh{solid::rectangle(p.vertices[0], p.vertices[1], p.size, p.lattice), {}};
      });
    case MeshKind::icosphere:
      return with_pointer(pointer + "/subdivisions", [&] {
        return FileMesh{solid::icosphere(p.subdivisions, p.radius), {}};
      });
    case MeshKind::cylinder:
      require(p.vertices[0] >= 3, pointer + "/vertices", "a cylinder needs at least 3 vertices around");
      return with_pointer(pointer + "/vertices", [&] {
        return FileMesh{solid::cylinder(p.size[0], p.size[1], p.vertices[0], p.vertices[1]), {}};
      });
    case MeshKind::file:
      break;
  }
  require(!p.file.empty(), pointer + "/file", "missing (kind is \"file\"); name a PLY or OBJ beside the scene");
  FileMesh mesh = read_mesh_beside_scene(world, p.file, pointer + "/file", warnings);
  require_bearable(mesh.soup, p, pointer);
  for (int n = 0; n < p.subdivisions; ++n) mesh.soup = solid::subdivide(mesh.soup);
  return mesh;
}

/// Smooth noise in [-1, 1]: five plane waves with seeded directions, a few across the sheet's extent.
double smooth_noise(const Vec3& x, double extent, int seed) {
  double sum = 0.0;
  for (std::uint64_t n = 0; n < 5; ++n) {
    const auto s = static_cast<std::uint64_t>(seed);
    const Vec3 direction(hash_signed(s, 4 * n), hash_signed(s, 4 * n + 1), hash_signed(s, 4 * n + 2));
    const double waves = (1.0 + static_cast<double>(n)) * 2.0 * M_PI / extent;
    sum += std::sin(waves * direction.dot(x) + 2.0 * M_PI * hash_unit(s, 4 * n + 3));
  }
  return sum / 5.0;
}

void add_wrinkles(Sheet& sheet) {
  const MeshParams& p = sheet.params.mesh;
  if (p.wrinkle <= 0.0) return;
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& x : sheet.mesh.rest) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double extent = std::max((high - low).norm(), 1e-12);
  require(p.wrinkle <= extent, sheet.pointer + "/mesh/wrinkle",
          "is more than the whole sheet measures (" + number_text(extent) + " m); lower it");
  const std::vector<Vec3> normals = solid::vertex_normals(sheet.mesh, sheet.mesh.rest);
  for (std::size_t i = 0; i < sheet.state.x.size(); ++i)
    sheet.state.x[i] += p.wrinkle * smooth_noise(sheet.mesh.rest[i] - low, extent, p.seed) * normals[i];
}

bool on_edge(PinEdge edge, const Vec2& material, const Vec2& low, const Vec2& high) {
  const Vec2 margin = 1e-9 * (high - low);
  switch (edge) {
    case PinEdge::none:
      return false;
    case PinEdge::lower_x:
      return material.x() <= low.x() + margin.x();
    case PinEdge::upper_x:
      return material.x() >= high.x() - margin.x();
    case PinEdge::lower_y:
      return material.y() <= low.y() + margin.y();
    case PinEdge::upper_y:
      return material.y() >= high.y() - margin.y();
  }
  return false;
}

/// The number of a vertex that the scene names as its file does. Subdivision adds vertices behind those of the
/// file.
std::size_t built_number(const Sheet& sheet, int vertex, const std::string& pointer) {
  const std::size_t kept = sheet.mesh.vertex_count(), named = sheet.file_number.size();
  const auto gone = static_cast<std::size_t>(std::count(sheet.file_number.begin(), sheet.file_number.end(), -1));
  const auto number = static_cast<std::size_t>(vertex);
  require(
      number < kept + gone, pointer,
      "vertex " + std::to_string(vertex) + " does not exist (the mesh has " + std::to_string(kept + gone) + ")");
  if (number >= named) return number - gone;
  require(sheet.file_number[number] >= 0, pointer,
          "vertex " + std::to_string(vertex) + " is in no triangle (so it is left out) name another");
  return static_cast<std::size_t>(sheet.file_number[number]);
}

PinSet build_pin(const Sheet& sheet, const PinParams& p, const std::string& pointer) {
  const std::size_t count = sheet.mesh.vertex_count();
  std::vector<std::uint8_t> held(count, 0);
  for (const int vertex : p.vertices) held[built_number(sheet, vertex, pointer + "/vertices")] = 1;
  if (p.edge != PinEdge::none) {
    require(sheet.params.mesh.kind == MeshKind::rectangle, pointer + "/edge",
            "only a rectangle has named edges; use point and radius");
    Vec2 low = Vec2::Constant(INFINITY), high = -low;
    for (const Vec2& m : sheet.mesh.material) low = low.cwiseMin(m), high = high.cwiseMax(m);
    for (std::size_t i = 0; i < count; ++i)
      if (on_edge(p.edge, sheet.mesh.material[i], low, high)) held[i] = 1;
  }
  PinSet pin{.params = p, .vertices = {}, .start = {}};
  for (std::size_t i = 0; i < count; ++i) {
    if (p.radius > 0.0 && (sheet.state.x[i] - p.point).norm() <= p.radius) held[i] = 1;
    if (!held[i]) continue;
    pin.vertices.push_back(static_cast<std::int32_t>(i));
    pin.start.push_back(sheet.state.x[i]);
  }
  require(!pin.vertices.empty(), pointer,
          "holds no vertex; give vertices, an edge, or a point with a radius that reaches one");
  return pin;
}

/// A triangle lives on with what burning has left of it; its inputs start virgin.
void start_solvers(Sheet& sheet, const WorldParams& world) {
  sheet.base = solid::make_shell_inputs(sheet.mesh, sheet.params.material);
  if (sheet.params.material.weaken_with_delta && world.diffusion)
    sheet.base.membrane_factor = 1.0 / (1.0 + world.diffusion->delta);
  sheet.inputs = sheet.base;
  if (sheet.free()) sheet.shell = std::make_unique<solid::ShellSolver>(sheet.mesh, sheet.params.material);
  if (!world.diffusion) return;
  const double kelvin = world.temperature_scale();
  sheet.heat_capacity.resize(sheet.mesh.vertex_count());
  for (std::size_t i = 0; i < sheet.heat_capacity.size(); ++i)
    sheet.heat_capacity[i] = sheet.areal_mass * sheet.mesh.vertex_area[i] * world.heat.heat_capacity * kelvin;
  sheet.diffusion = std::make_unique<diffusion::DiffusionSolver>(*world.diffusion);
}

/// Where the motion begins, with the velocity of its first step: the gas sees it before the sheet moves.
void start_motion(Sheet& sheet, double dt) {
  sheet.state.x = motion_at(sheet.params.motion, sheet.original, 0.0);
  const std::vector<Vec3> next = motion_at(sheet.params.motion, sheet.original, dt);
  for (std::size_t i = 0; i < next.size(); ++i) sheet.state.v[i] = (next[i] - sheet.state.x[i]) / dt;
}

/// Refuses what only a computed sheet can have: the motion would silently overrule it.
void require_nothing_else_moves(const ShellSection& p, const std::string& pointer) {
  if (p.motion.kind == MotionKind::none) return;
  const std::string why = " (the sheet is moved by motion alone) remove one of the two";
  require(p.pins.empty(), pointer + "/pins", "pins hold nothing" + why);
  require(p.moves, pointer + "/moves", "false holds the sheet" + why);
  require(p.velocity.isZero(), pointer + "/velocity", "a velocity at the start has no effect" + why);
  require(p.mesh.wrinkle == 0.0, pointer + "/mesh/wrinkle", "wrinkles at the start have no effect" + why);
}

}  // namespace

FileMesh read_mesh_beside_scene(const WorldParams& world, const std::string& file, const std::string& pointer,
                                std::vector<std::string>& warnings) {
  FileMesh mesh;
  mesh.soup = with_pointer(pointer, [&] { return solid::read_mesh_file(beside_scene(world, file)); });
  if (mesh.soup.triangles.empty()) return mesh;  // refused later, for that reason
  mesh.number = solid::drop_loose_vertices(mesh.soup);
  if (!mesh.number.empty())
    warnings.push_back(pointer + ": " + std::to_string(mesh.number.size() - mesh.soup.positions.size()) + " of " +
                       std::to_string(mesh.number.size()) +
                       " vertices are in no triangle and are left out; outputs number the others anew");
  return mesh;
}

Sheet build_sheet(const ShellSection& params, const std::string& pointer, const WorldParams& world,
                  std::vector<std::string>& warnings) {
  require_nothing_else_moves(params, pointer);
  Sheet sheet;
  sheet.name = params.name;
  sheet.pointer = pointer;
  sheet.params = params;
  sheet.areal_mass = params.material.density * params.material.thickness;

  auto made = make_mesh(params.mesh, pointer + "/mesh", world, warnings);
  sheet.file_number = std::move(made.number);
  solid::TriangleSoup& soup = made.soup;
  const Mat3 turn = rotation(params.mesh.rotation);
  for (Vec3& x : soup.positions) x = turn * (params.mesh.scale * x) + params.mesh.position;
  for (Vec2& m : soup.material) m *= params.mesh.scale;
  const bool from_file = params.mesh.kind == MeshKind::file;
  sheet.original = with_pointer(pointer + (from_file ? "/mesh/file" : "/mesh"), [&] {
    return solid::build_mesh(std::move(soup.positions), std::move(soup.material), std::move(soup.triangles));
  });
  sheet.mesh = sheet.original;
  sheet.state.x = sheet.mesh.rest;
  sheet.state.v.assign(sheet.mesh.vertex_count(), params.velocity);
  if (!sheet.free()) sheet.state.v.assign(sheet.mesh.vertex_count(), Vec3::Zero());
  require_motion_fits(params.motion, sheet.mesh, pointer + "/motion");
  add_wrinkles(sheet);
  if (sheet.driven()) start_motion(sheet, world.coupling.max_step);
  for (std::size_t n = 0; n < params.pins.size(); ++n)
    sheet.pins.push_back(build_pin(sheet, params.pins[n], pointer + "/pins/" + std::to_string(n)));

  if (world.diffusion) sheet.theta.assign(sheet.mesh.vertex_count(), 0.0);
  if (world.burning) {
    sheet.burning = make_burning_state(sheet.mesh.vertex_count());
    sheet.snapping = solid::edge_spacing(sheet.mesh.rest, sheet.mesh.edges);
    for (double& distance : sheet.snapping) distance *= world.burning->rim_snap;
  }
  if (world.smoke && world.coupling.scheme == CouplingScheme::partitioned)
    sheet.gas_force.assign(sheet.mesh.vertex_count(), Vec3::Zero());
  start_solvers(sheet, world);
  return sheet;
}

void rebuild_topology(Sheet& sheet, const WorldParams& world) {
  solid::ShellMesh& mesh = sheet.mesh;
  mesh = solid::rebuild_mesh(std::move(mesh.rest), std::move(mesh.material), std::move(mesh.triangles));
  start_solvers(sheet, world);
  refresh_inputs(sheet, world);
}

solid::Pins pins_at(const Sheet& sheet, double t) {
  solid::Pins pins;
  for (const PinSet& pin : sheet.pins) {
    if (t > pin.params.release_time) continue;
    const Vec3 moved = pin.params.velocity * std::min(t, pin.params.stop_time);
    for (std::size_t n = 0; n < pin.vertices.size(); ++n) {
      pins.vertex.push_back(pin.vertices[n]);
      pins.target.push_back(pin.start[n] + moved);
    }
  }
  return pins;
}

namespace {

/// Effective stress [Lenaerts 2008, on a membrane]: tension = that of the material - η φ0 P t. Without load the
/// material is then stretched by (1 - ν) η φ0 P / Y in every direction, which is where its rest lengths are put; at
/// most doubled.
void swell(Sheet& sheet, const diffusion::PorousParams& porous) {
  const solid::ShellParams& material = sheet.params.material;
  sheet.unswollen = sheet.inputs.rest_scale;
  const std::vector<double> pressure =
      diffusion::pore_pressure(porous, sheet.mesh, sheet.state.x, &sheet.unswollen, sheet.theta);
  const double young = 0.5 * (material.young_warp + material.young_weft) * sheet.inputs.membrane_factor;
  for (std::size_t t = 0; t < sheet.mesh.triangle_count(); ++t) {
    double mean = 0.0;
    for (const int vertex : sheet.mesh.triangles[t]) mean += pressure[vertex] / 3.0;
    const double stretch = (1.0 - material.poisson) * porous.effective_stress * porous.porosity * mean /
                           (young * sheet.inputs.stiffness_scale[t]);
    sheet.inputs.rest_scale[t] = sheet.unswollen[t] * (1.0 + std::min(stretch, 1.0));
  }
}

}  // namespace

void refresh_inputs(Sheet& sheet, const WorldParams& world) {
  const bool swells = sheet.free() && world.diffusion && world.diffusion->model == diffusion::Model::porous &&
                      world.diffusion->porous.effective_stress > 0.0;
  if (world.burning && !sheet.free()) {
    for (std::size_t i = 0; i < sheet.inputs.mass.size(); ++i)
      sheet.inputs.mass[i] = sheet.areal_mass * sheet.mesh.vertex_area[i] * sheet.burning.fraction_left[i];
  } else if (world.burning) {
    reshape(sheet.inputs, sheet.base, sheet.mesh, sheet.burning, *world.burning, sheet.areal_mass);
  } else if (swells) {
    sheet.inputs.rest_scale = sheet.base.rest_scale;
  }
  if (swells && sheet.theta.size() == sheet.mesh.vertex_count()) swell(sheet, world.diffusion->porous);
}

void follow_motion(Sheet& sheet, double t, double dt) {
  const std::vector<Vec3> next = motion_at(sheet.params.motion, sheet.original, t);
  for (std::size_t i = 0; i < next.size(); ++i) {
    sheet.state.v[i] = (next[i] - sheet.state.x[i]) / dt;
    sheet.state.x[i] = next[i];
  }
}

void visit(StateVisitor& visitor, Sheet& sheet) {
  visitor.array("rest", sheet.mesh.rest);
  visitor.array("material", sheet.mesh.material);
  visitor.array("triangles", sheet.mesh.triangles);
  visitor.array("snapping", sheet.snapping);
  for (std::size_t n = 0; n < sheet.pins.size(); ++n)
    visitor.group("pin_" + std::to_string(n), [&visitor, &pin = sheet.pins[n]] {
      visitor.array("vertices", pin.vertices);
      visitor.array("start", pin.start);
    });
  visit(visitor, sheet.state);
  visitor.array("theta", sheet.theta);
  visit(visitor, sheet.burning);
  if (!sheet.gas_force.empty()) visitor.array("gas_force", sheet.gas_force);
}

}  // namespace wick::coupling
