// Coordinate reference systems: points from one to another, by PROJ.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene.h"

namespace gpvc::io {

/// Geocentric coordinates (ECEF) on the WGS 84 ellipsoid.
inline constexpr const char* kGeocentric = "EPSG:4978";

/// What z means where the system of the points has no heights of its own: the height above its own ellipsoid, as PROJ takes it,
/// or above the ellipsoid of the target, as receivers of WGS 84 give it. Between older national systems and WGS 84 the two
/// differ by some 50 m, about as much as heights above sea level differ from heights above the ellipsoid.
enum class HeightsAbove { own_ellipsoid, ellipsoid_of_target };

/// Takes points from one system to another. Systems are what PROJ reads: EPSG:25832, a WKT, a PROJ string. x is east or
/// longitude in degrees, y north or latitude. Throws Error: one sentence that names the system that is unknown, the first point that lies
/// beyond what can be projected, or what is missing (MissingGrid) where PROJ would leave heights as they are. O(points).
void transform_points(const std::string& from, const std::string& to, std::span<WorldPoint> points,
                      HeightsAbove heights = HeightsAbove::own_ellipsoid);

/// A grid that PROJ needs for the best way from one system to another, and does not have; or that it knows no way at all to
/// take heights from one to the other.
struct MissingGrid {
  std::string name;       ///< "de_bkg_gcg2016.tif"; empty where PROJ knows no way for heights, with any grid
  std::string address;    ///< where it is to be had; may be empty
  double accuracy_m = 0;  ///< of the way that PROJ takes instead; below 0: that leaves heights, or more, as they are
};

/// Of transform_points() at a point; nullopt where nothing is missed. Throws Error as that does.
std::optional<MissingGrid> missing_grid(const std::string& from, const std::string& to, const WorldPoint& point,
                                        HeightsAbove heights = HeightsAbove::own_ellipsoid);

/// What a missing grid means, and where it is to be had: one sentence.
std::string sentence_on(const MissingGrid& grid, const std::string& from, const std::string& to);

struct SystemName {
  std::string name;  ///< "WGS 84 / UTM zone 32N"; empty where PROJ knows none
  std::string unit;  ///< of its first axis: "metre", "degree", "US survey foot"; empty where PROJ knows none
  /// What its heights are above: "EGM96 geoid"; empty: its ellipsoid; nullopt where it says nothing of heights.
  std::optional<std::string> heights{};
  /// "EPSG:32632", also of a system that a WKT or a PROJ string describes; empty where PROJ knows none that is the same.
  std::string code{};
  bool is_geocentric = false;  ///< x, y and z from the middle of the earth: none of them is a height
};

/// What PROJ calls a system. Empty for text that it does not know as one.
SystemName system_name(const std::string& system);

/// A system's definition in one line of WKT (ISO 19162:2019), as other programs read it. Throws Error for text that PROJ does not
/// know as a system.
std::string system_wkt(const std::string& system);

/// The UTM zone of a geocentric point, as EPSG:326NN or EPSG:327NN. Throws Error.
std::string utm_zone(const WorldPoint& geocentric);

}  // namespace gpvc::io
