#include "app/cli/help.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <vector>

#include "app/cli/command_options.h"
#include "app/pipeline/options.h"

namespace gpvc::cli {
namespace {

constexpr std::size_t kWidth = 96, kIndent = 2, kColumn = 26;

// Wraps a text at kWidth. The first line starts at `column`; the others are indented to it.
std::string wrapped(const std::string& text, std::size_t column) {
  std::istringstream words(text);
  std::string word, line, all;
  while (words >> word) {
    if (!line.empty() && column + line.size() + 1 + word.size() > kWidth) {
      all += line + "\n" + std::string(column, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return all + line + "\n";
}

std::string entry(const std::string& name, const std::string& text) {
  std::string line = std::string(kIndent, ' ') + name;
  if (line.size() + 2 > kColumn)
    line += "\n" + std::string(kColumn, ' ');
  else
    line.resize(kColumn, ' ');
  return line + wrapped(text, kColumn);
}

std::string option_name(const CLI::Option& option) {
  std::string name;
  for (const std::string& s : option.get_snames()) name += (name.empty() ? "-" : ", -") + s;
  for (const std::string& l : option.get_lnames()) name += (name.empty() ? "--" : ", --") + l;
  if (option.get_items_expected_max() > 0 && option.get_type_size_max() > 0) name += " " + option.get_type_name();
  return name;
}

std::string option_text(const CLI::Option& option) {
  std::string text = option.get_description();
  if (!option.get_default_str().empty()) text += " [" + option.get_default_str() + "]";
  return text;
}

std::string usage_line(const CLI::App& app, const std::string& full_name) {
  std::string line = "Usage: " + full_name;
  if (!app.get_subcommands({}).empty()) return line + " COMMAND ...\n";
  line += " [OPTION]...";
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional()) line += " " + option->get_name(true);
  for (const CLI::Option* option : app.get_options())
    if (option->get_required() && !option->get_positional())
      line += " -" + option->get_snames().front() + " " + option->get_type_name();
  return line + "\n";
}

}  // namespace

std::string full_name(const CLI::App& app) {
  return (app.get_parent() == nullptr ? "" : full_name(*app.get_parent()) + " ") + app.get_name();
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const {
  const std::string name = full_name(*app);
  std::string help = wrapped(name + ": " + app->get_description(), 0) + "\n" + usage_line(*app, name);

  std::string positionals;
  std::vector<std::string> groups;  // in the order in which one needs them
  for (const CLI::Option* option : app->get_options()) {
    if (option->get_positional())
      positionals += entry(option->get_name(true), option_text(*option));
    else if (!option->get_group().empty() &&
             std::find(groups.begin(), groups.end(), option->get_group()) == groups.end())
      groups.push_back(option->get_group());
  }
  const auto rank = [](std::string_view group) {
    constexpr std::array<std::string_view, 8> kOrder{pipeline::kInput,    pipeline::kQuality, pipeline::kSize,
                                                     pipeline::kOutput,   "a command's own",  pipeline::kMachine,
                                                     pipeline::kResearch, kCommonGroup};
    const auto at = std::ranges::find(kOrder, group);
    return (at != kOrder.end() ? at : std::ranges::find(kOrder, "a command's own")) - kOrder.begin();
  };
  std::ranges::stable_sort(groups, {}, rank);
  if (!positionals.empty()) help += "\n" + positionals;

  const auto commands = app->get_subcommands({});
  if (!commands.empty()) help += "\nCommands:\n";
  for (const CLI::App* command : commands) help += entry(command->get_name(), command->get_description());

  for (const std::string& group : groups) {
    help += "\n" + group + ":\n";
    for (const CLI::Option* option : app->get_options())
      if (!option->get_positional() && option->get_group() == group)
        help += entry(option_name(*option), option_text(*option));
  }
  if (!app->get_footer().empty()) help += "\n" + app->get_footer() + "\n";
  return help;
}

}  // namespace gpvc::cli
