#include "scenes/experiments/results_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include "scenes/atomic_file.h"

namespace wick::scenes {

namespace fs = std::filesystem;

namespace {

const char* mark(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "**fail**";
    case Verdict::reported:
      break;
  }
  return "";
}

/// A number as a page shows it; other text as it is.
std::string shortened(const std::string& cell) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  return cell.empty() || *end != '\0' ? cell : fmt::format("{:.3g}", value);
}

/// A table behind a line to click on.
std::string folded(const Table& table) {
  const auto line = [](std::vector<std::string> cells) {
    for (std::string& cell : cells) cell = shortened(cell);
    return fmt::format("| {} |\n", fmt::join(cells, " | "));
  };
  std::string text = fmt::format("<details><summary>{} rows of {}</summary>\n\n", table.rows.size(), table.name);
  text += line(table.columns) + line(std::vector<std::string>(table.columns.size(), "---"));
  for (const std::vector<std::string>& row : table.rows) text += line(row);
  return text + "\n</details>\n\n";
}

std::string section(const FinishedExperiment& f, const std::string& folder) {
  std::string text = fmt::format("## {}: {}\n\nTo be seen: {}\n\n", f.experiment->name, f.experiment->figure,
                                 f.experiment->to_be_seen);
  for (const NamedPicture& p : f.report.pictures)
    text +=
        fmt::format("![{}]({}/{}-{}.png)\n\n*{}*\n\n", p.caption, folder, f.experiment->name, p.name, p.caption);
  text += "| number | value | threshold | |\n|---|---|---|---|\n";
  for (const Check& check : f.report.checks)
    text += fmt::format("| {} | {} | {} | {} |\n", check.what, format_value(check.value), check.threshold,
                        mark(check.verdict));
  text += "\n";
  for (const Table& table : f.report.tables)
    if (table.on_page) text += folded(table);
  if (!f.report.analysis.empty()) text += f.report.analysis + "\n\n";
  return text;
}

}  // namespace

std::string format_value(const diffusion::Spread& value) {
  if (value.deviation == 0.0) return fmt::format("{:.4g}", value.mean);
  return fmt::format("{:.3g} ± {:.1g}", value.mean, value.deviation);
}

fs::path make_page_folder(const fs::path& page) {
  const fs::path pictures = page.parent_path() / page.stem();
  make_folder(pictures);
  return pictures;
}

void write_results_page(const fs::path& page, const std::vector<FinishedExperiment>& finished, bool quick) {
  const std::string folder = page.stem().string();
  int passed = 0, failed = 0;
  double seconds = 0.0;
  for (const FinishedExperiment& f : finished) {
    seconds += f.seconds;
    for (const Check& check : f.report.checks) {
      passed += check.verdict == Verdict::pass ? 1 : 0;
      failed += check.verdict == Verdict::fail ? 1 : 0;
    }
  }
  std::string names;
  for (const FinishedExperiment& f : finished)
    names += (names.empty() ? "" : " ") + std::string(f.experiment->name);
  const auto runs = [](const Experiment& e) { return *e.waits_for == '\0'; };
  if (static_cast<std::ptrdiff_t>(finished.size()) ==
      std::count_if(experiments().begin(), experiments().end(), runs))
    names = "all";
  std::string text = fmt::format(
      "# Results\n\nWritten by `wick experiment {} --page {}`{}. Thresholds were set before the "
      "runs. {} "
      "passed, {} failed; failures are kept and explained. Values are means ± standard deviations over seeds. All "
      "of it "
      "took {:.0f} minutes.\n\n",
      names, page.string(), quick ? " **in quick mode: fewer seeds, a look and not a result**" : "", passed, failed,
      seconds / 60.0);
  for (const FinishedExperiment& f : finished) text += section(f, folder);
  for (const Experiment& e : experiments())
    if (*e.waits_for != '\0') text += fmt::format("- {} ({}) waits for {}.\n", e.name, e.figure, e.waits_for);

  const fs::path pictures = make_page_folder(page);
  for (const FinishedExperiment& f : finished)
    for (const NamedPicture& p : f.report.pictures) {
      const std::vector<char> png = encode_png(p.picture);
      write_file(pictures / fmt::format("{}-{}.png", f.experiment->name, p.name), Bytes(png.begin(), png.end()));
    }
  write_file(page, Bytes(text.begin(), text.end()));
}

}  // namespace wick::scenes
