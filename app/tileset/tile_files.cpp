#include "app/tileset/tile_files.h"

#include <algorithm>
#include <utility>

#include "app/pipeline/texture_files.h"
#include "app/tileset/compressed_glb.h"

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

}  // namespace

PageFiles::PageFiles(std::filesystem::path folder, std::string prefix, const pipeline::OutputSettings& settings,
                     io::ColorProfile profile)
    : folder_(std::move(folder)), prefix_(std::move(prefix)), settings_(settings), profile_(std::move(profile)) {}

void PageFiles::begin(const atlas::AtlasEstimate& size) {
  for (std::size_t p = 0; p < size.pages; ++p)
    files_.push_back({folder_ / (prefix_ + pipeline::page_name(p, settings_.texture)), settings_.texture});
}

void PageFiles::take_page(std::size_t number, Image page) {
  io::write_image(files_[number].file, page, settings_.texture, settings_.quality, profile_);
}

void PageFiles::remove() noexcept {
  std::error_code ignored;
  for (const io::PageFile& page : files_) std::filesystem::remove(page.file, ignored);
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

void write_tile(const std::filesystem::path& glb, TileModel& tile, const io::ModelOptions& options, bool compress) {
  tile.mesh.file_positions.clear();
  tile.model.mesh = &tile.mesh;
  std::filesystem::path stem = glb;
  io::write_gltf(stem.replace_extension(), io::GltfContainer::glb, tile.model, tile.pages, options);
  if (compress) compress_geometry(glb);
}

}  // namespace gpvc::tileset
