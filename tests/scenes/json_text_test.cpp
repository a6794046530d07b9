#include "scenes/json_text.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "core/require.h"

namespace wick::scenes {

namespace {

using Json = nlohmann::ordered_json;

/// `pointer: message` of the refusal.
std::string refusal_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Refusal& refusal) {
    return refusal.pointer() + ": " + refusal.what();
  }
  return "accepted";
}
std::string refusal_of(const std::string& text) {
  return refusal_of([&] { parse_json(text); });
}
bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(JsonText, TakesComments) {
  EXPECT_EQ(parse_json("{ // one\n \"a\": /* two */ 1 }")["a"], 1);
}

TEST(JsonText, RefusesDuplicateKeysWhereverTheyAre) {
  EXPECT_TRUE(mentions(refusal_of(R"({"a": 1, "a": 2})"), "/a: the same key twice"));
  EXPECT_TRUE(mentions(refusal_of(R"({"s": [{"x": 1}, {"b": [1, 2], "x": {}, "x": 2}]})"), "/s/1/x: the same key"));
  EXPECT_EQ(refusal_of(R"({"s": [{"x": 1}, {"x": 1}], "x": {"x": 2}})"), "accepted");
}

TEST(JsonText, NamesLineAndColumnOfASyntaxError) {
  EXPECT_TRUE(mentions(refusal_of("{\n  \"a\": 1,\n  \"b\" 2 }"), "line 3, column 7"));
  EXPECT_TRUE(mentions(refusal_of(""), "not JSON"));
  for (const char* text :
       {"{\"a\": NaN}", "{\"a\": Infinity}", "{\"a\": 1} x", "{\"a\": 01}", "{\"a\"", "\xff\xfe", "[1,]"})
    EXPECT_TRUE(mentions(refusal_of(std::string(text)), "not JSON")) << text;
}

TEST(JsonText, RefusesNumbersBeyondDouble) {
  EXPECT_TRUE(mentions(refusal_of(R"({"a": {"b": [0, 1e999]}})"), "/a/b/1: a number out of range"));
}

TEST(JsonText, RefusesDeepNesting) {
  EXPECT_TRUE(mentions(refusal_of(std::string(1000000, '[')), "nested more than"));
  EXPECT_TRUE(mentions(refusal_of("{\"a\":" + std::string(100, '[') + std::string(100, ']') + "}"), "nested"));
  EXPECT_EQ(refusal_of(std::string(60, '[') + std::string(60, ']')), "accepted");
}

/// Twice the elements take about twice the time. The smaller array takes milliseconds and the quadratic parser this
/// guards against took minutes for the larger one, so that 5 s of wall clock tell the two apart on any machine.
TEST(JsonText, ReadsLongArraysInTimeProportionalToTheirLength) {
  std::string text = "[{}";
  for (int n = 1; n < 1000000; ++n) text += ",{}";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(parse_json(text + "]").size(), 1000000U);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5.0);
}

TEST(JsonText, SurvivesEveryTruncationAndByteChange) {
  const std::string text =
      R"({"name": "x", "list": [{"a": 1.5e3}, {"b": [true, null, "\u00e9\n"]}], "c": {"d": -0.1}} // end)";
  for (std::size_t i = 0; i <= text.size(); ++i) refusal_of(text.substr(0, i));
  for (std::size_t i = 0; i < text.size(); ++i)
    for (const char c : {'\0', '"', '{', ']', '\x80', '9', ','}) {
      std::string changed = text;
      changed[i] = c;
      refusal_of(changed);
    }
}

TEST(JsonText, SetsValues) {
  Json json = parse_json(R"({"a": {"b": 1}, "list": [{"x": 1}]})");
  for (const char* assignment :
       {"/a/b=2", "/a/new/deep=[1, 2]", "/list/1/x=5", "/list/0/x=true", "/word=plain text", "/quoted=\"7\"",
        "/made/0/y=3", "/a~1b=4", "/gone/for=1", "/gone/for=null", "/never/there=null", "/empty="})
    set_value(json, assignment);
  EXPECT_EQ(json, parse_json(R"({"a": {"b": 2, "new": {"deep": [1, 2]}}, "list": [{"x": true}, {"x": 5}],
    "word": "plain text", "quoted": "7", "made": [{"y": 3}], "a/b": 4, "gone": {}, "empty": ""})"));
}

TEST(JsonText, RefusesBadAssignments) {
  Json json = parse_json(R"({"a": 1, "list": []})");
  const auto refused = [&](const char* assignment) { return refusal_of([&] { set_value(json, assignment); }); };
  EXPECT_TRUE(mentions(refused("a=1"), "is not /pointer=value"));
  EXPECT_TRUE(mentions(refused("/a"), "is not /pointer=value"));
  EXPECT_TRUE(mentions(refused("/list/1/x=3"), "/list/1: no such element"));
  EXPECT_TRUE(mentions(refused("/list/99999999999999999999=3"), "no such element"));
  EXPECT_TRUE(mentions(refused("/list/-1=3"), "no such element"));
  EXPECT_TRUE(mentions(refused("/a/b=1"), "/a/b: --set looks inside"));
  EXPECT_TRUE(mentions(refused("/b={\"x\": 1, \"x\": 2}"), "the same key twice"));
  EXPECT_TRUE(mentions(refused("//b=1"), "empty step"));
}

TEST(JsonText, QuotesOnOneLine) {
  EXPECT_EQ(in_quotes("a\nb\"\x01"), R"("a\nb\"\u0001")");
  EXPECT_LT(in_quotes(std::string(5000, 'x')).size(), 100U);
  EXPECT_EQ(pointer_to("/a", "b/c~d"), "/a/b~1c~0d");
}

}  // namespace

}  // namespace wick::scenes
