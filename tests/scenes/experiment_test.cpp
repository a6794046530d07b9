/// The machinery of experiments: catalogue, reports on disk, what is measured on a front, pictures.
#include "scenes/experiments/experiment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/require.h"
#include "scenes/experiments/comparison.h"
#include "scenes/experiments/front_numbers.h"
#include "scenes/experiments/results_page.h"
#include "solid/primitives.h"
#include "tests/scenes/program.h"

namespace wick::scenes {
namespace {

TEST(Experiments, HaveNamesOfTheirOwnAndRunOrSayWhatTheyWaitFor) {
  std::set<std::string> names;
  for (const Experiment& e : experiments()) {
    EXPECT_TRUE(names.insert(e.name).second) << e.name;
    EXPECT_NE(*e.figure, '\0');
    EXPECT_EQ(e.run == nullptr, *e.waits_for != '\0') << e.name;
  }
  for (const char* name :
       {"fig01", "fig03", "fig04", "fig05", "fig06", "fig07", "fig09", "fig17", "fig18", "rigid"})
    EXPECT_EQ(names.count(name), 1u) << name;
}

TEST(Experiments, WriteTablesPicturesAndThePage) {
  const test::TemporaryFolder folder;
  ExperimentOptions options{.names = {"fig04", "fig07"}, .out = folder.path() / "out", .quiet = true};
  options.page = folder.path() / "results.md";
  run_experiments(options);
  EXPECT_NE(test::slurp(folder.path() / "out/fig07/checks.csv").find("pass"), std::string::npos);
  EXPECT_NE(test::slurp(folder.path() / "out/fig07/table1.csv").find("0.535"), std::string::npos);
  EXPECT_NE(test::slurp(folder.path() / "out/fig07/checks.csv").find("number,mean,deviation,threshold,verdict\n"),
            std::string::npos);
  EXPECT_EQ(test::slurp(folder.path() / "out/fig04/strain.png").substr(1, 3), "PNG");
  EXPECT_EQ(test::slurp(folder.path() / "results/fig04-strain.png").substr(1, 3), "PNG");
  const std::string page = test::slurp(folder.path() / "results.md");
  EXPECT_NE(page.find("## fig07"), std::string::npos);
  EXPECT_NE(page.find("waits for tearing"), std::string::npos);
}

TEST(Experiments, ShowTablesOnThePageWithNumbersToReadNotToCompute) {
  const test::TemporaryFolder folder;
  Table table{.name = "work", .columns = {"method", "ms"}, .rows = {}, .on_page = true};
  table.add({"cotan, graded"}, {1.23456789});
  ExperimentReport report;
  report.tables = {table, {.name = "hidden", .columns = {"x"}, .rows = {}}};
  write_results_page(folder.path() / "page.md", {{&experiments().front(), report}}, false);
  const std::string page = test::slurp(folder.path() / "page.md");
  EXPECT_NE(page.find("1 rows of work"), std::string::npos);
  EXPECT_NE(page.find("| method | ms |\n| --- | --- |\n| cotan, graded | 1.23 |\n"), std::string::npos);
  EXPECT_EQ(page.find("hidden"), std::string::npos);
}

TEST(Experiments, RefuseAnUnknownNameWithTheNearestOne) {
  try {
    run_experiments({.names = {"fig0l"}, .quiet = true});
    FAIL() << "accepted";
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.code(), ExitCode::command_line);
    EXPECT_NE(std::string(refusal.what()).find("did you mean fig0"), std::string::npos);
  }
}

TEST(Checks, CompareTheMeanOverTheSeeds) {
  EXPECT_EQ(at_least("x", {1.0, 2.0, 3.0}, 2.0).verdict, Verdict::pass);
  EXPECT_EQ(at_least("x", {1.0, 2.0, 2.9}, 2.0).verdict, Verdict::fail);
  EXPECT_EQ(at_most("x", {1.0}, 1.0).verdict, Verdict::pass);
  EXPECT_EQ(at_most("x", {std::nan("")}, 1.0).verdict, Verdict::fail);
  EXPECT_EQ(reported("x", {1.0}).verdict, Verdict::reported);
}

/// A front that moves up a unit sheet as y = speed t + bump(x) t, u falling by 5 a metre.
SheetHistory moving_front(const solid::ShellMesh& mesh, const std::function<double(double)>& bump) {
  SheetHistory history;
  history.mesh = mesh;
  for (int n = 0; n <= 40; ++n) {
    SheetFrame frame{.time = n / 40.0, .u = {}, .left = {}, .x = mesh.rest, .heat = {}};
    for (const Vec3& p : mesh.rest)
      frame.u.push_back(std::clamp(0.5 + 5.0 * ((0.8 + bump(p.x())) * frame.time - p.y()), 0.0, 1.0));
    history.frames.push_back(frame);
  }
  return history;
}

TEST(FrontNumbers, TellAFrontThatFollowsStrainFromOneThatDoesNot) {
  const solid::ShellMesh mesh = solid::build_mesh(solid::rectangle(61, 71, Vec2(1.0, 1.0)));
  const auto strain = [](double x) { return 1.0 + std::sin(4.0 * M_PI * x); };
  std::vector<double> c;
  for (const Vec3& p : mesh.rest) c.push_back(strain(p.x()));
  const SheetHistory flat = moving_front(mesh, [](double) { return 0.0; });
  const SheetHistory follows = moving_front(mesh, [&](double x) { return 0.1 * strain(x); });
  const FrontQuestion question = {FrontOf::u, 0.35, true};
  const FrontNumbers ours = measure_front(follows, flat, {c}, question);
  const FrontNumbers plain = measure_front(flat, flat, {c}, question);
  EXPECT_GT(ours.displacement, 0.9);
  EXPECT_GT(ours.advance, 0.7);  // slopes shorten the way to the old front beside the fastest places
  EXPECT_NEAR(plain.tortuosity, 1.0, 1e-9);
  EXPECT_LT(std::abs(plain.displacement), 0.05);
  EXPECT_EQ(plain.pieces, 1.0);
  // y = a sin(4π x) of amplitude a = 0.1 t: its length, and where the coverage of 0.35 is met.
  const double a = 0.1 * 0.35 / 0.9, k = 4.0 * M_PI;
  EXPECT_NEAR(ours.tortuosity, 1.0 + a * a * k * k / 4.0, 0.01);
  EXPECT_NEAR(ours.covered, 0.35, 0.03);
}

TEST(FrontNumbers, PartialAdvanceSeesThroughStrainThatLiesBesideTheSource) {
  // The front tilts, as it is fast on the right, and c falls with the distance from the source alone.
  const solid::ShellMesh mesh = solid::build_mesh(solid::rectangle(61, 71, Vec2(1.0, 1.0)));
  std::vector<double> c;
  for (const Vec3& p : mesh.rest) c.push_back(1.0 - p.y());
  const SheetHistory tilted = moving_front(mesh, [](double x) { return 0.1 * x; });
  const FrontNumbers numbers = measure_front(tilted, tilted, {c}, {FrontOf::u, 0.35, true});
  EXPECT_LT(numbers.advance, -0.9);
  EXPECT_LT(std::abs(numbers.advance_partial), 0.3);
}

}  // namespace
}  // namespace wick::scenes
