#include "scenes/checkpoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/noise.h"
#include "tests/scenes/program.h"

namespace wick::scenes {

namespace {

/// One field of every sort that a state can have.
struct Sample {
  std::vector<float> floats{1.5F, -0.0F, 3e-42F};
  std::vector<double> doubles{1.0 / 3.0};
  std::vector<std::int32_t> none;
  std::vector<std::uint8_t> bytes{0, 255};
  std::vector<Vec3> points{{1, 2, 3}, {4, 5, 6}};
  std::vector<Int3> triangles{{0, 1, 2}};
  std::vector<std::string> words{"", "two words", "é"};
  Vec3 where{7, 8, 9};
  double time = 0.1;
  std::uint64_t big = ~std::uint64_t{0};
  bool flag = true;

  void visit(StateVisitor& v) {
    v.array("floats", floats);
    v.group("inner", [&] {
      v.array("doubles", doubles);
      v.array("none", none);
      v.group("deeper", [&] { v.array("bytes", bytes); });
    });
    v.array("points", points);
    v.array("triangles", triangles);
    v.array("words", words);
    v.value("where", where);
    v.value("time", time);
    v.value("big", big);
    v.value("flag", flag);
  }
  std::uint64_t hash() {
    StateHash hash;
    visit(hash);
    return hash.digest();
  }
};

Bytes bytes_of(Sample& sample, int frame = 3) {
  Sample metrics;
  return make_checkpoint(
      {frame, 0.5, "1.2.3", "{\"fps\":24}"}, [&](StateVisitor& v) { metrics.visit(v); },
      [&](StateVisitor& v) { sample.visit(v); });
}

TEST(Checkpoint, GivesBackEveryBit) {
  const test::TemporaryFolder folder;
  Sample before;
  write_file(folder / "0003.h5", bytes_of(before));
  const Checkpoint checkpoint(folder / "0003.h5");
  EXPECT_EQ(checkpoint.header().frame, 3);
  EXPECT_EQ(checkpoint.header().time, 0.5);
  EXPECT_EQ(checkpoint.header().version, "1.2.3");
  EXPECT_EQ(checkpoint.header().identity, "{\"fps\":24}");
  Sample after, metrics;
  after.floats.clear();
  after.none = {1, 2, 3};
  after.words = {"other"};
  after.time = 9;
  after.flag = false;
  checkpoint.read([&](StateVisitor& v) { metrics.visit(v); }, [&](StateVisitor& v) { after.visit(v); });
  EXPECT_EQ(after.hash(), before.hash());
  EXPECT_EQ(after.words, before.words);
}

TEST(Checkpoint, IsTheSameFileForTheSameState) {
  Sample one, two;
  EXPECT_EQ(bytes_of(one), bytes_of(two));
}

TEST(Checkpoint, RefusesEveryDamage) {
  const test::TemporaryFolder folder;
  Sample sample;
  const Bytes whole = bytes_of(sample);
  const auto refused = [&](const Bytes& bytes) {
    test::spit(folder / "c.h5", bytes);
    EXPECT_THROW(Checkpoint(folder / "c.h5"), std::runtime_error);
  };
  for (std::uint64_t n = 0; n < 300; ++n) {
    Bytes damaged = whole;
    damaged[hash_index(1, n) % damaged.size()] ^= static_cast<char>(1 << (n % 8));
    refused(damaged);
    refused(whole.substr(0, hash_index(2, n) % whole.size()));
  }
  refused("");
  refused(whole + "x");
  refused(Bytes(whole.size(), '\0'));
  EXPECT_THROW(Checkpoint(folder / "none.h5"), std::runtime_error);
}

TEST(Checkpoint, RefusesAnotherState) {
  const test::TemporaryFolder folder;
  Sample sample;
  write_file(folder / "c.h5", bytes_of(sample));
  const Checkpoint checkpoint(folder / "c.h5");
  const auto nothing = [](StateVisitor&) {};
  std::vector<double> floats, missing;
  std::vector<Vec2> points;
  EXPECT_THROW(checkpoint.read(nothing, [&](StateVisitor& v) { v.array("floats", floats); }), std::runtime_error);
  EXPECT_THROW(checkpoint.read(nothing, [&](StateVisitor& v) { v.array("missing", missing); }), std::runtime_error);
  EXPECT_THROW(checkpoint.read(nothing, [&](StateVisitor& v) { v.array("points", points); }), std::runtime_error);
}

TEST(Checkpoint, KeepsTheLastFew) {
  const test::TemporaryFolder folder;
  for (const int frame : {1, 2, 10, 100, 12000}) test::spit(folder / checkpoint_name(frame), "x");
  test::spit(folder / "notes.h5", "x");
  test::spit(folder / "007.h5", "x");
  EXPECT_EQ(checkpoint_frames(folder.path()), (std::vector<int>{12000, 100, 10, 2, 1}));
  prune_checkpoints(folder.path(), 100, 2);  // 12000 is of another time: it is not counted and not touched
  EXPECT_EQ(checkpoint_frames(folder.path()), (std::vector<int>{12000, 100, 10}));
  EXPECT_TRUE(fs::exists(folder / "notes.h5"));
}

TEST(FiniteCheckTest, FindsTheFirstBadValue) {
  Sample sample;
  FiniteCheck good;
  sample.visit(good);
  EXPECT_EQ(good.first(), "");
  sample.doubles[0] = std::numeric_limits<double>::infinity();
  sample.points[1][2] = std::nan("");
  FiniteCheck bad;
  sample.visit(bad);
  EXPECT_EQ(bad.first(), "/inner/doubles[0] = inf");
}

}  // namespace

}  // namespace wick::scenes
