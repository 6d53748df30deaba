// What is wrong with the words of a command line, as its user would say it.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace gpvc::cli {

/// "gpvc help COMMAND" as "gpvc COMMAND --help"; any other words as they are. The first is the program.
std::vector<std::string> without_help_command(std::vector<std::string> words);

/// A sentence about a word that stands where a command is expected and is none, and the command that was reached before it.
/// It comes before all that follows: options of a mistyped command are not its parent's.
struct WrongCommand {
  std::string sentence;
  const CLI::App* reached;
};
std::optional<WrongCommand> wrong_command(const CLI::App& app, const std::vector<std::string>& words);

/// What the parser refused, in one sentence of our own.
std::string usage_complaint(const CLI::App& reached, const CLI::ParseError& error);

}  // namespace gpvc::cli
