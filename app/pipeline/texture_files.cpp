#include "app/pipeline/texture_files.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "app/pipeline/given_layout.h"
#include "app/pipeline/misfit_picture.h"
#include "app/pipeline/render_model.h"
#include "app/pipeline/web_model.h"
#include "io/freed_memory.h"
#include "io/images.h"
#include "io/npy.h"
#include "io/output_file.h"
#include "io/paths.h"
#include "io/reference_system.h"
#include "io/vector.h"

namespace gpvc::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kPreviewWidth = 1600, kPreviewHeight = 1200, kPreviewSamples = 2;
// Pages are kept for the preview at a size with as many texels at most: twice those of the picture before it is reduced.
constexpr std::size_t kPreviewTexels =
    2 * std::size_t{kPreviewWidth} * kPreviewHeight * kPreviewSamples * kPreviewSamples;
constexpr std::array<std::uint8_t, 3> kBackground{214, 217, 221};

std::vector<io::PageFile> promise_pages(const Input& input, OutputFolder& folder, std::size_t pages,
                                        io::ImageFormat format) {
  std::vector<io::PageFile> files;
  for (std::size_t n = 0; n < pages; ++n) {
    files.push_back({folder.file(page_file_name(input, n, format)), format});
    if (input.layout != nullptr) files.back().material = input.layout->pages[n].material;
  }
  return files;
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

std::string xml_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return escaped;
}

}  // namespace

io::TexturedModel without_dropped(io::TexturedModel model, std::span<const labeling::FaceTag> tags,
                                  atlas::UnseenFaces unseen) {
  for (std::size_t face = 0; face < model.face_page.size(); ++face)
    if (atlas::is_dropped(unseen, tags[face])) model.face_page[face] = io::kNoPage;
  return model;
}

bool has_offset(const io::ModelOptions& model) {
  return !(model.offset == WorldPoint{}) || !model.srs.empty() || !(model.srs_offset == WorldPoint{});
}

void write_offset(const io::ModelOptions& model, const std::filesystem::path& file) {
  io::write_file(file, offset_text(model));
}

void read_reference_system(const std::filesystem::path& model_file, io::ModelOptions& model) {
  const fs::path file = model_file.parent_path() / kOffsetFile;
  io::refuse_special_file(file);
  std::ifstream in(file);
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    std::istringstream words(line);
    std::string word;
    words >> word;
    WorldPoint& p = model.srs_offset;
    if (word == "srs_offset" && !(words >> p.x >> p.y >> p.z))
      throw InputError(file, fmt::format("line {}", number), "expected three numbers, x y z");
    if (word == "srs") std::getline(words >> std::ws, model.srs);
  }
}

void write_metadata(const io::ModelOptions& model, const std::filesystem::path& file) {
  // Programs that read the file look for a code.
  const bool is_named = model.srs.starts_with("EPSG:") || model.srs.starts_with("ENU:");
  const std::string code = is_named ? std::string() : io::system_name(model.srs).code;
  const WorldPoint origin = model.offset + model.srs_offset;
  io::write_file(file, fmt::format("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<ModelMetadata version=\"1\">\n"
                                   "  <SRS>{}</SRS>\n  <SRSOrigin>{},{},{}</SRSOrigin>\n</ModelMetadata>\n",
                                   xml_text(code.empty() ? model.srs : code), origin.x, origin.y, origin.z));
}

io::ModelOptions model_options(const Input& input, std::span<const ViewId> labels, const OutputSettings& settings,
                               Coordinates coordinates) {
  io::ModelOptions model;
  const bool own_system = coordinates == Coordinates::of_mesh_file && !input.mesh.file_positions.empty();
  model.offset = local_origin(input.mesh, own_system ? input.mesh.file_positions : input.mesh.positions, labels,
                              input.scene, input.views);
  model.normals = settings.normals;
  model.lit = settings.lit;
  if (settings.target == Target::web) model.coding = io::GltfCoding::quantized;
  model.pageless_faces = input.layout != nullptr;  // those without texture coordinates
  // Reference systems of meshes have heights along z.
  model.up = settings.up ? *settings.up : own_system ? io::UpAxis::pos_z : scene_up(input.scene, input.views);
  model.srs = one_line(own_system ? input.mesh.file_srs : input.scene.srs);
  if (!own_system) model.srs_offset = input.scene.offset;
  return model;
}

io::ColorProfile profile_of_photo(const Scene& scene, ViewId view, io::PhotoSource& photos) {
  const fs::path& file = scene.views[index(view)].photo;
  if (file.empty()) return {};
  photos.key(view);  // throws where the file has changed
  io::ColorProfile profile = io::read_color_profile(file);
  photos.key(view);
  return profile;
}

