// The options of gpvc texture, and of gpvc tileset, which has most of them.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

void add_selection(CLI::App& app, pipeline::Settings& settings) {
  const OptionGroup group{app, "View selection"};
  labeling::CostOptions& costs = settings.costs;
  group.choice(
      "--data-term", labeling::kDataTermNames, costs.term,
      "What makes a view good for a face: its area in pixels or the image gradient integrated over it, alone or "
      "times the squared cosine of the viewing angle");
  group.choice(
      "--outliers", labeling::kOutliersNames, costs.outliers,
      "Views that disagree in colour with the others (cars, people): keep them, raise their cost, or drop them");
  group.flag("--keep-views", costs.keep_views,
             "Use photos that agree with the others no better than chance; by default they are left out, and a scene "
             "where most are such, or whose mesh is not where the photos show it, is refused");
  group.flag(
      "--allow-unseen", settings.allow_unseen,
      "Texture a mesh of which all photos together see less than 5 % of the faces, which is refused otherwise: it "
      "is one in other coordinates as a rule");
  add_smoothness(app, settings.solver.smoothness, settings.edge_weights);
  group.flag(
      "--thorough", settings.solver.thorough,
      "Search the whole mesh for better views until none is found: several times slower, for an energy that is at most "
      "0.2 % lower");
  group.number(
      "--margin", costs.margin_px, 0, 64, "PX",
      "Pixels along silhouettes in which a view costs more, as photo and mesh disagree there, 0 to 64; 0 is off");
}

void add_limits(const OptionGroup& group, atlas::AtlasOptions& atlas) {
  group.number("--max-pages", atlas.max_pages, 1, 1000000, "N", "Reduce all charts by one factor to fit on N pages")
      ->default_str("");
  group
      .number("--max-texels", atlas.max_texels, 4096.0, 1e15, "N",
              "Reduce all charts by one factor until all pages together have at most N texels, 4096 or more")
      ->default_str("");
}

void add_pages(const OptionGroup& group, pipeline::Settings& settings) {
  atlas::AtlasOptions& atlas = settings.atlas;
  pipeline::OutputSettings& output = settings.output;
  group.number("--page-size", atlas.page_size, 256, 32768, "N", "Largest edge of a texture page, 256 to 32768 texels");
  group.number(
      "--padding", atlas.padding, 1, 64, "N",
      "Texels around a chart that repeat its colours, 1 to 64; with 8, mip levels down to an eighth keep charts "
      "apart, with 4 down to a quarter");
  group
      .number("--texel-size", atlas.texel_size, 1e-9, 1e9, "X",
              "Smallest edge of a texel, in the mesh's units: charts with finer texels are reduced to it")
      ->default_str("");
  group.choice(
      "--unseen", atlas::kUnseenFacesNames, atlas.unseen,
      "Faces that no photo shows: fill continues the colours around them, drop leaves them out of the GLB (the "
      "OBJ keeps every face), color gives them --unseen-color");
  const auto take = [&atlas](const std::vector<int>& channels) {
    for (std::size_t c = 0; c < 3; ++c) atlas.unseen_color[c] = static_cast<std::uint8_t>(channels[c]);
  };
  group.app.add_option_function<std::vector<int>>("--unseen-color", take, "For --unseen color, 0 to 255 each")
      ->type_name("R,G,B")
      ->delimiter(',')
      ->expected(3)
      ->check(in_range(0, 255))
      ->default_str("128,128,128")
      ->group(group.heading);
  group.choice("--seams", atlas::kSeamLevelingNames, atlas.seams,
               "Colour levelling across seams: none; global, one correction per chart and vertex; or full, that and a "
               "blend near the seam");
  group.choice(
      "--blend", atlas::kBlendingNames, atlas.blend,
      "coarse: what is coarser than some four pixels comes in part from all photos that see a place whole, so that "
      "they differ less along seams, while fine detail is that of one photo; none: every face shows one photo alone");
  group.choice("--texture", io::kImageFormatNames, output.texture,
               "Format of the pages: jpg is quick to write and load, png is lossless");
  group.number("--quality", output.quality, 1, 100, "N", "JPEG quality of the pages, 1 to 100");
}

// --up, of files with the axes of glTF.
void add_up(const OptionGroup& group, pipeline::OutputSettings& output) {
  constexpr Named<std::optional<io::UpAxis>> kUps[] = {
      {"auto", std::nullopt},    {"+x", io::UpAxis::pos_x}, {"-x", io::UpAxis::neg_x}, {"+y", io::UpAxis::pos_y},
      {"-y", io::UpAxis::neg_y}, {"+z", io::UpAxis::pos_z}, {"-z", io::UpAxis::neg_z}};
  group.choice("--up", kUps, output.up,
               "Axis of the scene that points up in the GLB; auto: away from the cameras' mean viewing direction");
}

void add_texture_output(const OptionGroup& group, pipeline::Settings& settings) {
  pipeline::OutputSettings& output = settings.output;
  add_pages(group, settings);
  add_limits(group, settings.atlas);
  group.choice(
      "--gltf", io::kGltfContainerNames, output.gltf,
      "glb: one file, model.glb; files: model.gltf with model.bin and the pages beside it, which is also written "
      "for a model beyond the 4 GiB of a GLB");
  group.flag(
      "--normals", output.normals,
      "Also write smooth normals, vn in the OBJ and NORMAL in the GLB; without them viewers do not shade the model");
  add_up(group, output);
}

}  // namespace

void add_memory(CLI::App& app, std::size_t& memory_bytes) {
  OptionGroup{app, kCommonGroup}.parsed(
      "--memory", [&memory_bytes](const std::string& given) { memory_bytes = bytes_from("--memory", given); }, "SIZE",
      "what the scene needs, 70 % of what is free at most",
      "Stay below this much memory, 600M or 4G; more of it saves decoding photos twice. The result is the same");
}

