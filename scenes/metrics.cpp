#include "scenes/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "scenes/hdf5_image.h"
#include "scenes/machine.h"

namespace wick::scenes {

namespace {

/// Whole numbers are stored as such.
bool is_count(const std::string& path) {
  return path == "/frame" || path == "/substeps" || path == "/unconverged_solves" || path == "/lengthened_steps" ||
         path == "/squeezed_steps" || path == "/forced_contacts" || path.ends_with("/iterations");
}

/// What a frame that does not name `path` has there.
double filler(const std::string& path) {
  // A solver that did not run left nothing unsolved.
  const bool amount = path.starts_with("/timing/") || path.starts_with("/ledger/") || path.starts_with("/solve/");
  return amount || is_count(path) ? 0.0 : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void Metrics::add(const Row& row, std::uint64_t state_hash) {
  for (const auto& [path, value] : row) {
    std::vector<double>& column = columns_[path];
    column.resize(rows(), filler(path));
    column.push_back(value);
  }
  state_hash_.push_back(state_hash);
  for (auto& [path, column] : columns_) column.resize(rows(), filler(path));
}

void Metrics::set(int frame, const std::string& path, double value) {
  std::vector<double>& column = columns_[path];
  column.resize(rows(), filler(path));
  column.at(static_cast<std::size_t>(frame) - 1) = value;
}

void Metrics::recall_output_times(std::string_view file) {
  const Hdf5Reader reader(file);
  std::vector<std::uint64_t> hashes(reader.rows("/state_hash", ScalarType::u64, 1));
  reader.read("/state_hash", ScalarType::u64, hashes.data());
  std::size_t same = 0;
  while (same < std::min(hashes.size(), rows()) && hashes[same] == state_hash_[same]) ++same;
  for (const char* path : {output_timing, background_timing}) {
    const auto column = columns_.find(path);
    if (column == columns_.end() || !reader.has(path)) continue;
    std::vector<double> seconds(reader.rows(path, ScalarType::f64, 1));
    reader.read(path, ScalarType::f64, seconds.data());
    std::copy_n(seconds.begin(), std::min(same, seconds.size()), column->second.begin());
  }
}

const std::vector<double>* Metrics::column(const std::string& path) const {
  const auto found = columns_.find(path);
  return found == columns_.end() ? nullptr : &found->second;
}

Bytes Metrics::file() const {
  Hdf5Writer writer;
  for (const auto& [path, column] : columns_) {
    if (is_count(path)) {
      const std::vector<std::int64_t> counts(column.begin(), column.end());
      writer.dataset(path, ScalarType::i64, counts.size(), 1, counts.data());
    } else {
      writer.dataset(path, ScalarType::f64, column.size(), 1, column.data());
    }
  }
  writer.dataset("/state_hash", ScalarType::u64, state_hash_.size(), 1, state_hash_.data());
  return writer.finish();
}

void Metrics::visit(StateVisitor& visitor) {
  std::vector<std::string> paths;
  std::vector<double> values;
  for (const auto& [path, column] : columns_) {
    paths.push_back(path);
    values.insert(values.end(), column.begin(), column.end());
  }
  visitor.array("state_hash", state_hash_);
  visitor.array("paths", paths);
  visitor.array("values", values);
  if (values.size() != paths.size() * rows())
    throw std::runtime_error("the metrics of a checkpoint do not fit together");
  columns_.clear();
  for (std::size_t i = 0; i < paths.size(); ++i)
    columns_[paths[i]].assign(values.begin() + static_cast<std::ptrdiff_t>(i * rows()),
                              values.begin() + static_cast<std::ptrdiff_t>((i + 1) * rows()));
}

Metrics::Row metrics_row(const coupling::World& world, const coupling::FrameReport& report) {
  Metrics::Row row;
  row["/frame"] = world.frame();
  row["/time"] = world.time();
  row["/substeps"] = report.substeps;
  row["/unconverged_solves"] = report.unconverged_solves;
  row["/squeezed_steps"] = report.squeezed_steps;
  row["/forced_contacts"] = report.forced_contacts;
  row["/lengthened_steps"] = report.lengthened_steps;
  for (const char* path : {output_timing, background_timing}) row[path] = 0.0;
  row["/memory/peak_rss_bytes"] = static_cast<double>(peak_memory());
  for (const auto& [stage, seconds] : report.seconds) row["/timing/" + stage] = seconds;
  for (const auto& [solver, solve] : report.solves) {
    row["/solve/" + solver + "/iterations"] = solve.iterations;
    row["/solve/" + solver + "/residual"] = solve.residual_after;
  }
  for (const auto& [quantity, ledger] : world.ledgers()) {
    const std::string path = "/ledger/" + quantity + "/";
    for (const auto& [term, amount] : ledger.stocks()) row[path + term] = amount;
    for (const auto& [term, amount] : ledger.flows()) row[path + term] = amount;
    row[path + "relative_error"] = ledger.relative_error();
  }
  for (const auto& [shell, quantities] : world.shell_metrics())
    for (const auto& [quantity, value] : quantities) row["/shell/" + shell + "/" + quantity] = value;
  return row;
}

}  // namespace wick::scenes
