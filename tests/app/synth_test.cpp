// Scenes of layers, and what spoils scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/synth/city.h"
#include "app/synth/synth_builder.h"
#include "app/synth/terrain.h"
#include "io/mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

void expect_exact_in_floats(const Mesh& mesh) {
  for (const WorldPoint& p : mesh.positions)
    for (const double v : {p.x, p.y, p.z}) ASSERT_EQ(static_cast<double>(static_cast<float>(v)), v);
}

TEST(Terrain, SheetsFollowTheHillsAtTheGap) {
  synth::LayerOptions low, high;
  low.faces = high.faces = 5000;
  low.gap_m = 1;
  high.gap_m = 9;
  const synth::SynthScene a = synth::make_terrain(low), b = synth::make_terrain(high);
  EXPECT_NEAR(static_cast<double>(a.mesh.faces.size()), 5000, 500);
  ASSERT_EQ(a.mesh.faces.size(), b.mesh.faces.size());
  ASSERT_EQ(a.face_surface, b.face_surface);
  expect_exact_in_floats(a.mesh);
  std::size_t above = 0;
  for (std::size_t f = 0; f < a.mesh.faces.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const WorldPoint &p = a.mesh.positions[a.mesh.faces[f][i]], &q = b.mesh.positions[b.mesh.faces[f][i]];
      EXPECT_EQ(q.z - p.z, a.face_surface[f] == 0 ? 0 : 8);
      above += a.face_surface[f] != 0;
    }
  EXPECT_GT(above, a.mesh.faces.size() * 2 / 5);
}

// With heights that follow the same hills over other triangles the layers would cross.
TEST(Terrain, EveryFacetOfASheetHasOneOfTheGroundBelow) {
  synth::LayerOptions options;
  options.faces = 5000;
  options.gap_m = 0.01;
  const synth::SynthScene scene = synth::make_terrain(options);
  const auto flat = [](const WorldPoint& p) { return std::pair(p.x, p.y); };
  std::map<std::set<std::pair<double, double>>, std::map<std::pair<double, double>, double>> ground;
  std::size_t sheets = 0;
  for (std::size_t f = 0; f < scene.mesh.faces.size(); ++f) {
    std::set<std::pair<double, double>> corners;
    std::map<std::pair<double, double>, double> heights;
    for (const std::uint32_t v : scene.mesh.faces[f]) {
      const WorldPoint& p = scene.mesh.positions[v];
      corners.insert(flat(p));
      heights[flat(p)] = p.z;
    }
    if (scene.face_surface[f] == 0) {
      ground[corners] = heights;
      continue;
    }
    ASSERT_TRUE(ground.contains(corners)) << f;
    // A 1024th for the rounding of heights.
    for (const auto& [at, z] : heights) EXPECT_NEAR(z - ground[corners][at], 0.01, 1.01 / 1024);
    ++sheets;
  }
  EXPECT_GT(sheets, 700u);
}

TEST(Slits, GapsHalveFromAQuarterToHundredthsOfAMillimetre) {
  synth::LayerOptions options;
  options.faces = 20000;
  options.size_m = 1;
  const synth::SynthScene scene = synth::make_slits(options);
  expect_exact_in_floats(scene.mesh);
  // A stand is a board of brick, followed by its slats. The gap is the distance from the board to the nearest of them.
  std::vector<WorldPoint> middle(scene.surfaces.size());
  std::vector<double> corners(scene.surfaces.size(), 0);
  for (std::size_t f = 0; f < scene.mesh.faces.size(); ++f)
    for (const std::uint32_t v : scene.mesh.faces[f]) {
      middle[scene.face_surface[f]] = middle[scene.face_surface[f]] + scene.mesh.positions[v];
      ++corners[scene.face_surface[f]];
    }
  std::vector<double> gaps;
  const synth::Surface* board = nullptr;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    if (scene.surfaces[s].material == synth::Material::brick) {
      board = &scene.surfaces[s];
      gaps.push_back(1e9);
    } else if (board != nullptr) {
      const WorldPoint &u = board->u_axis, &v = board->v_axis;
      const WorldPoint normal{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
      gaps.back() = std::min(gaps.back(), dot(normal, middle[s] * (1 / corners[s]) - board->origin));
    }
  }
  ASSERT_EQ(gaps.size(), 16u);
  std::sort(gaps.begin(), gaps.end());
  EXPECT_NEAR(gaps.front(), 1.0 / 65536, 4e-6);  // vertices lie on a grid of 2^-20
  EXPECT_NEAR(gaps.back(), 0.25, 4e-6);
  for (std::size_t i = 1; i < gaps.size(); ++i) EXPECT_LT(gaps[i], 2.1 * gaps[i - 1]);
}

