/// Who may know whom: the table of the architecture, held against every include of the tree.
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "tests/scenes/program.h"

namespace wick::test {

namespace {

const std::map<std::string, std::set<std::string>> may_include = {
    {"core", {"core"}},
    {"solid", {"core", "solid"}},
    {"fluid", {"core", "fluid"}},
    {"diffusion", {"core", "solid", "diffusion"}},
    {"coupling", {"core", "solid", "fluid", "diffusion", "coupling"}},
    {"scenes", {"core", "solid", "fluid", "diffusion", "coupling", "scenes"}},
};

/// Heavy libraries: only in .cpp files, and only in these rooms. All of Eigen but its core is heavy.
struct Heavy {
  const char* pattern;
  std::set<std::string> rooms;
};
const Heavy heavy[] = {
    {"^openvdb/", {"scenes", "coupling"}},
    {"^hdf5", {"scenes"}},
    {"^fftw3", {"fluid"}},
    {"^tbb/", {"core", "fluid", "solid", "diffusion", "coupling", "scenes"}},
    {"^Eigen/(?!Core$|Geometry$)", {"fluid", "solid", "diffusion", "coupling"}},
    {"^CLI/", {"scenes"}},
    {"^nlohmann/json.hpp", {"scenes"}},
    {"^png.h", {"scenes"}},
    {"^cairo", {"scenes"}},
};

struct Include {
  std::string file, room, target;
  bool header;
};

std::vector<Include> includes_of_the_tree() {
  static const std::regex line(R"(^\s*#\s*include\s*[<"]([^">]+)[">])");
  std::vector<Include> includes;
  for (const auto& [room, allowed] : may_include)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(WICK_SOURCE) / room)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      std::istringstream text(slurp(entry.path()));
      std::smatch match;
      for (std::string each; std::getline(text, each);)
        if (std::regex_search(each, match, line))
          includes.push_back({fs::relative(entry.path(), WICK_SOURCE).string(), room, match[1], extension == ".h"});
    }
  return includes;
}

TEST(IncludeTable, RoomsKnowOnlyTheRoomsBelow) {
  const std::vector<Include> includes = includes_of_the_tree();
  EXPECT_GT(includes.size(), 100U);
  for (const Include& include : includes) {
    const std::string room = include.target.substr(0, include.target.find('/'));
    if (room == "tests") ADD_FAILURE() << include.file << " includes a test";
    if (!may_include.contains(room)) continue;
    EXPECT_TRUE(may_include.at(include.room).contains(room)) << include.file << " includes " << include.target;
  }
}

TEST(IncludeTable, HeavyLibrariesStayInSources) {
  for (const Include& include : includes_of_the_tree())
    for (const auto& [pattern, rooms] : heavy) {
      if (!std::regex_search(include.target, std::regex(pattern))) continue;
      EXPECT_FALSE(include.header) << include.file << " includes " << include.target;
      EXPECT_TRUE(rooms.contains(include.room)) << include.file << " includes " << include.target;
    }
}

}  // namespace

}  // namespace wick::test
