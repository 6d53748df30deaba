#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <set>
#include <thread>

#include "io/file_hashes.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

constexpr int kPhotoWidth = 40, kPhotoHeight = 30;
constexpr std::size_t kPhotoBytes = 3 * kPhotoWidth * kPhotoHeight;

/// Photos of one colour each: view i is all i.
struct CachedPhotos {
  explicit CachedPhotos(int count) {
    for (int i = 0; i < count; ++i) {
      View view;
      view.name = std::string("p").append(std::to_string(i)).append(".png");
      view.photo = folder.path() / view.name;
      view.camera.width = kPhotoWidth;
      view.camera.height = kPhotoHeight;
      write_image(view.photo,
                  {kPhotoWidth, kPhotoHeight, 3, std::vector<std::uint8_t>(kPhotoBytes, static_cast<std::uint8_t>(i))},
                  ImageFormat::png, 0);
      scene.views.push_back(std::move(view));
    }
  }
  TemporaryFolder folder;
  Scene scene;
};

ViewId view(int i) { return ViewId{static_cast<std::uint32_t>(i)}; }

TEST(PhotoCache, KeepsWhatFitsAndDropsTheLeastRecentlyUsed) {
  const CachedPhotos photos(3);
  PhotoCache cache(photos.scene, 2 * kPhotoBytes);
  // Without a reference elsewhere, a weak pointer lives exactly as long as the photo is cached.
  std::weak_ptr<const Image> zero = cache.photo(view(0)), one = cache.photo(view(1));
  EXPECT_FALSE(zero.expired());
  cache.photo(view(0));
  const std::weak_ptr<const Image> two = cache.photo(view(2));
  EXPECT_FALSE(zero.expired());
  EXPECT_TRUE(one.expired());
  EXPECT_FALSE(two.expired());
  EXPECT_EQ(cache.photo(view(0)), zero.lock());
}

TEST(PhotoCache, HoldsNothingBeyondItsLimit) {
  const CachedPhotos photos(2);
  PhotoCache cache(photos.scene, kPhotoBytes - 1);
  const std::weak_ptr<const Image> zero = cache.photo(view(0));
  EXPECT_TRUE(zero.expired());
  EXPECT_EQ(cache.photo(view(1))->pixels.front(), 1);
}

TEST(PhotoCache, DecodesIntoTheMemoryOfPhotosThatWereLetGo) {
  CachedPhotos photos(3);
  View& small = photos.scene.views[1];
  small.camera.width = kPhotoWidth / 2;
  small.camera.height = kPhotoHeight / 2;
  write_image(small.photo, {small.camera.width, small.camera.height, 3, std::vector<std::uint8_t>(kPhotoBytes / 4, 1)},
              ImageFormat::png, 0);
  PhotoCache cache(photos.scene);
  const auto held = cache.photo(view(0));
  for (const int i : {2, 1, 2, 0, 1}) {
    const auto& camera = photos.scene.views[static_cast<std::size_t>(i)].camera;
    const auto photo = cache.photo(view(i));
    const auto samples = static_cast<std::size_t>(3 * camera.width * camera.height);
    EXPECT_EQ(photo->pixels, std::vector<std::uint8_t>(samples, static_cast<std::uint8_t>(i)));
  }
  EXPECT_EQ(held->pixels, std::vector<std::uint8_t>(kPhotoBytes, 0));
}

TEST(PhotoCache, DecodesIntoAsMuchMemoryAsPhotosHaveTakenAtATime) {
  const CachedPhotos photos(6);
  PhotoCache cache(photos.scene);
  std::set<const std::uint8_t*> places;
  for (int i = 0; i < 6; i += 3) {
    const auto a = cache.photo(view(i)), b = cache.photo(view(i + 1)), c = cache.photo(view(i + 2));
    for (const auto& photo : {a, b, c}) places.insert(photo->pixels.data());
  }
  EXPECT_EQ(places.size(), 3u);
}

