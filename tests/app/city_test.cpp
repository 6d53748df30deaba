#include "app/synth/city.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "io/images.h"
#include "io/mesh.h"
#include "io/scene_files.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

synth::CityOptions small_city() {
  synth::CityOptions options;
  options.faces = 8000;
  options.flight.size_m = 60;
  options.flight.photos = 7;
  options.flight.width = 120;
  options.flight.height = 80;
  return options;
}

TEST(City, ComesNearTheFacesAskedFor) {
  for (const std::size_t faces : {20000u, 60000u}) {
    synth::CityOptions options;
    options.faces = faces;
    const synth::SynthScene city = synth::make_city(options);
    EXPECT_NEAR(static_cast<double>(city.mesh.faces.size()), static_cast<double>(faces),
                0.05 * static_cast<double>(faces));
    EXPECT_EQ(city.face_surface.size(), city.mesh.faces.size());
  }
}

TEST(City, IsTheSameEveryTimeAndAnotherForAnotherSeed) {
  synth::CityOptions options = small_city();
  const synth::SynthScene a = synth::make_city(options), b = synth::make_city(options);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.faces, b.mesh.faces);
  options.flight.seed = 2;
  EXPECT_NE(synth::make_city(options).mesh.positions, a.mesh.positions);
}

TEST(City, CoordinatesSurviveFloats) {
  for (const WorldPoint& p : synth::make_city(small_city()).mesh.positions)
    for (const double v : {p.x, p.y, p.z}) EXPECT_EQ(static_cast<double>(static_cast<float>(v)), v);
}

TEST(City, FacesOfASurfaceWindAlike) {
  // Neighbours run through their common edge in opposite directions.
  const synth::SynthScene city = synth::make_city(small_city());
  std::map<std::array<std::uint32_t, 3>, int> uses;
  for (std::size_t f = 0; f < city.mesh.faces.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const Triangle& t = city.mesh.faces[f];
      ++uses[{city.face_surface[f], t[i], t[(i + 1) % 3]}];
    }
  for (const auto& [edge, count] : uses) EXPECT_EQ(count, 1);
}

TEST(City, RoofsAndGroundFaceUpAndWindowedWallsAreUpright) {
  const synth::SynthScene city = synth::make_city(small_city());
  std::map<synth::Material, int> seen;
  for (std::size_t f = 0; f < city.mesh.faces.size(); ++f) {
    const synth::Surface& surface = city.surfaces[city.face_surface[f]];
    const Triangle& t = city.mesh.faces[f];
    const WorldPoint &a = city.mesh.positions[t[0]], &b = city.mesh.positions[t[1]], &c = city.mesh.positions[t[2]];
    const double up = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);  // twice the area on the map
    ++seen[surface.material];
    if (surface.material == synth::Material::ground || surface.material == synth::Material::tiles ||
        surface.material == synth::Material::gravel) {
      EXPECT_GT(up, 0.0);
    } else if (surface.windows) {
      EXPECT_NEAR(up, 0.0, 0.02);  // vertices lie on a grid of 1 mm
    }
  }
  EXPECT_GT(seen[synth::Material::ground], 0);
  EXPECT_GT(seen[synth::Material::tiles] + seen[synth::Material::gravel], 0);
}

TEST(City, CrownsAreClosedAndWindOutwards) {
  const synth::SynthScene city = synth::make_city(small_city());
  std::map<std::uint32_t, double> volume;
  std::map<std::uint32_t, std::multiset<std::pair<std::uint32_t, std::uint32_t>>> edges;
  for (std::size_t f = 0; f < city.mesh.faces.size(); ++f) {
    const std::uint32_t surface = city.face_surface[f];
    if (city.surfaces[surface].material != synth::Material::leaves) continue;
    const Triangle& t = city.mesh.faces[f];
    const WorldPoint &a = city.mesh.positions[t[0]], &b = city.mesh.positions[t[1]], &c = city.mesh.positions[t[2]];
    volume[surface] +=
        (a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)) / 6;
    for (std::size_t i = 0; i < 3; ++i) edges[surface].insert({t[i], t[(i + 1) % 3]});
  }
  EXPECT_GT(volume.size(), 3u);
  for (const auto& [surface, v] : volume) {
    // A ball of 1.5 m to 2.6 m radius, lumps of 14 % aside.
    EXPECT_GT(v, 4.0 / 3 * 3.14 * 1.2 * 1.2 * 1.2);
    EXPECT_LT(v, 4.0 / 3 * 3.15 * 3.0 * 3.0 * 3.0);
    for (const auto& [from, to] : edges[surface]) EXPECT_EQ(edges[surface].count({to, from}), 1u);
  }
}

