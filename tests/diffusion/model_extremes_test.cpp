/// Every model with steps, diffusivities, strains, meshes and sigma at the ends of their ranges: the budget closes,
/// u stays within 0 and the capacity.
#include <gtest/gtest.h>

#include "core/require.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

/// Sums of some hundred terms in compensated arithmetic.
constexpr double rounding = 1e-12;

constexpr Model all_models[] = {Model::isotropic,
                                Model::strain_constrained,
                                Model::strain_unconstrained,
                                Model::porous,
                                Model::diffuse_gravity,
                                Model::noise,
                                Model::strain_noise,
                                Model::tensor};

Values blob(const Sheet& s) {
  return s.field([](const Vec3& x) { return std::exp(-30.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
}

/// Two steps from u; `label` names the case.
void check(const DiffusionParams& p, DiffusionInput in, Values u, double dt, const std::string& label) {
  in.gravity = Vec3(0, -9.81, 0);
  const double cap = in.capacity;
  DiffusionSolver solver(p);
  for (int k = 0; k < 2; ++k) {
    const DiffusionReport r = solver.step(u, in, dt);
    ASSERT_LT(testing::budget_error(r), rounding) << label;
    for (const double v : u) {
      ASSERT_TRUE(std::isfinite(v) && v >= 0.0) << label << ": " << v;
      ASSERT_TRUE(cap == 0.0 || v <= cap * (1.0 + rounding)) << label << ": " << v << " above the capacity";
    }
    // Nothing is created or lost where sigma is 1 and no C is added for nothing.
    if (p.sigma == 1.0 && p.model != Model::strain_unconstrained) {
      ASSERT_LE(std::abs(r.sigma_source), rounding * std::max(r.before + std::abs(r.supplied), 1e-290)) << label;
    }
  }
}

std::string name(Model model, const char* what, double a = 0.0, double b = 0.0) {
  return "model " + std::to_string(static_cast<int>(model)) + ' ' + what + ' ' + std::to_string(a) + ' ' +
         std::to_string(b);
}

TEST(ModelExtremes, StepsAndDiffusivitiesOverTwelveDecades) {
  Sheet s(testing::jittered(12, 14, 0.25));
  s.x = testing::crumple(s.mesh);
  for (const Model model : all_models)
    for (const double dt : {0.0, 1e-9, 1e-3, 1.0, 1e3})
      for (const double alpha : {0.0, 1e-9, 1e-3, 1.0, 1e3})
        for (const double capacity : {0.0, 0.8}) {
          DiffusionParams p = make_preset(Preset::wetting);
          p.model = model;
          p.alpha = alpha;
          p.porous.permeability = 1e-8 * alpha;
          p.gravity_transport.diffusion_rate = alpha;
          DiffusionInput in = s.input();
          in.capacity = capacity;
          check(p, in, blob(s), dt, name(model, "dt, alpha", dt, alpha));
        }
}

TEST(ModelExtremes, StrainToFiveHundredPercentInvertedAndCollapsed) {
  Sheet s(testing::jittered(12, 14, 0.25));
  struct Shape {
    const char* what;
    std::function<Vec3(const Vec3&)> map;
  };
  const std::vector<Shape> shapes = {
      {"stretched sixfold along x", [](const Vec3& x) { return Vec3(6.0 * x.x(), x.y(), 0.0); }},
      {"stretched sixfold both ways", [](const Vec3& x) { return Vec3(6.0 * x); }},
      {"stretched on one side only", [](const Vec3& x) { return Vec3(x.x() * (1.0 + 5.0 * x.y()), x.y(), 0.0); }},
      {"mirrored", [](const Vec3& x) { return Vec3(-x.x(), x.y(), 0.0); }},
      {"folded over", [](const Vec3& x) { return Vec3(std::abs(x.x() - 0.5), x.y(), 0.0); }},
      {"on a line", [](const Vec3& x) { return Vec3(x.x() + x.y(), 0.0, 0.0); }},
      {"in a point", [](const Vec3&) { return Vec3(1.0, 2.0, 3.0); }}};
  const std::vector<Vec3> rest = s.x;
  for (const Shape& shape : shapes) {
    for (std::size_t i = 0; i < rest.size(); ++i) s.x[i] = shape.map(rest[i]);
    for (const Model model : all_models)
      for (const Metric metric : {Metric::rest, Metric::current})
        for (const Preset preset : {Preset::burning, Preset::wetting}) {
          DiffusionParams p = make_preset(preset);
          p.model = model;
          p.metric = metric;
          DiffusionInput in = s.input();
          in.capacity = 1.0;
          check(p, in, blob(s), 1.0 / 60.0, name(model, shape.what));
        }
  }
}

TEST(ModelExtremes, ThreeVerticesAndPiecesThatDoNotTouch) {
  for (const Model model : all_models) {
    DiffusionParams p = make_preset(Preset::wetting);
    p.model = model;
    Sheet one(solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {}, {{0, 1, 2}}));
    one.x[1] *= 1.3;
    for (const Values& u : {Values{0.0, 0.0, 0.0}, Values{1.0, 0.3, 0.0}, Values{1e-300, 1e100, 0.5}})
      check(p, one.input(), u, 0.1, name(model, "one triangle"));

    // Two triangles and a vertex of none: what the second holds stays there, but for Eq (7), which creates.
    Sheet two(solid::build_mesh(
        {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(2, 1, 0), Vec3(5, 5, 5)},
        {}, {{0, 1, 2}, {3, 4, 5}}));
    two.x[4].x() += 0.4;
    Values u = {1.0, 0.3, 0.0, 0.2, 0.1, 0.4, 0.7};
    check(p, two.input(), u, 0.1, name(model, "two triangles"));
    const double before = u[3] + u[4] + u[5];
    DiffusionSolver(p).step(u, two.input(), 0.1);
    if (model != Model::strain_unconstrained) {
      EXPECT_NEAR((u[3] + u[4] + u[5]) / before, 1.0, rounding) << name(model, "amount of the second triangle");
    }
    EXPECT_EQ(u[6], 0.7) << name(model, "vertex of none");
  }
}

TEST(ModelExtremes, SigmaAtItsEnds) {
  Sheet s(testing::sheet(12, 14));
  s.x = testing::crumple(s.mesh);
  Values rate(s.mass.size(), 0.0);
  const Values value(s.mass.size(), 0.9);
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (s.mesh.rest[i].y() == 0.0) rate[i] = 1e9 * s.mass[i];
  for (const Model model : all_models)
    for (const SigmaMode mode : {SigmaMode::rate, SigmaMode::per_step, SigmaMode::influx})
      for (const double sigma : {0.0, 1e-6, 1.0, 1e6})
        for (const double capacity : {0.0, 1.0}) {
          DiffusionParams p = make_preset(Preset::wetting);
          p.model = model;
          p.sigma = sigma;
          p.sigma_mode = mode;
          DiffusionInput in = s.input();
          in.supply_rate = &rate;
          in.supply_value = &value;
          in.capacity = capacity;
          check(p, in, blob(s), 0.1, name(model, "sigma", sigma, static_cast<double>(mode)));
        }
}

TEST(ModelExtremes, BandWithoutWidthIsRefusedByName) {
  for (const Model model : all_models)
    for (const auto& [low, high] : {std::pair{0.3, 0.3}, std::pair{0.0, 0.3}, std::pair{0.4, 0.3}}) {
      DiffusionParams p;
      p.model = model;
      p.u_min = low;
      p.u_max = high;
      try {
        const DiffusionSolver solver(p);
        FAIL() << name(model, "accepted", low, high);
      } catch (const Refusal& refusal) {
        EXPECT_EQ(refusal.pointer(), "/diffusion/u_min");
      }
    }
}

}  // namespace
}  // namespace wick::diffusion
