// Help texts, made from the declarations that parse the options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace gpvc::cli {

/// The command as users type it: "gpvc synth city".
std::string full_name(const CLI::App& app);

/// Purpose, usage, options by group with their defaults, then the footer (examples, exit status).
class HelpFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

}  // namespace gpvc::cli
