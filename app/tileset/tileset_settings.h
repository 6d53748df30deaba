// The settings of tilesets.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace gpvc::tileset {

/// Where on the globe a scene without a reference system stands: its origin, or the point that large coordinates are written
/// from.
struct Place {
  double latitude = 0, longitude = 0;  ///< degrees, WGS 84
  double height = 0;                   ///< above the ellipsoid, m
  double heading = 0;  ///< of the scene's y axis, or what is north with another axis up; degrees from north to east
};

struct TilesetSettings {
  std::size_t faces_per_tile = 50000;  ///< at most, which nearly all leaves have
  bool compress = false;               ///< geometry of the tiles' GLBs: io::GltfCoding::compressed
  std::string copyright{};             ///< for viewers to show; empty: none
  std::optional<Place> place{};        ///< for a scene without a reference system
};

}  // namespace gpvc::tileset
