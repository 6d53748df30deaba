// The files of a textured model.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <filesystem>
#include <future>

#include "app/pipeline/pipeline.h"
#include "app/pipeline/render_model.h"
#include "io/images/image_file.h"
#include "io/npy.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kPreviewWidth = 1600, kPreviewHeight = 1200, kPreviewSamples = 2;
constexpr std::array<std::uint8_t, 3> kBackground{214, 217, 221};

// The color profile of the first view's photo file, for the pages; empty where it has none or there is no file. Warns of
// photos with another profile, because colors are not converted. Reads file headers only. Throws InputError.
io::ColorProfile profile_of_photos(const Input& input, Observer& observer) {
  const auto view_of = [&](std::size_t n) -> const View& { return input.scene.views[index(input.views[n])]; };
  const auto profile_of = [&](std::size_t n) {
    return view_of(n).photo.empty() ? io::ColorProfile{} : io::read_color_profile(view_of(n).photo);
  };
  const io::ColorProfile first = profile_of(0);
  std::vector<std::uint8_t> differs(input.views.size(), 0);
  tbb::parallel_for(std::size_t{1}, input.views.size(),
                    [&](std::size_t n) { differs[n] = profile_of(n) != first ? 1 : 0; });
  std::vector<std::string> names;
  for (std::size_t n = 0; n < differs.size(); ++n)
    if (differs[n] != 0) names.push_back(view_of(n).name);
  if (!names.empty())
    observer.warning(
        fmt::format("{} of {} photos have another colour profile than {}, {}: {}; colours are not converted",
                    names.size(), differs.size(), view_of(0).name,
                    first.empty() ? "which has none, so the pages have none" : "whose profile the pages keep",
                    readable_list(names, 5)));
  return first;
}

std::vector<io::PageFile> promise_pages(OutputFolder& folder, std::size_t pages, io::ImageFormat format) {
  std::vector<io::PageFile> files;
  for (std::size_t n = 0; n < pages; ++n)
    files.push_back({folder.file(fmt::format("model_{}.{}", n, name_of(io::kImageFormatNames, format))), format});
  return files;
}

Viewpoint write_preview(const fs::path& file, const Input& input, const TexturedMesh& textured, io::UpAxis up,
                        const io::ColorProfile& profile) {
  Viewpoint view = overview(input.mesh, textured.selection.labels, input.scene, input.views, up,
                            kPreviewWidth * kPreviewSamples, kPreviewHeight * kPreviewSamples);
  const RenderResult render =
      render_model(textured.atlas.model, textured.atlas.pages, view.camera, view.pose, {true, true, kBackground});
  io::write_image(file, io::reduce_image(render.image, kPreviewSamples), io::ImageFormat::png, 0, profile);
  // The camera of the picture, which is drawn larger and then reduced.
  Camera& camera = view.camera;
  camera.width = kPreviewWidth;
  camera.height = kPreviewHeight;
  for (double* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *length /= kPreviewSamples;
  return view;
}

// The files that a glTF consists of are known only after it is written.
void promise_gltf(const io::GltfFiles& files, io::GltfContainer wanted, OutputFolder& folder, Observer& observer) {
  folder.file(files.file.filename());
  for (const fs::path& buffer : files.buffers) folder.file(buffer.filename());
  if (wanted == io::GltfContainer::glb && !files.buffers.empty())
    observer.warning(fmt::format(
        "model.glb would be {:.2f} GiB, and a GLB holds at most 4: wrote model.gltf instead, which needs the "
        ".bin files and the pages beside it",
        static_cast<double>(files.glb_bytes) / 0x1p30));
}

// The definition of a reference system may have several lines.
std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool blank = static_cast<unsigned char>(c) <= ' ';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  return line;
}

