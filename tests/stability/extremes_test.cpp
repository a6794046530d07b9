/// Every knob of the burning world, a thousand times both ways from its default or to its physical limit: a few
/// frames must stay finite and within their invariants, or the world must refuse by name before it starts.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <ostream>

#include "core/require.h"
#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

WorldParams small_world() {
  WorldParams world;
  world.smoke = test::closed_box(12);
  world.smoke->sides[5] = fluid::Side::open;
  world.shells.push_back(test::flat_sheet(9, 0.6, 0.4));
  world.shells[0].pins.push_back({.edge = PinEdge::upper_x});
  world.diffusion = diffusion::make_preset(diffusion::Preset::burning);
  world.diffusion->alpha = 2.5e-3;
  world.burning.emplace();
  world.heat_sources.push_back(
      {.center = Vec3(0.2, 0.5, 0.4), .radius = 0.15, .gas_power = 10.0, .gas_smoke = 1e-5, .stop = 10.0});
  world.coupling.max_substeps = 24;
  return world;
}

void expect_sound(const World& world, const std::string& what) {
  for (const ShellView& view : world.shells()) {
    for (const Vec3& x : *view.x) ASSERT_TRUE(x.allFinite()) << what;
    for (const Vec3& v : *view.v) ASSERT_TRUE(v.allFinite()) << what;
    for (const auto& [name, values] : view.values)
      for (const float value : values) {
        ASSERT_TRUE(std::isfinite(value)) << what << " " << name;
        ASSERT_GE(value, 0.0F) << what << " " << name;
        if (name == "char") {
          ASSERT_LE(value, 1.0F) << what;
        }
      }
  }
  if (const fluid::SmokeState* gas = world.smoke()) {
    for (const auto& component : gas->velocity)
      for (const float u : component) ASSERT_TRUE(std::isfinite(u)) << what;
    for (const float d : gas->density) {
      ASSERT_TRUE(std::isfinite(d)) << what;
      ASSERT_GE(d, -1e-6F) << what;
    }
    for (const float t : gas->temperature) ASSERT_TRUE(std::isfinite(t)) << what;
  }
  // What burns is booked in double.
  if (world.ledgers().contains("solid")) {
    ASSERT_LT(world.ledgers().at("solid").relative_error(), 1e-10) << what;
  }
  // A ledger in float gas closes to rounding times the number of steps; 1e-3 is far above that and far below a
  // leak.
  for (const auto& [quantity, ledger] : world.ledgers())
    ASSERT_LT(ledger.relative_error(), 1e-3) << what << " " << quantity;
}

/// Runs `frames` frames. A refusal that names a parameter passes too, but only before the first frame.
void run_sound(const WorldParams& params, const std::string& what, int frames = 3, double dt = 1.0 / 24) {
  std::optional<World> world;
  try {
    world.emplace(params);
  } catch (const Refusal& refusal) {
    EXPECT_FALSE(refusal.pointer().empty()) << what << ": " << refusal.what();
    return;
  }
  for (int n = 0; n < frames; ++n) world->step(dt);
  expect_sound(*world, what);
}

struct Knob {
  const char* name;
  std::function<void(WorldParams&, double)> scale;
};

// GoogleTest finds it by this name. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const Knob& knob, std::ostream* out) {
  *out << knob.name;
}

class Extremes : public testing::TestWithParam<Knob> {};

