#include "app/cli/command_options.h"

#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"
#include "io/mesh.h"

namespace gpvc::cli {

CLI::App* add_visibility_command(CLI::App& parent, VisibilityCommandOptions& options) {
  CLI::App* app = parent.add_subcommand("visibility", "say which faces of a mesh each photo sees");
  add_scene(*app, options.input);
  const auto take_meshes = [&input = options.input](const std::vector<std::string>& files) {
    input.mesh = files.front();
    input.more_meshes.assign(files.begin() + 1, files.end());
  };
  app->add_option_function<std::vector<std::string>>(
         "MESH...", take_meshes,
         "Triangle meshes (PLY, OBJ, STL, OFF, GLB, glTF) in the cameras' coordinates, which occlude one another")
      ->required();
  add_photos(*app, options.input);
  add_output(*app, options);
  OptionGroup{*app, pipeline::kOutput}.flag(
      "--ivm", options.ivm,
      "Also write ivm/NAME.npy: per pixel the face there, 0xFFFFFFFF for none; exact for gpvc, else as drawn");
  add_settings(*app, options.visibility);
  OptionGroup{*app, pipeline::kResearch}
      .number(
          "--oracle-check", options.oracle_check, 1, 1000000, "N",
          "Compare N views, drawn at random but always the same, with a brute-force oracle that shares no code with "
          "the rest; fails where gpvc with the exact correction is wrong")
      ->default_str("");
  add_common(*app, options.common, R"(Example:
  gpvc visibility colmap/sparse/0 mesh.ply --images photos -o seen --ivm

Writes to OUT: visibility/NAME.npy (uint8 per face: 0 hidden, 1 partial, 2 full,
3 unresolved), views.json, run.json; prints a line of figures per view. With several
meshes, writes visibility/0/NAME.npy, visibility/1/NAME.npy and so on; in ivm/NAME.npy the
faces are numbered from mesh to mesh. --oracle-check adds oracle.json.

)");
  return app;
}

CLI::App* add_evaluate(CLI::App& parent, EvaluateCommandOptions& options) {
  CLI::App* app = parent.add_subcommand("evaluate", "compare renders of a textured model with photos");
  app->add_option("MODEL", options.model, "Textured model of any program: OBJ, GLB, glTF, or PLY with TextureFile")
      ->required();
  app->add_option("SCENE", options.input.scene, "Scene whose photos the renders are compared with, as texture takes it")
      ->required();
  const OptionGroup input{*app, pipeline::kInput}, output{*app, pipeline::kOutput};
  input.add("--mesh", options.input.mesh, "MESH", "Mesh that was to be textured, to measure completeness")
      ->default_str("the model's own faces");
  add_mesh_crs(
      input, options.input,
      "Reference system of MESH, and of MODEL unless it fits the cameras as it is, where cameras are in another");
  input.add("--images", options.input.images_dir, "DIR", "Folder of the photos")
      ->default_str("where the scene says, or 'images' beside it");
  add_masks(*app, options.input);
  add_bands(*app, options.input);
  add_skipping(*app, options.input);
  input.add("--views", options.input.views, "LIST", "Only these views: names or globs, separated by commas")
      ->check(not_empty())
      ->default_str("those that views.json beside MODEL marks as held out, else all");
  input.add("--exclude-views", options.input.exclude_views, "LIST", "Not these views");
  input.add(
      "--truth", options.truth, "DIR",
      "Folder of the synthetic scene (gpvc synth) that MODEL was textured from: print the share of the surfaces in "
      "photos that is textured, and the share that has another surface's colour");
  input.number("--reduction", options.reduction, 1, 64, "N", "Compare at 1/N of the photos' size, 1 to 64");
  output
      .add("-o,--output", options.out, "OUT",
           "Folder for photo, render and error side by side, evaluate.json and run.json")
      ->check(not_empty());
  output.flag("--force", options.force, "Replace an earlier result in OUT");
  add_common(*app, options.common, R"(Example, with views that the texture was made without:
  gpvc texture colmap mesh.ply -o out --hold-out 6
  gpvc evaluate out/model.obj colmap --mesh mesh.ply -o scores
A synthetic scene against its truth:
  gpvc evaluate out/model.obj city/colmap --truth city

Virtual rephotography (Waechter et al. 2017): completeness; PSNR and mean CIEDE2000 after one
gain per channel, as photos differ in exposure and a model has but one; SSIM and 1 - NCC; without
the gain PSNR and CIEDE2000, its mean and what 95 % of the pixels stay below: per view and on
average. With --truth, photos are compared only if --views or -o is given. A surface point counts
as seen if it is visible, at least 2 pixels from any other surface, in a photo that views.json
beside MODEL marks as used (in any photo if there is no such file). A texel is wrong if it differs
by 16 grey levels from the colours that those photos show around the point and is nearer to the
colour of another surface in one of them; it is unexplained if it differs as much but is near no
such colour. The last line says how far brightness and tint are off in squares of a twentieth
of the ground, once one gain for the whole model is removed.

)");
  return app;
}

CLI::App* add_label(CLI::App& parent, LabelOptions& options) {
  CLI::App* app = parent.add_subcommand("label", "choose a view per face from stored costs");
  app->add_option("COSTS", options.costs,
                  "Folder with counts.npy, views.npy and costs.npy, or mvs-texturing's sparse table (.spt)")
      ->required();
  add_mesh(*app, options.mesh)->required();
  add_output(*app, options);
  add_settings(*app, options.settings, [](const pipeline::OptionInfo& info) {
    return info.name == std::string_view("smoothness") || info.name == std::string_view("edge-weights");
  });
  OptionGroup{*app, pipeline::kResearch}.number(
      "--sweeps", options.settings.solver.max_sweeps, 1, 1000, "N",
      "Sweeps over all labels at most; stops earlier once none lowers the energy");
  app->add_flag_callback(
         "--fast", [&options] { options.settings.solver.thorough = false; },
         "Search near borders between views alone, as gpvc texture does: several times as fast, for an energy that is "
         "up to 0.2 % higher")
      ->group(pipeline::kResearch);
  add_common(*app, options.common,
             R"(COSTS as a folder: counts.npy (uint32 per face: number of candidates), then views.npy (uint32) and
costs.npy (float32; 0 is best), candidate after candidate in face order, views ascending within a
face.

Writes labels.npy (int32 per face: its view, -1 without candidates) and run.json to OUT; prints
the energy: the sum of the chosen costs and of the smoothness over adjacent faces that differ.

)");
  return app;
}

CLI::App* add_inspect(CLI::App& parent, InspectOptions& options) {
  CLI::App* app = parent.add_subcommand("inspect", "print what a scene and a mesh contain");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh);
  add_photos(*app, options.input);
  app->add_flag("--check", options.check,
                "Look through all photos at the mesh, and print how well each agrees with the others: photos of other "
                "poses, or turned ones, agree no better than chance; whether the mesh is where the photos show it "
                "and the scene's tie points lie; and how blurred, bright and burnt out each photo is");
  app->add_option("--picture", options.picture,
                  "With --check: also write this PNG, the photos that agree least with the others, each beside what "
                  "another one shows of the mesh from the same place; the two are alike where all fits")
      ->type_name("FILE")
      ->check(not_empty());
  app->add_flag("--plan", options.plan,
                "Also print what a job of gpvc tiles would take: units, memory, core hours, disk, and photos read");
  const auto take_place = [&at = options.at](const std::vector<double>& p) { at = {p[0], p[1], p[2]}; };
  app->add_option_function<std::vector<double>>("--at", take_place,
                                                "With a result of gpvc texture in the place of SCENE: only print which "
                                                "photo it shows there. In the coordinates "
                                                "of the mesh that was textured")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(in_range(-io::kMostCoordinate, io::kMostCoordinate));
  options.job.tiles.faces_per_tile = tiles::kDefaultTileFaces;
  OptionGroup{*app, ""}.number("--tile-faces", options.job.tiles.faces_per_tile, std::size_t{100},
                               std::size_t{100000000}, "N", "For --plan: most faces of a tile");
  add_common(*app, options.common, "");
  return app;
}

}  // namespace gpvc::cli
