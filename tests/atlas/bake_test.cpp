#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "atlas/sampling/each_photo.h"
#include "io/clock.h"
#include "io/error.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

/// Smooth waves with periods above 1.5 m.
Color strong_waves(double x, double y) {
  return {static_cast<float>(128 + 80 * std::sin(2 * x) * std::cos(1.7 * y)),
          static_cast<float>(128 + 80 * std::cos(1.3 * x + y)), static_cast<float>(60 + 12 * x + 3 * y)};
}

struct Differences {
  double worst = 0, mean = 0;
};

/// Differences between the texture and the albedo at points of every face.
Differences compare(const TextureAtlas& atlas, const Mesh& mesh, const Albedo& albedo) {
  Differences result;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int i = 0; i <= 6; ++i) {
      for (int j = 0; i + j <= 6; ++j) {
        const WorldPoint p = point_at(mesh, face, i / 6.0, j / 6.0);
        const Color truth = albedo(p.x, p.y);
        const Color got =
            lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, i / 6.0, j / 6.0));
        const Color d = got - truth;
        const double worst = std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b)});
        result.worst = std::max(result.worst, worst);
        sum += worst;
        ++count;
      }
    }
  }
  result.mean = sum / static_cast<double>(count);
  return result;
}

AtlasOptions options_with(SeamLeveling seams) {
  AtlasOptions options;
  options.seams = seams;
  return options;
}

TEST(Bake, TextureOfAnUndistortedPhotoIsTheAlbedo) {
  AtlasScene s;
  s.add_plane(8, 8, 1.0);
  s.add_view(4, 4, 10, 640, 640, 640);  // 64 px a metre
  s.photograph(0, strong_waves);
  const TextureAtlas atlas = s.build(options_with(SeamLeveling::none));
  ASSERT_EQ(atlas.pages.size(), 1u);
  EXPECT_EQ(atlas.statistics.charts, 1u);
  const auto d = compare(atlas, s.mesh, strong_waves);
  EXPECT_LE(d.worst, 1.0);
}

TEST(Bake, LargeFacesAreNotBentByPerspective) {
  AtlasScene s;
  s.add_plane(2, 1, 4.0);  // four faces, some 300 px each, seen at 45 degrees from 5 to 11 m
  View& view = s.add_view(4, -4, 5, 900, 900, 640);
  const double r = std::sqrt(0.5);
  view.pose.rotation = {1, 0, 0, 0, -r, -r, 0, r, -r};
  s.photograph(0, strong_waves);
  const TextureAtlas atlas = s.build(options_with(SeamLeveling::full));
  EXPECT_EQ(atlas.statistics.charts, 4u);
  EXPECT_LE(compare(atlas, s.mesh, strong_waves).worst, 2.0);
  // Of small faces one chart is enough.
  AtlasScene fine;
  fine.add_plane(32, 16, 0.25);
  fine.add_view(4, -4, 5, 900, 900, 640).pose = view.pose;
  fine.photograph(0, strong_waves);
  const TextureAtlas whole = fine.build(options_with(SeamLeveling::full));
  EXPECT_EQ(whole.statistics.charts, 1u);
  EXPECT_LE(compare(whole, fine.mesh, strong_waves).worst, 2.0);
}

TEST(Bake, TexelsOfAnUndistortedPhotoAreItsPixels) {
  AtlasScene s;
  s.add_plane(1, 1, 2.0);
  s.add_view(1, 1, 10, 200, 200, 250);      // the square is pixels 75..125
  s.photograph(0, [](double x, double y) {  // pure noise, which any resampling would change
    const double n = std::sin(x * 12345.678) * 43758.5453 + std::cos(y * 9876.54) * 12543.123;
    return Color{static_cast<float>(255 * (n - std::floor(n))), 7, 9};
  });
  AtlasOptions options = options_with(SeamLeveling::none);
  options.padding = 8;
  const TextureAtlas atlas = s.build(options);
  const Image& page = atlas.pages.at(0);
  // Seven blocks of 8 hold the square and its margin of 2.
  ASSERT_EQ(page.width, 56);
  ASSERT_EQ(page.height, 56);
  const Image photo = io::read_image(s.scene.views[0].photo);
  // The ring of one texel around it continues the photo, for bilinear lookups along the border.
  for (int y = -1; y <= 50; ++y) {
    for (int x = -1; x <= 50; ++x) {
      if ((x == -1 || x == 50) && (y == -1 || y == 50)) continue;
      EXPECT_EQ(page.at(2 + x, 2 + y)[0], photo.at(75 + x, 75 + y)[0]) << x << " " << y;
    }
  }
}

