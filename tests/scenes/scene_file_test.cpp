#include "scenes/scene_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/parameters.h"
#include "scenes/atomic_file.h"
#include "scenes/effective_scene.h"
#include "scenes/json_text.h"
#include "tests/scenes/program.h"

namespace wick::scenes {

namespace {

enum class Kind { plain, fancy };

struct Part {
  std::string name = "part";
  double size = 1.0;
};
void describe(ParameterVisitor& v, Part& p) {
  v.text({"name", "", {}, "of the part"}, p.name);
  v.number({"size", "m", above(0), "of the part"}, p.size);
}

/// One field of every sort; a kind that is chosen resets the rest, as presets do.
struct Everything {
  Kind kind = Kind::plain;
  double speed = 1.0;
  int count = 2;
  bool on = false;
  std::string label;
  Vec3 where = Vec3::Zero();
  Int2 cells = {4, 4};
  std::vector<int> chosen;
  Part part;
  std::optional<Part> spare;
  std::vector<Part> parts;
};
void describe(ParameterVisitor& v, Everything& p) {
  static const char* const kinds[] = {"plain", "fancy"};
  const Kind before = p.kind;
  v.choice({"kind", "", {}, "resets the rest"}, p.kind, kinds);
  if (p.kind != before) {
    const Kind now = p.kind;
    p = Everything();
    p.kind = now;
    p.speed = 5.0;
  }
  v.number({"speed", "m/s", between(0, 10), "of it"}, p.speed);
  v.integer({"count", "1", at_least(1), "of them"}, p.count);
  v.flag({"on", "", {}, "whether"}, p.on);
  v.text({"label", "", {}, "any text"}, p.label);
  v.vector({"where", "m", any_value(), "place"}, p.where);
  v.vector({"cells", "1", between(1, 100), "numbers of cells"}, p.cells);
  v.index_list({"chosen", "1", at_least(0), "numbers"}, p.chosen);
  v.nested("part", "always there", p.part);
  v.section("spare", "may be absent", p.spare);
  v.list("parts", "many", p.parts);
}

Everything read(const std::string& text) {
  Everything result;
  read_parameters(parse_json(text), [&](ParameterVisitor& v) { describe(v, result); });
  return result;
}

std::string refusal_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Refusal& refusal) {
    return format_refusal("f", refusal);
  }
  return "accepted";
}
std::string refusal_of(const std::string& text) {
  return refusal_of([&] { read(text); });
}

TEST(SceneFile, ReadsEverySortOfParameter) {
  const Everything e =
      read(R"({"speed": 2, "count": 3.0, "on": true, "label": "é", "where": [1, 2, 3], "cells": [5, 6],
    "chosen": [7, 8, 9], "part": {"size": 4}, "spare": {}, "parts": [{"name": "a"}, {"size": 2}]})");
  EXPECT_EQ(e.speed, 2.0);
  EXPECT_EQ(e.count, 3);
  EXPECT_TRUE(e.on);
  EXPECT_EQ(e.label, "é");
  EXPECT_EQ(e.where, Vec3(1, 2, 3));
  EXPECT_EQ(e.cells, (Int2{5, 6}));
  EXPECT_EQ(e.chosen, (std::vector<int>{7, 8, 9}));
  EXPECT_EQ(e.part.size, 4.0);
  EXPECT_TRUE(e.spare.has_value());
  ASSERT_EQ(e.parts.size(), 2U);
  EXPECT_EQ(e.parts[0].name, "a");
  EXPECT_EQ(e.parts[1].size, 2.0);
  EXPECT_FALSE(read("{}").spare.has_value());
}

TEST(SceneFile, AppliesKeysInTheOrderOfTheList) {
  EXPECT_EQ(read(R"({"kind": "fancy"})").speed, 5.0);
  EXPECT_EQ(read(R"({"speed": 3, "kind": "fancy"})").speed, 3.0);
  EXPECT_EQ(read(R"({"kind": "fancy", "speed": 3})").speed, 3.0);
}

