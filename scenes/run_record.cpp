#include "scenes/run_record.h"

#include <nlohmann/json.hpp>

#include "scenes/git_revision.h"
#include "scenes/machine.h"
#include "scenes/version.h"

namespace wick::scenes {

std::string run_record_text(const RunRecord& record) {
  nlohmann::ordered_json json;
  json["version"] = version;
  json["git"] = git_revision();
  json["outcome"] = record.outcome;
  if (!record.reason.empty()) json["reason"] = record.reason;
  json["frames"] = record.frames;
  json["models"] = record.models;
  json["threads"] = record.threads;
  json["wall_s"] = record.wall_s;
  json["peak_rss_bytes"] = peak_memory();
  json["state_hash"] = record.state_hash;
  json["scene_sha256"] = record.scene_sha256;
  json["checkpoint_s"] = record.checkpoint_s;
  json["unconverged_solves"] = record.unconverged_solves;
  json["damaged_outputs"] = record.damaged_outputs;
  json["warnings"] = record.warnings;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace wick::scenes
