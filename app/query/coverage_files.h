// Coverage as files: a map of areas, a table, and a picture from above.
#pragma once

#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "app/query/coverage.h"
#include "app/query/ground.h"
#include "app/query/outline.h"
#include "io/image.h"

namespace gpvc::query {

/// RFC 7946: a FeatureCollection of MultiPolygons, one an area, in longitude and latitude; without a reference system in the
/// ground's coordinates, which "coordinates" says. Throws Error.
evaluate::Json areas_geojson(const std::vector<Area>& areas, const Ground& ground, const CellGrid& grid);

/// One line an area, under a head. Coordinates are the scene's (with its offset) and, where they are known, degrees.
std::string areas_table(const std::vector<Area>& areas, const checks::Input& input, const Ground& ground);

/// The highest faces over a grid, coloured by the number of photos that see them, those that are coarse or seen at grazing angles
/// hatched; with a legend below.
Image coverage_picture(const Ground& ground, const FaceCoverage& coverage, const std::vector<Lack>& lacks,
                       const Wanted& wanted, const CellGrid& grid);

}  // namespace gpvc::query
