// `gpvc compare`: one scene textured once per visibility mode, everything else equal, in figures and pictures.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/options.h"

namespace CLI {
class App;
}

namespace gpvc::compare {

struct CompareOptions {
  cli::TextureOptions texture;         ///< shared by all modes; its visibility is replaced by each mode's
  std::string modes;                   ///< list; empty: default_modes()
  std::vector<double> epsilons;        ///< of modes given without one; empty: BiasScale::sweep()
  std::vector<std::string> externals;  ///< NAME=MODEL
  std::optional<std::filesystem::path> truth;
  int crops = 8, crop_views = 6;
  int oracle_views = 3, score_views = 12;
  std::optional<int> reduction;  ///< by which photos and renders are scored smaller than textured
  /// By default, a quarter of the photo as taken.
  int scored_reduction() const { return reduction.value_or(std::max(1, 4 / texture.input.downscale)); }
  bool keep_models = false;
  std::vector<std::filesystem::path> summarize;  ///< report.json files: no scene is textured
};

CLI::App* add_compare(CLI::App& parent, CompareOptions& options);
void run_compare(const CompareOptions& options, cli::Console& console);

/// Reads report.json files and writes summary.md, summary.html and summary.json: how close each bias comes to gpvc over
/// all scenes. Throws InputError, OutputError.
void summarize_reports(const CompareOptions& options, cli::Console& console);

}  // namespace gpvc::compare
