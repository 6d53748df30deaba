#include "app/ortho/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "app/pipeline/bake_into.h"
#include "app/pipeline/checkpoint.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/steps.h"
#include "app/pipeline/texture_files.h"
#include "io/freed_memory.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/npy.h"
#include "io/paths.h"

namespace gpvc::ortho {
namespace {

namespace fs = std::filesystem;

// The models of a job's tiles, by their numbers.
std::vector<fs::path> tile_models(const fs::path& folder) {
  std::vector<std::pair<std::size_t, fs::path>> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder / "obj", none)) {
    const std::string name = entry.path().filename().string();
    std::size_t number = 0;
    const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (failed != std::errc{} || end != name.data() + name.size()) continue;
    if (io::is_file(entry.path() / "model.obj")) found.emplace_back(number, entry.path() / "model.obj");
  }
  std::ranges::sort(found);
  std::vector<fs::path> files;
  for (auto& [number, file] : found) files.push_back(std::move(file));
  return files;
}

FaceKind kind_of(bool has_page, std::optional<labeling::FaceTag> tag, atlas::UnseenFaces unseen) {
  if (tag == labeling::FaceTag::background) return FaceKind::absent;
  return has_page && !(tag && atlas::is_dropped(unseen, *tag)) ? FaceKind::textured : FaceKind::bare;
}

// Per face of the model; `tags`: empty where they are unknown.
std::vector<FaceKind> kinds_of(const io::TexturedModel& model, std::span<const labeling::FaceTag> tags,
                               atlas::UnseenFaces unseen) {
  std::vector<FaceKind> kinds(model.face_page.size());
  for (std::size_t f = 0; f < kinds.size(); ++f)
    kinds[f] = kind_of(model.face_page[f] != io::kNoPage, tags.empty() ? std::nullopt : std::optional(tags[f]), unseen);
  return kinds;
}

template <typename T>
std::vector<T> per_face(const fs::path& file, std::size_t faces) {
  std::vector<T> values = io::read_npy<T>(file).values;
  if (values.size() != faces)
    throw InputError(file, "", fmt::format("has {} faces, and the model beside it {}", values.size(), faces));
  return values;
}

// What ContextCapture, DJI Terra and others state beside a model.
void take_mesh_origin(const fs::path& file, io::ModelOptions& coordinates) {
  const std::optional<io::MeshOrigin> origin = io::read_mesh_origin(file);
  if (!origin) return;
  coordinates.srs = origin->srs;
  coordinates.srs_offset = origin->origin;
}

// What gpvc texture writes beside a model.
void read_labels(const fs::path& folder, atlas::UnseenFaces unseen, Surface& surface) {
  const std::size_t faces = surface.mesh.faces.size();
  const auto labels = per_face<std::int32_t>(folder / "labels.npy", faces);
  std::vector<labeling::FaceTag> tags;
  for (const std::uint8_t tag : per_face<std::uint8_t>(folder / "tags.npy", faces)) {
    if (tag > static_cast<std::uint8_t>(labeling::FaceTag::background))
      throw InputError(folder / "tags.npy", fmt::format("face {}", tags.size()),
                       fmt::format("has {}, expected 0 to 3", tag));
    tags.push_back(static_cast<labeling::FaceTag>(tag));
  }
  surface.kind = kinds_of(surface.model, tags, unseen);
  for (const std::int32_t label : labels)
    surface.photo.push_back(label < 0 ? kNoPhoto : static_cast<std::uint32_t>(label));
}

// The samples beside a model's pages.
void read_samples(const fs::path& model, const io::LoadedModel& loaded, std::size_t first_page, PageStore& pages) {
  for (std::size_t page = first_page; page < pages.size(); ++page) {
    const fs::path file = pipeline::page_file_of(model, loaded, page - first_page);
    auto found = pipeline::samples_beside(file, pages[page].width, pages[page].height);
    if (!found) return;
    pages.take_samples(page, {std::move(found->samples), {}}, io::read_band_set(found->file));
  }
}

// Adds a model whose pages begin at `first_page`, in coordinates less the offset of the first.
void append(const fs::path& file, io::LoadedModel&& more, std::size_t first_page, Surface& all) {
  constexpr std::size_t kMost = 0xFFFFFFFFU;
  const std::size_t texcoords = all.model.texcoords.size();
  if (texcoords + more.model.texcoords.size() > kMost || all.mesh.positions.size() + more.mesh.positions.size() > kMost)
    throw InputError(file, "",
                     "with the models before it, has more than 4 294 967 295 vertices or texture coordinates");
  const WorldPoint& from = more.offset;
  const WorldPoint& to = all.coordinates.offset;
  for (WorldPoint& p : more.mesh.positions) p = {p.x + (from.x - to.x), p.y + (from.y - to.y), p.z + (from.z - to.z)};
  io::append_mesh(all.mesh, more.mesh);
  all.model.texcoords.insert(all.model.texcoords.end(), more.model.texcoords.begin(), more.model.texcoords.end());
  for (Triangle corners : more.model.face_texcoords) {
    for (std::uint32_t& corner : corners) corner += static_cast<std::uint32_t>(texcoords);
    all.model.face_texcoords.push_back(corners);
  }
  for (const std::uint32_t page : more.model.face_page)
    all.model.face_page.push_back(page == io::kNoPage ? page : page + static_cast<std::uint32_t>(first_page));
}

}  // namespace

