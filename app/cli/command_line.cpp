#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <optional>

#include "app/cli/app.h"
#include "app/cli/command_options.h"
#include "app/cli/help.h"
#include "app/cli/interrupt.h"
#include "app/cli/near_words.h"
#include "app/cli/options.h"
#include "app/compare/compare.h"

namespace gpvc::cli {
namespace {

constexpr int kFailed = 1, kBadUsage = 2, kInterrupted = 130;

int list_devices_command() {
  const auto devices = visibility::list_devices();
  if (devices.empty()) {
    std::fputs("gpvc: error: no EGL device offers OpenGL 4.5 (Debian: install libegl1 and libgl1-mesa-dri)\n", stderr);
    return kFailed;
  }
  for (const visibility::DeviceInfo& device : devices)
    std::printf("%d  %s (%s%s)\n", device.index, device.renderer.c_str(), device.driver.c_str(),
                device.software ? ", software" : "");
  return 0;
}

bool asks_for_devices(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--device=list" || (word == "--device" && i + 1 < argc && std::string(argv[i + 1]) == "list"))
      return true;
  }
  return false;
}

// What went to standard output did not all arrive (a full disk behind a redirection).
bool results_were_lost() { return std::fflush(stdout) != 0 || std::ferror(stdout) != 0; }

int run_guarded(const CommonOptions& common, const std::function<void(Console&)>& command) {
  std::optional<Console> console;
  try {
    console.emplace(common.loudness(), common.log);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpvc: error: %s\n", e.what());
    return kFailed;
  }
  try {
    std::optional<tbb::global_control> limit;
    if (common.threads > 0) {
      limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(common.threads));
      setenv("LP_NUM_THREADS", std::to_string(common.threads).c_str(), 0);  // llvmpipe, the software OpenGL
    }
    command(*console);
    if (results_were_lost()) throw std::runtime_error("standard output: cannot be written");
    return 0;
  } catch (const Cancelled&) {
    console->error("interrupted; nothing was written");
    return kInterrupted;
  } catch (const UsageError& e) {
    console->error(e.what());
    return kBadUsage;
  } catch (const std::bad_alloc&) {
    console->error("out of memory");
  } catch (const std::exception& e) {
    console->error(e.what());
  }
  return kFailed;
}

// The command the user got to.
const CLI::App& reached_command(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

// What is wrong with the words, where CLI11's own sentence would be less clear.
std::string usage_complaint(const CLI::App& reached, const CLI::ParseError& error) {
  const auto meant = [](const std::string& word, const std::vector<std::string>& words) {
    const auto near = near_words(word, words, 1, 1 + word.size() / 4);
    return near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near.front());
  };
  std::vector<std::string> commands, options;
  for (const CLI::App* command : reached.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  for (const CLI::Option* option : reached.get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  const std::vector<std::string> left = reached.remaining(true);
  for (const std::string& word : left)
    if (word.starts_with("-") && word.size() > 1)
      return fmt::format("there is no option '{}'{}", word, meant(word.substr(0, word.find('=')), options));
  if (!commands.empty())
    return left.empty() ? "a command is missing"
                        : fmt::format("there is no command '{}'{}", left.front(), meant(left.front(), commands));
  if (!left.empty()) return fmt::format("'{}' is one argument too many", left.front());
  return error.what();
}

}  // namespace

int run_command_line(int argc, char** argv) {
  install_signal_handlers();
  if (asks_for_devices(argc, argv)) return list_devices_command();

  CLI::App app("photo texture for UAV meshes, by graphics-pipeline visibility", "gpvc");
  app.formatter(std::make_shared<HelpFormatter>());
  app.require_subcommand(1);
  app.set_help_flag("-h,--help", "Print this help and end")->group(kCommonGroup);
  app.set_version_flag("--version", "gpvc " + program_version())
      ->description("Print the version and end")
      ->group(kCommonGroup);
  app.footer(
      std::string("Try 'gpvc COMMAND --help' for a command's options. --device list prints the EGL devices.\n\n") +
      kExitStatus);

  TextureOptions texture;
  VisibilityCommandOptions visibility;
  EvaluateCommandOptions evaluate;
  SynthOptions city = synth_defaults(SynthKind::city), terrain = synth_defaults(SynthKind::terrain),
               slits = synth_defaults(SynthKind::slits);
  CLI::App* texture_app = add_texture(app, texture);
  CLI::App* visibility_app = add_visibility_command(app, visibility);
  CLI::App* evaluate_app = add_evaluate(app, evaluate);
  compare::CompareOptions compare;
  CLI::App* compare_app = compare::add_compare(app, compare);
  LabelOptions label;
  CLI::App* label_app = add_label(app, label);
  InspectOptions inspect;
  CLI::App* inspect_app = add_inspect(app, inspect);
  ConvertOptions convert;
  CLI::App* convert_app = add_convert(app, convert);
  CLI::App* synth_app = app.add_subcommand("synth", "make a synthetic scene of known truth");
  synth_app->require_subcommand(1);
  synth_app->set_help_flag("-h,--help", "Print this help and end")->group(kCommonGroup);
  const std::vector<std::pair<CLI::App*, SynthOptions*>> synths{{add_synth(*synth_app, city), &city},
                                                                {add_synth(*synth_app, terrain), &terrain},
                                                                {add_synth(*synth_app, slits), &slits}};

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {  // --help, --version
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    const CLI::App& reached = reached_command(app);
    std::fprintf(stderr, "gpvc: error: %s\nTry '%s --help'.\n", usage_complaint(reached, e).c_str(),
                 full_name(reached).c_str());
    return kBadUsage;
  }
  const std::vector<std::string> given(argv, argv + argc);
  for (CommonOptions* common :
       {&texture.common, &visibility.common, &evaluate.common, &compare.texture.common, &label.common, &inspect.common,
        &convert.common, &city.common, &terrain.common, &slits.common})
    common->command_line = given;
  if (texture_app->parsed())
    return run_guarded(texture.common, [&](Console& console) { run_texture(texture, console); });
  if (visibility_app->parsed())
    return run_guarded(visibility.common, [&](Console& console) { run_visibility(visibility, console); });
  if (evaluate_app->parsed())
    return run_guarded(evaluate.common, [&](Console& console) { run_evaluate(evaluate, console); });
  if (compare_app->parsed())
    return run_guarded(compare.texture.common, [&](Console& console) { compare::run_compare(compare, console); });
  if (label_app->parsed()) return run_guarded(label.common, [&](Console& console) { run_label(label, console); });
  if (inspect_app->parsed()) {
    inspect.with_mesh = !inspect.input.mesh.empty();
    return run_guarded(inspect.common, [&](Console& console) { run_inspect(inspect, console); });
  }
  if (convert_app->parsed())
    return run_guarded(convert.common, [&](Console& console) { run_convert(convert, console); });
  for (const auto& [synth, options] : synths)
    if (synth->parsed()) {
      const SynthOptions& asked = *options;
      return run_guarded(asked.common, [&asked](Console& console) { run_synth(asked, console); });
    }
  return kBadUsage;
}

}  // namespace gpvc::cli
