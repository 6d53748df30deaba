// Declares the options of each command, for the parser and the help. Each function adds its command to `parent`; parsing
// writes into `options`, which must outlive it.
#pragma once

#include <CLI/CLI.hpp>

#include "app/cli/options.h"

namespace gpvc::cli {

inline constexpr const char* kCommonGroup = "Common";
inline constexpr const char* kExitStatus =
    "Exit status: 0 all promised files are complete; 1 bad input or a failed run; 2 bad usage;\n130 interrupted.";

CLI::App* add_texture(CLI::App& parent, TextureOptions& options);
CLI::App* add_tileset(CLI::App& parent, TilesetOptions& options);
CLI::App* add_ortho(CLI::App& parent, OrthoCommandOptions& options);
CLI::App* add_tiles(CLI::App& parent, TilesOptions& options);
CLI::App* add_unit(CLI::App& parent, UnitOptions& options);
CLI::App* add_plan(CLI::App& parent, PlanOptions& options);
CLI::App* add_visibility_command(CLI::App& parent, VisibilityCommandOptions& options);
CLI::App* add_evaluate(CLI::App& parent, EvaluateCommandOptions& options);
CLI::App* add_compare(CLI::App& parent, CompareOptions& options);
CLI::App* add_label(CLI::App& parent, LabelOptions& options);
CLI::App* add_photos_command(CLI::App& parent, PhotosOptions& options);
CLI::App* add_coverage(CLI::App& parent, CoverageOptions& options);
CLI::App* add_view(CLI::App& parent, ViewOptions& options);
CLI::App* add_convert(CLI::App& parent, ConvertOptions& options);
CLI::App* add_inspect(CLI::App& parent, InspectOptions& options);
/// The command for the kind of scene that `options` holds.
CLI::App* add_synth(CLI::App& parent, SynthOptions& options);

}  // namespace gpvc::cli
