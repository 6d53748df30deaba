// A textured mesh as a tileset with levels of detail, for viewers that load what is seen (3D Tiles 1.1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "../pipeline/pipeline.h"
#include "tileset_settings.h"

namespace gpvc::tileset {

struct LevelReport {
  std::size_t tiles = 0, faces = 0, page_texels = 0, bytes = 0;
  double texel_size = 0;  ///< least edge of a texel, in the scene's units; 0: those of the photos
  double error = 0;       ///< greatest geometricError of its tiles
};

struct TilesetReport {
  std::vector<LevelReport> levels;  ///< from the leaves to the root
  std::string placing;              ///< remark_on_placing()
};

/// Writes tileset.json, tiles/LEVEL_NUMBER.glb and index.html. Level 0 is the mesh as pipeline::texture_into() textures it, with charts
/// that end at the borders of tiles. Each level above has a quarter of the faces and texels twice as large, and is textured
/// from the photos anew: views are chosen for its own faces, and its texels are means of photo pixels, not of those of the
/// level below. Views that texture nothing on level 0 are not used above. Work is kept level by level, as texture_into() does.
/// Tiles are GLBs without normals, whatever the run's settings say; rules that list faces are about level 0, see
/// rules_of_coarser(). Throws what texture_into() throws, and InputError as refuse_place().
TilesetReport tileset_into(const pipeline::Run& run, const TilesetSettings& settings, pipeline::OutputFolder& folder);

}  // namespace gpvc::tileset
