/// Every bundled scene at its own settings for a few frames: what it shows must be physical, and its books closed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "coupling/world.h"
#include "scenes/scene_file.h"
#include "solid/crossings.h"

namespace wick::scenes {
namespace {

Scene bundled(const std::string& name, const std::vector<std::string>& changes = {}) {
  return read_scene(std::string(WICK_SOURCE) + "/scenes/" + name + ".json", changes);
}

/// The same sheets without gas, heat and fire.
Scene bare(const std::string& name) {
  Scene scene = bundled(name);
  scene.world.smoke.reset();
  scene.world.diffusion.reset();
  scene.world.burning.reset();
  scene.world.heat_sources.clear();
  return scene;
}

/// Largest strain of edges none of whose ends has begun to burn: char shrinks and loses its stiffness by design.
double largest_stretch_of_paper(const coupling::ShellView& shell) {
  const std::vector<float>* charred = nullptr;
  for (const auto& [name, values] : shell.values)
    if (name == "char") charred = &values;
  double largest = -1.0;
  for (std::size_t e = 0; e < shell.mesh->edges.size(); ++e) {
    const auto& [a, b] = shell.mesh->edges[e];
    if (charred != nullptr && std::max((*charred)[a], (*charred)[b]) > 0.0F) continue;
    largest = std::max(largest, ((*shell.x)[a] - (*shell.x)[b]).norm() / shell.mesh->rest_length[e] - 1.0);
  }
  return largest;
}

double largest_stretch(const Scene& scene, int frames) {
  coupling::World world(scene.world);
  double largest = -1.0;
  for (int k = 0; k < frames; ++k) {
    world.step(1.0 / scene.fps);
    for (const coupling::ShellView& shell : world.shells())
      largest = std::max(largest, largest_stretch_of_paper(shell));
  }
  return largest;
}

constexpr double kMostStretch = 0.02;

TEST(BundledStretch, PaperAlone) {
  for (const char* name : {"burning_sheet", "burning_sheet_128"})
    EXPECT_LT(largest_stretch(bare(name), 12), kMostStretch) << name;
}

/// What snaps taut or lands stretches for a moment by itself; what the substeps add to that is what four times as
/// many take away.
TEST(LongBundledStretch, BunnyThatLandsAndClothHeldAtItsCorners) {
  for (const char* name : {"burning_bunny", "hanging_cloth"}) {
    Scene finer = bare(name);
    finer.world.shells[0].material.substeps *= 4;
    EXPECT_LT(largest_stretch(bare(name), 12) - largest_stretch(finer, 12), kMostStretch) << name;
  }
}

TEST(LongBundledStretch, ClothAtRest) {
  const Scene scene = bare("hanging_cloth");
  coupling::World world(scene.world);
  for (int k = 1; k < scene.frames; ++k) world.step(1.0 / scene.fps);
  EXPECT_LT(largest_stretch_of_paper(world.shells()[0]), kMostStretch);
}

TEST(BundledStretch, PaperInItsFire) {
  EXPECT_LT(largest_stretch(bundled("burning_sheet"), 12), kMostStretch);
}

struct Extent {
  double low = INFINITY, high = -INFINITY;
  bool finite = true;
  template <class Values>
  void take(const Values& values, double offset = 0.0) {
    for (const auto value : values) {
      finite = finite && std::isfinite(value);
      low = std::min(low, offset + double(value));
      high = std::max(high, offset + double(value));
    }
  }
};

/// Adiabatic flame temperature of paper in air, which neither sheet nor gas can pass [K].
constexpr double kFlame = 2300.0;

void expect_physical(const coupling::World& world, double ambient) {
  if (const fluid::SmokeState* gas = world.smoke()) {
    Extent temperature, flame, density;
    temperature.take(gas->temperature, ambient);
    flame.take(gas->flame);
    density.take(gas->density);
    EXPECT_TRUE(temperature.finite && flame.finite && density.finite);
    // Nothing cools; a tenth of a degree is left to the steep edges of the transport.
    EXPECT_GT(temperature.low, ambient - 0.1);
    EXPECT_GE(flame.low, 0.0);
    EXPECT_LE(flame.high, 1.0);
    EXPECT_GT(density.low, -1e-9);
  }
  for (const coupling::ShellView& shell : world.shells())
    for (const auto& [name, values] : shell.values) {
      Extent extent;
      extent.take(values);
      EXPECT_TRUE(extent.finite) << shell.name << ' ' << name;
      if (name == "temperature") {
        EXPECT_LT(extent.high, kFlame);
        EXPECT_GT(extent.low, ambient - 0.1);
      }
      if (name == "char") {
        EXPECT_GE(extent.low, 0.0);
        EXPECT_LE(extent.high, 1.0);
      }
    }
}

/// Largest relative error of each book, and the hottest gas [K], of a run.
struct Record {
  std::map<std::string, double> error;
  double hottest_gas = 0.0;
};

/// Heat and smoke close to 1e-8, also where the grid carries them in single precision: what one cell rounds away
/// the next one gets.
constexpr double kSolid = 1e-10, kHeat = 1e-8, kSmoke = 1e-8;

/// `models`: what the world builds, and nothing else.
Record run(const Scene& scene, int frames, const std::vector<std::string>& models) {
  SCOPED_TRACE(scene.name);
  coupling::World world(scene.world);
  EXPECT_EQ(world.models(), models);
  const double ambient = scene.world.smoke ? scene.world.smoke->ambient_temperature : 293.15;
  Record record;
  for (int k = 0; k < frames; ++k) {
    const coupling::FrameReport report = world.step(1.0 / scene.fps);
    EXPECT_EQ(report.unconverged_solves, 0);
    EXPECT_EQ(report.lengthened_steps, 0);
    expect_physical(world, ambient);
    if (const fluid::SmokeState* gas = world.smoke())
      for (const float excess : gas->temperature)
        record.hottest_gas = std::max(record.hottest_gas, ambient + excess);
    for (const auto& [name, ledger] : world.ledgers())
      record.error[name] = std::max(record.error[name], ledger.relative_error());
  }
  return record;
}

void expect_closed(const Record& record) {
  const std::map<std::string, double> tolerance = {{"solid", kSolid}, {"heat", kHeat}, {"smoke", kSmoke}};
  for (const auto& [name, error] : record.error) EXPECT_LT(error, tolerance.at(name)) << name;
}

const std::vector<std::string> kEverything = {"shell", "diffusion", "smoke", "burning"};

TEST(Bundled, BurningSheetIsPhysical) {
  expect_closed(run(bundled("burning_sheet"), 14, kEverything));
}

TEST(Bundled, BurningSheet128IsPhysical) {
  // Half the cells in each direction, for time.
  expect_closed(run(bundled("burning_sheet_128", {"/smoke/resolution=[64,64,64]"}), 6, kEverything));
}

TEST(Bundled, BurningBunnyIsPhysical) {
  expect_closed(run(bundled("burning_bunny"), 6, kEverything));
}

TEST(Bundled, CurtainFireIsPhysical) {
  expect_closed(run(bundled("curtain_fire", {"/smoke/resolution=[28,28,42]"}), 8,
                    {"shell", "contact", "diffusion", "smoke", "burning"}));
}

TEST(Bundled, HangingClothIsPhysicalAndOnlyAShell) {
  expect_closed(run(bundled("hanging_cloth"), 12, {"shell"}));
}

TEST(Bundled, HeatedSheetIsPhysicalAndOnlyDiffuses) {
  expect_closed(run(bundled("heated_sheet"), 12, {"diffusion"}));
}

TEST(Bundled, SmokePlumeIsPhysicalAndOnlySmoke) {
  const Record record = run(bundled("smoke_plume"), 12, {"smoke"});
  expect_closed(record);
  EXPECT_LT(record.hottest_gas, kFlame);
}

TEST(LongBundled, HeatInTheGasClosesLikeThatOfAnIsolatedSheet) {
  expect_closed(run(bundled("smoke_plume"), 96, {"smoke"}));
  expect_closed(run(bundled("burning_sheet"), 24, kEverything));
}

/// One curtain burns away; the fire takes the other, and nothing passes through anything.
TEST(LongBundled, TheFireTakesTheOtherCurtain) {
  const Scene scene = bundled("curtain_fire");
  coupling::World world(scene.world);
  const std::size_t whole = world.shells()[1].mesh->triangle_count();
  for (int frame = 2; frame <= scene.frames; ++frame) {
    world.step(1.0 / scene.fps);
    std::vector<solid::PosedSheet> posed;
    for (const coupling::ShellView& view : world.shells()) posed.push_back({view.mesh, view.x});
    ASSERT_EQ(solid::find_crossings(posed).size(), 0u) << "frame " << frame;
  }
  EXPECT_LT(world.shells()[0].mesh->triangle_count(), whole / 10);
  EXPECT_LT(world.shells()[1].mesh->triangle_count(), whole * 9 / 10);
}

TEST(LongBundled, GasIsNoHotterThanAFlame) {
  EXPECT_LT(run(bundled("burning_sheet"), 24, kEverything).hottest_gas, kFlame);
  EXPECT_LT(run(bundled("burning_bunny"), 24, kEverything).hottest_gas, kFlame);
}

/// Part of the largest value of `b`.
double largest_difference(const fluid::CellField& a, const fluid::CellField& b) {
  float largest = 0.0F, difference = 0.0F;
  for (std::size_t c = 0; c < a.size(); ++c) {
    largest = std::max(largest, b[c]);
    difference = std::max(difference, std::abs(a[c] - b[c]));
  }
  return static_cast<double>(difference) / largest;
}

/// The tolerance that /smoke/active_window states, in a fire that comes to fill its box: what a tenth of a percent
/// of lift changes, and less than one percent of the largest values. Fires are unstable: both grow tenfold in 20
/// frames.
TEST(LongBundled, ActiveWindowChangesASheetsFireLessThanLiftDoes) {
  // Whether a vertex of the rim is cut in this frame or in the next hangs on the last digit.
  const std::string whole_triangles = "/burning/rim=whole";
  const auto fire = [&](const char* setting, const char* lift) {
    return coupling::World(bundled("burning_sheet", {whole_triangles, setting, lift}).world);
  };
  coupling::World window = fire("/smoke/active_window=true", "/smoke/buoyancy_heat=1");
  coupling::World whole = fire("/smoke/active_window=false", "/smoke/buoyancy_heat=1");
  coupling::World lifted = fire("/smoke/active_window=false", "/smoke/buoyancy_heat=1.001");
  bool smaller = false;
  for (int frame = 0; frame < 30; ++frame) {
    for (coupling::World* world : {&window, &whole, &lifted}) world->step(1.0 / 24.0);
    smaller = smaller || !window.smoke()->window.empty();
    if (frame % 5 != 4) continue;
    for (const auto field : {&fluid::SmokeState::density, &fluid::SmokeState::temperature}) {
      const double difference = largest_difference(window.smoke()->*field, whole.smoke()->*field);
      EXPECT_LE(difference, 0.01) << "frame " << frame;
      EXPECT_LE(difference, largest_difference(lifted.smoke()->*field, whole.smoke()->*field)) << "frame " << frame;
    }
  }
  EXPECT_TRUE(smaller) << "else this compares the box with itself";
}

/// A warm plume rises: the mean height of its smoke grows from the source upwards.
TEST(Bundled, SmokePlumeRises) {
  const Scene scene = bundled("smoke_plume", {"/smoke/resolution=[32,32,48]"});
  coupling::World world(scene.world);
  for (int k = 0; k < 24; ++k) world.step(1.0 / scene.fps);
  const auto& smoke = world.smoke()->density;
  double mass = 0.0, height = 0.0;
  const int layer = 32 * 32;
  for (std::size_t c = 0; c < smoke.size(); ++c) {
    mass += smoke[c];
    height += smoke[c] * (static_cast<double>(c / layer) + 0.5) / 32.0;
  }
  EXPECT_GT(height / mass, scene.world.heat_sources[0].center.z() + 0.2);
}

}  // namespace
}  // namespace wick::scenes
