// Points taken between reference systems, against formulas of the tests' own.
#include "io/reference_system.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/without_grids.h"

namespace gpvc::io {
namespace {

using test::contains;

// Geocentric coordinates of a place on WGS 84.
WorldPoint on_ellipsoid(double latitude, double longitude, double height) {
  constexpr double kAxis = 6378137, kFlattening = 1 / 298.257223563, kE2 = kFlattening * (2 - kFlattening);
  const double b = latitude * std::numbers::pi / 180, l = longitude * std::numbers::pi / 180;
  const double n = kAxis / std::sqrt(1 - kE2 * std::sin(b) * std::sin(b));
  return {(n + height) * std::cos(b) * std::cos(l), (n + height) * std::cos(b) * std::sin(l),
          (n * (1 - kE2) + height) * std::sin(b)};
}

WorldPoint transformed(const std::string& from, const std::string& to, const WorldPoint& point) {
  std::vector<WorldPoint> points{point};
  transform_points(from, to, points);
  return points[0];
}

void expect_near(const WorldPoint& a, const WorldPoint& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(ReferenceSystem, DegreesAreEastNorthAndHeightAboveTheEllipsoid) {
  const WorldPoint place = on_ellipsoid(50.82, -0.14, 120);
  expect_near(transformed("EPSG:4326", kGeocentric, {-0.14, 50.82, 120}), place, 1e-6);
  expect_near(transformed("EPSG:4979", kGeocentric, {-0.14, 50.82, 120}), place, 1e-6);
  // As Metashape writes it, bound to itself.
  expect_near(
      transformed(R"(GEOGCS["WGS 84",DATUM["World Geodetic System 1984",SPHEROID["WGS 84",6378137,298.257223563],)"
                  R"(TOWGS84[0,0,0,0,0,0,0]],PRIMEM["Greenwich",0],UNIT["degree",0.01745329251994328]])",
                  kGeocentric, {-0.14, 50.82, 120}),
      place, 1e-6);
}

TEST(ReferenceSystem, ProjStringsNeedNotSayThatTheyAreSystems) {
  const WorldPoint place{535216, 5630000, 20};
  const WorldPoint truth = transformed("EPSG:32630", kGeocentric, place);
  expect_near(transformed("+proj=utm +zone=30 +datum=WGS84 +units=m +no_defs", kGeocentric, place), truth, 1e-6);
  expect_near(transformed("+proj=utm +zone=30 +datum=WGS84 +units=m +type=crs", kGeocentric, place), truth, 1e-6);
}

TEST(ReferenceSystem, UtmKeepsHeights) {
  // On a zone's meridian the easting is 500 km, and half a degree further east it is not far from the arc's length times
  // the scale of 0.9996.
  const WorldPoint on_meridian = transformed(kGeocentric, "EPSG:32630", on_ellipsoid(50.82, -3, 77));
  EXPECT_NEAR(on_meridian.x, 500000, 1e-6);
  EXPECT_NEAR(on_meridian.z, 77, 1e-6);
  const WorldPoint beside{535216, on_meridian.y + 118, 20};
  expect_near(transformed(kGeocentric, "EPSG:32630", transformed("EPSG:32630", kGeocentric, beside)), beside, 1e-6);
  const WorldPoint there = transformed("EPSG:32630", "EPSG:4979", beside);
  EXPECT_NEAR(there.x, -2.5, 1e-3);
  EXPECT_NEAR(there.y, 50.82, 1e-3);
}

TEST(ReferenceSystem, NamesUtmZones) {
  EXPECT_EQ(utm_zone(on_ellipsoid(50.82, -0.14, 0)), "EPSG:32630");
  EXPECT_EQ(utm_zone(on_ellipsoid(-33.9, 18.4, 0)), "EPSG:32734");
  EXPECT_EQ(utm_zone(on_ellipsoid(10, 179.999, 0)), "EPSG:32660");
}

TEST(ReferenceSystem, NamesSystemsAndTheirUnits) {
  EXPECT_EQ(system_name("EPSG:32632").name, "WGS 84 / UTM zone 32N");
  EXPECT_EQ(system_name("EPSG:32632").unit, "metre");
  EXPECT_EQ(system_name("EPSG:4326").unit, "degree");
  EXPECT_EQ(system_name("EPSG:2263").unit, "US survey foot");  // New York Long Island
  EXPECT_EQ(system_name("+proj=utm +zone=32 +datum=WGS84 +units=m").name, "") << "not unknown";
  EXPECT_EQ(system_name("EPSG:25832+5783").unit, "metre");  // with heights
  EXPECT_EQ(system_name("+proj=utm +zone=32 +datum=WGS84 +units=m +type=crs").unit, "metre");
  EXPECT_EQ(system_name("+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs").unit, "metre")
      << "as OpenDroneMap writes it";
  EXPECT_EQ(system_name("+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs").code, "EPSG:32632");
  EXPECT_EQ(system_name("EPSG:25832").code, "EPSG:25832");
  EXPECT_EQ(system_name("+proj=tmerc +lat_0=48.2 +lon_0=11 +datum=WGS84").code, "") << "somebody's own";
  EXPECT_EQ(system_name("Local Coordinates (m)").unit, "");
  EXPECT_EQ(system_name("").name, "");
}

TEST(ReferenceSystem, NamesWhatHeightsAreAbove) {
  EXPECT_EQ(system_name("EPSG:32632+5773").heights, "EGM96 geoid");
  EXPECT_EQ(system_name("EPSG:26910+5703").heights, "North American Vertical Datum 1988");
  for (const char* ellipsoidal : {"EPSG:4979", "EPSG:4978"}) EXPECT_EQ(system_name(ellipsoidal).heights, "");
  for (const char* flat : {"EPSG:32632", "EPSG:4326", "+proj=utm +zone=32 +datum=WGS84"})
    EXPECT_FALSE(system_name(flat).heights) << flat;
}

// PROJ by itself leaves heights as they are where it lacks the geoid.
TEST(ReferenceSystem, RefusesHeightsWhoseGridIsMissing) {
  const std::string from = "EPSG:32632+3855";
  const WorldPoint place{500000, 5600000, 100};
  const test::WithoutGrids without;
  const auto grid = missing_grid(from, kGeocentric, place);
  ASSERT_TRUE(grid);
  EXPECT_LT(grid->accuracy_m, 0);
  try {
    transformed(from, kGeocentric, place);
    FAIL() << "heights left as they are";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), sentence_on(*grid, from, kGeocentric));
    EXPECT_TRUE(contains(error.what(), "PROJ lacks the grid " + grid->name + " for the way from 'EPSG:32632+3855'"));
  }
}

// Of DHHN92 PROJ knows where other heights of Europe lie, but no geoid, and by itself leaves heights as they are.
TEST(ReferenceSystem, RefusesHeightsForWhichThereIsNoWay) {
  const WorldPoint place{500000, 5600000, 100};
  const std::string from = "EPSG:25832+5783";
  for (const std::string to : {"EPSG:4979", kGeocentric, "EPSG:32632"}) {
    const auto lacking = missing_grid(from, to, place);
    ASSERT_TRUE(lacking) << to;
    EXPECT_EQ(lacking->name, "");
    EXPECT_LT(lacking->accuracy_m, 0);
    const std::optional<Error> error = test::caught([&] { transformed(from, to, place); });
    ASSERT_TRUE(error) << to;
    EXPECT_TRUE(contains(error->what(), "PROJ knows no way for heights from 'EPSG:25832+5783' to '" + to + "'"));
  }
  EXPECT_TRUE(test::caught([&] { transformed("EPSG:32632", from, place); })) << "and back";
  for (const std::string to : {"EPSG:25833+5783", "EPSG:25832+7837"}) {
    EXPECT_FALSE(missing_grid(from, to, place)) << to;
    EXPECT_NEAR(transformed(from, to, place).z, 100, 0.1) << to;
  }
}

TEST(ReferenceSystem, MissesNoGridWhereNoneIsNeeded) {
  const WorldPoint place{500000, 5600000, 100};
  EXPECT_FALSE(missing_grid("EPSG:32632", kGeocentric, place));
  EXPECT_FALSE(missing_grid("EPSG:25832", kGeocentric, place));
  EXPECT_FALSE(missing_grid("EPSG:32632+5773", kGeocentric, place)) << "EGM96 comes with PROJ";
  EXPECT_FALSE(missing_grid("EPSG:25832+7837", "EPSG:25833+7837", place)) << "the same heights";
}

TEST(ReferenceSystem, SaysWhatIsUnknownOrImpossible) {
  const auto error = [](const std::string& from, const WorldPoint& point) -> std::string {
    try {
      transformed(from, kGeocentric, point);
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_TRUE(contains(error("EPSG:99999", {}), "'EPSG:99999' is no coordinate reference system"));
  EXPECT_TRUE(contains(error("EPSG:32630", {1e12, 1e12, 0}), "the point (1e+12, 1e+12, 0) is none of 'EPSG:32630'"));
}

}  // namespace
}  // namespace gpvc::io
