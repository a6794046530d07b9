#include "scenes/experiments/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "core/require.h"
#include "scenes/atomic_file.h"
#include "scenes/bundled.h"
#include "scenes/experiments/results_page.h"
#include "scenes/scene_file.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "FAIL";
    case Verdict::reported:
      break;
  }
  return "-";
}

void print_report(const Experiment& experiment, const ExperimentReport& report, double seconds) {
  fmt::print("{}: {}\n  to be seen: {}\n", experiment.name, experiment.figure, experiment.to_be_seen);
  std::size_t width = 10;
  for (const Check& check : report.checks) width = std::max(width, check.what.size());
  for (const Check& check : report.checks)
    fmt::print("  {:<{}}  {:>12}  {:<22} {}\n", check.what, width, format_value(check.value), check.threshold,
               verdict_name(check.verdict));
  fmt::print("  {:.1f} s\n\n", seconds);
  std::fflush(stdout);  // what is finished is told, whatever happens to the rest
}

std::string csv(const Table& table) {
  const auto line = [](std::vector<std::string> cells) {
    for (std::string& cell : cells)
      if (cell.find(',') != std::string::npos) cell = "\"" + cell + "\"";
    return fmt::format("{}\n", fmt::join(cells, ","));
  };
  std::string text = line(table.columns);
  for (const std::vector<std::string>& row : table.rows) text += line(row);
  return text;
}

Table checks_table(const ExperimentReport& report) {
  Table table{.name = "checks", .columns = {"number", "mean", "deviation", "threshold", "verdict"}, .rows = {}};
  for (const Check& check : report.checks)
    table.rows.push_back({check.what, fmt::format("{:.9g}", check.value.mean),
                          fmt::format("{:.3g}", check.value.deviation), check.threshold,
                          verdict_name(check.verdict)});
  return table;
}

Bytes bytes_of(const std::string& text) {
  return Bytes(text.begin(), text.end());
}

void write_report(const ExperimentReport& report, const fs::path& folder) {
  make_folder(folder);
  write_file(folder / "checks.csv", bytes_of(csv(checks_table(report))));
  for (const Table& table : report.tables) write_file(folder / (table.name + ".csv"), bytes_of(csv(table)));
  for (const NamedPicture& p : report.pictures) {
    const std::vector<char> png = encode_png(p.picture);
    write_file(folder / (p.name + ".png"), Bytes(png.begin(), png.end()));
  }
}

void print_list() {
  for (const Experiment& e : experiments())
    fmt::print("{:<14}{}{}\n", e.name, e.figure,
               *e.waits_for == '\0' ? std::string() : fmt::format(" (waits for {})", e.waits_for));
}

std::vector<const Experiment*> chosen(const ExperimentOptions& options) {
  std::vector<const Experiment*> list;
  std::vector<std::string> known;
  for (const Experiment& e : experiments()) known.emplace_back(e.name);
  for (const std::string& name : options.names) {
    const bool all = name == "all";
    const auto found = std::find(known.begin(), known.end(), name);
    if (!all && found == known.end()) {
      const std::string near = nearest(name, known);
      throw Refusal(ExitCode::command_line, "",
                    fmt::format("no experiment \"{}\" (see `wick experiment list`){}", name,
                                near.empty() ? "" : " did you mean " + near + "?"));
    }
    for (const Experiment& e : experiments()) {
      const bool runs = *e.waits_for == '\0';
      if (name == e.name && !runs)
        throw Refusal(ExitCode::input_missing, "", fmt::format("{} waits for {}", name, e.waits_for));
      const bool listed = std::find(list.begin(), list.end(), &e) != list.end();
      if (runs && !listed && (all || name == e.name)) list.push_back(&e);
    }
  }
  return list;
}

}  // namespace

Check at_least(std::string what, const std::vector<double>& values, double threshold) {
  const diffusion::Spread s = diffusion::spread(values);
  return {std::move(what), s, fmt::format(">= {:g}", threshold),
          s.mean >= threshold ? Verdict::pass : Verdict::fail};
}

Check at_most(std::string what, const std::vector<double>& values, double threshold) {
  const diffusion::Spread s = diffusion::spread(values);
  return {std::move(what), s, fmt::format("<= {:g}", threshold),
          s.mean <= threshold ? Verdict::pass : Verdict::fail};
}

Check reported(std::string what, const std::vector<double>& values) {
  return {std::move(what), diffusion::spread(values), "", Verdict::reported};
}

Check holds(std::string what, bool it_does, std::string threshold) {
  return {
      std::move(what), {it_does ? 1.0 : 0.0, 0.0}, std::move(threshold), it_does ? Verdict::pass : Verdict::fail};
}

void Table::add(const std::vector<std::string>& labels, const std::vector<double>& values) {
  std::vector<std::string> row = labels;
  for (const double value : values) row.push_back(fmt::format("{:.9g}", value));
  rows.push_back(std::move(row));
}

Scene Surroundings::scene(const std::string& name, const std::vector<std::string>& assignments) const {
  return read_scene(folder / (name + ".json"), assignments);
}

void run_experiments(const ExperimentOptions& options) {
  if (options.names.empty() || options.names[0] == "list") return print_list();
  Surroundings surroundings;
  surroundings.quick = options.quick;
  surroundings.folder = bundled_folder() / "experiments";
  surroundings.say = [&](const std::string& line) {
    if (!options.quiet) fmt::print(stderr, "wick: {}\n", line);
  };
  const std::vector<const Experiment*> list = chosen(options);
  make_folder(options.out);  // before hours of work, not after
  if (!options.page.empty()) make_page_folder(options.page);
  std::vector<FinishedExperiment> finished;
  int passed = 0, judged = 0;
  for (const Experiment* experiment : list) {
    const auto start = std::chrono::steady_clock::now();
    ExperimentReport report = experiment->run(surroundings);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    print_report(*experiment, report, seconds);
    write_report(report, fs::path(options.out) / experiment->name);
    for (const Check& check : report.checks) {
      passed += check.verdict == Verdict::pass ? 1 : 0;
      judged += check.verdict != Verdict::reported ? 1 : 0;
    }
    finished.push_back({experiment, std::move(report), seconds});
  }
  fmt::print("{} of {} thresholds passed{}; tables and pictures are in {}\n", passed, judged,
             options.quick ? " in quick mode: a look with fewer seeds, not a result" : "", options.out);
  if (!options.page.empty()) write_results_page(options.page, finished, options.quick);
}

}  // namespace wick::scenes
