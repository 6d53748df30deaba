// Parses the command line and runs the command it names.
#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <system_error>
#include <type_traits>

#include "app/cli/app.h"
#include "app/cli/command_options.h"
#include "app/cli/help.h"
#include "app/cli/interrupt.h"
#include "app/cli/options.h"
#include "app/cli/usage.h"
#include "visibility/device.h"

namespace gpvc::cli {
namespace {

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

// A file opened as descriptor 0, 1 or 2 would get what is printed.
void open_standard_descriptors() {
  for (int descriptor = 0; descriptor <= 2; ++descriptor)
    if (fcntl(descriptor, F_GETFD) < 0) static_cast<void>(open("/dev/null", O_RDWR));
}

int run_guarded(const CommonOptions& common, const std::function<void(Console&)>& command) {
  std::optional<Console> console;
  try {
    console.emplace(common.loudness(), common.log);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpvc: error: %s\n", results::printable(e.what()).c_str());
    return kFailed;
  }
  try {
    std::optional<tbb::global_control> limit;
    if (common.threads > 0) {
      limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(common.threads));
      setenv("LP_NUM_THREADS", std::to_string(common.threads).c_str(), 0);  // llvmpipe, the software OpenGL
    }
    for (const std::string& note : common.notes) console->note(note);
    command(*console);
    if (console->results_were_lost()) throw std::runtime_error("standard output: cannot be written");
    return 0;
  } catch (const Cancelled&) {
    console->interrupted();
    return kInterrupted;
  } catch (const UsageError& e) {
    console->error(e.what());
    return kBadUsage;
  } catch (const std::bad_alloc&) {
    console->error("out of memory");
  } catch (const std::filesystem::filesystem_error& e) {
    console->error(e.path1().empty() ? std::string(e.what())
                                     : fmt::format("{}: {}", e.path1().string(), e.code().message()));
  } catch (const std::system_error& e) {
    // What std::thread throws does not say so.
    console->error(e.code() == std::errc::resource_unavailable_try_again
                       ? "no further thread could be started: memory or the number of processes is limited; try fewer "
                         "--threads"
                       : e.what());
  } catch (const Error& e) {
    console->error(e.what(), e.cures());
  } catch (const std::exception& e) {
    console->error(e.what());
  }
  return kFailed;
}

// The innermost command that was given.
const CLI::App& reached_command(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

struct Command {
  CLI::App* app;
  CommonOptions* common;
  std::function<void(Console&)> run;
};

template <class Options>
Command command(CLI::App& parent, CLI::App* (*add)(CLI::App&, Options&), void (*run)(const Options&, Console&),
                const std::type_identity_t<Options>& defaults = {}) {
  const auto options = std::make_shared<Options>(defaults);
  return {add(parent, *options), &options->common, [options, run](Console& console) { run(*options, console); }};
}

// Adds every command, in the order of the help.
std::vector<Command> add_commands(CLI::App& app) {
  std::vector<Command> commands{command(app, add_texture, run_texture),
                                command(app, add_tileset, run_tileset),
                                command(app, add_ortho, run_ortho),
                                command(app, add_tiles, run_tiles),
                                command(app, add_unit, run_unit),
                                command(app, add_plan, run_plan),
                                command(app, add_visibility_command, run_visibility),
                                command(app, add_evaluate, run_evaluate),
                                command(app, add_compare, run_compare),
                                command(app, add_label, run_label),
                                command(app, add_inspect, run_inspect),
                                command(app, add_photos_command, run_photos),
                                command(app, add_coverage, run_coverage),
                                command(app, add_view, run_view),
                                command(app, add_convert, run_convert)};
  CLI::App* synth = app.add_subcommand("synth", "make a synthetic scene of known truth");
  synth->require_subcommand(1);
  synth->set_help_flag("-h,--help", "Print this help and end")->group(kCommonGroup);
  for (const SynthKind kind : {SynthKind::city, SynthKind::terrain, SynthKind::slits})
    commands.push_back(command(*synth, add_synth, run_synth, synth_defaults(kind)));
  return commands;
}

}  // namespace

int run_command_line(int argc, char** argv) {
  open_standard_descriptors();
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

  const std::vector<Command> commands = add_commands(app);
  const auto refuse = [](const std::string& complaint, const CLI::App& reached) {
    std::fprintf(stderr, "gpvc: error: %s\nTry '%s --help'.\n", results::printable(complaint).c_str(),
                 full_name(reached).c_str());
    return kBadUsage;
  };
  std::vector<std::string> words = without_help_command({argv, argv + argc});
  if (const auto wrong = wrong_command(app, words)) return refuse(wrong->sentence, *wrong->reached);
  try {
    std::vector<std::string> reversed(words.rbegin(), words.rend() - 1);  // as the parser takes them
    app.parse(std::move(reversed));
  } catch (const CLI::Success& e) {  // --help, --version
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    const CLI::App& reached = reached_command(app);
    return refuse(usage_complaint(reached, e), reached);
  }
  for (const Command& command : commands) {
    if (!command.app->parsed()) continue;
    command.common->command_line.assign(argv, argv + argc);
    return run_guarded(*command.common, command.run);
  }
  return kBadUsage;
}

}  // namespace gpvc::cli
