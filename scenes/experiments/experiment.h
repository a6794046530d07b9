#pragma once
/// Experiments: each figure of the paper as a command. An experiment is one or more scene files and a measurement;
/// its report holds numbers with thresholds set beforehand, tables and pictures.
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "diffusion/rank_statistics.h"
#include "scenes/experiments/figure.h"
#include "scenes/scene.h"

namespace wick::scenes {

enum class Verdict { pass, fail, reported };

/// One number against its threshold; `value` is over the seeds.
struct Check {
  std::string what;
  diffusion::Spread value;
  std::string threshold;  ///< as printed; empty where the number is only reported
  Verdict verdict = Verdict::reported;
};
Check at_least(std::string what, const std::vector<double>& values, double threshold);
Check at_most(std::string what, const std::vector<double>& values, double threshold);
Check reported(std::string what, const std::vector<double>& values);
/// Something that holds or not, in words.
Check holds(std::string what, bool it_does, std::string threshold);

/// Numbers for a CSV file.
struct Table {
  std::string name;  ///< of the file, without ending
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  bool on_page = false;  ///< the results page shows it too
  void add(const std::vector<std::string>& labels, const std::vector<double>& values);
};

struct NamedPicture {
  std::string name;     ///< of the file, without ending
  std::string caption;  ///< what is to be seen
  Picture picture;
};

struct ExperimentReport {
  std::vector<Check> checks;
  std::vector<Table> tables;
  std::vector<NamedPicture> pictures;
  std::string analysis;  ///< why a threshold fails, or what the numbers mean; Markdown
};

/// What an experiment may ask of its surroundings.
struct Surroundings {
  bool quick = false;                           ///< fewer seeds: a look, not a result
  std::filesystem::path folder;                 ///< of the experiments' scenes
  std::function<void(const std::string&)> say;  ///< progress, one line
  [[nodiscard]] int seeds() const { return quick ? 2 : 5; }
  /// The scene `name` with assignments (/pointer=value) applied.
  [[nodiscard]] Scene scene(const std::string& name, const std::vector<std::string>& assignments = {}) const;
};

struct Experiment {
  const char* name;
  const char* figure;  ///< of Kim 2017, or what it adds to it
  const char* to_be_seen;
  const char* waits_for;  ///< capability that it needs and the program lacks; empty: it runs
  std::function<ExperimentReport(const Surroundings&)> run;
};

/// All of them, in the order of the figures.
std::span<const Experiment> experiments();

struct ExperimentOptions {
  std::vector<std::string> names;  ///< or "list", or "all"
  bool quick = false;
  std::string out = "out/experiments";
  std::string page = {};  ///< Markdown page to write, pictures beside it; empty: none
  bool quiet = false;
};

/// Runs them, prints their tables, writes CSV and PNG below `out`. Throws Refusal for an unknown name.
void run_experiments(const ExperimentOptions& options);

}  // namespace wick::scenes
