#include "app/cli/usage.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/near_words.h"

namespace gpvc::cli {
namespace {

std::string meant(const std::string& word, const std::vector<std::string>& words) {
  const auto near = io::near_words(word, words, 1, 1 + word.size() / 4);
  return near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near.front());
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

std::string no_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> names = names_of_commands(app);
  if (app.get_parent() == nullptr) names.emplace_back("help");
  return fmt::format("there is no command '{}'{}", word, meant(word, names));
}

bool is_option(const std::string& word) { return word.starts_with("-") && word.size() > 1; }

// The parser's errors name one option or argument first, and sometimes a second one last.
std::string in_our_words(const CLI::ParseError& error) {
  const std::string kind = error.get_name(), text = error.what();
  const std::string first = text.substr(0, text.find_first_of(": ")), last = text.substr(text.rfind(' ') + 1);
  if (kind == "RequiredError") return first + " is missing";
  if (kind == "ExcludesError") return fmt::format("{} and {} exclude each other", first, last);
  if (kind == "RequiresError") return fmt::format("{} belongs to {}, which is missing", first, last);
  if (kind == "ArgumentMismatch")
    return first + (text.find("received") != std::string::npos ? " is given more than once" : " needs a value");
  if (kind == "ConversionError") return fmt::format("{}: '{}' is no value for it", last, first);
  return text;  // of a validator, which is ours
}

}  // namespace

std::vector<std::string> without_help_command(std::vector<std::string> words) {
  if (words.size() < 2 || words[1] != "help") return words;
  words.erase(words.begin() + 1);
  if (std::ranges::find(words, "--help") == words.end()) words.emplace_back("--help");
  return words;
}

std::optional<WrongCommand> wrong_command(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* at = &app;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::vector<std::string> names = names_of_commands(*at);
    if (names.empty()) break;
    if (is_option(words[i])) continue;
    if (std::ranges::find(names, words[i]) == names.end()) return WrongCommand{no_command(*at, words[i]), at};
    at = at->get_subcommand(words[i]);
  }
  return std::nullopt;
}

std::string usage_complaint(const CLI::App& reached, const CLI::ParseError& error) {
  std::vector<std::string> options;
  for (const CLI::Option* option : reached.get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  const std::vector<std::string> left = reached.remaining(true);
  for (const std::string& word : left)
    if (is_option(word))
      return fmt::format("there is no option '{}'{}", word, meant(word.substr(0, word.find('=')), options));
  if (!names_of_commands(reached).empty()) return "a command is missing";
  if (!left.empty()) return fmt::format("'{}' is one argument too many", left.front());
  return in_our_words(error);
}

}  // namespace gpvc::cli
