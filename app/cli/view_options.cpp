// The options of gpvc view.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {

CLI::App* add_view(CLI::App& parent, ViewOptions& options) {
  CLI::App* app =
      parent.add_subcommand("view", "look at a result in the browser, ask which photo is where, and change it");
  app->add_option("RESULT", options.result,
                  "What to look at: the folder of a result of gpvc texture or gpvc compare, or a textured model of any "
                  "program (OBJ, GLB, glTF, PLY, or the folder of a tileset)")
      ->required()
      ->check(not_empty());
  add_scene(*app, options.input);
  app->get_option("SCENE")->required(false);
  add_mesh(*app, options.input.mesh)->needs(app->get_option("SCENE"));
  app->get_option("SCENE")->needs(app->get_option("MESH"));
  add_photos(*app, options.input);
  const OptionGroup input{*app, pipeline::kInput}, output{*app, pipeline::kOutput};
  input.add("--beside", options.beside, "RESULT", "A second result of the same scene, on the other side of a slider")
      ->check(not_empty());
  output.number("--port", options.port, 0, 65535, "N", "Port of 127.0.0.1; 0: one that is free");
  output.flag("--no-browser", options.no_browser, "Print the address, and leave opening it to you");
  output
      .add("--export", options.export_to, "DIR",
           "Write the page to DIR as files for any web server, without questions and changes, and end")
      ->check(not_empty());
  output.flag("--force", options.force, "Write into DIR although there are files in it");
  add_common(*app, options.common, R"(Examples:
  gpvc view textured
  gpvc view textured SCENE MESH --images PHOTOS
  gpvc view textured --beside textured_other
  gpvc view textured --export page

Serves one page on this machine alone, under an address that nobody else knows, until Ctrl-C or until
the page is closed. A click says where a point lies, which photo is shown there and what the others show,
or why they do not. SCENE and MESH are those that the result was made from, unless they are given.
Results of gpvc texture --editable can be changed: faces are marked, photos forbidden or required
there, and Apply makes the result anew where that matters. The rules are kept in RESULT/rules.json, in
the format of --allow.
)");
  return app;
}

}  // namespace gpvc::cli