io::ColorProfile profile_of_photos(const Run& run) {
  const Input& input = run.input;
  const auto view_of = [&](std::size_t n) -> const View& { return input.scene.views[index(input.views[n])]; };
  const auto profile_of = [&](std::size_t n) {
    return view_of(n).photo.empty() ? io::ColorProfile{} : io::read_color_profile(view_of(n).photo);
  };
  const io::ColorProfile first = profile_of_photo(input.scene, input.views.front(), run.photos);
  std::vector<std::uint8_t> differs(input.views.size(), 0);
  tbb::parallel_for(std::size_t{1}, input.views.size(),
                    [&](std::size_t n) { differs[n] = profile_of(n) != first ? 1 : 0; });
  std::vector<std::string> names;
  for (std::size_t n = 0; n < differs.size(); ++n)
    if (differs[n] != 0) names.push_back(view_of(n).name);
  if (!names.empty())
    run.observer.warning(
        fmt::format("{} of {} photos have another colour profile than {}, {}: {}; colours are not converted",
                    names.size(), differs.size(), view_of(0).name,
                    first.empty() ? "which has none, so the pages have none" : "whose profile the pages keep",
                    results::readable_list(names, 5)));
  return first;
}

std::string page_name(std::size_t number, io::ImageFormat format) {
  return fmt::format("model_{}.{}", number, name_of(io::kImageFormatNames, format));
}

fs::path samples_of(const fs::path& page, io::SampleFormat format) {
  if (format == io::SampleFormat::tif) return fs::path(page).replace_extension(".tif");
  // The page itself may be a PNG.
  return page.parent_path() / (page.stem().string() + "_bands.png");
}

void check_band_format(const Input& input, const OutputSettings& settings) {
  const std::optional<BandSet>& set = input.scene.bands;
  if (!set || settings.band_format != io::SampleFormat::png || io::fits_png(*set)) return;
  throw InputError(input.scene.views[index(input.views.front())].photo, "",
                   fmt::format("holds {} {} of {}, and a PNG holds 1 to 4 of u8 or u16", set->bands.size(),
                               set->bands.size() == 1 ? "band" : "bands", name_of(kSampleTypeNames, set->type)),
                   {Cure::bands_as_tiff});
}

fs::path page_file_of(const fs::path& model, const io::LoadedModel& loaded, std::size_t page) {
  const bool has_file = page < loaded.page_files.size() && !loaded.page_files[page].empty();
  return has_file ? loaded.page_files[page] : model.parent_path() / page_name(page, io::ImageFormat::jpg);
}

std::optional<FoundSamples> samples_beside(const fs::path& page, int width, int height) {
  for (const io::SampleFormat format : {io::SampleFormat::tif, io::SampleFormat::png}) {
    fs::path file = samples_of(page, format);
    if (!io::is_file(file)) continue;
    Samples samples = io::read_samples(file);
    if (samples.width == width && samples.height == height) return FoundSamples{std::move(file), std::move(samples)};
  }
  return std::nullopt;
}

FileSizes predicted_sizes(const Input& input, const Settings& settings, double texels) {
  const auto faces = static_cast<double>(input.mesh.faces.size());
  const auto vertices = static_cast<double>(input.mesh.positions.size());
  // labels.npy and tags.npy; in model.obj at least "f 1 2 3" and "v 0 0 0", each with a line end.
  double of_samples = 0;
  FileSizes sizes{(4 + 1) * faces + 8 * faces + 8 * vertices, 0};
  // Samples hardly become smaller.
  if (input.scene.bands) of_samples = static_cast<double>(input.scene.bands->pixel_bytes());
  // As city scenes and photographed ones have them: 90 bytes a face in model.obj, 45 in model.glb beside the pages; a byte a
  // texel as JPEG, three as PNG, once by itself and once in model.glb; the preview.
  const double of_texel = settings.output.texture == io::ImageFormat::png ? 3 : 1;
  sizes.likely = std::max(sizes.least, (5 + 4 + 90 + 45) * faces + (2 * of_texel + of_samples) * texels + 2e6);
  return sizes;
}

ModelFiles::ModelFiles(const Run& run, OutputFolder& folder, std::span<const ViewId> labels,
                       std::span<const labeling::FaceTag> tags)
    : run_(run), folder_(folder), profile_(profile_of_photos(run)), labels_(labels), tags_(tags) {
  run.observer.figure("color_profile_bytes", profile_.size());
}

void ModelFiles::begin(const atlas::AtlasEstimate& size) {
  options_ = model_options(run_.input, labels_, run_.settings.output);
  obj_file_ = folder_.file("model.obj");
  folder_.file("model.mtl");
  pages_ = promise_pages(run_.input, folder_, size.pages, run_.settings.output.texture);
  if (run_.input.scene.bands)
    for (const io::PageFile& page : pages_)
      samples_.push_back(folder_.file(samples_of(page.file.filename(), run_.settings.output.band_format)));
  preview_file_ = folder_.file("preview.png");
  labels_file_ = folder_.file("labels.npy");
  tags_file_ = folder_.file("tags.npy");
  faces_file_ = folder_.file("faces.npy");
  if (has_offset(options_)) write_offset(options_, folder_.file(kOffsetFile));
  if (!options_.srs.empty()) write_metadata(options_, folder_.file(kMetadataFile));
  if (!run_.input.mesh.source_face.empty())
    io::write_npy_as<std::uint32_t>(folder_.file("source_faces.npy"), run_.input.mesh.source_face);
  reduction_ = preview_reduction(size.page_texels);
  preview_pages_.resize(size.pages);
  page_sizes_.resize(size.pages);
  left_ = size.pages;
}

