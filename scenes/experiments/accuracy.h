#pragma once
/// What the accuracy measurements share: meshes of three kinds, operators by name, and timed marches.
#include <functional>
#include <string>
#include <vector>

#include "diffusion/strain_diffusion.h"
#include "scenes/experiments/experiment.h"
#include "solid/primitives.h"

namespace wick::scenes {

/// staggered: equilateral triangles. jittered: inner vertices moved by up to a quarter of the spacing, at random.
/// graded: spacing along x varies threefold and smoothly, with obtuse triangles where it is widest.
/// single_diagonal, union_jack: squares cut in two.
enum class MeshKind { staggered, jittered, graded, single_diagonal, union_jack };
const char* name_of(MeshKind kind);

/// `along` vertices along x on [0, size.x] x [0, size.y].
solid::ShellMesh make_sheet(MeshKind kind, int along, const Vec2& size);

struct NamedOperator {
  const char* name;
  diffusion::Operator kind;
  double umbrella_factor;
  bool clamp;
};
/// The three that a scene may choose for physical runs: cotan, cotan clamped, umbrella with its nominal
/// diffusivity.
const std::vector<NamedOperator>& operators_compared();
/// Isotropic linear diffusion with this operator.
diffusion::DiffusionParams plain_diffusion(const NamedOperator& op, double alpha, double tolerance);

/// A sheet in its rest shape, with M = area.
struct TestSheet {
  solid::ShellMesh mesh;
  explicit TestSheet(solid::ShellMesh m) : mesh(std::move(m)) {}
  [[nodiscard]] diffusion::DiffusionInput input() const {
    return {.mesh = &mesh, .x = &mesh.rest, .mass = &mesh.vertex_area};
  }
  [[nodiscard]] std::vector<double> field(const std::function<double(const Vec3&)>& f) const;
  [[nodiscard]] double total(const std::vector<double>& u) const;
};

/// Root mean square of a - b over that of b, weighted with areas.
double relative_error(const TestSheet& sheet, const std::vector<double>& a, const std::vector<double>& b);

/// Steps u, and returns milliseconds for all steps together. `prepare(step, u)`, where given, refreshes what the
/// input points to, outside the clock. Graph and factors of the topology are made before it starts.
double march(diffusion::DiffusionInput input, const diffusion::DiffusionParams& params, double dt, int steps,
             std::vector<double>& u,
             const std::function<void(int step, const std::vector<double>& u)>& prepare = {});

/// Errors of one method against its work, as the resolution or the tolerance changes.
struct WorkPrecision {
  std::string label;
  std::vector<double> resolution;  ///< h, dt or tolerance
  std::vector<double> error, milliseconds;
  void add(double at, double err, double ms);
  /// Slope of log error against log resolution between the last two entries.
  [[nodiscard]] double order() const;
};
void tabulate(Table& table, const std::string& problem, const std::string& varied, const WorkPrecision& w);
/// Error against what is varied, and error against milliseconds, on logarithmic axes.
Picture chart(const std::string& title, const std::string& varied, const std::vector<WorkPrecision>& curves);

/// The four problems; each adds its checks, rows and pictures.
void measure_gaussian(const Surroundings& s, ExperimentReport& report, Table& table);
void measure_harmonics(const Surroundings& s, ExperimentReport& report, Table& table);
void measure_half_line(const Surroundings& s, ExperimentReport& report, Table& table);
void measure_wave(const Surroundings& s, ExperimentReport& report, Table& table);

}  // namespace wick::scenes
