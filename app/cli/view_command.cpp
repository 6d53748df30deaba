// gpvc view: a result in the browser, with questions about it and changes.
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "app/cli/earlier_run.h"
#include "app/cli/interrupt.h"
#include "app/cli/scene_input.h"
#include "app/pipeline/judgement.h"
#include "app/pipeline/viewpoint.h"
#include "app/view/page_files.h"
#include "app/view/server.h"
#include "app/view/session.h"
#include "app/view/tileset_files.h"
#include "io/file_bytes.h"
#include "io/paths.h"
#include "io/photos.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRulesFile = "rules.json";

// Says nothing, since several questions may be answered at a time.
class Silent final : public results::Observer {
 public:
  void check_cancelled() override { throw_if_interrupted(); }
};

// The scene of a result, held as long as questions are asked.
struct OpenScene {
  SceneInputData data;
  checks::Input input;
  pipeline::Settings settings;
  io::PhotoCache photos;
  Silent silent;
  pipeline::Run run;

  OpenScene(SceneInputData read, const pipeline::Settings& with)
      : data(std::move(read)),
        input(data.input()),
        settings(with),
        photos(data.scene),
        run{input, settings, photos, silent} {}

  view::SceneSide side(const fs::path& result, RunRecord* record) {
    view::SceneSide side{&run, nullptr, {}};
    if (io::is_file(result / "edit-model.bin")) try {
        side.judgement = std::make_shared<const pipeline::Judgement>(pipeline::read_judgement(result, run));
        side.allowed = pipeline::allowed_views(side.judgement->rules, data.mesh, data.scene.views.size(), silent);
      } catch (const InputError& e) {
        if (record) record->warning(e.what());
      }
    return side;
  }
};

std::string name_of(const fs::path& result) {
  const fs::path path = fs::absolute(result).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

// What to look at: a result, or each mode of a comparison; none for a tileset.
std::vector<view::NamedResult> results_in(const ViewOptions& options) {
  std::vector<view::NamedResult> results;
  for (const fs::path& given : {options.result, options.beside}) {
    if (given.empty()) continue;
    if (given == options.result && view::is_tileset(given)) return {};
    if (io::is_file(given / "report.json"))
      for (const fs::path& mode : results_of_comparison(given)) results.push_back({mode.filename().string(), mode});
    else
      results.push_back({name_of(given), given});
  }
  if (results.empty())
    throw InputError(options.result, "", "is a comparison without models: gpvc compare --keep-models keeps them");
  return results;
}

// Opens the address in the browser that the desktop has; false where there is none.
bool open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return false;
  std::string program = "xdg-open", argument = address;
  char* words[] = {program.data(), argument.data(), nullptr};
  pid_t process = 0;
  if (posix_spawnp(&process, program.c_str(), nullptr, nullptr, words, environ) != 0) return false;
  int status = 0;
  return waitpid(process, &status, 0) == process && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// Until Ctrl-C or the page's end. True after a signal.
void serve(view::Server& server, const ViewOptions& options, Console& console) {
  console.result(server.address());
  if (!options.no_browser && !open_browser(server.address()))
    console.note("no browser could be opened here: open the address above in one on this machine");
  console.note("Ctrl-C ends it, and so does closing the page");
  server.run([] {
    try {
      throw_if_interrupted();
      return false;
    } catch (const Cancelled&) {
      return true;
    }
  });
}

view::Changing changing(const ViewOptions& options, const EarlierRun& earlier, OpenScene& scene, Console& console) {
  view::Changing changing{options.result / kRulesFile, earlier.options.allow, {}, {}};
  TextureOptions again = earlier.options;
  again.input = scene_of(options, earlier);
  again.from = again.out = options.result;
  again.force = true;
  changing.apply = [again, earlier, &console](const fs::path& rules, results::Observer& observer) mutable {
    again.allow = rules;
    again.common.command_line = words_to_change(earlier, again.from, rules);
    run_texture(again, console, &observer);
  };
  changing.reopened = [&scene, result = options.result] { return scene.side(result, nullptr); };
  return changing;
}

void write_export(view::Session& session, const ViewOptions& options, Console& console) {
  std::error_code ignored;
  if (!options.force && fs::exists(options.export_to, ignored) && !fs::is_empty(options.export_to, ignored))
    throw OutputError(options.export_to, "holds files already; --force writes beside them");
  session.write_to(options.export_to);
  console.result((options.export_to / "index.html").string());
}

}  // namespace

void run_view(const ViewOptions& options, Console& console) {
  if (view::page_files().empty())
    throw Error(
        "the page is not part of this program: node, npm or its packages were missing when it was built (Debian: "
        "app/setup/install_packages.sh view, then configure and build again)");
  RunRecord record(console);
  results::OutputFolder::finish_interrupted(options.result);
  view::SessionInput input;
  input.results = results_in(options);
  if (input.results.empty()) input.tileset = options.result;
  fs::path first = input.results.empty() ? options.result : input.results.front().folder;
  std::error_code none;
  const bool is_folder = fs::is_directory(options.result, none);
  const std::optional<EarlierRun> earlier = earlier_run(is_folder ? options.result : options.result.parent_path());
  if (!is_folder) first = first.parent_path();
  std::optional<OpenScene> scene;
  if (const SceneInput from = scene_of(options, earlier.value_or(EarlierRun{})); has_files(from)) {
    scene.emplace(read_scene_input(from, record), earlier ? earlier->options.settings : pipeline::Settings{});
    input.scene = scene->side(first, &record);
    for (const View& view : scene->data.scene.views) input.photos.push_back(view.name);
    input.up = pipeline::up_direction(scene->data.scene, scene->data.used);
  } else {
    input.photos = listed_views(first / "model.obj");
    if (earlier)
      console.note("its scene, mesh or photos are not where they were: SCENE and MESH say where they are now");
  }
  if (scene && earlier && earlier->changes && is_folder && input.scene->judgement && options.export_to.empty())
    input.changing = changing(options, *earlier, *scene, console);
  record.begin({"model"});
  std::optional<view::Server> server;
  view::Session session(std::move(input), [&server](const std::string& event, const std::string& data) {
    if (server) server->tell(event, data);
  });
  record.end("");
  if (!options.export_to.empty()) return write_export(session, options, console);
  view::ServerOptions serving;
  serving.port = options.port;
  server.emplace([&session](const view::Request& request) { return session.answer(request); }, serving);
  serve(*server, options, console);
}

}  // namespace gpvc::cli