TEST(Bake, DistortedPhotosAreSampledOnceThroughTheLens) {
  AtlasScene s;
  s.add_plane(8, 8, 1.0);
  View& view = s.add_view(4, 4, 10, 640, 640, 640);
  view.camera.distortion = {-0.12, 0.03, 0.001, -0.0015, 0.002};
  limit_distortion(view.camera);
  s.photograph(0, strong_waves);
  const TextureAtlas atlas = s.build(options_with(SeamLeveling::none));
  // Half a level is from rounding the photo, half from rounding the texel, the rest from the two interpolations.
  const auto d = compare(atlas, s.mesh, strong_waves);
  EXPECT_LE(d.worst, 1.6);
  EXPECT_LE(d.mean, 0.6);
}

TEST(Sampling, LatticeErrsLessThanItPromises) {
  Camera camera{4000, 2250, 2300, 2300, 2011, 1108, {-0.13, 0.11, 0.0006, -0.0004, -0.02}};
  limit_distortion(camera);
  const int step = lattice_step(camera);
  ASSERT_GE(step, 2);
  double worst = 0;
  for (double y = 0; y + step <= camera.height; y += 37) {
    for (double x = 0; x + step <= camera.width; x += 41) {
      const PhotoPositions positions(camera, x, y, x + step, y + step);
      for (double t : {0.25, 0.5, 0.8}) {
        const auto exact = photo_from_pixel(camera, {x + t * step, y + 0.5 * step});
        const auto got = positions.at(x + t * step, y + 0.5 * step);
        ASSERT_TRUE(exact && got);
        worst = std::max(worst, std::hypot(exact->x - got->x, exact->y - got->y));
      }
    }
  }
  EXPECT_LE(worst, kLatticeErrorPx);
  EXPECT_GT(worst, 0);
}

TEST(Sampling, CatmullRomReproducesPixelsAndRamps) {
  Image image{8, 8, 3, std::vector<std::uint8_t>(8 * 8 * 3)};
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      store(image.at(x, y), {10.0f * static_cast<float>(x), 10.0f * static_cast<float>(y), 100});
  EXPECT_FLOAT_EQ(sample_bicubic(image, 3.5, 4.5).r, 30);
  EXPECT_FLOAT_EQ(sample_bicubic(image, 3.5, 4.5).g, 40);
  EXPECT_NEAR(sample_bicubic(image, 3.75, 4.1).r, 32.5, 1e-4);
  EXPECT_NEAR(sample_bicubic(image, 3.75, 4.1).g, 36, 1e-4);
  EXPECT_NEAR(sample_bicubic(image, -3, 4).r, 0, 1e-4);
}

TEST(Sampling, PatchesGiveTheSamplesOfTheWholePhoto) {
  Image image{40, 30, 3, std::vector<std::uint8_t>(40 * 30 * 3)};
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<std::uint8_t>(i * i % 251);
  PhotoPatch patch;
  // The rectangles lie inside the photo, and half a pixel beyond each of its corners.
  for (const PhotoPoint& low : {PhotoPoint{12.3, 8.1}, PhotoPoint{-0.5, -0.5}, PhotoPoint{32.6, 21.2}}) {
    const PhotoPoint high{low.x + 7.9, low.y + 9.3}, step{7.9 / 7, 9.3 / 7};
    patch.load(image, low, high);
    std::array<Color, PhotoPatch::kRow> sums{};
    patch.add_row(low, step, sums);
    patch.add_row(low, step, sums);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double t = static_cast<double>(i);
      const Color whole = sample_bicubic(image, low.x + t * step.x, low.y + t * step.y);
      EXPECT_NEAR(sums[i].r, 2 * whole.r, 0.01) << low.x << ' ' << i;
      EXPECT_NEAR(sums[i].g, 2 * whole.g, 0.01) << low.x << ' ' << i;
      EXPECT_NEAR(sums[i].b, 2 * whole.b, 0.01) << low.x << ' ' << i;
    }
  }
}