/// What a user sets without effect is named, with the reason; what an effective scene repeats is not.
TEST(SceneFile, WarnsOfParametersWithoutEffect) {
  const auto warnings = [](const std::string& text, const std::string& pointer, const std::string& why) {
    const Scene scene = scene_from_json(parse_json(text), ".");
    ASSERT_EQ(scene.warnings.size(), 1U) << text;
    EXPECT_EQ(scene.warnings[0], pointer + ": has no effect (" + why + ")");
    const Scene again = scene_from_json(effective_json(scene), ".");
    EXPECT_EQ(again.warnings, scene.warnings) << text;
  };
  warnings(R"({"smoke": {}, "burning": {"activation_temperature": 9000}})", "/burning/activation_temperature",
           "law is not arrhenius");
  warnings(R"({"smoke": {}, "burning": {"law": "arrhenius", "rate": 2}})", "/burning/rate", "law is not threshold");
  warnings(R"({"shells": [{"mesh": {"kind": "icosphere", "size": [2, 2]}}]})", "/shells/0/mesh/size",
           "kind is not rectangle or cylinder");
  warnings(R"({"shells": [{"pins": [{"edge": "-x", "stop_time": 2}]}]})", "/shells/0/pins/0/stop_time",
           "velocity is 0");
  warnings(R"({"smoke": {}, "obstacles": [{"kind": "box", "radius": 2}]})", "/obstacles/0/radius",
           "kind is not sphere");
  warnings(R"({"smoke": {"side_velocity": {"-x": [0, 1, 0]}}})", "/smoke/side_velocity/-x", "no_slip is false");
  warnings(R"({"shells": [{}], "diffusion": {"porous": {"pressure": 3}}})", "/diffusion/porous/pressure",
           "model is not porous");
  warnings(R"({"shells": [{}], "heat": {"loss": 3}})", "/heat/loss", "there is no diffusion section");
  warnings(R"({"shells": [{}], "heat_sources": [{"radius": 3}]})", "/heat_sources",
           "there is neither diffusion nor smoke to heat");
  EXPECT_TRUE(
      scene_from_json(parse_json(R"({"smoke": {}, "heat_sources": [{"kind": "box", "radius": 0.05}]})"), ".")
          .warnings.empty());
}

TEST(SceneFile, NamesTheNearestKey) {
  EXPECT_EQ(refusal_of(R"({"part": {"siez": 1}})"),
            "f: /part/siez: unknown key (this section has name, size) did you mean \"size\"?");
  EXPECT_NE(refusal_of(R"({"qqqqqqqqqqqq": 1})").find("see `wick explain`"), std::string::npos);
}

TEST(SceneFile, RefusesWrongTypes) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"speed": "2"})", "f: /speed: expected a number, found a string \"2\""},
      {R"({"speed": true})", "f: /speed: expected a number, found true (wrong type)"},
      {R"({"speed": null})", "f: /speed: expected a number, found null (wrong type)"},
      {R"({"speed": 1e300})", "f: /speed: 1e+300 is out of range"},
      {R"({"spare": null})", "f: /spare: null is no section"},
      {R"({"part": null})", "f: /part: expected an object, found null"},
      {R"({"count": 2.5})", "f: /count: expected a whole number, found 2.5"},
      {R"({"on": 1})", "f: /on: expected true or false, found a number 1"},
      {R"({"label": 3})", "f: /label: expected a string"},
      {R"({"label": "a\u0000b"})", "f: /label: holds a zero byte"},
      {R"({"where": [1, 2]})", "f: /where: 2 elements (it must be an array of 3 numbers)"},
      {R"({"where": [1, 2, "3"]})", "f: /where/2: expected a number"},
      {R"({"chosen": 3})", "f: /chosen: expected an array"},
      {R"({"part": []})", "f: /part: expected an object, found an array"},
      {R"({"parts": {}})", "f: /parts: expected an array of objects"},
      {R"({"parts": [{}, 3]})", "f: /parts/1: expected an object, found a number"},
      {R"({"kind": 1})", "f: /kind: expected one of the names of a choice"},
      {R"({"kind": "fanzy"})",
       "f: /kind: \"fanzy\" is not a choice (there are plain, fancy) did you mean \"fancy\"?"},
      {R"([])", "f: expected an object"}};
  for (const auto& [text, message] : cases) {
    const std::string refusal = refusal_of(std::string(text));
    EXPECT_TRUE(refusal.starts_with(message)) << text << "\n  " << refusal;
    EXPECT_EQ(refusal.find('\n'), std::string::npos);
  }
}

