// tileset.json of 3D Tiles 1.1, https://docs.ogc.org/cs/22-025r4/22-025r4.html
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../../io/scene.h"
#include "../../io/textured_model.h"

namespace gpvc::tileset {

/// A point of a tile's coordinates, in which z points up: those of the glTF, whose y does, as viewers turn them.
struct TilePoint {
  std::array<double, 3> at{};
};

/// An axis-aligned box in a tile's coordinates; empty as made.
struct TileBox {
  TilePoint low, high;
  bool is_empty = true;
  void add(const TilePoint& p);
  void add(const TileBox& box);
};

/// The tile's coordinates of a position, as viewers place it. `options`: those that the tile's file is written with.
TilePoint tile_from_world(const io::ModelOptions& options, const WorldPoint& p);

struct Tile {
  std::string file;  ///< relative to tileset.json; empty: no content
  TileBox box;       ///< of its faces
  double error =
      0;  ///< how much detail it lacks, in the scene's units: viewers replace it by its children where that is seen
};

/// Tile::error of a level above the leaves. \param surface how far its surface is from that of the leaves
/// \param texel edge of its texels
double geometric_error(double surface, double texel);

/// The matrix, column by column, that takes tiles to geocentric coordinates, from the reference system of `options`: what
/// PROJ knows, or ENU:LATITUDE,LONGITUDE. The system's axes at the offset of `options` stand for those around it. nullopt
/// where no system is named, or none that is known.
std::optional<std::array<double, 16>> geocentric_from_tile(const io::ModelOptions& options);

/// Why geocentric_from_tile() gives none, a sentence's end; empty where it gives one.
std::string obstacle_to_geocentric(const io::ModelOptions& options);

/// The text of tileset.json. `levels`: from the leaves up to the root; tile n has the children 4 n to 4 n + 3. Where tiles
/// have children, they are replaced by them.
std::string tileset_text(std::span<const std::vector<Tile>> levels, const io::ModelOptions& options);

}  // namespace gpvc::tileset
