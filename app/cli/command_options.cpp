#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

// One or several meshes that occlude one another.
void add_meshes(CLI::App& app, SceneInput& input) {
  const auto take = [&input](const std::vector<std::string>& files) {
    input.mesh = files.front();
    input.more_meshes.assign(files.begin() + 1, files.end());
  };
  app.add_option_function<std::vector<std::string>>(
         "MESH...", take, "Triangle mesh in the cameras' frame, PLY or OBJ; several hide one another")
      ->required();
}

}  // namespace

CLI::App* add_visibility_command(CLI::App& parent, VisibilityCommandOptions& options) {
  CLI::App* app = parent.add_subcommand("visibility", "say which faces of a mesh each photo sees");
  add_scene(*app, options.input);
  add_meshes(*app, options.input);
  add_photos(*app, options.input);
  add_masks(*app, options.input);
  add_output(*app, options.out, options.force);
  app->add_flag("--ivm", options.ivm,
                "Also write ivm/NAME.npy: per pixel the face drawn there, before any correction, 0xFFFFFFFF for none")
      ->group("Output");
  add_visibility(*app, options.visibility);
  app->add_option("--oracle-check", options.oracle_check,
                  "Compare N views, drawn at random but always the same, with a brute-force oracle that "
                  "shares no code with the rest; fails where gpvc with the exact correction is wrong")
      ->type_name("N")
      ->check(in_range(1, 1000000))
      ->group("Visibility");
  add_common(*app, options.common);
  app->footer(std::string("Example:\n"
                          "  gpvc visibility colmap/sparse/0 mesh.ply --images photos -o seen --ivm\n\n"
                          "Writes to OUT: visibility/NAME.npy (uint8 per face: 0 hidden, 1 partial, 2 full,\n"
                          "3 unresolved), views.json, run.json; prints a line of figures per view. With\n"
                          "several meshes visibility/0/NAME.npy, visibility/1/NAME.npy and so on; the faces\n"
                          "of ivm/NAME.npy follow one another. --oracle-check adds oracle.json.\n\n") +
              kExitStatus);
  return app;
}

CLI::App* add_evaluate(CLI::App& parent, EvaluateCommandOptions& options) {
  constexpr const char* kGroup = "Input";
  CLI::App* app = parent.add_subcommand("evaluate", "compare renders of a textured model with photos");
  app->add_option("MODEL", options.model, "Textured model of any program, OBJ or GLB")->required();
  app->add_option("SCENE", options.input.scene, "Scene whose photos the renders are compared with, as texture takes it")
      ->required();
  app->add_option("--mesh", options.input.mesh, "Mesh that was to be textured, for completeness")
      ->type_name("MESH")
      ->default_str("the model's own faces")
      ->group(kGroup);
  app->add_option("--images", options.input.images_dir, "Folder of the photos")
      ->type_name("DIR")
      ->default_str("where the scene says, or 'images' beside it")
      ->group(kGroup);
  add_masks(*app, options.input);
  app->add_option("--views", options.input.views, "Only these views: names or globs, separated by commas")
      ->check(not_empty())
      ->type_name("LIST")
      ->default_str("those that views.json beside MODEL marks as held out, else all")
      ->group(kGroup);
  app->add_option("--truth", options.truth,
                  "Folder of the synthetic scene (gpvc synth) that MODEL was textured from: print which share "
                  "of the surfaces photos see is textured, and which carries another surface's colour")
      ->type_name("DIR")
      ->group(kGroup);
  app->add_option("--reduction", options.reduction, "Compare at 1/N of the photos' size, 1 to 64")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str("4")
      ->group(kGroup);
  app->add_option("-o,--output", options.out,
                  "Folder for photo, render and error side by side, evaluate.json and run.json")
      ->type_name("OUT")
      ->check(not_empty())
      ->group("Output");
  app->add_flag("--force", options.force, "Replace an earlier result in OUT")->group("Output");
  add_common(*app, options.common);
  app->footer(
      std::string(
          "Example, with views the texture was made without:\n"
          "  gpvc texture colmap mesh.ply -o out --hold-out 6\n"
          "  gpvc evaluate out/model.obj colmap --mesh mesh.ply -o scores\n"
          "A synthetic scene against its truth:\n"
          "  gpvc evaluate out/model.obj city/colmap --truth city\n\n"
          "Virtual rephotography (Waechter et al. 2017): completeness, PSNR after one gain per\n"
          "channel, SSIM, and 1 - NCC, per view and in the mean. With --truth, photos are compared only\n"
          "when --views or -o is given; seen is what shows in a photo that views.json beside MODEL\n"
          "marks as used (all photos where there is none), clear of other surfaces by 2 pixels. A texel\n"
          "is wrong when it is 16 grey levels off the colours such photos show around the point and\n"
          "nearer to one that a photo shows there of another surface; unexplained when off and near none.\n\n") +
      kExitStatus);
  return app;
}

CLI::App* add_label(CLI::App& parent, LabelOptions& options) {
  CLI::App* app = parent.add_subcommand("label", "choose a view per face from stored costs");
  app->add_option("COSTS", options.costs,
                  "Folder with counts.npy, views.npy and costs.npy, or mvs-texturing's sparse table (.spt)")
      ->required();
  add_mesh(*app, options.mesh)->required();
  add_output(*app, options.out, options.force);
  app->add_option("--smoothness", options.solver.smoothness,
                  "Price of two neighbouring faces with different views; 0 and up")
      ->type_name("X")
      ->check(in_range(0.0, 1e6))
      ->default_str(fmt::format("{}", labeling::SolverOptions{}.smoothness))
      ->group("View selection");
  add_edge_weights(*app, options.edge_weights);
  app->add_option("--sweeps", options.solver.max_sweeps, "Sweeps over all labels at most; it stops where none helps")
      ->type_name("N")
      ->check(in_range(1, 1000))
      ->default_str(std::to_string(labeling::SolverOptions{}.max_sweeps))
      ->group("View selection");
  add_common(*app, options.common);
  app->footer(
      std::string("COSTS as a folder: counts.npy (uint32 per face: how many candidates), then views.npy (uint32) "
                  "and\n"
                  "costs.npy (float32, from 0, which is best), candidate after candidate in face order, views\n"
                  "ascending within a face.\n\n"
                  "Writes labels.npy (int32 per face: its view, -1 without candidates) and run.json to OUT; prints "
                  "the\n"
                  "energy: the sum of the chosen costs and of the smoothness over differing neighbours.\n\n") +
      kExitStatus);
  return app;
}

CLI::App* add_inspect(CLI::App& parent, InspectOptions& options) {
  CLI::App* app = parent.add_subcommand("inspect", "print what is understood of a scene and a mesh");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh);
  add_photos(*app, options.input);
  add_masks(*app, options.input);
  add_common(*app, options.common);
  app->footer(kExitStatus);
  return app;
}

}  // namespace gpvc::cli
