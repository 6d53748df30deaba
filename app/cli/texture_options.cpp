// The options of gpvc texture, and of gpvc tileset, which has most of them.
#include <fmt/format.h>

#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"

namespace gpvc::cli {
CLI::App* add_texture(CLI::App& parent, TextureOptions& options) {
  CLI::App* app = parent.add_subcommand("texture", "texture a triangle mesh from calibrated photos");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  OptionGroup{*app, pipeline::kInput}.flag(
      "--preview", options.input.preview,
      fmt::format(
          "Take a quick look: some {} photos for each place, in 1/{} of their width and height; --downscale sets "
          "another size",
          kPreviewPhotosOfPlace, kPreviewReduction));
  OptionGroup{*app, pipeline::kResearch}.add(
      "--hold-out", options.input.hold_out, "K|LIST",
      "Texture without every K-th photo, or without these (names or globs), and mark them in views.json, so that gpvc "
      "evaluate compares with them");
  add_rules(*app, options.allow);
  OptionGroup{*app, pipeline::kOutput}
      .add("--from", options.from, "DIR",
           "Change the editable result in DIR: only faces that other --allow rules affect are textured anew, on new "
           "pages. With --force, DIR may be OUT")
      ->check(not_empty());
  OptionGroup{*app, pipeline::kSize}.flag(
      "--keep-uv", options.keep_uv,
      "Bake onto the texture coordinates that MESH (.obj, .ply, .glb, .gltf) has, instead of laying charts out anew. "
      "Materials "
      "and UDIM tiles become pages, as large as their images, or with a longer edge of --page-size");
  OptionGroup{*app, pipeline::kOutput}
      .add("--layers", options.layers, "DIR",
           "Bake further photos onto the same pages as well, each face from its same photo: folders with photos of the "
           "same names and sizes, such as another date, a camera beside the first or pictures of classes. Pages go to "
           "OUT/layers/NAME, with their values as they are in the photos")
      ->check(not_empty());
  OptionGroup{*app, pipeline::kOutput}.flag(
      "--level-layers", options.level_layers,
      "Level seams and blend photos of --layers, as those of the model: for photographs of another date");
  add_output(*app, options);
  add_settings(*app, options.settings, options_for(pipeline::For::one_model));
  app->get_option("--page-size")->each([&options](const std::string&) { options.sizes_pages = true; });
  add_earlier_names(*app, options.settings, options.common);
  add_common(*app, options.common,
             std::string(R"(Examples:
  gpvc texture colmap/sparse/0 mesh.ply --images photos -o out
  gpvc texture colmap mesh.ply -o look --preview
  gpvc texture colmap mesh.ply -o out --texture png --page-size 4096 --force
  gpvc texture colmap mesh.ply --from out --allow roof.json -o out2
  gpvc texture colmap mesh.ply -o web --target web --max-bytes 20M
  gpvc texture colmap unwrapped.obj -o out --keep-uv --page-size 4096
  gpvc texture colmap mesh.ply -o out --layers classes --texture png

Writes to OUT: model.obj, model.mtl, model_N.jpg, model.glb (or model.gltf and model.bin),
preview.png, misfit.png (how well photos fit each other at cuts: green well, red 2 px apart),
views.json, labels.npy (view per face), tags.npy (0 seen, 1 partly, 2 filled, 3 background),
faces.npy (GLB triangle to input face), source_faces.npy (face to the polygon it was cut from,
where there are any), offset.txt where coordinates are large, metadata.xml where their reference
system is known (SRS and SRSOrigin, as ContextCapture writes them), run.json; with --editable or
--from edit-views.bin, edit-model.bin and edit-hashes.txt. With --target web model.glb is for
browsers, and faces.npy is in its order; model.obj and its pages are as ever. With --keep-uv
several materials have pages model_MATERIAL.jpg, UDIM tiles model.1001.jpg and so on. With --layers
layers/NAME holds pages called as those of the model.

)") + kRulesHelp +
                 R"(Where floats would round coordinates noticeably (UTM, for example), model.obj and model.glb are
local: add the three numbers of offset.txt to get the mesh's own coordinates; the GLB's root node
carries them as extras.offset. The root node's rotation only turns the scene's up axis to glTF's +y.

)");
  return app;
}

CLI::App* add_tileset(CLI::App& parent, TilesetOptions& options) {
  CLI::App* app = parent.add_subcommand("tileset", "texture a mesh as 3D Tiles with levels of detail");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  add_output(*app, options);
  add_settings(*app, options.tiles);
  add_rules(*app, options.allow);
  add_settings(*app, options.settings, options_for(pipeline::For::one_process));
  add_earlier_names(*app, options.settings, options.common);
  add_common(*app, options.common, R"(Examples:
  gpvc tileset colmap/sparse/0 mesh.ply --images photos -o tiles
  gpvc tileset colmap mesh.ply --mesh-crs EPSG:25832 -o tiles --tile-faces 20000
  gpvc tileset colmap mesh.ply --place 48.1374,11.5755,565,90 -o tiles

Writes to OUT: tileset.json (3D Tiles 1.1), tiles/LEVEL_NUMBER.glb, index.html, preview.png, views.json, run.json.
Level 0 has the faces of the mesh at the photos' resolution; each level above a quarter of the faces
and texels twice as large, textured from the photos anew. Tiles of different levels meet without cracks.
Who picks a face learns which photo it shows, and what a pixel of that photo covers there: "photo" and
"gsd" (EXT_mesh_features, EXT_structural_metadata). index.html opens the tiles with a CesiumJS beside it.

Where the scene names its reference system, the root's transform places the tiles on the earth, with
heights above the ellipsoid; else --place does. Without either they keep the scene's own coordinates.

)" + std::string(kRulesHelp));
  return app;
}

}  // namespace gpvc::cli