// The offset from the model's coordinates to the scene's, then the one from there to the reference system.
std::string offset_text(const io::ModelOptions& model) {
  const auto numbers = [](const WorldPoint& p) { return fmt::format("{} {} {}\n", p.x, p.y, p.z); };
  std::string text = numbers(model.offset);
  if (!model.srs.empty() || !(model.srs_offset == WorldPoint{})) text += "srs_offset " + numbers(model.srs_offset);
  if (!model.srs.empty()) text += "srs " + model.srs + "\n";
  return text;
}

// The model with unseen faces taken off their pages, which leaves them out of a glTF.
io::TexturedModel without_unseen(const TexturedMesh& textured) {
  io::TexturedModel model = textured.atlas.model;
  for (std::size_t face = 0; face < model.face_page.size(); ++face)
    if (textured.tags[face] == labeling::FaceTag::unseen) model.face_page[face] = io::kNoPage;
  return model;
}

io::ModelOptions model_options(const Input& input, const TexturedMesh& textured, const OutputSettings& settings) {
  io::ModelOptions model;
  model.offset = local_origin(input.mesh, textured.selection.labels, input.scene, input.views);
  model.normals = settings.normals;
  model.pageless_faces = false;
  model.up = settings.up ? *settings.up : scene_up(input.scene, input.views);
  model.srs = one_line(input.scene.srs);
  model.srs_offset = input.scene.offset;
  return model;
}

void write_offset(const io::ModelOptions& model, OutputFolder& folder) {
  if (model.offset == WorldPoint{} && model.srs.empty() && model.srs_offset == WorldPoint{}) return;
  io::OutputFile file(folder.file("offset.txt"));
  file.write(offset_text(model));
  file.commit();
}

}  // namespace

WrittenModel write(const Input& input, const TexturedMesh& textured, const Settings& settings, OutputFolder& folder,
                   Observer& observer) {
  observer.begin({"write"});
  const atlas::TextureAtlas& atlas = textured.atlas;
  const OutputSettings& output = settings.output;
  const io::ColorProfile profile = profile_of_photos(input, observer);
  observer.figure("color_profile_bytes", profile.size());
  const fs::path obj_file = folder.file("model.obj");
  folder.file("model.mtl");
  const std::vector<io::PageFile> pages = promise_pages(folder, atlas.pages.size(), output.texture);
  const fs::path preview_file = folder.file("preview.png"), labels_file = folder.file("labels.npy");
  const fs::path tags_file = folder.file("tags.npy"), faces_file = folder.file("faces.npy");
  const io::ModelOptions model = model_options(input, textured, output);
  write_offset(model, folder);
  if (!input.mesh.source_face.empty())
    io::write_npy_as<std::uint32_t>(folder.file("source_faces.npy"), input.mesh.source_face);

  auto obj = std::async(std::launch::async, [&] { io::write_obj(obj_file, atlas.model, pages, model); });
  auto arrays = std::async(std::launch::async, [&] {
    io::write_npy_as<std::int32_t>(labels_file, textured.selection.labels);  // kNoView becomes -1
    io::write_npy_as<std::uint8_t>(tags_file, textured.tags);
  });
  auto gltf = std::async(std::launch::async, [&] {
    tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t n) {
      observer.check_cancelled();
      io::write_image(pages[n].file, atlas.pages[n], output.texture, output.quality, profile);
    });
    const bool drop = settings.atlas.unseen == atlas::UnseenFaces::drop;
    io::GltfFiles files = io::write_gltf(folder.in_making() / "model", output.gltf,
                                         drop ? without_unseen(textured) : atlas.model, pages, model);
    io::write_npy_as<std::uint32_t>(faces_file, files.faces);
    files.faces = {};
    return files;
  });
  const Viewpoint preview = write_preview(preview_file, input, textured, model.up, profile);
  obj.get();
  arrays.get();
  promise_gltf(gltf.get(), output.gltf, folder, observer);
  observer.end(fmt::format("{} {}", atlas.pages.size(), atlas.pages.size() == 1 ? "page" : "pages"));
  return {preview, kBackground, model.up, model.offset};
}

}  // namespace gpvc::pipeline