TEST(PhotoCache, HandsOutWhatSomebodyHolds) {
  const CachedPhotos photos(2);
  PhotoCache cache(photos.scene);
  auto held = cache.photo(view(0));
  EXPECT_EQ(cache.photo(view(0)), held);
  EXPECT_EQ(cache.photo(view(1))->pixels.front(), 1);
  EXPECT_EQ(cache.decodes().times, 2u);
  held.reset();
  EXPECT_EQ(cache.photo(view(0))->pixels.front(), 0);
  EXPECT_EQ(cache.decodes().times, 3u);
  EXPECT_EQ(cache.decodes().photos, 2u);
}

TEST(PhotoCache, GivesEveryThreadTheSamePhoto) {
  const CachedPhotos photos(4);
  PhotoCache cache(photos.scene, 4 * kPhotoBytes);
  for (int i = 0; i < 4; ++i) {
    std::vector<std::shared_ptr<const Image>> got(8);
    {
      std::vector<std::jthread> threads;
      for (auto& photo : got) threads.emplace_back([&] { photo = cache.photo(view(i)); });
    }
    for (const auto& photo : got) EXPECT_EQ(photo, got.front());
    EXPECT_EQ(got.front()->pixels.back(), i);
  }
}

TEST(PhotoCache, StaysRightWhileThreadsCompeteForALittleRoom) {
  const CachedPhotos photos(6);
  PhotoCache cache(photos.scene, 2 * kPhotoBytes);
  std::atomic<int> wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (unsigned t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        std::uint32_t random = t + 1;
        for (int i = 0; i < 200; ++i) {
          random = random * 1664525u + 1013904223u;
          const int which = static_cast<int>(random >> 16) % 6;
          wrong += cache.photo(view(which))->pixels.front() != which;
        }
      });
  }
  EXPECT_EQ(wrong, 0);
}

TEST(PhotoCache, PassesErrorsToEveryoneAndTriesAgainLater) {
  const CachedPhotos photos(1);
  const std::filesystem::path& file = photos.scene.views[0].photo;
  const std::filesystem::path away = photos.folder.path() / "away.png";
  std::filesystem::rename(file, away);
  PhotoCache cache(photos.scene, 10 * kPhotoBytes);
  std::atomic<int> errors = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 6; ++t)
      threads.emplace_back([&] {
        try {
          cache.photo(view(0));
        } catch (const InputError&) {
          ++errors;
        }
      });
  }
  EXPECT_EQ(errors, 6);
  std::filesystem::rename(away, file);
  EXPECT_EQ(cache.photo(view(0))->width, kPhotoWidth);
}

/// Sets a file's bytes, and, if told so, its time of modification to what it was.
void replace(const std::filesystem::path& file, const std::string& bytes, bool keep_time = false) {
  const auto time = std::filesystem::last_write_time(file);
  std::ofstream(file, std::ios::binary) << bytes;
  if (keep_time) std::filesystem::last_write_time(file, time);
}

void touch(const std::filesystem::path& file) {
  std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
}

// Whichever the readings are: to decode it, or for its key.
TEST(PhotoCache, RefusesAPhotoThatChangesBetweenTwoReadings) {
  for (const bool same_size : {false, true})
    for (const bool keyed : {false, true}) {
      CachedPhotos photos(2);
      const auto pnm = [](char value) { return "P6 40 30 255\n" + std::string(kPhotoBytes, value); };
      const std::filesystem::path file = photos.folder.write("p.ppm", pnm(1));
      photos.scene.views[1].photo = file;
      const std::string other = pnm(2) + (same_size ? "" : "more");
      PhotoCache cache(photos.scene);
      if (keyed)
        cache.key(view(1));
      else
        cache.photo(view(1));
      replace(file, other, same_size);
      const std::string sentence = file.string() + ": has changed since it was first read";
      EXPECT_TRUE(contains(input_error([&] { cache.photo(view(1)); }), sentence));
      EXPECT_TRUE(contains(input_error([&] { cache.key(view(1)); }), sentence));
      EXPECT_EQ(cache.photo(view(0))->pixels.front(), 0) << "the others are what they were";
    }
}

