// The options of gpvc tiles, unit and plan.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"

namespace gpvc::cli {
namespace {

void add_job(CLI::App& app, std::filesystem::path& job) {
  app.add_option("JOB", job, "Folder that gpvc tiles has made")
      ->required()
      ->check(not_empty())
      ->group(pipeline::kInput);
}

}  // namespace

CLI::App* add_tiles(CLI::App& parent, TilesOptions& options) {
  CLI::App* app = parent.add_subcommand("tiles", "cut a scene into a job of units, for a cluster or a small memory");
  options.settings.tiles.faces_per_tile = tiles::kDefaultTileFaces;
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  OptionGroup{*app, pipeline::kResearch}.add("--hold-out", options.input.hold_out, "K|LIST",
                                             "Texture without every K-th photo, or without these (names or globs)");
  add_output(*app, options);
  add_rules(*app, options.allow);
  add_settings(*app, options.settings, options_for(pipeline::For::all));
  add_earlier_names(*app, options.settings.texture, options.common);
  add_common(*app, options.common, R"(Examples:
  gpvc tiles colmap mesh.ply -o job && gpvc unit job --all --memory 6G
  gpvc tiles colmap mesh.ply -o job && snakemake -s app/workflow/Snakefile --config job=job --profile ...
  gpvc tiles colmap mesh.ply -o job && gpvc plan job --sbatch > job.sh && bash job.sh

Writes to JOB: plan.json (the units, with what they wait for and what they take), job.json, mesh/, views.json, run.json.
The units write JOB/units/NAME/ and the result: JOB/result/tileset.json, index.html, tiles/LEVEL_N.glb and, for
level 0, obj/N/model.obj with its pages, offset.txt and metadata.xml, as gpvc texture writes them.
All tiles have one labeling and one leveling: seams along their borders are as those inside.

)" + std::string(kRulesHelp));
  return app;
}

CLI::App* add_unit(CLI::App& parent, UnitOptions& options) {
  CLI::App* app = parent.add_subcommand("unit", "run units of a job that gpvc tiles has made");
  add_job(*app, options.job);
  app->add_option("UNIT", options.names, "Names of units, as in plan.json")->group(pipeline::kInput);
  OptionGroup{*app, pipeline::kInput}.flag("--all", options.all, "All units that are not complete, one after another");
  OptionGroup{*app, pipeline::kOutput}.flag(
      "--clean", options.clean,
      "With --all: once the result is complete, remove what units have left for each "
      "other (JOB/units); a later --all then runs all of them again");
  add_settings(*app, options.limits, [](const pipeline::OptionInfo& info) {
    return info.is_amount() && info.affects == pipeline::Affects::nothing;
  });
  add_common(*app, options.common, R"(Examples:
  gpvc unit job see-0-3 --threads 4 --memory 2G
  gpvc unit job --all --clean

A unit that is complete, and whose input is unchanged, is not run again. It may run on any machine that sees
JOB and the photos under the same names.

)");
  return app;
}

CLI::App* add_plan(CLI::App& parent, PlanOptions& options) {
  CLI::App* app = parent.add_subcommand("plan", "show what a job takes, or print it for Slurm");
  add_job(*app, options.job);
  OptionGroup{*app, pipeline::kOutput}.flag(
      "--sbatch", options.sbatch,
      "Print a shell script that submits all units to Slurm as job arrays, each after the one before");
  add_common(*app, options.common, R"(Examples:
  gpvc plan job
  gpvc plan job --sbatch > job.sh && bash job.sh --partition=long

)");
  return app;
}

}  // namespace gpvc::cli
