// The description of a glTF: its JSON, from where the arrays and pages lie in the buffers.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/meshes/gltf_arrays.h"

namespace gpvc::io {

/// A range of a buffer; offsets are multiples of four.
struct Part {
  std::size_t buffer = 0, offset = 0, bytes = 0;
};

/// A page inside a buffer, and its fallback where it has one.
struct EmbeddedPage {
  Part page;
  std::optional<Part> fallback;
};

/// Buffer layout: for each primitive its arrays, one after the other; behind them the table of photos and, in a GLB, the page
/// files. Every buffer is written front to back.
struct GltfLayout {
  std::vector<std::array<Part, kGltfArrays>> primitives;
  std::optional<Part> photo_table;  ///< in the last buffer
  std::vector<EmbeddedPage> pages;  ///< one a primitive; empty when pages stay files
  std::vector<std::size_t> buffer_bytes;
};

/// The JSON; `buffer_files` is empty for a GLB. Throws OutputError where a coordinate is beyond 32-bit floats.
std::string describe(const GltfAsset& asset, const GltfLayout& layout,
                     const std::vector<std::filesystem::path>& buffer_files);

}  // namespace gpvc::io
