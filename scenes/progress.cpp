#include "scenes/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "scenes/machine.h"

namespace wick::scenes {

namespace {

constexpr int bar_width = 24;

std::string solver_text(const coupling::FrameReport& report) {
  std::string text;
  for (const auto& [solver, solve] : report.solves) text += fmt::format("  {} {} it", solver, solve.iterations);
  if (report.unconverged_solves > 0) text += fmt::format("  {} solves unconverged", report.unconverged_solves);
  return text;
}

using Rows = std::vector<std::pair<std::string, double>>;

/// Stages by their time, each followed by its parts ("smoke_pressure" is a part of "smoke"), indented. Rows that
/// would show zero are those of models that the scene has not.
Rows table_rows(const std::map<std::string, double>& stages) {
  constexpr double shown_as_zero = 0.0005;
  const auto parent_of = [&](const std::string& stage) {
    const std::string parent = stage.substr(0, stage.find('_'));
    return parent != stage && stages.contains(parent) ? parent : "";
  };
  const auto children_of = [&](const std::string& parent) {
    Rows rows;
    for (const auto& [stage, seconds] : stages)
      if (seconds >= shown_as_zero && parent_of(stage) == parent) rows.emplace_back(stage, seconds);
    std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
    return rows;
  };
  Rows table;
  for (const auto& [stage, seconds] : children_of("")) {
    table.emplace_back(stage, seconds);
    for (const auto& [part, time] : children_of(stage))
      table.emplace_back("  " + part.substr(stage.size() + 1), time);
  }
  return table;
}

}  // namespace

void say(std::FILE* stream, const std::string& text) {
  std::fputs(text.c_str(), stream);
}

Progress::Progress(int first, int last, bool quiet)
    : first_(first), last_(last), quiet_(quiet), bar_(!quiet && isatty(STDERR_FILENO) == 1) {}

void Progress::frame(const coupling::FrameReport& report, double seconds) {
  ++frames_;
  step_seconds_ += seconds;
  for (const auto& [stage, time] : report.seconds) stages_[stage] += time;
  // Recent frames count more: smoke fills the box as it rises, so frames grow dearer.
  mean_seconds_ = frames_ == 1 ? seconds : 0.8 * mean_seconds_ + 0.2 * seconds;
  if (quiet_) return;
  const std::string line =
      fmt::format("frame {}/{}  {} substeps{}  {:.2f} s/frame  {} left", report.frame, last_, report.substeps,
                  solver_text(report), seconds, seconds_text(mean_seconds_ * (last_ - report.frame)));
  if (!bar_) {
    say(stderr, line + "\n");
    return;
  }
  const int span = std::max(last_ - first_, 1);
  const int filled = std::clamp(bar_width * (report.frame - first_) / span, 0, bar_width);
  say(stderr, fmt::format("\r\x1b[K[{:=<{}}{: <{}}] {}", "", filled, "", bar_width - filled, line));
  std::fflush(stderr);
  bar_shown_ = true;
}

void Progress::clear_bar() {
  if (bar_shown_) say(stderr, "\n");
  bar_shown_ = false;
}

void Progress::note(const std::string& text) {
  if (quiet_) return;
  clear_bar();
  say(stderr, text + "\n");
}

void Progress::summary(double wall_seconds, double background_seconds) {
  clear_bar();
  if (quiet_ || frames_ == 0) return;
  const auto line = [](const std::string& name, const std::string& a, const std::string& b, const std::string& c) {
    say(stdout, fmt::format("{:<24}{:>12}{:>12}{:>10}\n", name, a, b, c));
  };
  line("stage (of which)", "seconds ", "s/frame ", "share ");
  const auto row = [&](const std::string& name, double seconds) {
    // A part is in its whole already: in brackets it is not added to it a second time.
    const bool part = name.starts_with(' ');
    const auto cell = [&](const std::string& number) { return part ? "(" + number + ")" : number + " "; };
    const double share = wall_seconds > 0.0 ? 100.0 * seconds / wall_seconds : 0.0;
    line(name, cell(fmt::format("{:.3f}", seconds)), cell(fmt::format("{:.4f}", seconds / frames_)),
         cell(fmt::format("{:.1f}%", share)));
  };
  for (const auto& [name, seconds] : table_rows(stages_)) row(name, seconds);
  row("all steps", step_seconds_);
  row("whole run", wall_seconds);
  row("writing, meanwhile", background_seconds);
}

}  // namespace wick::scenes