// Straight down from 25 m on two squares, the upper one 2^-13 m (an eighth of a millimetre) above the lower.
TEST(SynthRenderer, TellsLayersAnEighthOfAMillimetreApart) {
  synth::SynthBuilder builder(10, 1048576, 1);
  builder.quad(synth::Material::gravel, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  builder.quad(synth::Material::paint, {-1, -1, 1.0 / 8192}, {2, 0, 0}, {0, 2, 0});
  const synth::SynthScene scene = builder.take();
  synth::SynthRenderer renderer(scene);
  Camera camera;
  camera.width = camera.height = 41;
  camera.fx = camera.fy = 200;
  camera.cx = camera.cy = 20.5;
  Pose pose;
  pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  pose.centre = {0, 0, 25};
  const synth::SynthPhoto photo = renderer.photo(camera, pose);
  const auto at = [&](int x, int y) { return photo.surfaces[static_cast<std::size_t>(y * 41 + x)]; };
  EXPECT_EQ(at(20, 20), 1u);
  EXPECT_EQ(at(20 - 7, 20), 1u);  // 8 px a metre: the paint ends 8 px from the middle
  EXPECT_EQ(at(20 - 10, 20), 0u);
  EXPECT_EQ(at(0, 0), synth::kNoSurface);
  EXPECT_FALSE(renderer.sees(pose, {0.5, 0.25, 0}, 1)) << "under the paint";
  EXPECT_TRUE(renderer.sees(pose, {1.5, 0.25, 0}, 1));
  EXPECT_TRUE(renderer.sees(pose, {0.5, 0.25, 1.0 / 8192}, 2));
}

struct Overhead {
  synth::CityOptions options;
  View view;
  explicit Overhead(int width = 160) {
    options.faces = 6000;
    options.flight.size_m = 60;
    options.flight.photos = 1;
    options.flight.width = width;
    options.flight.height = width * 3 / 4;
    view = synth::synth_flight(options.flight).front();
  }
};

TEST(SynthRenderer, CarsAndPeopleAreInTheirPhotoAlone) {
  const Overhead at(960);  // 6 cm a pixel: a person is some pixels wide
  const synth::SynthScene city = synth::make_city(at.options);
  constexpr synth::Unmodelled kWhat{.cars = 30, .people = 40};
  const synth::SynthScene movers = synth::make_unmodelled(at.options, 0, kWhat);
  ASSERT_EQ(movers.surfaces.size(), 30u * 11 + 40 * 18);
  synth::SynthRenderer renderer(city);
  const synth::SynthPhoto before = renderer.photo(at.view.camera, at.view.pose),
                          with = renderer.photo(at.view.camera, at.view.pose, {}, &movers),
                          after = renderer.photo(at.view.camera, at.view.pose);
  EXPECT_EQ(before.image.pixels, after.image.pixels);
  std::size_t car_pixels = 0, person_pixels = 0;
  for (std::size_t i = 0; i < with.surfaces.size(); ++i) {
    EXPECT_EQ(before.unmodelled[i], 0);
    const std::uint32_t s = with.surfaces[i];
    const bool mover = s < synth::kMixedSurfaces && s >= city.surfaces.size();
    if (mover) {
      ASSERT_LT(s, city.surfaces.size() + movers.surfaces.size());
      ++(s < city.surfaces.size() + 30 * 11 ? car_pixels : person_pixels);
      EXPECT_EQ(with.unmodelled[i], 255);
    } else if (s != synth::kMixedSurfaces) {
      EXPECT_EQ(s, before.surfaces[i]);
      EXPECT_EQ(with.unmodelled[i], 0);
    }
  }
  EXPECT_GT(car_pixels, 20u);
  EXPECT_GT(person_pixels, 0u);
  EXPECT_NE(synth::make_unmodelled(at.options, 1, kWhat).mesh.positions, movers.mesh.positions);
  EXPECT_EQ(synth::make_unmodelled(at.options, 0, kWhat).mesh.positions, movers.mesh.positions);
}

TEST(SynthUnmodelled, PeopleAreAsTallAsPeopleAndStandAtStreets) {
  const Overhead at;
  const synth::SynthScene people = synth::make_unmodelled(at.options, 3, {.people = 50});
  double top = 0;
  for (const WorldPoint& p : people.mesh.positions) {
    top = std::max(top, p.z);
    EXPECT_GE(p.z, 0);
    const auto off_block = [](double v) {
      return std::abs(v / synth::kBlockPitch_m - std::round(v / synth::kBlockPitch_m)) * synth::kBlockPitch_m;
    };
    // Beyond the gardens, which end where pavements begin.
    EXPECT_GT(std::max(off_block(p.x), off_block(p.y)),
              (synth::kBlockPitch_m - synth::kStreet_m) / 2 - synth::kWalk_m - 0.1);
  }
  EXPECT_NEAR(top, 1.74, 0.01);
}

// From 5 m before a wall a fence of wires 3 cm wide every 20 cm, one metre before it, covers 28 % of it.
TEST(SynthUnmodelled, FencesStandBeforeWallsInAllPhotosAlike) {
  const Overhead at;
  const synth::SynthScene fence = synth::make_unmodelled(at.options, 0, {.fences = true});
  ASSERT_EQ(fence.surfaces.size(), 1u);
  EXPECT_EQ(fence.mesh.positions, synth::make_unmodelled(at.options, 7, {.fences = true}).mesh.positions);
  EXPECT_EQ(synth::make_unmodelled(at.options, 7, {.cars = 2, .fences = true}).surfaces.size(), 23u);
  const synth::SynthScene city = synth::make_city(at.options);
  synth::SynthRenderer renderer(city);
  // The southernmost wall with windows looks away from the middle of the city.
  std::uint32_t wall = 0;
  double south = 0;
  for (std::uint32_t s = 0; s < city.surfaces.size(); ++s)
    if (city.surfaces[s].windows && city.surfaces[s].u_axis.x > 0.9 && city.surfaces[s].origin.y < south) {
      south = city.surfaces[s].origin.y;
      wall = s;
    }
  const synth::Surface& front = city.surfaces[wall];
  const WorldPoint &u = front.u_axis, out = {u.y, -u.x, 0};
  Pose pose;
  pose.rotation = {u.x, u.y, 0, 0, 0, -1, -out.x, -out.y, 0};
  pose.centre = front.origin + u * 4 + WorldPoint{0, 0, 1.2} + out * 5;
  Camera camera;
  camera.width = camera.height = 200;
  camera.fx = camera.fy = 400;  // 1 cm a pixel at the fence, of which 2 m x 2 m are seen
  camera.cx = camera.cy = 100;
  const synth::SynthPhoto photo = renderer.photo(camera, pose, {}, &fence);
  double covered = 0;
  for (const std::uint8_t share : photo.unmodelled) covered += share / 255.0 / 40000;
  // Wires every 20 cm across and down; a post of 8 cm may be in sight.
  EXPECT_NEAR(covered, 1 - 0.85 * 0.85, 0.06);
}

// From above, crowns of leaves, and wires 6 cm wide, in all photos alike.
TEST(SynthUnmodelled, TreesAndWiresStandInAllPhotosAlike) {
  const Overhead at;
  const synth::Unmodelled what{.trees = true, .wires = true};
  const synth::SynthScene scene = synth::make_unmodelled(at.options, 0, what);
  EXPECT_EQ(scene.surfaces.size(), 3u) << "crowns, trunks, wires and poles";
  EXPECT_EQ(scene.mesh.positions, synth::make_unmodelled(at.options, 7, what).mesh.positions);
  EXPECT_EQ(synth::make_unmodelled(at.options, 0, {.trees = true}).surfaces.size(), 2u);
  EXPECT_EQ(synth::make_unmodelled(at.options, 0, {.wires = true}).surfaces.size(), 1u);
  std::array<double, 3> top{};
  std::array<std::size_t, 3> faces{};
  for (std::size_t f = 0; f < scene.mesh.faces.size(); ++f) {
    const std::uint32_t surface = scene.face_surface[f];
    ++faces[surface];
    for (const std::uint32_t v : scene.mesh.faces[f]) top[surface] = std::max(top[surface], scene.mesh.positions[v].z);
  }
  EXPECT_GT(faces[0], 1000u);
  EXPECT_NEAR(top[0], 7.5, 1.6) << "crowns";
  EXPECT_LT(top[1], top[0]);
  EXPECT_NEAR(top[2], 7.8, 0.01) << "poles";
}

// Straight towards a wall in open country: panes mirror 8 % of the sky, and nothing else changes.
TEST(SynthRenderer, WindowPanesMirrorTheSky) {
  synth::SynthBuilder builder(10, 1024, 1);
  builder.quad(synth::Material::plaster, {0, 0, 0}, {10, 0, 0}, {0, 0, 9}, true);
  const synth::SynthScene scene = builder.take();
  synth::SynthRenderer renderer(scene);
  Camera camera;
  camera.width = camera.height = 120;
  camera.fx = camera.fy = 4000;  // 1000 m off: all rays within a degree of the normal
  camera.cx = camera.cy = 60;
  Pose pose;
  pose.rotation = {1, 0, 0, 0, 0, -1, 0, 1, 0};
  pose.centre = {5, -200, 4.5};
  synth::Shot mirroring;
  mirroring.reflections = true;
  const Image plain = renderer.photo(camera, pose).image, mirrors = renderer.photo(camera, pose, mirroring).image;
  std::size_t panes = 0, others = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 120; ++x) {
      const auto pane = [&](double dx, double dy) {
        return synth::in_window_pane(scene.surfaces[0], {5 + (x + dx - 60) / 20, 0, 4.5 - (y + dy - 60) / 20});
      };
      const int count = pane(0, 0) + pane(1, 0) + pane(0, 1) + pane(1, 1) + pane(0.5, 0.5);
      const std::uint8_t *p = plain.at(x, y), *m = mirrors.at(x, y);
      if (count == 5) {
        ++panes;
        EXPECT_NEAR(m[0], p[0] + 0.08 * (206 - p[0]), 1.1);
        EXPECT_NEAR(m[2], p[2] + 0.08 * (232 - p[2]), 1.1);
      } else if (count == 0) {
        ++others;
        EXPECT_EQ(m[0], p[0]);
      }
    }
  EXPECT_GT(panes, 1000u);
  EXPECT_GT(others, 5000u);
  // At 80 degrees to the normal, 0.08 + 0.92 (1 - cos 80)^5 = 0.43.
  pose.centre = {5 - 200 * 0.98480775, -200 * 0.17364818, 4.5};
  pose.rotation = {0.17364818, -0.98480775, 0, 0, 0, -1, 0.98480775, 0.17364818, 0};
  const Image flat = renderer.photo(camera, pose).image, glare = renderer.photo(camera, pose, mirroring).image;
  double most = 0;
  for (std::size_t i = 0; i < flat.pixels.size(); i += 3)
    if (flat.pixels[i] < 100)
      most = std::max(most, (static_cast<double>(glare.pixels[i]) - flat.pixels[i]) / (206 - flat.pixels[i]));
  EXPECT_NEAR(most, 0.43, 0.04);
}

