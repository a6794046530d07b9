#pragma once
/// The results page: every experiment with its numbers, pictures and what failed.
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/experiments/experiment.h"

namespace wick::scenes {

struct FinishedExperiment {
  const Experiment* experiment;
  ExperimentReport report;
  double seconds = 0.0;
};

/// Mean, with ± deviation where there is one.
std::string format_value(const diffusion::Spread& value);

/// The folder of the page's pictures, made.
std::filesystem::path make_page_folder(const std::filesystem::path& page);

/// Writes the Markdown page, and its pictures into a folder of the page's name beside it.
void write_results_page(const std::filesystem::path& page, const std::vector<FinishedExperiment>& finished,
                        bool quick);

}  // namespace wick::scenes