TEST_P(Extremes, StaysSoundFromAThousandthToAThousandfold) {
  for (const double factor : {1e-3, 1e-1, 10.0, 1e3}) {
    WorldParams params = small_world();
    GetParam().scale(params, factor);
    run_sound(params, std::string(GetParam().name) + " x " + std::to_string(factor));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Stability, Extremes,
    testing::Values(Knob{"max_step", [](WorldParams& p, double f) { p.coupling.max_step *= f; }},
                    Knob{"cfl", [](WorldParams& p, double f) { p.smoke->cfl *= f; }},
                    Knob{"diffusivity", [](WorldParams& p, double f) { p.diffusion->alpha *= f; }},
                    Knob{"gain", [](WorldParams& p, double f) { p.diffusion->gain *= f; }},
                    Knob{"stiffness",
                         [](WorldParams& p, double f) {
                           p.shells[0].material.young_warp *= f, p.shells[0].material.young_weft *= f;
                         }},
                    Knob{"thickness", [](WorldParams& p, double f) { p.shells[0].material.thickness *= f; }},
                    Knob{"sheet_density", [](WorldParams& p, double f) { p.shells[0].material.density *= f; }},
                    Knob{"gravity", [](WorldParams& p, double f) { p.gravity *= f; }},
                    Knob{"source_temperature",
                         [](WorldParams& p, double f) {
                           p.heat_sources[0].temperature = std::min(20000.0, 1200 * f);
                         }},
                    Knob{"source_power", [](WorldParams& p, double f) { p.heat_sources[0].gas_power *= f; }},
                    Knob{"burning_rate", [](WorldParams& p, double f) { p.burning->rate *= f; }},
                    Knob{"sheet_heat", [](WorldParams& p, double f) { p.burning->sheet_heat *= f; }},
                    Knob{"convection", [](WorldParams& p, double f) { p.heat.convection *= f; }},
                    Knob{"air_density", [](WorldParams& p, double f) { p.smoke->air_density *= f; }},
                    Knob{"viscosity", [](WorldParams& p, double f) { p.smoke->viscosity = 1e-3 * f; }},
                    Knob{"vorticity", [](WorldParams& p, double f) { p.smoke->vorticity = 0.1 * f; }},
                    Knob{"world_size",
                         [](WorldParams& p, double f) {
                           p.smoke->width *= f;
                           p.shells[0].mesh.size *= f;
                           p.shells[0].mesh.position *= f;
                           p.heat_sources[0].center *= f;
                           p.heat_sources[0].radius *= f;
                         }}),
    [](const testing::TestParamInfo<Knob>& knob) { return knob.param.name; });

TEST(Stability, FrameLengthsFromAMicrosecondToAThousandSeconds) {
  for (const double dt : {1e-6, 1e-3, 1.0, 1e3}) run_sound(small_world(), "frame of " + std::to_string(dt), 2, dt);
}

TEST(Stability, SigmaFromAHundredthToAHundredInEveryMode) {
  for (const auto mode : {diffusion::SigmaMode::rate, diffusion::SigmaMode::per_step, diffusion::SigmaMode::influx})
    for (const double sigma : {0.01, 0.5, 2.0, 100.0}) {
      WorldParams params = small_world();
      params.diffusion->sigma_mode = mode;
      params.diffusion->sigma = sigma;
      run_sound(params, "sigma " + std::to_string(sigma));
    }
}

TEST(Stability, BoxesOfOddShapes) {
  for (const Int3 resolution :
       {Int3{1, 12, 12}, Int3{12, 1, 12}, Int3{12, 12, 1}, Int3{1, 1, 1}, Int3{2, 2, 128}, Int3{128, 2, 2}}) {
    WorldParams params = small_world();
    params.smoke->resolution = resolution;
    params.smoke->width = resolution[0] / 12.0;
    run_sound(params, "box " + std::to_string(resolution[0]) + "x" + std::to_string(resolution[1]) + "x" +
                          std::to_string(resolution[2]));
  }
}

TEST(Stability, GridSpacingsFromAThousandthToAThousandfoldUnderTheSameSheet) {
  // The cells change and nothing else: the box covers a speck of the sheet, or the sheet lies in a corner of a
  // cell.
  for (const double factor : {1e-3, 1e-2, 1e-1, 10.0, 1e2, 1e3}) {
    WorldParams params = small_world();
    params.smoke->width *= factor;
    params.smoke->lower = Vec3(0.5, 0.5, 0.4) * (1.0 - factor);
    run_sound(params, "grid spacing x " + std::to_string(factor));
  }
  for (const int cells : {2, 5, 48}) {
    WorldParams params = small_world();
    params.smoke->resolution = {cells, cells, cells};
    run_sound(params, std::to_string(cells) + " cells across the same box", 2);
  }
}

TEST(Stability, BoxesSixtyFourTimesAsLongAsWide) {
  for (const Int3 resolution :
       {Int3{1, 64, 1}, Int3{64, 1, 1}, Int3{4, 4, 256}, Int3{4, 256, 4}, Int3{256, 4, 4}}) {
    WorldParams params = small_world();
    params.smoke->resolution = resolution;
    params.smoke->width = resolution[0] / 12.0;
    run_sound(params, "box with an edge of " + std::to_string(resolution[0]));
  }
}

TEST(Stability, ASheetOfTwoTriangles) {
  WorldParams params = small_world();
  params.shells[0].mesh.vertices = {2, 2};
  params.shells[0].mesh.lattice = solid::Lattice::grid;
  run_sound(params, "two triangles");
}

TEST(Stability, ASheetOfTwoHundredThousandTriangles) {
  WorldParams params = small_world();
  params.shells[0].mesh.vertices = {317, 317};
  params.shells[0].material.substeps = 4;
  run_sound(params, "200,000 triangles", 1);
}

TEST(Stability, IgnitionEverywhereAtOnce) {
  WorldParams params = small_world();
  params.heat_sources[0].center = Vec3(0.5, 0.5, 0.4);
  params.heat_sources[0].radius = 10.0;
  params.heat_sources[0].rate = 1e6;
  run_sound(params, "ignition everywhere", 24);
}

TEST(Stability, SheetsOutsideAndAcrossTheBox) {
  for (const double z : {-0.5, -0.01, 0.999, 5.0}) {
    WorldParams params = small_world();
    params.shells[0].mesh.position.z() = z;
    run_sound(params, "sheet at z = " + std::to_string(z));
  }
}

TEST(Stability, ManySheetsInOneCell) {
  WorldParams params = small_world();
  for (int n = 1; n < 6; ++n) {
    params.shells.push_back(params.shells[0]);
    params.shells.back().name = "sheet" + std::to_string(n);
    params.shells.back().mesh.position.z() += 0.002 * n;
  }
  run_sound(params, "six sheets in one cell", 6);
}

}  // namespace
}  // namespace wick::coupling