TEST(SynthRenderer, ExposureScalesColorsAndDarkensCorners) {
  const Overhead at;
  const synth::SynthScene city = synth::make_city(at.options);
  synth::SynthRenderer renderer(city);
  synth::Shot half;
  half.exposure = {{0.5, 0.5, 0.5}, 0.4};
  const Image plain = renderer.photo(at.view.camera, at.view.pose).image,
              dark = renderer.photo(at.view.camera, at.view.pose, half).image;
  for (const auto& [x, y, share] : {std::array<double, 3>{80, 60, 0}, {0, 0, 1}, {159, 119, 1}})
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(dark.at(static_cast<int>(x), static_cast<int>(y))[c],
                  plain.at(static_cast<int>(x), static_cast<int>(y))[c] * 0.5 * (1 - 0.4 * share), 2.5);
}

TEST(SynthFiles, MeshesFarOffAreWrittenExactly) {
  const test::TemporaryFolder folder;
  synth::LayerOptions options;
  options.faces = 2000;
  const Mesh mesh = synth::make_terrain(options).mesh;
  const WorldPoint utm{448192, 5411328, 256};
  synth::write_synth_mesh(folder.path() / "mesh.ply", mesh, utm);
  const Mesh back = io::read_mesh(folder.path() / "mesh.ply");
  ASSERT_EQ(back.positions.size(), mesh.positions.size());
  EXPECT_EQ(back.faces, mesh.faces);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) ASSERT_EQ(back.positions[v], mesh.positions[v] + utm);
}

}  // namespace
}  // namespace gpvc