TEST(SceneFile, NamesValueAndRange) {
  EXPECT_EQ(refusal_of(R"({"speed": -1})"), "f: /speed: -1 is out of range (allowed: 0 to 10)");
  EXPECT_EQ(refusal_of(R"({"part": {"size": 0}})"), "f: /part/size: 0 is out of range (allowed: > 0)");
  EXPECT_EQ(refusal_of(R"({"count": 0})"), "f: /count: 0 is out of range (allowed: 1 to 2147483647)");
  EXPECT_EQ(refusal_of(R"({"count": 1e10})"),
            "f: /count: 10000000000.0 is out of range (allowed: 1 to 2147483647)");
  EXPECT_EQ(refusal_of(R"({"cells": [1, 101]})"), "f: /cells/1: 101 is out of range (allowed: 1 to 100)");
}

TEST(SceneFile, RestrictsNames) {
  for (const char* name : {"", ".", "..", "a/b", "a b", "-a", ".hidden", "é", "a\\u0000"})
    EXPECT_NE(refusal_of(R"({"part": {"name": ")" + std::string(name) + R"("}})"), "accepted") << name;
  EXPECT_NE(refusal_of(R"({"part": {"name": ")" + std::string(65, 'a') + R"("}})"), "accepted");
  EXPECT_EQ(refusal_of(R"({"part": {"name": "Paper_2.b-c"}})"), "accepted");
}

Scene scene_of(const std::string& text) {
  return scene_from_json(parse_json(text), ".");
}

TEST(SceneFile, RefusesTwoGridsOfOneName) {
  EXPECT_NE(refusal_of([] {
              scene_of(R"({"output": {"volume": {"names": {"flame": "vel"}}}})");
            }).find("names two grids"),
            std::string::npos);
}

TEST(SceneFile, NamesASceneAfterItsFile) {
  const test::TemporaryFolder folder;
  test::spit(folder / "candle.json", R"({"frames": 3})");
  EXPECT_EQ(read_scene(folder / "candle.json").name, "candle");
  EXPECT_EQ(read_scene(folder / "candle.json", {"/name=other", "/frames=9"}).frames, 9);
  EXPECT_EQ(read_scene(folder / "candle.json").world.directory, folder.path().string());
}

TEST(SceneFile, EffectiveSceneReadsBackTheSame) {
  for (const auto& entry : fs::directory_iterator(fs::path(WICK_SOURCE) / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Scene scene = read_scene(entry.path());
    const nlohmann::ordered_json effective = effective_json(scene);
    const Scene again = scene_from_json(parse_json(effective.dump()), scene.world.directory);
    EXPECT_EQ(effective_json(again), effective) << entry.path();
    EXPECT_EQ(effective.dump().find("null"), std::string::npos) << "a default that is not finite";
    EXPECT_EQ(identity_difference(scene_identity(scene), scene_identity(again)), "");
  }
}

TEST(SceneFile, IdentityLeavesOutWhatMayChange) {
  const Scene scene = scene_of(R"({"frames": 5})");
  EXPECT_EQ(scene_identity(scene),
            scene_identity(scene_of(R"({"frames": 50, "output": {"checkpoint": {"every": 3}}})")));
  const std::string other = scene_identity(scene_of(R"({"fps": 25})"));
  EXPECT_EQ(identity_difference(scene_identity(scene), other), "/fps was 24.0, is 25.0");
}

TEST(SceneFile, IdentityKnowsTheContentOfMeshFiles) {
  const test::TemporaryFolder folder;
  const auto identity = [&](const std::string& mesh) {
    test::spit(folder / "m.obj", mesh);
    test::spit(folder / "s.json", R"({"shells": [{"mesh": {"kind": "file", "file": "m.obj"}}]})");
    return scene_identity(read_scene(folder / "s.json"));
  };
  EXPECT_EQ(identity("v 0 0 0"), identity("v 0 0 0"));
  EXPECT_NE(identity("v 0 0 0"), identity("v 0 0 1"));
}

}  // namespace

}  // namespace wick::scenes