std::future<void> ModelFiles::take_model(const io::TexturedModel& model) {
  return std::async(std::launch::async, [this, &model] {
    io::write_npy_as<std::int32_t>(labels_file_, labels_);  // kNoView becomes -1
    io::write_npy_as<std::uint8_t>(tags_file_, tags_);
    io::write_obj(obj_file_, model, pages_, options_);
  });
}

void ModelFiles::take_page(std::size_t number, Image page) {
  page_sizes_[number] = {page.width, page.height};
  const auto write = [this, number](const Image& whole) {
    io::write_image(pages_[number].file, whole, run_.settings.output.texture, run_.settings.output.quality, profile_);
  };
  if (--left_ > 0) {
    write(page);
    preview_pages_[number] = io::reduce_image(page, reduction_);
    return;
  }
  const auto kept = std::make_shared<const Image>(std::move(page));
  last_page_ = std::async(std::launch::async, [write, kept] { write(*kept); });
  preview_pages_[number] = io::reduce_image(*kept, reduction_);
}

void ModelFiles::take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) {
  io::write_samples(samples_[number], page.samples, bands, page.charts);
}

void ModelFiles::keep_samples(std::size_t number, const fs::path& from) { io::copy_file(from, samples_[number]); }

void ModelFiles::keep_page(std::size_t number, const fs::path& from, const Image& page) {
  run_.observer.check_cancelled();
  io::copy_file(from, pages_[number].file);
  page_sizes_[number] = {page.width, page.height};
  preview_pages_[number] = io::reduce_image(page, reduction_);
  --left_;
}

WrittenModel ModelFiles::finish(const io::TexturedModel& model, const atlas::CutMisfit& cuts) {
  const atlas::UnseenFaces unseen = run_.settings.atlas.unseen;
  const bool drops = std::ranges::any_of(tags_, [&](labeling::FaceTag tag) { return atlas::is_dropped(unseen, tag); });
  const io::TexturedModel shown = drops ? without_dropped(model, tags_, unseen) : model;
  auto gltf = std::async(std::launch::async, [&] {
    if (last_page_.valid()) last_page_.get();
    const fs::path stem = folder_.in_making() / "model";
    const OutputSettings& output = run_.settings.output;
    WebModel made = output.target == Target::web
                        ? write_web_model(run_, stem, shown, pages_, options_)
                        : WebModel{io::write_gltf(stem, output.gltf, shown, pages_, options_), {}, 0};
    io::write_npy_as<std::uint32_t>(faces_file_, made.files.faces);
    free_memory(made.files.faces);
    return made;
  });
  const io::UpAxis up =
      run_.input.mesh.file_positions.empty() ? options_.up : scene_up(run_.input.scene, run_.input.views);
  const Preview preview = write_preview(run_.input, shown, preview_pages_, labels_, up, profile_, preview_file_);
  if (!cuts.where.empty())
    io::write_image(folder_.file("misfit.png"),
                    misfit_picture(run_.input.mesh, preview.image, preview.from, cuts.where), io::ImageFormat::png, 0);
  const WebModel made = gltf.get();
  promise_gltf(made.files, run_.settings.output.gltf, folder_, run_.observer);
  if (run_.settings.output.target == Target::web) {
    if (!made.files.buffers.empty())
      for (const fs::path& page : made.pages.written) folder_.file(page.filename());
    report(made, run_.observer);
  }
  return {preview.from, kBackground, options_.up, options_.offset};
}

int preview_reduction(std::size_t page_texels) {
  int reduction = 1;
  while (page_texels / pixel_index(0, reduction, reduction) > kPreviewTexels) reduction *= 2;
  return reduction;
}

Preview write_preview(const Input& input, const io::TexturedModel& model, const std::vector<Image>& pages,
                      std::span<const ViewId> labels, io::UpAxis up, const io::ColorProfile& profile,
                      const std::filesystem::path& file) {
  Viewpoint view = overview(input.mesh, labels, input.scene, input.views, up, kPreviewWidth * kPreviewSamples,
                            kPreviewHeight * kPreviewSamples);
  const RenderResult render = render_model(model, pages, view.camera, view.pose, {true, true, kBackground});
  Image image = io::reduce_image(render.image, kPreviewSamples);
  io::write_image(file, image, io::ImageFormat::png, 0, profile);
  // The camera of the picture, which is drawn larger and then reduced.
  Camera& camera = view.camera;
  camera.width = kPreviewWidth;
  camera.height = kPreviewHeight;
  for (double* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *length /= kPreviewSamples;
  return {view, std::move(image)};
}

}  // namespace gpvc::pipeline
