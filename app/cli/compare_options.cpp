#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

CLI::Option* add_count(CLI::App& app, const std::string& name, int& count, int least, int most,
                       const std::string& text) {
  return app.add_option(name, count, text)
      ->type_name("N")
      ->check(in_range(least, most))
      ->default_str(std::to_string(count));
}

void add_compared(CLI::App& app, CompareOptions& options) {
  const std::string before = app.option_defaults()->get_group();
  app.option_defaults()->group("Comparison");
  app.add_option("--modes", options.modes,
                 "Visibility modes, separated by commas, as texture's --visibility takes them; gpvc:uncorrected "
                 "and gpvc:paper (coverage correction off, LPCC alone); shadow-map and ray modes without an "
                 "epsilon run once per --eps")
      ->type_name("LIST")
      ->default_str(compare::default_modes());
  app.add_option("--eps", options.epsilons, "Epsilons of the modes that have a bias, separated by commas")
      ->type_name("LIST")
      ->delimiter(',')
      ->check(in_range(1e-300, 1e300))
      ->default_str("powers of ten that suit the scene's depths, for each mode");
  app.add_option("--external", options.externals,
                 "Another program's textured model of the same mesh, OBJ, GLB or glTF, scored and shown beside "
                 "ours; may be given several times")
      ->type_name("NAME=MODEL");
  app.add_option("--hold-out", options.input.hold_out,
                 "Leave views out of all texturing and score on them: every K-th, or names and globs")
      ->type_name("K|LIST");
  app.add_option("--truth", options.settings.truth, "Folder of a synthetic scene, with surfaces.json")
      ->type_name("DIR")
      ->default_str("SCENE's parent, where it holds one");
  add_count(app, "--oracle-views", options.settings.oracle_views, 0, 1000000,
            "Views, drawn at random but always the same, in which classes are compared with the exact oracle's; 0 is "
            "none");
  add_count(app, "--score-views", options.settings.score_views, 1, 1000000,
            "Views scored at most if none is held out, spread evenly");
  app.add_option("--reduction", options.reduction, "Score at 1/N of the size that was textured from, 1 to 64")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str("4 without --downscale, so a quarter of the photos");
  add_count(app, "--crops", options.settings.crops, 0, 40, "Places to show, where the models differ most, 0 to 40");
  app.add_option("--summarize", options.summarize,
                 "Instead of SCENE and MESH: report.json files of several scenes, into one summary")
      ->type_name("REPORT...");
  app.option_defaults()->group(before);
}

}  // namespace

CLI::App* add_compare(CLI::App& parent, CompareOptions& options) {
  CLI::App* app = parent.add_subcommand("compare", "texture a scene once per visibility mode and compare");
  app->add_option("SCENE", options.input.scene, "Scene, as texture takes it");
  add_mesh(*app, options.input.mesh);
  add_photos(*app, options.input);
  add_compared(*app, options);
  add_output(*app, options);
  app->add_flag("--keep-models", options.settings.keep_models, "Also write each mode's model, to modes/NAME")
      ->group("Output");
  // A summary only reads reports: options that shape a comparison have no effect on it.
  CLI::Option* summarize = app->get_option("--summarize");
  for (CLI::Option* option : app->get_options()) {
    const bool shapes =
        option->get_group() == "Comparison" || option->get_group() == "Input" || option->check_name("--keep-models");
    if (shapes && option != summarize && !option->get_positional()) summarize->excludes(option);
  }
  add_common(*app, options.common,
             "Examples:\n"
             "  gpvc compare colmap/sparse/0 mesh.ply -o compared --hold-out 8\n"
             "  gpvc compare colmap mesh.ply -o compared --modes none,shadow-map:spc,gpvc --eps 1e-3\n"
             "  gpvc compare colmap mesh.ply -o compared --external mvs=mvs/model.obj\n"
             "  gpvc compare --summarize city/report.json slits/report.json -o summary\n\n"
             "Writes to OUT: report.html (one page with its pictures, needs no network), report.md,\n"
             "report.json, run.json. --summarize writes summary.html, summary.md, summary.json.\n\n");
  return app;
}

}  // namespace gpvc::cli
