#include "scenes/manifest.h"

#include <gtest/gtest.h>

#include "scenes/sha256.h"
#include "tests/scenes/program.h"

namespace wick::scenes {

namespace {

const auto never = [] { return false; };

TEST(Sha256, GivesThePublishedDigests) {
  // The examples published with [FIPS 180-4]: one block, two blocks, a million letters.
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

class ManifestTest : public testing::Test {
 protected:
  void write(const std::string& name, int frame, const std::string& text) {
    test::spit(folder_ / name, text);
    manifest_.add(folder_.path(), folder_ / name, frame, text);
  }
  test::TemporaryFolder folder_;
  Manifest manifest_;
};

TEST_F(ManifestTest, NamesEveryFileThatIsNotAsItWasWritten) {
  for (int frame = 1; frame <= 4; ++frame) write("f" + std::to_string(frame), frame, "content of a file");
  EXPECT_TRUE(manifest_.damaged(folder_.path(), never).empty());
  fs::remove(folder_ / "f2");
  test::spit(folder_ / "f3", "content of a filf");
  test::spit(folder_ / "f4", "content");
  const std::vector<DamagedOutput> damaged = manifest_.damaged(folder_.path(), never);
  ASSERT_EQ(damaged.size(), 3U);
  EXPECT_EQ(summary_of(damaged), "f2 (missing), f3 (checksum differs), f4 (7 bytes instead of 17)");
  EXPECT_EQ(damaged[1].frame, 3);
  EXPECT_TRUE(manifest_.damaged(folder_.path(), [] { return true; }).empty());
}

TEST_F(ManifestTest, IsReadAsItWasWritten) {
  write("f1", 1, "one");
  write("f2", 2, "two");
  write_file(folder_ / "manifest.json", manifest_.text());
  Manifest again = Manifest::read(folder_ / "manifest.json");
  EXPECT_EQ(again.text(), manifest_.text());
  again.keep_up_to(1);
  EXPECT_EQ(again.entries().size(), 1U);
}

TEST_F(ManifestTest, RefusesWhatIsNoManifest) {
  const auto entry = [](const std::string& name, const std::string& bytes) {
    return "{\"files\": {\"" + name + "\": {\"frame\": 1, \"bytes\": " + bytes + ", \"sha256\": \"x\"}}}";
  };
  for (const std::string& text : {std::string(), std::string("[]"), std::string("{}"),
                                  std::string("{\"files\": []}"), std::string("{\"files\": {\"a\": 1}}"),
                                  entry("../a", "1"), entry("/a", "1"), entry("a", "-1"), entry("a", "\"1\"")}) {
    test::spit(folder_ / "manifest.json", text);
    EXPECT_THROW(Manifest::read(folder_ / "manifest.json"), std::runtime_error) << text;
  }
  EXPECT_THROW(Manifest::read(folder_ / "none.json"), std::runtime_error);
}

}  // namespace

}  // namespace wick::scenes
