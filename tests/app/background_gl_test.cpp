// A wall before the sky, whose mesh bulges over it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "app/pipeline/pipeline.h"
#include "app/results/output_folder.h"
#include "app/tiles/done.h"
#include "app/tiles/make_job.h"
#include "app/tiles/units.h"
#include "io/images.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

// The wall is 6 wide and 4 high, 10 in front of the cameras; y points down. The mesh is wider and higher by 0.5.
constexpr double kHalfWidth = 3, kTop = -2, kBottom = 2, kBulge = 0.5, kDepth = 10;
constexpr int kCells = 35;

class WallBeforeSky : public testing::Test {
 protected:
  WallBeforeSky() {
    for (int j = 0; j <= kCells; ++j)
      for (int i = 0; i <= kCells; ++i)
        mesh_.positions.push_back({-kHalfWidth - kBulge + (2 * (kHalfWidth + kBulge)) * i / kCells,
                                   kTop - kBulge + (kBottom - kTop + kBulge) * j / kCells, kDepth});
    for (std::uint32_t j = 0; j < kCells; ++j)
      for (std::uint32_t i = 0; i < kCells; ++i) {
        const std::uint32_t a = j * (kCells + 1) + i, b = a + 1, c = a + kCells + 1, d = c + 1;
        mesh_.faces.push_back({a, c, b});
        mesh_.faces.push_back({b, c, d});
      }
    std::vector<io::Picture> pictures;
    for (const WorldPoint& centre : {WorldPoint{-2, 1.5, 0}, {0, 1.5, -1.5}, {2, 1.5, 0}, {0.5, 1.5, 1}}) {
      View view;
      view.name = std::to_string(scene_.views.size()) + ".png";
      view.camera = {480, 360, 380, 380, 240, 180, {}};
      view.pose.centre = centre;
      scene_.views.push_back(view);
      pictures.push_back({photo_of(view), {}});
    }
    views_ = all_views(scene_);
    input_.views = views_;
    photos_ = std::make_unique<io::PictureSource>(scene_, std::move(pictures));
  }

  static bool is_wall(const WorldPoint& p) { return std::abs(p.x) < kHalfWidth && p.y > kTop && p.y < kBottom; }

  static Image photo_of(const View& view) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 2);
    Image photo{view.camera.width, view.camera.height, 3, {}};
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) {
        const WorldPoint ray = ray_of(view, {x + 0.5, y + 0.5});
        const WorldPoint p = view.pose.centre + ray * ((kDepth - view.pose.centre.z) / ray.z);
        const bool stone = (static_cast<int>(std::floor(p.x * 4)) + static_cast<int>(std::floor(p.y * 4))) % 2 == 0;
        const double sky[] = {130 - 60 * ray.y, 170 - 40 * ray.y, 235};
        const double wall[] = {stone ? 120.0 : 170.0, stone ? 70.0 : 140.0, 60};
        for (std::size_t c = 0; c < 3; ++c)
          photo.pixels.push_back(
              static_cast<std::uint8_t>(std::clamp((is_wall(p) ? wall[c] : sky[c]) + noise(random), 0.0, 255.0)));
      }
    return photo;
  }

  pipeline::Run run(const pipeline::Settings& settings) { return {input_, settings, *photos_, silent_}; }

  // The face's corners that lie on the wall.
  int corners_on_wall(std::size_t face) const {
    return static_cast<int>(
        std::ranges::count_if(mesh_.faces[face], [&](std::uint32_t v) { return is_wall(mesh_.positions[v]); }));
  }

  Mesh mesh_;
  Scene scene_;
  std::vector<ViewId> views_;
  std::unique_ptr<io::PictureSource> photos_;
  results::Observer silent_;
  checks::Input input_{scene_, mesh_, {}};
};

TEST_F(WallBeforeSky, FacesBeforeTheSkyHaveNoPhoto) {
  const pipeline::Settings settings;
  const pipeline::Seen seen = pipeline::see(run(settings));
  std::size_t sky = 0, kept = 0;
  for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
    const bool is_background = seen.candidates.tags[f] == labeling::FaceTag::background;
    if (corners_on_wall(f) == 0) {
      ++sky;
      kept += is_background ? 0 : 1;
    } else if (corners_on_wall(f) == 3) {
      EXPECT_FALSE(is_background) << f;
      EXPECT_TRUE(labeling::has_candidates(seen.candidates.tags[f])) << f;
    }
  }
  EXPECT_GT(sky, 400u);
  EXPECT_LE(kept, sky / 50);
}

TEST_F(WallBeforeSky, HasItWhereAskedTo) {
  pipeline::Settings settings;
  settings.costs.background = labeling::Background::none;
  const pipeline::Seen seen = pipeline::see(run(settings));
  EXPECT_TRUE(std::ranges::all_of(seen.candidates.tags, labeling::has_candidates));
}

TEST_F(WallBeforeSky, TilesCountTheirFacesBeforeTheSky) {
  const test::TemporaryFolder folder;
  for (View& view : scene_.views) {
    view.photo = folder.path() / view.name;
    io::write_image(view.photo, photo_of(view), io::ImageFormat::png, 0);
  }
  const tiles::JobFolder job(folder.path() / "job");
  tiles::JobSettings settings;
  settings.tiles.faces_per_tile = mesh_.faces.size() / 3;
  tiles::make_job(job, input_, settings, "test", silent_);
  tiles::UnitRunner runner(job, {}, silent_);
  for (const tiles::Unit& unit : runner.units()) ASSERT_EQ(runner.run(unit), tiles::UnitResult::done) << unit.name;
  const auto figures = tiles::read_done(job.done_file(tiles::kFinishUnit)).value().figures;
  std::size_t all = 0;
  for (const char* tag : {"seen", "partial", "filled", "background"})
    all += figures["cost." + std::string(tag)].get<std::size_t>();
  EXPECT_EQ(all, mesh_.faces.size());
  EXPECT_GT(figures["cost.background"], 400);
}

TEST_F(WallBeforeSky, IsAloneInTheGlbWhileTheObjKeepsAllFaces) {
  const test::TemporaryFolder folder;
  const pipeline::Settings settings;
  results::OutputFolder out(folder.path() / "out");
  pipeline::texture_into(run(settings), out);
  out.publish();
  const io::LoadedModel glb = io::read_textured_model(folder.path() / "out" / "model.glb");
  const io::LoadedModel obj = io::read_textured_model(folder.path() / "out" / "model.obj");
  EXPECT_EQ(obj.mesh.faces.size(), mesh_.faces.size());
  std::size_t wall = 0;
  for (std::size_t f = 0; f < mesh_.faces.size(); ++f) wall += corners_on_wall(f) == 3 ? 1 : 0;
  EXPECT_GE(glb.mesh.faces.size(), wall);
  EXPECT_LE(glb.mesh.faces.size(), wall + 250);  // with those that are half wall
  // Nothing that the GLB shows has the sky's colour.
  std::size_t blue = 0;
  for (std::size_t f = 0; f < glb.mesh.faces.size(); ++f) {
    float u = 0, v = 0;
    for (const std::uint32_t corner : glb.model.face_texcoords[f]) {
      u += glb.model.texcoords[corner].u / 3;
      v += glb.model.texcoords[corner].v / 3;
    }
    const Image& page = glb.pages[glb.model.face_page[f]];
    blue += page.at(static_cast<int>(u * static_cast<float>(page.width)),
                    static_cast<int>(v * static_cast<float>(page.height)))[2] > 190
                ? 1
                : 0;
  }
  EXPECT_LE(blue, 5u);
}

}  // namespace
}  // namespace gpvc
