#include "scenes/run_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/require.h"
#include "scenes/atomic_file.h"
#include "scenes/git_revision.h"
#include "scenes/machine.h"
#include "scenes/sha256.h"
#include "scenes/version.h"

namespace wick::scenes {

std::string run_record_text(const RunRecord& record) {
  nlohmann::ordered_json json;
  json["version"] = version;
  json["git"] = git_revision();
  json["scene"] = record.scene;
  json["outcome"] = record.outcome;
  if (!record.reason.empty()) json["reason"] = record.reason;
  json["frames"] = record.frames;
  json["models"] = record.models;
  json["threads"] = record.threads;
  json["wall_s"] = record.wall_s;
  json["peak_rss_bytes"] = peak_memory();
  json["state_hash"] = record.state_hash;
  json["scene_sha256"] = record.scene_sha256;
  json["scene_file_sha256"] = record.scene_file_sha256;
  json["metrics_sha256"] = record.metrics_sha256;
  json["checkpoint_s"] = record.checkpoint_s;
  json["unconverged_solves"] = record.unconverged_solves;
  json["damaged_outputs"] = record.damaged_outputs;
  json["warnings"] = record.warnings;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::optional<RecordedRun> read_run_record(const std::filesystem::path& file) {
  constexpr std::uint64_t largest_record = 16 << 20;
  Bytes bytes;
  try {
    bytes = read_file(file, largest_record);
  } catch (const Refusal&) {
    return std::nullopt;
  }
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  const auto text = [&](const char* key) -> std::string {
    return json.is_object() && json.contains(key) && json[key].is_string() ? json[key] : "";
  };
  RecordedRun run{text("scene"), text("scene_sha256"), text("scene_file_sha256"), text("metrics_sha256"),
                  text("outcome")};
  if (run.scene_sha256.empty() || run.outcome.empty()) return std::nullopt;
  return run;
}

Bytes recorded_metrics(const RunFolder& folder) {
  constexpr std::uint64_t largest_metrics = std::uint64_t{4} << 30;
  const std::optional<RecordedRun> recorded = read_run_record(folder.record());
  if (!recorded || recorded->metrics_sha256.empty()) return {};
  try {
    Bytes bytes = read_file(folder.metrics(), largest_metrics);
    return sha256(bytes) == recorded->metrics_sha256 ? bytes : Bytes();
  } catch (const Refusal&) {
    return {};
  }
}

RecordKeeper::~RecordKeeper() {
  std::error_code ignored;
  std::filesystem::remove(folder_.reserve(), ignored);
}

void RecordKeeper::begin(RunRecord& record) {
  write(record, "running");
  // Warnings may still come, and the reason of a failure.
  const std::size_t room = std::max<std::size_t>(1 << 16, 2 * run_record_text(record).size());
  static_cast<void>(make_reserve(folder_.reserve(), room));  // without it the last word is written as any other
}

void RecordKeeper::write(RunRecord& record, const std::string& outcome) {
  record.outcome = outcome;
  record.wall_s = seconds();
  write_file(folder_.record(), run_record_text(record));
}

void RecordKeeper::fail(RunRecord& record, const std::string& reason) {
  record.outcome = "failed";
  record.reason = reason;
  record.wall_s = seconds();
  try {
    write_file_from(folder_.reserve(), folder_.record(), run_record_text(record));
  } catch (const std::exception&) {
    // The caller reports the first error; a record that cannot be written keeps saying "running".
  }
}

double RecordKeeper::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace wick::scenes
