// One scene textured once per visibility mode, everything else equal, in figures and pictures.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/compare/compare_settings.h"
#include "app/evaluate/json.h"
#include "app/results/observer.h"
#include "app/results/output_folder.h"
#include "visibility/device.h"

namespace gpvc::compare {

using evaluate::Json;

/// What is compared. Borrows what the references and spans refer to.
struct CompareInput {
  checks::Input input;
  std::span<const ViewId> held_out;  ///< ascending; views to score in, none of which is textured from; may be empty
  io::PhotoSource& photos;
  int downscale = 1;    ///< the photos are this much smaller than taken
  std::string version;  ///< of the program, for the report
};

struct CompareSummary {
  std::optional<visibility::DeviceInfo> device;  ///< that the first mode to use one drew with
  Json settings;                                 ///< as in report.json
  std::size_t models = 0, failed = 0;            ///< failed ones lack figures in the report
};

/// Textures the scene once per mode, measures each model and those of other programs, and writes report.html, report.md
/// and report.json, and with keep_models modes/NAME. A model that fails is reported as failed, and the others go on.
/// Throws InputError for the truth, OutputError, and what the observer throws.
CompareSummary compare(const CompareInput& input, const CompareSettings& settings, results::OutputFolder& folder,
                       results::Observer& observer);

/// How close each bias comes to gpvc over the scenes of several report.json files: {format, tables}, each table as
/// markdown_table() takes it. Throws InputError.
Json summarize(const std::vector<std::filesystem::path>& reports);
/// Writes summary.html, summary.md and summary.json. Throws OutputError.
void write_summary(const Json& summary, results::OutputFolder& folder);

}  // namespace gpvc::compare
