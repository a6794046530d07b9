#include "scenes/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/hdf5_image.h"
#include "tests/scenes/memory_walk.h"

namespace wick::scenes {

namespace {

template <class T>
std::vector<T> dataset(const Bytes& bytes, const std::string& path) {
  const Hdf5Reader reader(bytes);
  std::vector<T> values(reader.rows(path, scalar_type<T>(), 1));
  if (!values.empty()) reader.read(path, scalar_type<T>(), values.data());
  return values;
}

TEST(Metrics, HasOneRowAFrame) {
  Metrics metrics;
  metrics.add({{"/frame", 1}, {"/time", 0.0}, {"/timing/smoke", 0.5}}, 11);
  metrics.add({{"/frame", 2}, {"/time", 0.25}, {"/timing/smoke", 0.75}}, ~std::uint64_t{0});
  const Bytes bytes = metrics.file();
  EXPECT_EQ(dataset<std::int64_t>(bytes, "/frame"), (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(dataset<double>(bytes, "/timing/smoke"), (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(dataset<std::uint64_t>(bytes, "/state_hash"), (std::vector<std::uint64_t>{11, ~std::uint64_t{0}}));
}

TEST(Metrics, FillsColumnsThatComeLateOrGo) {
  Metrics metrics;
  metrics.add({{"/frame", 1}, {"/shell/a/area", 3.0}}, 1);
  metrics.add({{"/frame", 2}, {"/ledger/heat/out", 2.0}, {"/solve/p/iterations", 4}, {"/solve/p/residual", 1e-6}},
              2);
  EXPECT_EQ((*metrics.column("/ledger/heat/out"))[0], 0.0);
  EXPECT_EQ((*metrics.column("/solve/p/iterations"))[0], 0.0);
  EXPECT_EQ((*metrics.column("/solve/p/residual"))[0], 0.0) << "no solve, nothing left unsolved";
  EXPECT_TRUE(std::isnan((*metrics.column("/shell/a/area"))[1]));
  for (const auto& [path, column] : metrics.columns()) EXPECT_EQ(column.size(), 2U) << path;
}

TEST(Metrics, CompletesAnEarlierRow) {
  Metrics metrics;
  metrics.add({{"/frame", 1}}, 1);
  metrics.add({{"/frame", 2}, {"/timing/output", 0.5}}, 2);
  metrics.set(1, "/timing/output", 0.25);
  metrics.set(2, "/timing/late", 4.0);
  EXPECT_EQ(*metrics.column("/timing/output"), (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(*metrics.column("/timing/late"), (std::vector<double>{0.0, 4.0}));
}

TEST(Metrics, ComesBackFromACheckpoint) {
  Metrics metrics;
  metrics.add({{"/frame", 1}, {"/a/b", 0.5}}, 7);
  metrics.add({{"/frame", 2}, {"/a/c", 1.5}}, 8);
  Hdf5Writer writer;
  test::write_state(writer, [&](StateVisitor& v) { metrics.visit(v); });
  const Bytes bytes = writer.finish();
  Metrics again;
  test::read_state(bytes, [&](StateVisitor& v) { again.visit(v); });
  EXPECT_EQ(again.file(), metrics.file());
  EXPECT_EQ(again.last_hash(), 8U);
  Metrics empty, empty_again;
  Hdf5Writer other;
  test::write_state(other, [&](StateVisitor& v) { empty.visit(v); });
  const Bytes none = other.finish();
  test::read_state(none, [&](StateVisitor& v) { empty_again.visit(v); });
  EXPECT_EQ(empty_again.rows(), 0U);
}

/// The table is rebuilt each frame: a long run must not pay for it. 2000 frames of 60 columns in a tenth of a
/// second leaves a factor of 10 for slow machines against what was measured.
TEST(Metrics, StaysCheapInALongRun) {
  Metrics metrics;
  Metrics::Row row;
  for (int c = 0; c < 60; ++c) row["/column/" + std::to_string(c)] = c;
  for (int frame = 0; frame < 2000; ++frame) metrics.add(row, 1);
  const auto start = std::chrono::steady_clock::now();
  const Bytes bytes = metrics.file();
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 0.1);
  EXPECT_LT(bytes.size(), 60 * 2000 * 8 + 200000U);
}

}  // namespace

}  // namespace wick::scenes