TEST(City, FlightLooksDownAndFromFourSides) {
  synth::CityOptions options = small_city();
  options.flight.photos = 23;
  const std::vector<View> views = synth::synth_flight(options.flight);
  ASSERT_EQ(views.size(), 23u);
  std::map<std::string, int> groups;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (v > 0) {
      EXPECT_LT(views[v - 1].name, views[v].name);
    }
    const auto& r = views[v].pose.rotation;
    for (std::size_t i = 0; i < 9; i += 3)
      for (std::size_t j = 0; j < 9; j += 3)
        EXPECT_NEAR(r[i] * r[j] + r[i + 1] * r[j + 1] + r[i + 2] * r[j + 2], i == j ? 1 : 0, 1e-14);
    EXPECT_LT(r[8], -0.6);  // forward points down
    const std::string group = views[v].name.substr(0, views[v].name.find('_'));
    ++groups[group];
    if (group == "nadir") {
      EXPECT_LT(r[8], -0.99);
    }
    if (group == "east") {
      EXPECT_GT(r[6], 0.6);
    }
    if (group == "south") {
      EXPECT_LT(r[7], -0.6);
    }
  }
  EXPECT_EQ(groups.size(), 5u);
  EXPECT_EQ(groups["nadir"], 5);
}

TEST(SynthRenderer, PhotoShowsAKnownPointWhereTheCameraPutsIt) {
  // The centre line of the street along y = 18 m: white dashes on asphalt, 1.5 m long, from x = 0 on. Seen from straight
  // above the first dash, the middle of the photo is white, and 2 m to the side it is dark.
  synth::CityOptions options;
  options.faces = 8000;
  const synth::SynthScene city = synth::make_city(options);
  synth::SynthRenderer renderer(city);
  View view = synth::synth_flight(options.flight).front();
  view.camera = {};
  view.camera.width = view.camera.height = 101;
  view.camera.fx = view.camera.fy = 400;  // 10 m above: 4 cm a pixel
  view.camera.cx = view.camera.cy = 50.5;
  view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  view.pose.centre = {0.75, 18, 16};
  const Image photo = renderer.photo(view.camera, view.pose).image;
  // The ground is surface 0, and its faces come first.
  ASSERT_EQ(city.face_surface[0], 0u);
  ASSERT_TRUE(renderer.sees(view.pose, {0.75, 18, 0}, 0));
  const auto brightness = [&](int x, int y) { return photo.at(x, y)[0] + photo.at(x, y)[1] + photo.at(x, y)[2]; };
  EXPECT_GT(brightness(50, 50), 2 * brightness(50, 20));
  // The dash is 0.24 m wide: 6 pixels; rows 47.5 to 53.5 by their centres.
  int white = 0;
  for (int y = 0; y < 101; ++y) white += brightness(50, y) * 2 > brightness(50, 50) + brightness(50, 20) ? 1 : 0;
  EXPECT_NEAR(white, 6, 1);
}

TEST(SynthRenderer, DistortedPhotoIsThePinholePhotoBent) {
  synth::CityOptions options = small_city();
  const synth::SynthScene city = synth::make_city(options);
  synth::SynthRenderer renderer(city);
  const View view = synth::synth_flight(options.flight).front();
  ASSERT_FALSE(view.camera.distortion.is_identity());
  const Image bent = renderer.photo(view.camera, view.pose).image;
  // The ray through a photo's pixel is the ray through the pixel of the undistorted frame that the lens maps to it. A
  // pinhole camera of one pixel around that ray must see the same.
  for (const PhotoPoint at : {PhotoPoint{10.5, 12.5}, {60.5, 40.5}, {109.5, 70.5}}) {
    const auto pixel = pixel_from_photo(view.camera, at);
    ASSERT_TRUE(pixel.has_value());
    Camera single = view.camera;
    single.distortion = {};
    single.width = single.height = 1;
    single.cx -= pixel->x - 0.5;
    single.cy -= pixel->y - 0.5;
    const Image straight = renderer.photo(single, view.pose).image;
    const std::uint8_t* expected = bent.at(static_cast<int>(at.x), static_cast<int>(at.y));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(straight.at(0, 0)[c], expected[c], 12) << at.x;
  }
}

TEST(CityFiles, CamerasReadBackWithTheirPoses) {
  const test::TemporaryFolder folder;
  synth::CityOptions options = small_city();
  const synth::SynthScene city = synth::make_city(options);
  synth::SynthRenderer renderer(city);
  std::vector<View> views = synth::synth_flight(options.flight);
  std::filesystem::create_directories(folder.path() / "colmap");
  std::filesystem::create_directories(folder.path() / "images");
  for (const View& view : views)
    io::write_image(folder.path() / "images" / view.name, renderer.photo(view.camera, view.pose).image,
                    io::ImageFormat::jpg, 95);
  synth::write_synth_cameras(folder.path() / "colmap", city, views, views, renderer, {});
  synth::write_synth_mesh(folder.path() / "mesh.ply", city.mesh, {});

  const Scene scene = io::read_scene(folder.path() / "colmap", {});
  ASSERT_EQ(scene.views.size(), views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(scene.views[v].name, views[v].name);
    EXPECT_EQ(scene.views[v].camera, views[v].camera);
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(scene.views[v].pose.rotation[i], views[v].pose.rotation[i], 1e-12);
    EXPECT_NEAR(scene.views[v].pose.centre.x, views[v].pose.centre.x, 1e-9);
    EXPECT_NEAR(scene.views[v].pose.centre.z, views[v].pose.centre.z, 1e-9);
  }
  const Mesh mesh = io::read_mesh(folder.path() / "mesh.ply");
  EXPECT_EQ(mesh.positions, city.mesh.positions);
  EXPECT_EQ(mesh.faces, city.mesh.faces);
}

}  // namespace
}  // namespace gpvc
