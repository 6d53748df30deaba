#include <fmt/format.h>

#include "app/pipeline/pipeline.h"
#include "app/pipeline/texture_files.h"

namespace gpvc::cli {
namespace {

Json options_json(const TextureOptions& o) {
  constexpr const char* kUnseen[] = {"fill", "drop", "color"};
  constexpr const char* kSeams[] = {"none", "global", "full"};
  Json json = scene_json(o.input);
  json.update(visibility_json(o.visibility));
  json["data_term"] = name_of(labeling::kDataTermNames, o.costs.term);
  json["outliers"] = name_of(labeling::kOutliersNames, o.costs.outliers);
  json["margin_px"] = o.costs.margin_px;
  json["smoothness"] = o.solver.smoothness;
  json["edge_weights"] = name_of(labeling::kEdgeWeightsNames, o.edge_weights);
  json["max_sweeps"] = o.solver.max_sweeps;
  json["page_size"] = o.atlas.page_size;
  json["padding"] = o.atlas.padding;
  json["texel_size"] = o.atlas.texel_size;
  json["max_pages"] = o.atlas.max_pages;
  json["max_texels"] = o.atlas.max_texels;
  json["unseen"] = kUnseen[static_cast<std::size_t>(o.atlas.unseen)];
  json["unseen_color"] = o.atlas.unseen_color;
  json["seams"] = kSeams[static_cast<std::size_t>(o.atlas.seams)];
  json["texture"] = o.texture == io::ImageFormat::png ? "png" : "jpg";
  json["quality"] = o.quality;
  json["gltf"] = o.gltf == io::GltfContainer::glb ? "glb" : "files";
  json["normals"] = o.normals;
  json["up"] = o.up ? "given" : "auto";
  return json;
}

void texture(const TextureOptions& options, pipeline::OutputFolder& folder, Console& console) {
  RunRecord record;
  const SceneInputData in = read_scene_input(options.input, console, record);
  folder.protect(input_files(in));
  visibility::GraphicsDevice device(options.common.device);
  console.detail(fmt::format("device: {} ({})", device.info().renderer, device.info().driver));
  io::PhotoCache photos(in.scene, options.input.downscale, pipeline::photo_cache_bytes());

  const labeling::FaceGraph graph = pipeline::weighed_graph(in.mesh, options, console, record);
  const pipeline::SeenScene seen = pipeline::see_views(in, photos, device, options, console, record);
  pipeline::count_tags(seen.candidates, options.input.mesh, console, record);
  const labeling::Selection selection = pipeline::choose_views(seen, graph, options, console, record);
  const atlas::TextureAtlas atlas = pipeline::make_atlas(
      {in.mesh, in.scene, photos, graph, selection.labels, seen.candidates.tags, seen.candidates.table, seen.coverage},
      options, console, record);
  pipeline::write_textured_scene({in, selection, seen.candidates, atlas}, options, folder, console, record);
  write_run_json(folder, {"texture", options.common, options_json(options), device_json(device.info())}, record);
}

}  // namespace

void run_texture(const TextureOptions& options, Console& console) {
  refuse_overwriting(options.input, options.out, {"model.obj"});
  pipeline::OutputFolder folder(options.out, options.force, "texture");
  try {
    texture(options, folder, console);
    folder.publish();
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
  for (const char* name : {"model.obj", "model.glb", "model.gltf", "preview.png"})
    if (std::filesystem::exists(options.out / name)) console.result((options.out / name).string());
}

}  // namespace gpvc::cli
