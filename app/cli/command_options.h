// The options of each command, declared once for the parser and the help. Each function adds its command to `parent`
// and lets it fill `options`, which must outlive the parsing.
#pragma once

#include <CLI/CLI.hpp>

#include "app/cli/options.h"

namespace gpvc::cli {

inline constexpr const char* kCommonGroup = "Common";
inline constexpr const char* kExitStatus =
    "Exit status: 0 all promised files are complete; 1 bad input or a failed run; 2 bad usage;\n130 "
    "interrupted.";

CLI::App* add_texture(CLI::App& parent, TextureOptions& options);
CLI::App* add_visibility_command(CLI::App& parent, VisibilityCommandOptions& options);
CLI::App* add_evaluate(CLI::App& parent, EvaluateCommandOptions& options);
CLI::App* add_label(CLI::App& parent, LabelOptions& options);
CLI::App* add_convert(CLI::App& parent, ConvertOptions& options);
CLI::App* add_inspect(CLI::App& parent, InspectOptions& options);
/// Of the kind that `options` holds.
CLI::App* add_synth(CLI::App& parent, SynthOptions& options);

}  // namespace gpvc::cli
