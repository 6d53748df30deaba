// The options of gpvc compare.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

void add_compared(CLI::App& app, CompareOptions& options) {
  const OptionGroup group{app, "Comparison"};
  compare::CompareSettings& settings = options.settings;
  group
      .add("--modes", options.modes, "LIST",
           "Visibility modes, separated by commas, as texture's --visibility takes them; gpvc:uncorrected and "
           "gpvc:paper (coverage correction off, LPCC alone); shadow-map and ray modes without an epsilon run once per "
           "--eps")
      ->default_str(compare::default_modes());
  group.add("--eps", options.epsilons, "LIST", "Epsilons of the modes that have a bias, separated by commas")
      ->delimiter(',')
      ->check(in_range(1e-300, 1e300))
      ->default_str("powers of ten that suit the scene's depths, for each mode");
  group.add("--external", options.externals, "NAME=MODEL",
            "Another program's textured model of the same mesh, in its coordinates or the cameras', OBJ, PLY, GLB or "
            "glTF, scored and shown beside ours; may be given several times");
  group.add("--hold-out", options.input.hold_out, "K|LIST",
            "Leave views out of all texturing and score on them: every K-th photo, or names and globs");
  group.add("--truth", settings.truth, "DIR", "Folder of a synthetic scene, with surfaces.json")
      ->default_str("SCENE's parent, where it holds one");
  group.number(
      "--oracle-views", settings.oracle_views, 0, 1000000, "N",
      "Views, drawn at random but always the same, in which classes are compared with the exact oracle's; 0 is "
      "none");
  group.number("--score-views", settings.score_views, 1, 1000000, "N",
               "Views scored at most if none is held out, spread evenly");
  group.add("--reduction", options.reduction, "N", "Score at 1/N of the size that was textured from, 1 to 64")
      ->check(in_range(1, 64))
      ->default_str("4 without --downscale, so a quarter of the photos");
  group.number("--crops", settings.crops, 0, 40, "N", "Places to show, where the models differ most, 0 to 40");
  group.add("--summarize", options.summarize, "REPORT...",
            "Instead of SCENE and MESH: report.json files of several scenes, into one summary");
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
      ->group(pipeline::kOutput);
  // A summary only reads reports: options that shape a comparison have no effect on it.
  CLI::Option* summarize = app->get_option("--summarize");
  for (CLI::Option* option : app->get_options()) {
    const bool shapes = option->get_group() == "Comparison" || option->get_group() == pipeline::kInput ||
                        option->check_name("--keep-models");
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
