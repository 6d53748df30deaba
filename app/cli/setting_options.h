// Settings as options of the command line and in run.json, from their lists (app/pipeline/options.h).
#pragma once

#include <functional>

#include "app/cli/option_parts.h"
#include "app/evaluate/json.h"
#include "app/ortho/ortho_options.h"
#include "app/tiles/job_members.h"

namespace gpvc::cli {

using OptionFilter = std::function<bool(const pipeline::OptionInfo&)>;

/// Adds those that are offered and that the filter takes, each under its heading. The values they have are the defaults.
void add_settings(CLI::App& app, pipeline::Settings& settings, const OptionFilter& wanted);
void add_settings(CLI::App& app, tiles::JobSettings& settings, const OptionFilter& wanted);
void add_settings(CLI::App& app, tileset::TilesetSettings& settings);
void add_settings(CLI::App& app, ortho::OrthoSettings& settings);
void add_settings(CLI::App& app, visibility::VisibilityOptions& settings);

/// The filter of a kind of result: what is for it and for all kinds.
OptionFilter options_for(pipeline::For result);

/// Throws UsageError where settings of the output contradict each other.
void refuse_contradictions(const pipeline::Settings& settings);

/// By their names, with _ for -, those that the filter takes, offered or not. Rules about photos are left out.
evaluate::Json settings_json(const pipeline::Settings& settings, const OptionFilter& wanted);
evaluate::Json settings_json(const tiles::JobSettings& settings, const OptionFilter& wanted);
evaluate::Json settings_json(const tileset::TilesetSettings& settings);
evaluate::Json settings_json(const ortho::OrthoSettings& settings);
evaluate::Json settings_json(const visibility::VisibilityOptions& settings);

}  // namespace gpvc::cli