std::vector<fs::path> models_of(const fs::path& from) {
  std::error_code none;
  if (!fs::exists(from, none)) throw InputError(from, "", "does not exist");
  if (!fs::is_directory(from, none)) return {from};
  for (const char* name : {"model.obj", "model.glb", "model.gltf"})
    if (io::is_file(from / name)) return {from / name};
  std::vector<fs::path> tiles = tile_models(from);
  if (tiles.empty()) throw InputError(from, "", "holds no textured model (model.obj, model.glb, obj/0/model.obj)");
  return tiles;
}

Surface read_surface(const std::vector<fs::path>& models, atlas::UnseenFaces unseen, PageStore& pages) {
  Surface surface;
  surface.source = models.front();
  for (const fs::path& file : models) {
    const std::size_t first = pages.size();
    io::LoadedModel more = io::read_textured_model(
        file, [&](std::size_t number, Image page) { pages.take_page(first + number, std::move(page)); });
    read_samples(file, more, first, pages);
    if (&file != &models.front()) {
      append(file, std::move(more), first, surface);
      continue;
    }
    surface.mesh = std::move(more.mesh);
    surface.model = std::move(more.model);
    surface.coordinates.offset = more.offset;
    pipeline::read_reference_system(file, surface.coordinates);
    if (surface.coordinates.srs.empty() && more.offset == WorldPoint{}) take_mesh_origin(file, surface.coordinates);
  }
  pages.complete();
  const fs::path folder = models.front().parent_path();
  if (models.size() == 1 && io::is_file(folder / "labels.npy") && io::is_file(folder / "tags.npy") &&
      models.front().filename() == "model.obj")
    read_labels(folder, unseen, surface);
  else
    surface.kind = kinds_of(surface.model, {}, unseen);
  if (std::ranges::count(surface.kind, FaceKind::textured) == 0)
    throw InputError(models.front(), "", "has no textured face");
  return surface;
}

TexturedSurface texture_surface(const pipeline::Run& given, PageStore& pages, pipeline::OutputFolder& folder) {
  checks::validate(given.input);
  const auto& [input, settings, unused, observer, kept] = given;
  const pipeline::MemoryPlan memory = pipeline::plan_memory(input, settings);
  const pipeline::FileSizes sizes = pipeline::predicted_sizes(input, settings, memory.work.texels);
  io::CoarsePhotos photos = pipeline::with_coarse_photos(given, memory.work, sizes.likely, folder.in_making());
  pipeline::Run run{input, settings, photos, observer, nullptr};
  std::optional<pipeline::Checkpoint> checkpoint = pipeline::open_checkpoint(run, memory, sizes, folder);
  if (checkpoint) run.kept = &*checkpoint;
  pipeline::Choice chosen = pipeline::see_and_choose(run, memory);
  const atlas::AtlasInput from =
      pipeline::atlas_input(input, run.photos, chosen.graph, chosen.seen, chosen.selection.labels);
  const pipeline::BakeSpace space{.scratch_folder = folder.in_making(),
                                  .kept = checkpoint ? checkpoint->pages() : atlas::KeptPages{}};
  atlas::TextureAtlas atlas =
      pipeline::bake_into(run, from, pipeline::with_coverage(memory, chosen.seen.coverage), space, &pages);
  if (checkpoint) checkpoint->warn_of_failure(observer);
  pages.complete();

  Surface surface;
  surface.source = input.mesh_file;
  surface.coordinates = pipeline::model_options(input, chosen.selection.labels, settings.output);
  surface.coordinates.offset = {};
  surface.kind = kinds_of(atlas.model, chosen.seen.candidates.tags, settings.atlas.unseen);
  for (const ViewId label : chosen.selection.labels)
    surface.photo.push_back(label == kNoView ? kNoPhoto : static_cast<std::uint32_t>(label));
  for (const View& view : input.scene.views) surface.photos.push_back(view.name);
  // A mesh with coordinates of its own has heights along z.
  const bool own_system = !input.mesh.file_positions.empty();
  surface.up = own_system ? WorldPoint{0, 0, 1} : pipeline::up_direction(input.scene, input.views);
  surface.model = std::move(atlas.model);
  surface.model.mesh = nullptr;
  std::optional<visibility::DeviceInfo> device = std::move(chosen.seen.device);
  chosen = {};
  release_freed_memory();
  surface.mesh.positions = input.mesh.written_positions();
  surface.mesh.faces = input.mesh.faces;
  return {std::move(surface), std::move(device)};
}

}  // namespace gpvc::ortho
