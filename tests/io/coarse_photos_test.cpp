#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "io/photos.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

constexpr int kRampWidth = 9, kRampHeight = 6;
constexpr std::size_t kCoarseBytes = 3 * 4 * 3;

/// Photos of a ramp each; counts how many are fetched.
class Ramps final : public PhotoSource {
 public:
  std::shared_ptr<const Image> photo(ViewId view) override {
    ++fetched;
    Image image{kRampWidth, kRampHeight, 3, {}};
    for (std::size_t i = 0; i < 3 * kRampWidth * kRampHeight; ++i)
      image.pixels.push_back(static_cast<std::uint8_t>(i + 50 * index(view)));
    return std::make_shared<const Image>(std::move(image));
  }
  std::shared_ptr<const PhotoExclusion> exclusion(ViewId) override { return nullptr; }
  std::size_t fetched = 0;
};

Scene scene_of(std::initializer_list<const char*> files) {
  Scene scene;
  for (const char* file : files) {
    scene.views.emplace_back();
    scene.views.back().photo = file;
  }
  return scene;
}

TEST(CoarsePhotos, AreMadeOfPhotosThatAreFetchedAndKept) {
  const test::TemporaryFolder folder;
  const Scene scene = scene_of({"a.jpg", "b.jpg"});
  Ramps ramps;
  CoarsePhotos photos(ramps, scene, folder.path(), 2 * kCoarseBytes);
  for (const ViewId view : {ViewId{1}, ViewId{0}}) {
    const Image coarse = coarse_image(*photos.photo(view));
    EXPECT_EQ(coarse.width, kRampWidth / kCoarsePixel);
    EXPECT_EQ(coarse.height, kRampHeight / kCoarsePixel);
    const std::size_t fetched = ramps.fetched;
    EXPECT_EQ(photos.coarse(view)->pixels, coarse.pixels);
    EXPECT_EQ(photos.coarse(view)->width, coarse.width);
    EXPECT_EQ(ramps.fetched, fetched);
  }
  EXPECT_EQ(ramps.fetched, 2u);
}

TEST(CoarsePhotos, AreMadeEachTimeWhereThereIsNoRoom) {
  const test::TemporaryFolder folder;
  const Scene scene = scene_of({"a.jpg", "b.jpg"});
  Ramps ramps;
  CoarsePhotos photos(ramps, scene, folder.path(), 2 * kCoarseBytes - 1);
  const Image second = *ramps.photo(ViewId{1});
  ramps.fetched = 0;
  photos.photo(ViewId{0});
  for (int round = 1; round <= 3; ++round) {
    EXPECT_EQ(photos.coarse(ViewId{0})->pixels, coarse_image(*Ramps().photo(ViewId{0})).pixels);
    EXPECT_EQ(photos.coarse(ViewId{1})->pixels, coarse_image(second).pixels);
    EXPECT_EQ(ramps.fetched, static_cast<std::size_t>(1 + round));
  }
}

TEST(CoarsePhotos, OfAPhotoOfSeveralViewsIsKeptOnce) {
  const test::TemporaryFolder folder;
  const Scene scene = scene_of({"around.jpg", "", "around.jpg", ""});
  EXPECT_EQ(photo_of_view(scene), (std::vector<std::uint32_t>{0, 1, 0, 3}));
  Ramps ramps;
  CoarsePhotos photos(ramps, scene, folder.path(), kCoarseBytes);
  photos.photo(ViewId{0});
  photos.coarse(ViewId{2});
  EXPECT_EQ(ramps.fetched, 1u);
}

}  // namespace
}  // namespace gpvc::io
