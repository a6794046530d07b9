/// What must hold of the models that move amounts along edges, whatever they are given: budgets, bounds, bits.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "diffusion/edge_transfers.h"
#include "support.h"

namespace wick::diffusion {
namespace {

using testing::Sheet;
using testing::Values;

constexpr double closed = 1e-12;
const Vec3 down(0.0, 0.0, -9.81);

DiffusionParams params_of(Model model) {
  DiffusionParams p;
  p.model = model;
  p.porous.permeability = 1e-8;
  p.gravity_transport.diffusion_rate = 0.5;
  p.gravity_transport.gravity_rate = 0.2;
  return p;
}

Values blob(const Sheet& s) {
  return s.field([](const Vec3& x) { return std::exp(-30.0 * (x - Vec3(0.4, 0.5, 0)).squaredNorm()); });
}

struct Tally {
  int steps = 0, unconverged = 0;
};

/// Steps a few times and checks what must hold in any case.
void check(const DiffusionParams& p, DiffusionInput in, Values u, double dt, Tally& tally, int steps = 3) {
  in.gravity = down;
  DiffusionSolver solver(p);
  for (int k = 0; k < steps; ++k) {
    const DiffusionReport r = solver.step(u, in, dt);
    ASSERT_LT(testing::budget_error(r), closed) << "dt " << dt;
    ASSERT_NEAR(r.sigma_source, 0.0, closed * std::max(r.before, r.after));
    for (const double v : u) ASSERT_TRUE(std::isfinite(v) && v >= 0.0) << v;
    if (in.capacity > 0.0) {
      ASSERT_LE(testing::largest(u), in.capacity);
    }
    if (in.supply_rate == nullptr && in.loss == nullptr && in.amount == nullptr) {
      ASSERT_NEAR(r.after + r.excess, r.before, closed * r.before);
    }
    const Values& given = solver.supplied_vertex();
    ASSERT_NEAR(std::accumulate(given.begin(), given.end(), 0.0), r.supplied,
                closed * std::max({std::abs(r.supplied), r.before, 1e-290}));
    ++tally.steps;
    tally.unconverged += r.solve.converged ? 0 : 1;
  }
}

TEST(Transfers, StepsOverTwelveDecades) {
  for (const Model model : {Model::porous, Model::diffuse_gravity}) {
    Sheet s(testing::jittered(15, 17, 0.25));
    s.x = testing::crumple(s.mesh);
    Tally tally;
    for (const double capacity : {0.0, 1.0, 0.3})
      for (const double dt : {0.0, 1e-9, 1e-6, 1e-3, 1.0, 1e3}) {
        DiffusionInput in = s.input();
        in.capacity = capacity;
        check(params_of(model), in, blob(s), dt, tally);
      }
    std::printf("  %d of %d steps did not converge\n", tally.unconverged, tally.steps);
  }
}

TEST(Transfers, ParametersAtTheirExtremes) {
  Sheet s(testing::jittered(9, 10, 0.25));
  s.x = testing::crumple(s.mesh, 0.1);
  DiffusionInput in = s.input();
  Tally tally;
  std::vector<DiffusionParams> all;
  const DiffusionParams base = params_of(Model::porous);
  for (const auto& [field, values] :
       std::vector<std::pair<double PorousParams::*, Values>>{{&PorousParams::capillary, {1e-6, 1e9}},
                                                              {&PorousParams::exponent, {0.01, 1.0, 4.0}},
                                                              {&PorousParams::regularisation, {1e-12, 0.1}},
                                                              {&PorousParams::pressure, {0.0, 1e9}},
                                                              {&PorousParams::tait, {0.0, 20.0}},
                                                              {&PorousParams::permeability, {0.0, 1e-16, 1e-3}},
                                                              {&PorousParams::viscosity, {1e-6, 1e6}},
                                                              {&PorousParams::porosity, {0.01, 0.99}},
                                                              {&PorousParams::density, {0.0, 1e5}},
                                                              {&PorousParams::relative, {0.01, 10.0}},
                                                              {&PorousParams::full, {1e-3, 1e6}}})
    for (const double value : values) {
      all.push_back(base);
      all.back().porous.*field = value;
    }
  for (const double rate : {0.0, 1e-6, 1e3})
    for (const double threshold : {0.0, 0.424, 10.0}) {
      all.push_back(params_of(Model::diffuse_gravity));
      all.back().gravity_transport.diffusion_rate = rate;
      all.back().gravity_transport.gravity_rate = rate;
      all.back().gravity_transport.transport_threshold = threshold;
    }
  for (const DiffusionParams& p : all)
    for (const double capacity : {0.0, 1.0})
      for (const double dt : {1e-3, 1.0}) {
        in.capacity = capacity;
        check(p, in, blob(s), dt, tally, 2);
        if (HasFatalFailure()) FAIL() << "parameter set " << &p - all.data();
      }
  std::printf("  %d of %d steps did not converge\n", tally.unconverged, tally.steps);
}

TEST(Transfers, SupplyLossAndAmountFromNothingToInfinitelyStiff) {
  Sheet s(testing::sheet(11, 12));
  s.x = testing::crumple(s.mesh);
  const std::size_t n = s.mass.size();
  for (const Model model : {Model::porous, Model::diffuse_gravity})
    for (const double capacity : {0.0, 1.0})
      for (const double source : {0.0, 0.9, 1.0, 3.0})
        for (const double stiffness : {0.0, 1e-12, 1.0, 1e6, 1e12, 1e200}) {
          const Values value(n, source);
          Values rate(n, 0.0), loss(n, 0.0), amount(n, 0.0);
          for (std::size_t i = 0; i < n; ++i) {
            if (s.mesh.rest[i].x() < 0.2) rate[i] = stiffness * s.mass[i];
            if (s.mesh.rest[i].x() > 0.8) loss[i] = stiffness * s.mass[i];
            amount[i] = (i % 2 == 0 ? -stiffness : 0.3) * s.mass[i] * hash_unit(1, i);
          }
          DiffusionInput in = s.input();
          in.capacity = capacity;
          in.supply_rate = &rate;
          in.supply_value = &value;
          in.loss = &loss;
          Tally tally;
          check(params_of(model), in, blob(s), 0.1, tally);
          in.amount = &amount;
          check(params_of(model), in, blob(s), 0.1, tally);
          if (HasFatalFailure()) FAIL() << "stiffness " << stiffness << " source " << source;
        }
}

TEST(Transfers, CollapsedInvertedHugeSmallAndBrokenSheets) {
  for (const Model model : {Model::porous, Model::diffuse_gravity}) {
    const DiffusionParams p = params_of(model);
    Tally tally;
    Sheet s(testing::sheet(11, 12));
    const std::vector<Vec3> rest = s.x;
    const std::vector<std::function<Vec3(const Vec3&)>> maps = {
        [](const Vec3&) { return Vec3(Vec3::Zero()); }, [](const Vec3& x) { return Vec3(x.x(), 0, 0); },
        [](const Vec3& x) { return Vec3(-x.x(), x.y(), 0); }, [](const Vec3& x) { return Vec3(1e6 * x); },
        [](const Vec3& x) { return Vec3(x.x(), 0, 1e-9 * x.y()); }};
    for (const auto& map : maps)
      for (const Metric metric : {Metric::rest, Metric::current}) {
        for (std::size_t i = 0; i < rest.size(); ++i) s.x[i] = map(rest[i]);
        DiffusionParams q = p;
        q.metric = metric;
        check(q, s.input(), blob(s), 0.1, tally);
      }

    // Three vertices; two pieces and orphans; vertices that hold nothing; nothing at all.
    Sheet one(solid::build_mesh({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {}, {{0, 1, 2}}));
    check(p, one.input(), {1.0, 0.3, 0.0}, 0.1, tally);
    check(p, one.input(), {0.0, 0.0, 0.0}, 0.1, tally);
    const solid::ShellMesh whole = testing::sheet(21, 24);
    Sheet pieces = testing::two_pieces(whole, 0.4, 0.6);
    pieces.x = testing::crumple(pieces.mesh);
    check(p, pieces.input(), blob(pieces), 0.1, tally);
    const auto left = [&](const Values& u) {
      double sum = 0.0;
      for (std::size_t i = 0; i < u.size(); ++i) sum += pieces.mesh.rest[i].x() < 0.5 ? pieces.mass[i] * u[i] : 0.0;
      return sum;
    };
    Values u = blob(pieces);
    const double before = left(u);
    DiffusionSolver(p).step(u, pieces.input(), 0.1);
    EXPECT_NEAR(left(u) / before, 1.0, closed);
    for (std::size_t i = 0; i < pieces.mass.size(); i += 3) pieces.mass[i] = 0.0;
    const Values amount(pieces.mass.size(), 1e-4);
    DiffusionInput in = pieces.input();
    in.amount = &amount;
    check(p, in, blob(pieces), 0.1, tally);
    Sheet gone(solid::without_triangles(whole, std::vector<std::uint8_t>(whole.triangle_count(), 0)));
    check(p, gone.input(), blob(gone), 0.1, tally);
  }
}

TEST(Transfers, RenumberingTheVerticesRenumbersTheResult) {
  Sheet s(testing::jittered(15, 17, 0.2));
  s.x = testing::crumple(s.mesh);
  const int n = static_cast<int>(s.mass.size());
  std::vector<int> to(n);
  for (int i = 0; i < n; ++i) to[i] = (i * 101 + 7) % n;  // 101 and 255 have no common factor
  solid::TriangleSoup soup;
  soup.positions.resize(n);
  soup.material.resize(n);
  for (int i = 0; i < n; ++i) soup.positions[to[i]] = s.mesh.rest[i], soup.material[to[i]] = s.mesh.material[i];
  for (const Int3& t : s.mesh.triangles) soup.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
  Sheet q(solid::build_mesh(std::move(soup)));
  for (int i = 0; i < n; ++i) q.x[to[i]] = s.x[i];
  for (const Model model : {Model::porous, Model::diffuse_gravity}) {
    DiffusionParams p = params_of(model);
    p.tolerance = 1e-14;
    Values a = blob(s), b = blob(q);
    DiffusionSolver first(p), second(p);
    DiffusionInput one = s.input(), two = q.input();
    one.gravity = two.gravity = down;
    for (int k = 0; k < 3; ++k) first.step(a, one, 0.1), second.step(b, two, 0.1);
    // Picard leaves 1e-12 of imbalance, which adds up over the vertices.
    for (int i = 0; i < n; ++i) EXPECT_NEAR(b[to[i]], a[i], 1e-9);
  }
}

TEST(Transfers, SameBitsAtOneAndTwoThreadsAndAfterARestart) {
  Sheet s(testing::sheet(93, 107));
  s.x = testing::crumple(s.mesh);
  DiffusionInput in = s.input();
  in.gravity = down;
  for (const Model model : {Model::porous, Model::diffuse_gravity}) {
    const DiffusionParams p = params_of(model);
    std::vector<Values> results;
    for (const int threads : {1, 2}) {
      const ThreadLimit limit(threads);
      Values u = blob(s);
      DiffusionSolver solver(p);
      for (int k = 0; k < 3; ++k) solver.step(u, in, 0.02);
      results.push_back(u);
    }
    Values restarted = blob(s);
    for (int k = 0; k < 3; ++k) DiffusionSolver(p).step(restarted, in, 0.02);
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], restarted);
  }
}

TEST(Transfers, LimitsHoldAndSumsStay) {
  const Sheet s(testing::sheet(21, 24));
  const SheetGraph graph = build_graph(s.mesh);
  Values content, room, transfer;
  for (std::size_t i = 0; i < s.mass.size(); ++i) {
    content.push_back(hash_unit(3, i) > 0.5 ? hash_unit(1, i) : 0.0);
    room.push_back(hash_unit(4, i) > 0.5 ? hash_unit(2, i) : 0.0);
  }
  for (std::size_t e = 0; e < graph.corner.size(); ++e) transfer.push_back(3.0 * hash_signed(5, e));
  limit_transfers(graph, content, room, transfer);
  double sum = 0.0, moved = 0.0;
  for (std::size_t i = 0; i < content.size(); ++i) {
    const double out = net_outflow(graph, transfer, i);
    EXPECT_LE(out, content[i] + 1e-12);
    EXPECT_LE(-out, room[i] + 1e-12);
    sum += out;
    moved += std::abs(out);
  }
  EXPECT_NEAR(sum, 0.0, 1e-12);
  EXPECT_GT(moved, 1.0);
}

}  // namespace
}  // namespace wick::diffusion
