// One scene textured once per visibility mode, everything else equal, in figures and pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/compare/compare_modes.h"
#include "app/evaluate/json.h"
#include "app/pipeline/pipeline.h"

namespace gpvc::compare {

using evaluate::Json;

/// Another program's textured model of the same mesh.
struct ExternalModel {
  std::string name;
  std::filesystem::path file;
};

struct CompareSettings {
  pipeline::Settings texture;  ///< shared by all modes; its visibility is replaced by each mode's
  std::vector<ComparedMode> modes;
  std::vector<ExternalModel> externals;  ///< their names differ from the modes' and from "photo"
  std::string mesh_crs;  ///< of the mesh and of the externals where it is not the scene's; see match_frames()
  std::optional<std::filesystem::path> truth;  ///< a synthetic scene's folder; by default one that holds SCENE
  int crops = 8, crop_views = 6;
  int oracle_views = 3, score_views = 12;
  int reduction = 4;  ///< photos and renders are scored at 1/reduction of the size textured from
  bool keep_models = false;
};

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