/// All charts are red, so every texel of every page must be.
TEST(Bake, NoBackgroundColorAppearsUpToMipLevelThree) {
  AtlasScene s;
  s.add_plane(12, 12, 1.0);
  // Islands: every third square of every third row.
  std::vector<Triangle> kept;
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    if (f / 2 % 12 % 3 == 0 && f / 24 % 3 == 0) kept.push_back(s.mesh.faces[f]);
  s.mesh.faces = kept;
  s.labels.assign(kept.size(), ViewId{0});
  s.tags.assign(kept.size(), labeling::FaceTag::seen);
  s.add_view(6, 6, 10, 600, 600, 400);
  s.photograph(0, [](double, double) { return Color{200, 30, 30}; });
  const TextureAtlas atlas = s.build(options_with(SeamLeveling::none));
  EXPECT_GT(atlas.statistics.charts, 10u);
  for (const Image& page : atlas.pages)
    for (std::size_t i = 0; i < page.pixels.size(); i += 3)
      ASSERT_TRUE(page.pixels[i] == 200 && page.pixels[i + 1] == 30) << "texel " << i / 3;
}

/// Two charts of different colours: where a chart is, a reduction by 8 holds its colour alone.
TEST(Bake, PaddingKeepsChartsApart) {
  AtlasScene s;
  s.add_plane(2, 1, 1.0);
  for (auto& p : s.mesh.positions) p.x *= 2;
  s.labels = {ViewId{0}, ViewId{0}, ViewId{1}, ViewId{1}};
  s.add_view(2, 0.5, 10, 400, 400, 400);
  s.add_view(2, 0.5, 10, 400, 400, 400);
  s.photograph(0, [](double, double) { return Color{250, 0, 0}; });
  s.photograph(1, [](double, double) { return Color{0, 250, 0}; });
  AtlasOptions options = options_with(SeamLeveling::none);
  options.padding = 8;
  const TextureAtlas atlas = s.build(options);
  const Image& page = atlas.pages.at(0);
  for (std::size_t face = 0; face < 4; ++face) {
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; i + j <= 4; ++j) {
        const io::TexCoord t = texcoord_at(atlas.model, face, i / 4.0, j / 4.0);
        const int x0 = static_cast<int>(t.u * static_cast<float>(page.width)) / 8 * 8;
        const int y0 = static_cast<int>(t.v * static_cast<float>(page.height)) / 8 * 8;
        for (int y = y0; y < std::min(y0 + 8, page.height); ++y)
          for (int x = x0; x < std::min(x0 + 8, page.width); ++x)
            ASSERT_EQ(page.at(x, y)[face < 2 ? 1 : 0], 0) << "face " << face << " at " << x << " " << y;
      }
    }
  }
}

TEST(Bake, SameBytesForAnyNumberOfThreads) {
  const auto bake = [](int threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    AtlasScene s;
    s.add_plane(10, 10, 0.8);
    for (std::size_t f = 0; f < s.labels.size(); ++f) s.labels[f] = ViewId{static_cast<std::uint32_t>(f / 37 % 2)};
    for (std::size_t f = 60; f < 75; ++f) s.leave_unseen(f);
    for (int v = 0; v < 2; ++v) {
      View& view = s.add_view(3.5 + v, 4, 10, 640, 640, 500);
      view.camera.distortion = {-0.1, 0.02, 0, 0, 0};
      limit_distortion(view.camera);
    }
    for (std::size_t v = 0; v < 2; ++v)
      s.photograph(v, strong_waves, [v](int, int, Color c) { return (v ? 1.1f : 1.0f) * c; });
    return s.build(AtlasOptions{});
  };
  const TextureAtlas one = bake(1), many = bake(4);
  ASSERT_EQ(one.pages.size(), many.pages.size());
  for (std::size_t p = 0; p < one.pages.size(); ++p) EXPECT_EQ(one.pages[p].pixels, many.pages[p].pixels);
  EXPECT_EQ(one.model.face_texcoords, many.model.face_texcoords);
  EXPECT_EQ(one.statistics.seam_step_after, many.statistics.seam_step_after);
}

// A page needs few photos, however they are numbered: what lies close together is on it.
TEST(Bake, PagesShowPlacesThatLieCloseTogether) {
  constexpr int kPlaces = 24;
  AtlasScene s;
  s.add_plane(kPlaces, 1, 1);
  for (int v = 0; v < kPlaces; ++v) {
    s.add_view(v * 7 % kPlaces + 0.5, 0.5, 4, 80, 80, 160);
    s.photograph(static_cast<std::size_t>(v), strong_waves);
  }
  const auto place_of = [&](std::size_t face) { return static_cast<int>(point_at(s.mesh, face, 1.0 / 3, 1.0 / 3).x); };
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face)
    for (std::uint32_t v = 0; v < kPlaces; ++v)
      if (static_cast<int>(s.scene.views[v].pose.centre.x) == place_of(face)) s.labels[face] = ViewId{v};
  const TextureAtlas atlas = s.build({.page_size = 128});
  ASSERT_GE(atlas.pages.size(), 4u);
  std::vector<int> low(atlas.pages.size(), kPlaces), high(atlas.pages.size(), 0);
  for (std::size_t face = 0; face < s.mesh.faces.size(); ++face) {
    const std::uint32_t page = atlas.model.face_page[face];
    low[page] = std::min(low[page], place_of(face));
    high[page] = std::max(high[page], place_of(face));
  }
  for (std::size_t p = 0; p < low.size(); ++p) EXPECT_LE(high[p] - low[p], 9) << p;
}