void add_compress(const OptionGroup& group, bool& compress) {
  group.flag(
      "--compress", compress,
      "Compress the geometry of GLBs without loss, for viewers that know EXT_meshopt_compression: CesiumJS, three.js");
}

void add_tile_texture(CLI::App& app, pipeline::Settings& texture) {
  add_pages({app, "Texture"}, texture);
  add_up({app, "Texture"}, texture.output);
  add_selection(app, texture);
  add_visibility(app, texture.visibility);
  add_memory(app, texture.memory_bytes);
}

CLI::App* add_texture(CLI::App& parent, TextureOptions& options) {
  CLI::App* app = parent.add_subcommand("texture", "texture a triangle mesh from calibrated photos");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  OptionGroup{*app, "Input"}.add(
      "--hold-out", options.input.hold_out, "K|LIST",
      "Texture without every K-th photo, or without these (names or globs), and mark them in views.json, so that gpvc "
      "evaluate compares with them");
  OptionGroup{*app, "View selection"}
      .add(
          "--allow", options.allow, "FILE",
          "Rules (JSON or CSV) about boxes, polygons on the ground or faces, and photos that alone may texture them or "
          "may not; see below")
      ->check(not_empty());
  const OptionGroup edits{*app, "Changing a result"};
  edits.flag("--editable", options.settings.editable,
             "Also write edit-views.bin and edit-model.bin, with which --from can change the result");
  edits
      .add("--from", options.from, "DIR",
           "Make the result from an editable one in DIR that differs in --allow alone: only charts whose photos change "
           "are "
           "made anew, on new pages; DIR may be OUT, with --force")
      ->check(not_empty());
  add_output(*app, options);
  add_texture_output({*app, "Texture"}, options.settings);
  add_selection(*app, options.settings);
  add_visibility(*app, options.settings.visibility);
  add_memory(*app, options.settings.memory_bytes);
  CLI::Option* resume =
      OptionGroup{*app, kCommonGroup}.choice("--resume", pipeline::kKeepWorkNames, options.settings.keep_work,
                                             "Keep finished work in OUT/.work until all is done, so that the same "
                                             "command goes on from there if it is cut off; "
                                             "auto: if it may take more than a minute");
  app->add_flag_callback(
         "--no-resume", [&options] { options.settings.keep_work = pipeline::KeepWork::never; },
         "Keep no work, and use none that is kept: --resume never")
      ->group(kCommonGroup)
      ->excludes(resume);
  add_common(*app, options.common, R"(Examples:
  gpvc texture colmap/sparse/0 mesh.ply --images photos -o out
  gpvc texture colmap mesh.ply -o look --downscale 4 --views 'DJI_00[12]*'
  gpvc texture colmap mesh.ply -o out --texture png --page-size 4096 --force
  gpvc texture colmap mesh.ply --from out --allow roof.json -o out2
  gpvc texture colmap mesh.ply -o web --max-pages 1 --page-size 4096 --unseen drop

Writes to OUT: model.obj, model.mtl, model_N.jpg, model.glb (or model.gltf and model.bin),
preview.png, views.json, labels.npy (view per face), tags.npy (0 seen, 1 partly, 2 filled),
faces.npy (GLB triangle to input face), source_faces.npy (face to the polygon it was cut from,
where there are any), offset.txt where coordinates are large, run.json; with --editable or
--from edit-views.bin and edit-model.bin.

A line of --allow FILE is one of (a face is inside if its middle is; several rules all hold):
  box,X Y Z X Y Z,forbid,PHOTO;PHOTO...        polygon,X Y X Y X Y...,allow,PHOTO;PHOTO...
  faces,7 100-120 ...,forbid,PHOTO...          PHOTO: a name or glob, as in --views
or the file is {"rules": [{"polygon": [[X, Y], ...], "z": [LOW, HIGH], "forbid": [PHOTO, ...]}, ...]}.

Where floats would round coordinates noticeably (UTM, for example), model.obj and model.glb are
local: add the three numbers of offset.txt to get the mesh's own coordinates; the GLB's root node
carries them as extras.offset. The root node's rotation only turns the scene's up axis to glTF's +y.

)");
  return app;
}

CLI::App* add_tileset(CLI::App& parent, TilesetOptions& options) {
  CLI::App* app = parent.add_subcommand("tileset", "texture a mesh as 3D Tiles with levels of detail");
  pipeline::Settings& texture = options.settings.texture;
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  add_output(*app, options);
  OptionGroup{*app, "Tiles"}.number("--tile-faces", options.settings.faces_per_tile, std::size_t{100},
                                    std::size_t{10000000}, "N", "Most faces of a tile, 100 or more");
  add_compress({*app, "Tiles"}, options.settings.compress);
  add_tile_texture(*app, texture);
  add_common(*app, options.common, R"(Examples:
  gpvc tileset colmap/sparse/0 mesh.ply --images photos -o tiles
  gpvc tileset colmap mesh.ply --mesh-crs EPSG:25832 -o tiles --tile-faces 20000

Writes to OUT: tileset.json (3D Tiles 1.1), tiles/LEVEL_NUMBER.glb, views.json, run.json. Level 0 has
the faces of the mesh at the photos' resolution; each level above a quarter of the faces and texels
twice as large, textured from the photos anew. Tiles of different levels meet without cracks.

Where the scene or the mesh names its reference system, the root's transform places the tiles on the
earth; else they are in the scene's own coordinates, turned so that z is up.

)");
  return app;
}

}  // namespace gpvc::cli
