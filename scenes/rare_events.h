#pragma once
/// What should not happen often in a run: read from the metrics of all its frames, those of earlier processes too,
/// and told once at its end.
#include <map>
#include <string>
#include <vector>

#include "core/ledger.h"
#include "scenes/metrics.h"

namespace wick::scenes {

/// Sum of a column that counts; 0 where there is none.
long long total_count(const Metrics& metrics, const std::string& path);

/// One sentence for each kind that has happened.
std::vector<std::string> rare_events(const Metrics& metrics, const std::map<std::string, Ledger>& ledgers);

}  // namespace wick::scenes
