// Points of GeoJSON files, and archives of NumPy arrays.
#include "io/geojson_points.h"

#include <gtest/gtest.h>

#include "io/files/zip_file.h"
#include "io/npz.h"
#include "io/photo_pixel.h"
#include "io/view_rules.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

TEST(GeoJsonPoints, HaveNamesHeightsAndTheSystemOfTheFile) {
  const TemporaryFolder folder;
  const auto file = folder.write("points.geojson", R"({"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "GCP 7"}, "geometry": {"type": "Point", "coordinates": [8.5, 47.25, 400]}},
    {"type": "Feature", "id": 12, "properties": null, "geometry": {"type": "Point", "coordinates": [8, 47]}},
    {"type": "Feature", "properties": {"name": null}, "geometry": {"type": "MultiPoint", "coordinates": [[1, 2], [3, 4, 5]]}}]})");
  const GeoPoints read = read_geojson_points(file);
  EXPECT_EQ(read.srs, kGeoJsonSystem);
  ASSERT_EQ(read.points.size(), 4U);
  EXPECT_EQ(read.points[0].name, "GCP 7");
  EXPECT_EQ(read.points[0].at, (WorldPoint{8.5, 47.25, 400}));
  EXPECT_TRUE(read.points[0].has_height);
  EXPECT_EQ(read.points[1].name, "12");
  EXPECT_FALSE(read.points[1].has_height);
  EXPECT_EQ(read.points[3].name, "feature 3, point 2");
  const auto utm = folder.write("utm.geojson", R"({"type": "Point", "coordinates": [448000.5, 5411000],
    "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}})");
  EXPECT_EQ(read_geojson_points(utm).srs, "urn:ogc:def:crs:EPSG::25832");
}

TEST(GeoJsonPoints, EverythingElseIsRefusedWithItsPlace) {
  const TemporaryFolder folder;
  for (const auto& [text, why] : std::vector<std::pair<std::string, std::string>>{
           {"", "JSON"},
           {"7", "expected GeoJSON"},
           {"{}", "type"},
           {R"({"type": "Feature", "geometry": null})", "the feature"},
           {R"({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": {"type": "Polygon"}}]})",
            "feature 1: expected a Point or a MultiPoint, found 'Polygon'"},
           {R"({"type": "Point", "coordinates": [1e999, 2]})", "points.geojson"},
           {R"({"type": "Point", "coordinates": [1]})", "expected two or three numbers"},
           {R"({"type": "MultiPoint", "coordinates": []})", "holds no point"}}) {
    const auto file = folder.write("points.geojson", text);
    EXPECT_TRUE(contains(input_error([&] { read_geojson_points(file); }), why)) << text;
  }
}

TEST(Npz, HoldsArraysByNameAndTheSameBytesEachTime) {
  const TemporaryFolder folder;
  const std::vector<std::uint64_t> first{0, 2, 5000000000};
  const std::vector<float> costs(100000, 0.5F);
  std::string bytes[2];
  for (std::string& each : bytes) {
    const auto file = folder.path() / "a.npz";
    NpzWriter out(file);
    out.add("first", first);
    out.add("costs", costs);
    EXPECT_FALSE(std::filesystem::exists(file)) << "before it is complete";
    out.commit();
    each = test::read_file(file);
    std::filesystem::remove(file);
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_LT(bytes[0].size(), 20000U) << "packed";
  const std::filesystem::path name = "a.npz";
  const ZipFile archive(name, bytes[0]);
  const std::string array = archive.read("first.npy");
  EXPECT_TRUE(contains(array, "{'descr': '<u8', 'fortran_order': False, 'shape': (3,), }"));
  EXPECT_EQ(array.substr(128), std::string(reinterpret_cast<const char*>(first.data()), 24));
  EXPECT_EQ(archive.members().size(), 2U);
}

TEST(Npz, AnArchiveThatIsNotCommittedLeavesNothing) {
  const TemporaryFolder folder;
  { NpzWriter(folder.path() / "a.npz").add("x", std::vector<float>{1}); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(PhotoPixel, IsThatOfTheWholePhoto) {
  View view;
  view.camera.width = 400;
  view.reduction = 4;
  EXPECT_EQ(taken_pixel(view, {10.5, 3}).x, 42);
  EXPECT_EQ(taken_pixel(view, {10.5, 3}).y, 12);
}

}  // namespace
}  // namespace gpvc::io
