#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "io/images.h"
#include "io/photos.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

Scene scene_of(std::size_t views) {
  Scene scene;
  scene.views.resize(views);
  for (View& view : scene.views) view.camera.width = view.camera.height = 2;
  return scene;
}

Picture grey(std::uint8_t level) {
  Image image{2, 2, 3, {}};
  image.pixels.assign(12, level);
  return {image};
}

TEST(CallbackSource, AsksOnceForWhatIsHeldOrFits) {
  const Scene scene = scene_of(3);
  std::size_t calls = 0;
  CallbackSource photos(scene, [&](ViewId view) {
    ++calls;
    return grey(static_cast<std::uint8_t>(index(view)));
  });
  {
    const auto held = photos.photo(ViewId{1});
    EXPECT_EQ(photos.photo(ViewId{1}), held);
    EXPECT_EQ(photos.exclusion(ViewId{1}), nullptr);
    EXPECT_EQ(calls, 1u);
  }
  photos.photo(ViewId{1});
  EXPECT_EQ(calls, 2u) << "nothing is kept without leave";

  photos.keep_at_most(2 * 12);
  for (const std::uint32_t view : {0u, 1u, 0u, 1u}) EXPECT_EQ(photos.photo(ViewId{view})->pixels[0], view);
  EXPECT_EQ(calls, 4u);
  photos.photo(ViewId{2});  // 0 was used longest ago
  photos.photo(ViewId{1});
  EXPECT_EQ(calls, 5u);
  photos.photo(ViewId{0});
  EXPECT_EQ(calls, 6u);
  EXPECT_EQ(photos.decodes().photos, 3u);
  EXPECT_EQ(photos.decodes().times, 6u);
}

TEST(CallbackSource, ThreadsThatWantOnePhotoShareACall) {
  const Scene scene = scene_of(1);
  std::atomic<int> calls = 0;
  CallbackSource photos(scene, [&](ViewId) {
    ++calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return grey(1);
  });
  photos.keep_at_most(100);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back([&] { photos.photo(ViewId{0}); });
  threads.clear();
  EXPECT_EQ(calls, 1);
}

TEST(CallbackSource, ExcludedPixelsArePaintedOverInACopy) {
  const Scene scene = scene_of(1);
  const auto lent = std::make_shared<Bytes>(Bytes{9, 9, 9, 200, 200, 200, 9, 9, 9, 9, 9, 9});
  CallbackSource photos(scene, [&](ViewId) {
    return Picture{{2, 2, 3, Pixels::borrowed(*lent, lent)}, PhotoExclusion{2, 2, 1, {0b10, 0}}};
  });
  const auto photo = photos.photo(ViewId{0});
  EXPECT_EQ(photo->at(1, 0)[0], 9);
  EXPECT_EQ((*lent)[3], 200);
  ASSERT_NE(photos.exclusion(ViewId{0}), nullptr);
  EXPECT_TRUE(photos.exclusion(ViewId{0})->excludes(1, 0));
  EXPECT_FALSE(photos.exclusion(ViewId{0})->excludes(0, 0));
}

TEST(CallbackSource, ErrorsReachTheCallerAndTheNextCallTriesAgain) {
  const Scene scene = scene_of(1);
  bool fails = true;
  CallbackSource photos(scene, [&](ViewId) {
    if (fails) throw std::runtime_error("no such picture");
    return grey(3);
  });
  EXPECT_THROW(photos.photo(ViewId{0}), std::runtime_error);
  fails = false;
  EXPECT_EQ(photos.photo(ViewId{0})->pixels[0], 3);
}

TEST(ReadImageSize, IsThatOfTheHeader) {
  const test::TemporaryFolder folder;
  Image image{3, 2, 4, {}};
  image.pixels.assign(24, 50);
  write_image(folder.path() / "a.png", image, ImageFormat::png, 0);
  EXPECT_EQ(read_image_size(folder.path() / "a.png"), (ImageSize{3, 2}));
  EXPECT_TRUE(has_alpha(folder.path() / "a.png"));
  EXPECT_THROW(read_image_size(folder.path() / "b.png"), InputError);
}

}  // namespace
}  // namespace gpvc::io
