#include "app/tileset/tile_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "app/pipeline/texture_files.h"
#include "app/pipeline/web_model.h"
#include "io/vector.h"

namespace gpvc::tileset {
namespace {

// The distinct values of an array, ascending.
std::vector<std::uint32_t> distinct(std::vector<std::uint32_t> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

std::uint32_t place_in(const std::vector<std::uint32_t>& sorted, std::uint32_t value) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(sorted, value) - sorted.begin());
}

// What the faces of a photo cover, on the mesh and in pixels of the photo as it was taken.
struct Coverage {
  double area = 0, pixels = 0;
  void add(const View& view, const std::array<WorldPoint, 3>& p) {
    std::array<PixelPoint, 3> q;
    for (std::size_t i = 0; i < 3; ++i) {
      const CameraPoint c = camera_from_world(view.pose, p[i]);
      if (!(c.z > 0)) return;
      q[i] = pixel_from_camera(view.camera, c);
    }
    area += length(cross(p[1] - p[0], p[2] - p[0])) / 2;
    pixels += std::abs((q[1].x - q[0].x) * (q[2].y - q[0].y) - (q[2].x - q[0].x) * (q[1].y - q[0].y)) / 2 *
              view.reduction * view.reduction;
  }
};

}  // namespace

PageFiles::PageFiles(std::filesystem::path folder, std::string prefix, const pipeline::OutputSettings& settings,
                     io::ColorProfile profile, bool samples)
    : folder_(std::move(folder)),
      prefix_(std::move(prefix)),
      settings_(settings),
      profile_(std::move(profile)),
      samples_(samples) {}

void PageFiles::begin(const atlas::AtlasEstimate& size) {
  const auto file = [&](std::size_t page) {
    return folder_ / (prefix_ + pipeline::page_name(page, settings_.texture));
  };
  for (std::size_t p = 0; p < size.pages; ++p) files_.push_back({file(p), settings_.texture});
  // Those of an earlier result, which may have had more.
  std::error_code none;
  for (std::size_t p = size.pages; std::filesystem::remove(file(p), none); ++p)
    std::filesystem::remove(pipeline::samples_of(file(p), settings_.band_format), none);
}

void PageFiles::take_page(std::size_t number, Image page) {
  io::write_image(files_[number].file, page, settings_.texture, settings_.quality, profile_);
}

void PageFiles::take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) {
  if (samples_)
    io::write_samples(pipeline::samples_of(files_[number].file, settings_.band_format), page.samples, bands,
                      page.charts);
}

void PageFiles::remove() noexcept {
  std::error_code ignored;
  for (const io::PageFile& page : files_) {
    std::filesystem::remove(page.file, ignored);
    std::filesystem::remove(pipeline::samples_of(page.file, settings_.band_format), ignored);
  }
}

TileModel tile_model(const io::TexturedModel& all, std::span<const std::uint32_t> faces,
                     std::span<const io::PageFile> pages, const std::function<bool(std::uint32_t)>& drop) {
  TileModel tile;
  std::vector<std::uint32_t> vertices, texcoords, numbers;
  for (const std::uint32_t f : faces) {
    vertices.insert(vertices.end(), all.mesh->faces[f].begin(), all.mesh->faces[f].end());
    texcoords.insert(texcoords.end(), all.face_texcoords[f].begin(), all.face_texcoords[f].end());
    if (all.face_page[f] != io::kNoPage) numbers.push_back(all.face_page[f]);
  }
  vertices = distinct(std::move(vertices));
  texcoords = distinct(std::move(texcoords));
  numbers = distinct(std::move(numbers));
  for (const std::uint32_t v : vertices) tile.mesh.positions.push_back(all.mesh->positions[v]);
  if (!all.mesh->file_positions.empty())
    for (const std::uint32_t v : vertices) tile.mesh.file_positions.push_back(all.mesh->file_positions[v]);
  for (const std::uint32_t t : texcoords) tile.model.texcoords.push_back(all.texcoords[t]);
  for (const std::uint32_t p : numbers) tile.pages.push_back(pages[p]);
  for (const std::uint32_t f : faces) {
    Triangle corners = all.mesh->faces[f], places = all.face_texcoords[f];
    for (std::uint32_t& v : corners) v = place_in(vertices, v);
    for (std::uint32_t& t : places) t = place_in(texcoords, t);
    tile.mesh.faces.push_back(corners);
    tile.model.face_texcoords.push_back(places);
    const bool bare = drop(f) || all.face_page[f] == io::kNoPage;
    tile.model.face_page.push_back(bare ? io::kNoPage : place_in(numbers, all.face_page[f]));
  }
  return tile;
}

void add_photos(TileModel& tile, const Scene& scene, std::span<const std::uint32_t> faces,
                std::span<const ViewId> labels) {
  std::map<ViewId, Coverage> coverage;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const ViewId label = labels[faces[f]];
    Coverage& here = coverage[label];
    if (label == kNoView) continue;
    const Triangle& face = tile.mesh.faces[f];
    here.add(scene.views[index(label)],
             {tile.mesh.positions[face[0]], tile.mesh.positions[face[1]], tile.mesh.positions[face[2]]});
  }
  std::map<ViewId, std::uint32_t> row;
  for (const auto& [view, sum] : coverage) {
    row[view] = static_cast<std::uint32_t>(tile.photos.name.size());
    tile.photos.name.push_back(view == kNoView ? std::string() : scene.views[index(view)].name);
    tile.photos.gsd.push_back(sum.pixels > 0 ? static_cast<float>(std::sqrt(sum.area / sum.pixels)) : 0);
  }
  for (const std::uint32_t f : faces) tile.photos.of_face.push_back(row[labels[f]]);
}

void write_tile(const std::filesystem::path& glb, TileModel& tile, const io::ModelOptions& options,
                const pipeline::OutputSettings& settings, const std::filesystem::path& scratch_folder) {
  tile.mesh.file_positions.clear();
  tile.model.mesh = &tile.mesh;
  const bool for_web = settings.target == pipeline::Target::web;
  pipeline::WebPages web;
  if (for_web)
    web = pipeline::write_web_pages(tile.pages, scratch_folder / glb.stem(), settings, io::GltfContainer::glb);
  std::filesystem::path stem = glb;
  io::write_gltf(stem.replace_extension(), io::GltfContainer::glb, tile.model, for_web ? web.files : tile.pages,
                 options, tile.photos.name.empty() ? nullptr : &tile.photos);
  web.remove();
}

io::GltfCoding tile_coding(const pipeline::OutputSettings& settings, bool compress) {
  return settings.target == pipeline::Target::web ? io::GltfCoding::quantized
         : compress                               ? io::GltfCoding::compressed
                                                  : io::GltfCoding::plain;
}

}  // namespace gpvc::tileset
