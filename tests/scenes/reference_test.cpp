#include "scenes/reference.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "core/require.h"
#include "scenes/json_text.h"
#include "scenes/scene_file.h"
#include "tests/scenes/program.h"

namespace wick::scenes {

namespace {

TEST(Reference, ListsEveryParameterOnce) {
  std::set<std::string> pointers;
  for (const ParameterRow& row : scene_rows()) {
    EXPECT_TRUE(pointers.insert(row.pointer).second) << row.pointer;
    EXPECT_FALSE(row.doc.empty()) << row.pointer;
    EXPECT_EQ(row.doc.find('\n'), std::string::npos) << row.pointer;
    EXPECT_EQ(row.default_value.find("inf"), std::string::npos) << row.pointer;
  }
  for (const char* known :
       {"/name", "/frames", "/fps", "/gravity", "/smoke/resolution", "/smoke/active_window", "/diffusion/model",
        "/diffusion/sigma", "/shells/*/name", "/output/volume/names/velocity"})
    EXPECT_TRUE(pointers.contains(known)) << known;
}

TEST(Reference, ExplainsWhatIsAskedFor) {
  const std::string all = explain(""), part = explain("/smoke/resolution"), element = explain("/shells/0/name");
  EXPECT_NE(all.find("/output/checkpoint/every"), std::string::npos);
  EXPECT_NE(part.find("/smoke/resolution"), std::string::npos);
  EXPECT_EQ(part.find("/smoke/width"), std::string::npos);
  EXPECT_NE(element.find("/shells/*/name"), std::string::npos);
  try {
    explain("/smoke/resolutoin");
    FAIL();
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.code(), ExitCode::command_line);
    EXPECT_NE(std::string(refusal.what()).find("did you mean /smoke/resolution?"), std::string::npos);
  }
}

/// The page is generated: `./wick explain --markdown > docs/parameters.md`.
TEST(Reference, CommittedPageIsCurrent) {
  const fs::path page = fs::path(WICK_SOURCE) / "docs/parameters.md";
  ASSERT_TRUE(fs::exists(page)) << "make it: ./wick explain --markdown > docs/parameters.md";
  EXPECT_EQ(test::slurp(page), reference_page()) << "make it anew: ./wick explain --markdown > docs/parameters.md";
}

/// Scenes that the schema and the reader must judge alike; true: both accept.
const std::pair<const char*, bool> judged[] = {
    {R"({})", true},
    {R"({"name": "a", "frames": 3, "fps": 24})", true},
    {R"({"name": "a/b"})", false},
    {R"({"frames": 0})", false},
    {R"({"frames": 3.0})", true},
    {R"({"frames": 3.5})", false},
    {R"({"frames": true})", false},
    {R"({"fps": "24"})", false},
    {R"({"gravity": [0, 0, -1]})", true},
    {R"({"gravity": [0, 0]})", false},
    {R"({"gravity": [0, 0, null]})", false},
    {R"({"smoke": {}})", true},
    {R"({"smoke": null})", false},
    {R"({"smoke": []})", false},
    {R"({"smoke": {"resolution": [8, 8, 8]}})", true},
    {R"({"smoke": {"resolution": [0, 8, 8]}})", false},
    {R"({"smoke": {"resolution": [8, 8, 8.5]}})", false},
    {R"({"smoke": {"width": 0}})", false},
    {R"({"smoke": {"sides": {"-x": "open"}}})", true},
    {R"({"smoke": {"sides": {"-x": "ajar"}}})", false},
    {R"({"smok": {}})", false},
    {R"({"shells": [{}]})", true},
    {R"({"shells": [{"name": ".."}]})", false},
    {R"({"shells": [{"mesh": {"kind": "rectangle"}, "pins": [{"vertices": [0, 5]}]}]})", true},
    {R"({"shells": [{"pins": [{"vertices": [-1]}]}]})", false},
    {R"({"shells": {}})", false},
    {R"({"shells": [3]})", false},
    {R"({"diffusion": {"preset": "literal", "sigma": 1.05}})", true},
    {R"({"diffusion": {"preset": "literall"}})", false},
    {R"({"output": {"volume": {"precision": "float"}, "up_axis": "y"}})", true},
    {R"({"output": {"volume": {"precision": 16}}})", false},
    {R"({"output": {"frame_padding": 0}})", false},
    {R"({"extra": 1})", false}};

bool reader_accepts(const std::string& text) {
  try {
    scene_from_json(parse_json(text), ".");
    return true;
  } catch (const Refusal&) {
    return false;
  }
}

TEST(Reference, ReaderJudgesAsListed) {
  for (const auto& [text, accepted] : judged) EXPECT_EQ(reader_accepts(text), accepted) << text;
}

TEST(Reference, SchemaJudgesAsTheReader) {
  if (std::system("/usr/bin/python3 -c 'import jsonschema' 2>/dev/null") != 0)
    GTEST_SKIP() << "no python3-jsonschema";
  const test::TemporaryFolder folder;
  nlohmann::ordered_json cases = nlohmann::ordered_json::array();
  for (const auto& [text, accepted] : judged)
    cases.push_back({{"scene", parse_json(text)}, {"accepted", accepted}});
  test::spit(folder / "schema.json", scene_schema().dump());
  test::spit(folder / "cases.json", cases.dump());
  test::spit(folder / "judge.py", R"(import json, sys
from jsonschema import Draft7Validator
folder = sys.argv[1]
schema = json.load(open(folder + '/schema.json'))
Draft7Validator.check_schema(schema)
wrong = [c for c in json.load(open(folder + '/cases.json')) if Draft7Validator(schema).is_valid(c['scene']) != c['accepted']]
for case in wrong: print(case)
sys.exit(len(wrong))
)");
  const std::string command = "/usr/bin/python3 " + (folder / "judge.py").string() + " " + folder.path().string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace

}  // namespace wick::scenes
