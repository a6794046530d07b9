/// The effective stress of the porous model: what squeezed wet pores do to the sheet that they are in.
#include <gtest/gtest.h>

#include <cmath>

#include "coupling/sheet.h"
#include "coupling/world.h"
#include "tests/support/worlds.h"

namespace wick::coupling {
namespace {

WorldParams porous_world(double eta) {
  WorldParams params;
  params.gravity = Vec3::Zero();
  params.shells.push_back(test::flat_sheet(15, 0.3, 0.5));
  params.shells[0].material.young_warp = params.shells[0].material.young_weft = 1e5;
  params.diffusion.emplace();
  params.diffusion->model = diffusion::Model::porous;
  params.diffusion->porous.effective_stress = eta;
  return params;
}

TEST(EffectiveStress, PutsRestLengthsWhereTheUnloadedMaterialWouldBe) {
  // Squeezed by a twentieth in its plane: J = 0.9025, s = u/((J - 1 + phi)/phi).
  for (const double eta : {0.0, 0.5, 1.0}) {
    const WorldParams params = porous_world(eta);
    std::vector<std::string> warnings;
    Sheet sheet = build_sheet(params.shells[0], "/shells/0", params, warnings);
    for (Vec3& x : sheet.state.x) x.head<2>() *= 0.95;
    sheet.theta.assign(sheet.mesh.vertex_count(), 0.6);
    refresh_inputs(sheet, params);
    refresh_inputs(sheet, params);  // what has swollen once does not swell again
    const double j = 0.95 * 0.95, s = 0.6 / ((j - 0.2) / 0.8);
    const double pressure = 15000.0 * s * (std::pow(j, -7.0) - 1.0);
    const double stretch = (1.0 - params.shells[0].material.poisson) * eta * 0.8 * pressure / 1e5;
    for (const double scale : sheet.inputs.rest_scale) EXPECT_NEAR(scale, 1.0 + stretch, 1e-12);
    for (const double scale : sheet.rest_scale()) EXPECT_EQ(scale, 1.0);
  }
}

TEST(EffectiveStress, PushesASqueezedWetSheetOutwardAndADryOneNot) {
  // Let go while it is squeezed by a tenth, it overshoots the further the more its pores push.
  const auto width_after = [](double eta, double wet) {
    WorldParams params = porous_world(eta);
    params.shells[0].material.damping = 5.0;
    World world(params);
    class Squeeze final : public StateVisitor {
     public:
      explicit Squeeze(double u) : u_(u) {}
      void raw(std::string_view name, ScalarType /*type*/, std::size_t rows, std::size_t columns,
               const void* /*data*/, FunctionRef<void*(std::size_t)> resize) override {
        auto* values = name == "theta" || name == "x" ? static_cast<double*>(resize(rows)) : nullptr;
        for (std::size_t i = 0; values != nullptr && i < rows * columns; ++i)
          values[i] = name == "theta" ? u_ : i % 3 == 2 ? values[i] : 0.5 + 0.9 * (values[i] - 0.5);
      }
      void strings(std::string_view /*name*/, std::vector<std::string>& /*values*/) override {}
      void begin_group(std::string_view /*name*/) override {}
      void end_group() override {}

     private:
      double u_;
    } squeeze(wet);
    world.visit(squeeze);
    world.restored();
    double widest = 0.0;
    for (int frame = 0; frame < 30; ++frame) {
      world.step(1.0 / 60.0);
      const auto& x = *world.shells().front().x;
      double low = 1e9, high = -1e9;
      for (const Vec3& p : x) low = std::min(low, p.x()), high = std::max(high, p.x());
      EXPECT_TRUE(std::isfinite(high - low));
      widest = std::max(widest, high - low);
    }
    return widest;
  };
  const double dry = width_after(1.0, 0.0), off = width_after(0.0, 0.7), wet = width_after(1.0, 0.7);
  EXPECT_NEAR(dry, off, 1e-3 * off) << "pores without liquid have no pressure";
  EXPECT_GT(wet, 1.002 * off);
}

TEST(EffectiveStress, StaysFiniteAtTheEndsOfItsParameters) {
  for (const double young : {1e3, 1e9})
    for (const double pressure : {0.0, 1e9})
      for (const double wet : {0.0, 1.0}) {
        WorldParams params = porous_world(1.0);
        params.gravity = Vec3(0, 0, -9.81);
        params.shells[0].material.young_warp = params.shells[0].material.young_weft = young;
        params.shells[0].mesh.wrinkle = 0.01;
        params.shells[0].pins.push_back({.edge = PinEdge::lower_x});
        params.diffusion->porous.pressure = pressure;
        params.heat_sources.push_back(
            {.center = Vec3(0.5, 0.5, 0.5), .radius = 9.0, .rate = 1e3 * wet, .stop = 9.0});
        World world(params);
        for (int frame = 0; frame < 10; ++frame) world.step(1.0 / 60.0);
        for (const Vec3& x : *world.shells().front().x) ASSERT_TRUE(x.allFinite()) << young << " " << pressure;
      }
}

}  // namespace
}  // namespace wick::coupling
