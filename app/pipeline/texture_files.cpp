#include "app/pipeline/texture_files.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <filesystem>
#include <future>

#include "app/cli/interrupt.h"
#include "app/pipeline/photo_profile.h"
#include "app/pipeline/render_model.h"
#include "app/pipeline/viewpoint.h"
#include "io/images/image_file.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kPreviewWidth = 1600, kPreviewHeight = 1200, kPreviewSamples = 2;
constexpr std::array<std::uint8_t, 3> kBackground{214, 217, 221};

void write_faces(const fs::path& file, const std::vector<FaceId>& faces) {
  std::vector<std::uint32_t> values;
  for (const FaceId face : faces) values.push_back(static_cast<std::uint32_t>(face));
  const std::size_t shape = values.size();
  io::write_npy(file, values, std::span(&shape, 1));
}

void write_labels(const fs::path& labels_file, const fs::path& tags_file, const TexturedScene& scene) {
  std::vector<std::int32_t> labels;
  for (const ViewId label : scene.selection.labels)
    labels.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(label)));
  std::vector<std::uint8_t> tags;
  for (const labeling::FaceTag tag : scene.candidates.tags) tags.push_back(static_cast<std::uint8_t>(tag));
  const std::size_t shape = labels.size();
  io::write_npy(labels_file, labels, std::span(&shape, 1));
  io::write_npy(tags_file, tags, std::span(&shape, 1));
}

struct Names {
  fs::path obj, faces, labels, tags, views, preview;
  std::vector<io::PageFile> pages;
};

Names promise_files(OutputFolder& folder, std::size_t pages, io::ImageFormat format) {
  Names names;
  names.obj = folder.file("model.obj");
  folder.file("model.mtl");
  const char* extension = format == io::ImageFormat::png ? "png" : "jpg";
  for (std::size_t n = 0; n < pages; ++n)
    names.pages.push_back({folder.file(fmt::format("model_{}.{}", n, extension)), format});
  names.preview = folder.file("preview.png");
  names.views = folder.file("views.json");
  names.labels = folder.file("labels.npy");
  names.tags = folder.file("tags.npy");
  names.faces = folder.file("faces.npy");
  return names;
}

// The picture's camera and background, so that another renderer can be held against it.
cli::Json preview_json(const Viewpoint& view) {
  const Camera& c = view.camera;
  const auto& r = view.pose.rotation;
  const WorldPoint& at = view.pose.centre;
  constexpr double kSamples = kPreviewSamples;
  return {{"width", kPreviewWidth},
          {"height", kPreviewHeight},
          {"fx", c.fx / kSamples},
          {"fy", c.fy / kSamples},
          {"cx", c.cx / kSamples},
          {"cy", c.cy / kSamples},
          {"rotation", cli::Json::array({cli::Json::array({r[0], r[1], r[2]}), cli::Json::array({r[3], r[4], r[5]}),
                                         cli::Json::array({r[6], r[7], r[8]})})},
          {"centre", cli::Json::array({at.x, at.y, at.z})},
          {"background", kBackground}};
}

cli::Json write_preview(const fs::path& file, const TexturedScene& scene, io::UpAxis up,
                        const io::ColorProfile& profile) {
  const cli::SceneInputData& in = scene.input;
  const Viewpoint view = overview(in.mesh, scene.selection.labels, in.scene, in.used, up,
                                  kPreviewWidth * kPreviewSamples, kPreviewHeight * kPreviewSamples);
  const RenderResult render =
      render_model(scene.atlas.model, scene.atlas.pages, view.camera, view.pose, {true, true, kBackground});
  io::write_image(file, io::reduce_image(render.image, kPreviewSamples), io::ImageFormat::png, 0, profile);
  return preview_json(view);
}

// Which files a glTF takes is known once it is written.
void promise_gltf(const io::GltfFiles& files, io::GltfContainer wanted, OutputFolder& folder, cli::Console& console) {
  folder.file(files.file.filename());
  for (const fs::path& buffer : files.buffers) folder.file(buffer.filename());
  if (wanted == io::GltfContainer::glb && !files.buffers.empty())
    console.warning(
        fmt::format("model.glb would be {:.2f} GiB and a GLB ends at 4: wrote model.gltf instead, "
                    "which needs the .bin files and the pages beside it",
                    static_cast<double>(files.glb_bytes) / 0x1p30));
}

