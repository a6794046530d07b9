#include "scenes/run_record.h"

#include <nlohmann/json.hpp>

#include "scenes/machine.h"
#include "scenes/version.h"

namespace wick::scenes {

std::string run_record_text(const RunRecord& record) {
  nlohmann::ordered_json json;
  json["version"] = version;
  json["outcome"] = record.outcome;
  if (!record.reason.empty()) json["reason"] = record.reason;
  json["frames"] = record.frames;
  json["models"] = record.models;
  json["threads"] = record.threads;
  json["wall_s"] = record.wall_s;
  json["peak_rss_bytes"] = peak_memory();
  json["state_hash"] = record.state_hash;
  json["scene_hash"] = record.scene_hash;
  json["unconverged_solves"] = record.unconverged_solves;
  json["warnings"] = record.warnings;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace wick::scenes
