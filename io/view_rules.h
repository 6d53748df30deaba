// Which photos may texture which part of a mesh, as a user states it in a file: `gpvc texture --allow`.
//
// JSON: an object with a list "rules" of objects, each with one region and one choice:
//   "box": [[x, y, z], [x, y, z]]                   two opposite corners
//   "polygon": [[x, y], ...], "z": [low, high]      on the ground; "z" may be missing
//   "faces": [7, [100, 120], ...]                   indices, and ranges with both ends; or "FILE", a list of faces
//   "photo": "NAME", "pixels": [[x, y], [x, y]]     what a photo shows between two opposite corners, in pixels of the photo
//   "allow": "NAME" or ["NAME", ...]                names or globs of photos: no other ones there
//   "forbid": the same                              not these ones there; may be missing for "photo": not that one
// GeoJSON (RFC 7946), as GIS programs write it: each Polygon or MultiPolygon is a polygon as above; its properties "allow" or
// "forbid" (a list, or names separated by semicolons) and "z" say the rest, others are ignored.
// CSV: a line a rule of four fields; blank lines and lines that begin with # are skipped:
//   box,X Y Z X Y Z,allow,NAME;NAME...
//   polygon,X Y X Y X Y...,forbid,NAME;NAME...
//   faces,7 100-120 ...,forbid,NAME;NAME...         or @FILE, a list of faces
//   photo,NAME X Y X Y                              not that photo; or with ,allow|forbid,NAME;NAME...
// Coordinates are those of the mesh's file; of GeoJSON those that it states. A list of faces is text: indices and ranges as
// in CSV, separated by blanks, commas or line ends, # before a remark. Its path counts from the folder of the rules.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "scene.h"

namespace gpvc::io {

struct BoxRegion {
  WorldPoint low, high;
};
/// Above and below a polygon of the x-y plane, between two heights. Points in an odd number of its windings are inside.
struct GroundRegion {
  std::vector<std::array<double, 2>> corners;  ///< at least three
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};
struct FaceRegion {
  std::vector<std::array<std::uint32_t, 2>> ranges;  ///< first and last face
};
using Region = std::variant<BoxRegion, GroundRegion, FaceRegion>;

/// What a photo shows in a rectangle, in pixels of the photo as taken.
struct PhotoRegion {
  std::string photo;  ///< name or glob, as given
  PhotoPoint low, high;
};
using ListedRegion = std::variant<BoxRegion, GroundRegion, FaceRegion, PhotoRegion>;

/// The reference system of GeoJSON that names none: longitude and latitude.
inline constexpr const char* kGeoJsonSystem = "OGC:CRS84";

struct ListedViewRule {
  ListedRegion region;
  std::string srs;                  ///< of the region's coordinates; empty: those of the mesh's file
  bool allow = false;               ///< these photos alone; else all but these
  std::vector<std::string> photos;  ///< names or globs, as given; at least one
  std::string place;                ///< in the file: "rule 2", "line 4"
};

/// Told apart by content: JSON begins with a brace, and GeoJSON has a type. Throws InputError. O(bytes of the file).
std::vector<ListedViewRule> read_view_rules(const std::filesystem::path& file);
/// The same from memory; `file` is named in errors.
std::vector<ListedViewRule> parse_view_rules(const std::filesystem::path& file, std::string_view text);

/// The faces of a mesh by where they are, for many regions.
class FaceLocator {
 public:
  /// By the mesh's positions, or by others of its vertices. O(faces log faces), TBB.
  explicit FaceLocator(const Mesh& mesh) : FaceLocator(mesh.positions, mesh.faces) {}
  FaceLocator(std::span<const WorldPoint> positions, std::span<const Triangle> faces);
  /// Those whose middle (the mean of its corners) lies in the region, or which it lists, ascending. Faces beyond the mesh's are
  /// no error here. O(faces of the region's range of x x sides of a polygon at their y), TBB.
  std::vector<std::uint32_t> faces_in(const Region& region) const;

 private:
  std::vector<std::uint32_t> faces_where(std::array<double, 2> x,
                                         const std::function<bool(const WorldPoint&)>& is_inside) const;

  std::vector<WorldPoint> middles_;
  std::vector<std::uint32_t> by_x_;
};

/// A flag per face: 1 if it is one of FaceLocator(mesh).faces_in(region).
std::vector<std::uint8_t> faces_in(const Region& region, const Mesh& mesh);

}  // namespace gpvc::io