/// A single photo may take long, so progress is called, and may stop the work, before the photo is done.
TEST(Bake, ProgressStopsTheWorkWithinAPhoto) {
  AtlasScene s;
  s.add_plane(8, 8, 1.0);
  s.add_view(4, 4, 10, 640, 640, 640);
  s.photograph(0, strong_waves);
  s.graph = labeling::face_graph(s.mesh);
  s.candidates.first.assign(s.mesh.faces.size() + 1, 0);
  io::PhotoCache photos(s.scene, std::size_t{1} << 28);
  const AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
  bool finished = false;
  const Progress stop = [&](std::size_t done, std::size_t total) {
    finished = finished || done == total;
    throw Cancelled();
  };
  EXPECT_THROW(build_atlas(input, AtlasOptions{}, stop), Cancelled);
  EXPECT_FALSE(finished);
}

/// Other threads than the one that made it get photos, except the first view's, only after the work was stopped.
class LateSource final : public io::PhotoSource {
 public:
  std::shared_ptr<const Image> photo(ViewId view) override {
    if (view == ViewId{0} || std::this_thread::get_id() == maker_) return image;
    ++begun;
    for (const auto end = Clock::now() + std::chrono::seconds(1); !stopped && Clock::now() < end;)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return image;
  }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId) override { return nullptr; }

  const std::shared_ptr<const Image> image = std::make_shared<const Image>();
  std::atomic<int> begun = 0;
  std::atomic<bool> stopped = false;

 private:
  std::thread::id maker_ = std::this_thread::get_id();
};

TEST(EachPhoto, LetsGoOfPhotosThatAreDecodedAfterTheWorkWasStopped) {
  constexpr std::size_t kViews = 16;
  AtlasScene s;
  s.scene.views.resize(kViews);
  LateSource photos;
  const std::vector<std::vector<int>> work(kViews, {1});
  const auto fetch = [&](ViewId id) { return photos.photo(id); };
  const auto use = [&](ViewId, const std::shared_ptr<const Image>&, const std::vector<int>&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // time for other threads to begin
    if (photos.begun == 0) return;
    photos.stopped = true;
    throw Cancelled();
  };
  try {
    each_fetched(work, PhotoOrder::ascending, fetch, use);
  } catch (const Cancelled&) {  // nowhere with a single thread
  }
  EXPECT_EQ(photos.image.use_count(), 1);
}

// Errors of photos that were decoded ahead are not thrown while that of an earlier one unwinds.
TEST(EachPhoto, OneErrorIsThrownWhereAllPhotosAreDamaged) {
  const std::vector<std::vector<int>> work(16, {1});
  const auto fetch = [](ViewId) -> std::shared_ptr<const Image> { throw InputError("a.jpg", "", "is damaged"); };
  for (int i = 0; i < 1000; ++i)
    EXPECT_THROW(each_fetched(work, PhotoOrder::ascending, fetch, [](const auto&...) {}), InputError);
}

TEST(Bake, RefusesExposuresThatSumsHaveNoRoomFor) {
  AtlasScene s;
  s.add_plane(1, 1, 1.0);
  s.add_view(0.5, 0.5, 10, 100, 100, 100);
  s.photograph(0, strong_waves);
  s.exposure.resize(1);
  s.exposure[0].gain = {2.5f, 1, 0.1f};
  EXPECT_NO_THROW(s.build(AtlasOptions{}));
  s.exposure[0].gain[1] = 2.6f;
  EXPECT_THROW(s.build(AtlasOptions{}), std::invalid_argument);
}

TEST(Bake, RefusesOptionsThatLeaveNoRoom) {
  AtlasScene s;
  s.add_plane(1, 1, 1.0);
  s.add_view(0.5, 0.5, 10, 100, 100, 100);
  s.photograph(0, strong_waves);
  AtlasOptions options;
  options.page_size = 16;
  options.padding = 8;
  EXPECT_THROW(s.build(options), std::invalid_argument);
}

}  // namespace
}  // namespace gpvc::atlas