// A system's definition may run over several lines.
std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  return line;
}

// First what leads from the model's coordinates to the scene's, then what leads from there to its reference system.
std::string offset_text(const io::ModelOptions& model) {
  const auto numbers = [](const WorldPoint& p) { return fmt::format("{} {} {}\n", p.x, p.y, p.z); };
  std::string text = numbers(model.offset);
  if (!model.srs.empty() || !(model.srs_offset == WorldPoint{})) text += "srs_offset " + numbers(model.srs_offset);
  if (!model.srs.empty()) text += "srs " + model.srs + "\n";
  return text;
}

// The model without the faces that no photo shows: faces without a page are left out of a glTF.
io::TexturedModel without_unseen(const TexturedScene& scene) {
  io::TexturedModel model = scene.atlas.model;
  for (std::size_t face = 0; face < model.face_page.size(); ++face)
    if (scene.candidates.tags[face] == labeling::FaceTag::unseen) model.face_page[face] = io::kNoPage;
  return model;
}

}  // namespace

void write_textured_scene(const TexturedScene& scene, const cli::TextureOptions& options, OutputFolder& folder,
                          cli::Console& console, cli::RunRecord& record) {
  cli::Stage stage(console, record, "write");
  const cli::SceneInputData& in = scene.input;
  const atlas::TextureAtlas& atlas = scene.atlas;
  const io::ColorProfile profile = profile_of_photos(in, console);
  record.counts["color_profile_bytes"] = profile.size();
  const Names names = promise_files(folder, atlas.pages.size(), options.texture);
  io::ModelOptions model;
  model.offset = local_origin(in.mesh, scene.selection.labels, in.scene, in.used);
  model.normals = options.normals;
  model.up = options.up ? *options.up : scene_up(in.scene, in.used);
  model.srs = one_line(in.scene.srs);
  model.srs_offset = in.scene.offset;
  if (!(model.offset == WorldPoint{}) || !model.srs.empty() || !(model.srs_offset == WorldPoint{}))
    cli::write_text_file(folder.file("offset.txt"), offset_text(model));
  if (!in.mesh.source_face.empty()) {
    const std::size_t shape = in.mesh.source_face.size();
    io::write_npy(folder.file("source_faces.npy"), in.mesh.source_face, std::span(&shape, 1));
  }

  auto obj = std::async(std::launch::async, [&] { io::write_obj(names.obj, atlas.model, names.pages, model); });
  auto arrays = std::async(std::launch::async, [&] {
    cli::write_views_json(names.views, in);
    write_labels(names.labels, names.tags, scene);
  });
  auto gltf = std::async(std::launch::async, [&] {
    tbb::parallel_for(std::size_t{0}, atlas.pages.size(), [&](std::size_t n) {
      cli::throw_if_interrupted();
      io::write_image(names.pages[n].file, atlas.pages[n], options.texture, options.quality, profile);
    });
    const bool drop = options.atlas.unseen == atlas::UnseenFaces::drop;
    io::GltfFiles files = io::write_gltf(folder.in_making() / "model", options.gltf,
                                         drop ? without_unseen(scene) : atlas.model, names.pages, model);
    write_faces(names.faces, files.faces);
    files.faces = {};
    return files;
  });
  record.counts["preview"] = write_preview(names.preview, scene, model.up, profile);
  obj.get();
  arrays.get();
  promise_gltf(gltf.get(), options.gltf, folder, console);
  record.counts["up"] = up_name(model.up);
  record.counts["offset"] = cli::Json::array({model.offset.x, model.offset.y, model.offset.z});
  stage.finish(fmt::format("{} {}", atlas.pages.size(), atlas.pages.size() == 1 ? "page" : "pages"));
}

}  // namespace gpvc::pipeline
