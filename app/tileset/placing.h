// Where tiles are: their coordinates, and the way from there to the globe.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "../../io/scene.h"
#include "../../io/textured_model.h"
#include "tileset_settings.h"

namespace gpvc::tileset {

/// A point in the coordinates of a tile, whose z points up. In its glTF file y does; viewers of 3D Tiles turn it.
struct TilePoint {
  std::array<double, 3> at{};
};

/// The tile's coordinates of a position, as viewers place it. `options`: those that the tile's file is written with.
TilePoint tile_from_world(const io::ModelOptions& options, const WorldPoint& p);

/// The latitude and longitude, in degrees, of ENU:LATITUDE,LONGITUDE; nullopt for other systems.
std::optional<std::array<double, 2>> place_of_enu(const std::string& system);

/// Four columns, one after another.
using Matrix = std::array<double, 16>;

/// Transverse Mercator around the origin of coordinates east, north and up from a place, for PROJ: the plane of the two within a
/// centimetre for ten kilometres at this height, and known to every program.
std::string plane_around(const std::array<double, 2>& place, double height);

/// Takes tiles to geocentric coordinates, from the reference system of `options`: what PROJ knows, or
/// ENU:LATITUDE,LONGITUDE. The system's axes at the offset of `options` stand for those around it. nullopt where no system is
/// named, or none that is known.
std::optional<Matrix> geocentric_from_tile(const io::ModelOptions& options);

/// Why geocentric_from_tile() gives none, a sentence's end; empty where it gives one.
std::string obstacle_to_geocentric(const io::ModelOptions& options);

/// The root's transform: to geocentric coordinates by the reference system, or else by the place; without both back to the
/// scene's own coordinates.
Matrix root_transform(const io::ModelOptions& options, const std::optional<Place>& place);

/// A sentence on where root_transform() puts tiles, and what their heights are above; empty where there is nothing to say.
std::string remark_on_placing(const io::ModelOptions& options, const std::optional<Place>& place);

/// Throws InputError where a place is given for a scene that its reference system places. \param any a position of its mesh
void refuse_place(const Scene& scene, const WorldPoint& any, const std::optional<Place>& place);

}  // namespace gpvc::tileset
