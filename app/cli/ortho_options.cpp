// The options of gpvc ortho.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"

namespace gpvc::cli {
namespace {

// What textures a mesh and is not about the files of a model.
bool is_for_ortho(const pipeline::OptionInfo& info) {
  const std::string_view name = info.name;
  const bool of_files =
      name == "texture" || name == "quality" || name == "band-format" || name == "lit" || name == "up";
  return !of_files && options_for(pipeline::For::one_process)(info);
}

}  // namespace

CLI::App* add_ortho(CLI::App& parent, OrthoCommandOptions& options) {
  CLI::App* app = parent.add_subcommand("ortho", "draw a true orthophoto: a textured mesh straight from above");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->needs(app->get_option("SCENE"));
  app->get_option("SCENE")->required(false);
  add_photos(*app, options.input);
  OptionGroup{*app, pipeline::kInput}
      .add("--from", options.from, "DIR",
           "Draw a model that is textured already: the result of gpvc texture in DIR, tiles that gpvc unit has made, "
           "or a "
           "textured model of any program (OBJ, GLB, glTF, PLY), whose reference system --mesh-crs may name. SCENE and "
           "MESH "
           "are not needed then")
      ->check(not_empty());
  add_rules(*app, options.allow);
  add_output(*app, options);
  add_settings(*app, options.ortho);
  add_settings(*app, options.settings, is_for_ortho);
  add_common(*app, options.common, R"(Examples:
  gpvc ortho SCENE MESH --images PHOTOS --gsd 0.05 -o ortho
  gpvc ortho --from textured --gsd 0.05 -o ortho --crs EPSG:25832
  gpvc ortho --from textured -o ortho --bounds 448100,5411200,448300,5411400 --compress jpeg

Writes to OUT cloud-optimized GeoTIFFs with overviews:
  ortho.tif         red, green, blue, with an internal mask of the pixels that show something
  ortho_height.tif  the surface's height in the middle of each pixel (32-bit float, -9999: none)
  ortho_photo.tif   the number of the photo shown there (65535: none); ortho_photos.csv names them
  ortho_bands.tif   all bands, with their values, of a scene that has some
and run.json. A pixel is the mean of what lies in it and is seen straight from above: walls do not show,
and roofs lie where they stand. Its corners are multiples of the pixel size. Where no photo shows the
surface, the orthophoto shows nothing (--unseen fill: the colours around), but has its height.

)" + std::string(kRulesHelp));
  return app;
}

}  // namespace gpvc::cli