TEST(PhotoCache, TakesAPhotoThatWasMerelyTouched) {
  const CachedPhotos photos(2);
  PhotoCache cache(photos.scene);
  const auto key = cache.key(view(1));
  cache.photo(view(1));
  touch(photos.scene.views[1].photo);
  EXPECT_EQ(cache.photo(view(1))->pixels.front(), 1);
  replace(photos.scene.views[1].photo, test::read_file(photos.scene.views[1].photo));
  EXPECT_EQ(cache.photo(view(1))->pixels.front(), 1);
  EXPECT_EQ(cache.key(view(1)), key);
}

TEST(PhotoCache, RefusesAMaskThatChangesBetweenTwoReadings) {
  CachedPhotos photos(2);
  photos.scene.views[1].mask = photos.folder.path() / "mask.png";
  Image mask{kPhotoWidth, kPhotoHeight, 1, std::vector<std::uint8_t>(kPhotoBytes / 3, 255)};
  mask.pixels[7] = 0;
  write_image(photos.scene.views[1].mask, mask, ImageFormat::png, 0);
  PhotoCache cache(photos.scene);
  ASSERT_TRUE(cache.exclusion(view(1)));
  touch(photos.scene.views[1].mask);
  EXPECT_TRUE(cache.exclusion(view(1))->excludes(7, 0));
  mask.pixels[8] = 0;
  write_image(photos.scene.views[1].mask, mask, ImageFormat::png, 0);
  for (const auto& read : std::initializer_list<std::function<void()>>{
           [&] { cache.exclusion(view(1)); }, [&] { cache.photo(view(1)); }, [&] { cache.key(view(1)); }})
    EXPECT_TRUE(contains(input_error(read), "mask.png: has changed since it was first read"));
}

// As units of a job are, which others have looked at before.
TEST(PhotoCache, RefusesAPhotoThatIsNotWhatIsKnownOfIt) {
  const CachedPhotos photos(2);
  FileHashes known;
  known.of(photos.scene.views[0].photo);
  replace(photos.scene.views[0].photo, test::read_file(photos.scene.views[1].photo));
  PhotoCache cache(photos.scene, 0, &known);
  EXPECT_TRUE(contains(input_error([&] { cache.photo(view(0)); }), "p0.png: has changed since it was first read"));
  known.of(photos.scene.views[0].photo);
  EXPECT_EQ(cache.photo(view(0))->pixels.front(), 1);
}

TEST(PhotoCache, ReducesPhotosByBoxes) {
  const TemporaryFolder folder;
  // 5 x 4 reduced by 2: the last column is cut.
  //   0  1 | 10 20 | 99
  //   2  4 | 30 41 | 99     means 1.75 -> 2 and 25.25 -> 25
  Image image{5, 4, 3, {}};
  for (const int grey : {0, 1, 10, 20, 99, 2, 4, 30, 41, 99, 255, 255, 0, 0, 99, 255, 255, 0, 2, 99})
    image.pixels.insert(image.pixels.end(), 3, static_cast<std::uint8_t>(grey));
  write_image(folder.path() / "a.png", image, ImageFormat::png, 0);
  Scene scene;
  scene.views.resize(1);
  scene.views[0].photo = folder.path() / "a.png";
  scene.views[0].camera.width = 2;
  scene.views[0].camera.height = 2;
  scene.views[0].reduction = 2;
  PhotoCache cache(scene, 1000);
  const auto photo = cache.photo(view(0));
  std::vector<int> greys;
  for (std::size_t i = 0; i < photo->pixels.size(); i += 3) greys.push_back(photo->pixels[i]);
  EXPECT_EQ(greys, (std::vector<int>{2, 25, 255, 1}));
}

TEST(PhotoCache, RefusesAPhotoThatChangedItsSize) {
  CachedPhotos photos(1);
  photos.scene.views[0].camera.width = kPhotoWidth + 1;
  PhotoCache cache(photos.scene, 1000);
  EXPECT_TRUE(contains(input_error([&] { cache.photo(view(0)); }), "40 x 30"));
}

}  // namespace
}  // namespace gpvc::io
