// tileset.json of 3D Tiles 1.1, https://docs.ogc.org/cs/22-025r4/22-025r4.html, and the page that opens it.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../../io/textured_model.h"
#include "placing.h"

namespace gpvc::tileset {

/// An axis-aligned box in a tile's coordinates; empty as made.
struct TileBox {
  TilePoint low, high;
  bool is_empty = true;
  void add(const TilePoint& p);
  void add(const TileBox& box);
};

struct Tile {
  std::string file;  ///< relative to tileset.json; empty: no content
  TileBox box;       ///< of its faces
  double error =
      0;  ///< how much detail it lacks, in the scene's units: viewers replace it by its children where that is seen
};

/// Tile::error of a level above the leaves. \param surface how far its surface is from that of the leaves
/// \param texel edge of its texels
double geometric_error(double surface, double texel);

/// The text of tileset.json. `levels`: from the leaves up to the root; tile n has the children 4 n to 4 n + 3. Where tiles
/// have children, they are replaced by them. Its asset names the program, the day (UTC), whose it is, and where it lies.
std::string tileset_text(std::span<const std::vector<Tile>> levels, const io::ModelOptions& options,
                         const std::optional<Place>& place);

/// Writes tileset.json and index.html, which shows it with a CesiumJS in the folder cesium/ beside it, and else says how.
/// Throws OutputError.
void write_tileset(const std::filesystem::path& folder, std::span<const std::vector<Tile>> levels,
                   const io::ModelOptions& options, const std::optional<Place>& place);

/// The text of index.html.
extern const char* const kTilesetPage;

}  // namespace gpvc::tileset
