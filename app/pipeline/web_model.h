// Models for the web: small enough for a browser to load.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "../../io/textured_model.h"
#include "run.h"

namespace gpvc::pipeline {

/// Settings with what OutputSettings::target asks for where it is not set. For the web: kWebBytes, one page, and as many texels as
/// these bytes allow beside the geometry that so many faces take. Pages of places that are given stay as they are; those in model.glb are made smaller
/// where they take too many bytes. Throws InputError where the geometry alone takes more.
Settings with_target(Settings settings, std::size_t faces, bool has_layout = false);

/// Pages as WebP, each with a fallback where OutputSettings asks for one.
struct WebPages {
  std::vector<io::PageFile> files;
  std::vector<std::filesystem::path> written;  ///< files that came to be
  std::size_t bytes = 0;                       ///< that a reader loads: all but fallbacks that are files of their own
  int quality = 0;                             ///< of the WebPs
  int reduction = 1;                           ///< of their edges
  bool can_shrink = false;                     ///< they may be halved
  /// Removes what was written.
  void remove() const noexcept;
};

/// Writes STEM_N.webp from the file of each page. Its fallback is STEM_N_small.jpg, a JPEG of a quarter of its width and
/// height; for a glTF with files, where it takes nothing that is not there already, the page itself. Throws InputError,
/// OutputError. TBB.
WebPages write_web_pages(std::span<const io::PageFile> pages, const std::filesystem::path& stem,
                         const OutputSettings& settings, io::GltfContainer container);

struct WebModel {
  io::GltfFiles files;
  WebPages pages;         ///< beside a model.gltf; in a GLB, and removed
  std::size_t bytes = 0;  ///< that a reader loads
};

/// Writes STEM.glb or its parts for the web from the files of its pages, which stay as they are. With normals where viewers
/// light the model. To stay within OutputSettings::max_bytes, the quality of the pages falls, to 50 at the least, and then
/// their edges are halved. Throws OutputError where that is not enough.
WebModel write_web_model(const Run& run, const std::filesystem::path& stem, const io::TexturedModel& model,
                         std::span<const io::PageFile> pages, io::ModelOptions options);

/// Says how large it is, and why.
void report(const WebModel& model, Observer& observer);

}  // namespace gpvc::pipeline
