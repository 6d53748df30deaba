#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

void add_selection(CLI::App& app, TextureOptions& options) {
  constexpr const char* kGroup = "View selection";
  labeling::CostOptions& costs = options.settings.costs;
  add_choice(app, "--data-term", labeling::kDataTermNames, costs.term,
             "What makes a view good for a face: its area in pixels, the image gradient integrated over it, or that "
             "weighted by the viewing angle")
      ->group(kGroup);
  add_choice(app, "--outliers", labeling::kOutliersNames, costs.outliers,
             "Views that disagree in colour with the others (cars, people): keep, make dearer, or drop")
      ->group(kGroup);
  app.add_option("--smoothness", options.settings.solver.smoothness,
                 "Price of two neighbouring faces with different views; 0 and up")
      ->type_name("X")
      ->check(in_range(0.0, 1e6))
      ->default_str(fmt::format("{}", labeling::SolverOptions{}.smoothness))
      ->group(kGroup);
  add_edge_weights(app, options.settings.edge_weights);
  app.add_option("--margin", options.settings.costs.margin_px,
                 "Pixels along silhouettes in which a view costs more, as photo and mesh disagree there; 0 is off")
      ->type_name("PX")
      ->check(in_range(0, 64))
      ->default_str(std::to_string(labeling::CostOptions{}.margin_px))
      ->group(kGroup);
}

void add_density(CLI::App& app, atlas::AtlasOptions& atlas) {
  constexpr const char* kGroup = "Texture";
  app.add_option("--texel-size", atlas.texel_size,
                 "Reduce charts that photos show finer than this, in the mesh's units, to it")
      ->type_name("X")
      ->check(in_range(1e-9, 1e9))
      ->group(kGroup);
  app.add_option("--max-pages", atlas.max_pages, "Reduce all charts alike until so many pages suffice")
      ->type_name("N")
      ->check(in_range(1, 1000000))
      ->group(kGroup);
  app.add_option("--max-texels", atlas.max_texels, "The same until all pages together have no more texels")
      ->type_name("N")
      ->check(in_range(4096.0, 1e15))
      ->group(kGroup);
}

void add_unseen(CLI::App& app, atlas::AtlasOptions& atlas) {
  constexpr const char* kGroup = "Texture";
  add_choice(app, "--unseen", atlas::kUnseenFacesNames, atlas.unseen,
             "Faces that no photo shows: fill takes colours from around them, drop leaves them out of the GLB (the OBJ "
             "keeps every face), color paints them")
      ->group(kGroup);
  const auto take = [&](const std::vector<int>& channels) {
    for (std::size_t c = 0; c < 3; ++c) atlas.unseen_color[c] = static_cast<std::uint8_t>(channels[c]);
  };
  app.add_option_function<std::vector<int>>("--unseen-color", take, "For --unseen color, 0 to 255 each")
      ->type_name("R,G,B")
      ->delimiter(',')
      ->expected(3)
      ->check(in_range(0, 255))
      ->default_str("128,128,128")
      ->group(kGroup);
}

void add_texture_output(CLI::App& app, TextureOptions& options) {
  constexpr const char* kGroup = "Texture";
  atlas::AtlasOptions& atlas = options.settings.atlas;
  pipeline::OutputSettings& output = options.settings.output;
  app.add_option("--page-size", atlas.page_size, "Largest edge of a texture page, 256 to 32768 texels")
      ->type_name("N")
      ->check(in_range(256, 32768))
      ->default_str(std::to_string(atlas::AtlasOptions{}.page_size))
      ->group(kGroup);
  app.add_option("--padding", atlas.padding,
                 "Texels around a chart that carry its colours on, 1 to 64; with 8, mip levels down to an eighth keep "
                 "charts apart, with 4 down to a quarter")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str(std::to_string(atlas::AtlasOptions{}.padding))
      ->group(kGroup);
  add_density(app, atlas);
  add_unseen(app, atlas);
  add_choice(
      app, "--seams", atlas::kSeamLevelingNames, atlas.seams,
      "Levelling of colour across seams: none, one correction per chart and vertex, or that and a blend near the "
      "seam")
      ->group(kGroup);
  add_choice(app, "--texture", io::kImageFormatNames, output.texture,
             "Format of the pages: jpg is what photos were and quick to write and load, png loses nothing more")
      ->group(kGroup);
  app.add_option("--quality", output.quality, "Of jpg pages, 1 to 100")
      ->type_name("N")
      ->check(in_range(1, 100))
      ->default_str("95")
      ->group(kGroup);
  add_choice(
      app, "--gltf", io::kGltfContainerNames, output.gltf,
      "glb: one file, model.glb; files: model.gltf with model.bin and the pages beside it, which is what a model "
      "beyond the 4 GiB of a GLB becomes in any case")
      ->group(kGroup);
  app.add_flag("--normals", output.normals,
               "Write smooth normals too: vn in the OBJ, NORMAL in the GLB; nothing is shaded by default")
      ->group(kGroup);
  constexpr Named<std::optional<io::UpAxis>> kUps[] = {
      {"auto", std::nullopt},    {"+x", io::UpAxis::pos_x}, {"-x", io::UpAxis::neg_x}, {"+y", io::UpAxis::pos_y},
      {"-y", io::UpAxis::neg_y}, {"+z", io::UpAxis::pos_z}, {"-z", io::UpAxis::neg_z}};
  add_choice(app, "--up", kUps, output.up,
             "Axis of the scene that points up in the GLB; auto: away from the cameras' mean viewing direction")
      ->group(kGroup);
}

}  // namespace

CLI::App* add_texture(CLI::App& parent, TextureOptions& options) {
  CLI::App* app = parent.add_subcommand("texture", "texture a triangle mesh from calibrated photos");
  add_scene_input(*app, options.input);
  app->add_option("--hold-out", options.input.hold_out,
                  "Texture without every K-th view, or without these (names or globs), and mark them in "
                  "views.json, so that gpvc evaluate compares with them")
      ->type_name("K|LIST")
      ->group("Input");
  add_output(*app, options.out, options.force);
  add_texture_output(*app, options);
  add_selection(*app, options);
  add_visibility(*app, options.settings.visibility);
  add_common(*app, options.common);
  app->footer(
      std::string("Examples:\n"
                  "  gpvc texture colmap/sparse/0 mesh.ply --images photos -o out\n"
                  "  gpvc texture colmap mesh.ply -o look --downscale 4 --views 'DJI_00[12]*'\n"
                  "  gpvc texture colmap mesh.ply -o out --texture png --page-size 4096 --force\n"
                  "  gpvc texture colmap mesh.ply -o web --max-pages 1 --page-size 4096 --unseen drop\n\n"
                  "Writes to OUT: model.obj, model.mtl, model_N.jpg, model.glb, preview.png, views.json,\n"
                  "labels.npy (view per face), tags.npy (0 seen, 1 partly, 2 filled), faces.npy (GLB triangle\n"
                  "to input face), offset.txt where coordinates are large, run.json.\n\n"
                  "Where floats would round coordinates noticeably (UTM, say), model.obj and model.glb are local:\n"
                  "add the three numbers of offset.txt, which the GLB's root node carries as extras.offset, for the\n"
                  "mesh's own coordinates. The root node's rotation only turns the scene's up axis to glTF's "
                  "+y.\n\n") +
      kExitStatus);
  return app;
}

}  // namespace gpvc::cli
