// The files of textured tiles.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "../../io/images.h"
#include "../../io/textured_model.h"
#include "../pipeline/page_sink.h"
#include "../pipeline/settings.h"

namespace gpvc::tileset {

/// The pages of an atlas as files, for tiles that are written when all are there. Borrows the settings.
class PageFiles final : public pipeline::PageSink {
 public:
  /// \param prefix of the files' names \param samples write pages' samples, too
  PageFiles(std::filesystem::path folder, std::string prefix, const pipeline::OutputSettings& settings,
            io::ColorProfile profile, bool samples);
  void begin(const atlas::AtlasEstimate& size) override;
  void take_page(std::size_t number, Image page) override;
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override;
  std::span<const io::PageFile> files() const { return files_; }
  void remove() noexcept;

 private:
  std::filesystem::path folder_;
  std::string prefix_;
  const pipeline::OutputSettings& settings_;
  io::ColorProfile profile_;
  bool samples_;
  std::vector<io::PageFile> files_;
};

/// Some faces of a model with their vertices, texture coordinates and pages.
struct TileModel {
  Mesh mesh;
  io::TexturedModel model;  ///< model.mesh is null: set it to &mesh once this value no longer moves
  std::vector<io::PageFile> pages;
  io::PhotoTable photos{};  ///< see add_photos(); empty: none
};
/// \param drop leaves faces out
TileModel tile_model(const io::TexturedModel& all, std::span<const std::uint32_t> faces,
                     std::span<const io::PageFile> pages, const std::function<bool(std::uint32_t)>& drop);

/// Lists the photos that a tile's faces show, with the mean edge of what a pixel of the photo as taken covers on them (their
/// ground sampling distance). \param faces, labels of the whole, as tile_model() took them
void add_photos(TileModel& tile, const Scene& scene, std::span<const std::uint32_t> faces,
                std::span<const ViewId> labels);

/// Writes NAME.glb, for the web with WebP pages; changes the tile, which has the coordinates of the scene from then on. \param
/// scratch_folder for those pages until they are in the GLB. Throws OutputError.
void write_tile(const std::filesystem::path& glb, TileModel& tile, const io::ModelOptions& options,
                const pipeline::OutputSettings& settings, const std::filesystem::path& scratch_folder);

/// How a tile's geometry is stored. \param compress for a target that does not ask for more
io::GltfCoding tile_coding(const pipeline::OutputSettings& settings, bool compress);

}  // namespace gpvc::tileset
