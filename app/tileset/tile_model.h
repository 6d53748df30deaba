// The faces of a tile as a model of their own.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "../../io/textured_model.h"

namespace gpvc::tileset {

struct TileModel {
  Mesh mesh;
  io::TexturedModel model;  ///< model.mesh is null: set it to &mesh once this value no longer moves
  std::vector<io::PageFile> pages;
};

/// Some faces of a model with their vertices, texture coordinates and pages.
/// \param drop leaves faces out
TileModel tile_model(const io::TexturedModel& all, std::span<const std::uint32_t> faces,
                     std::span<const io::PageFile> pages, const std::function<bool(std::uint32_t)>& drop);

}  // namespace gpvc::tileset
