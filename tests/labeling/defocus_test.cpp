// Photos that are out of focus count as what they show; sharp ones, however they differ, as all their pixels.
#include "labeling/costs/defocus.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kFacesAcross = 40, kPhotos = 4;  // a square of faces, each a cell
constexpr float kQuality = 50;

Grouped<std::uint32_t> neighbours_of_grid() {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t face = 0; face < kFacesAcross * kFacesAcross; ++face) {
    if ((face + 1) % kFacesAcross != 0) pairs.push_back({face, face + 1});
    if (face + kFacesAcross < kFacesAcross * kFacesAcross) pairs.push_back({face, face + kFacesAcross});
  }
  return group_neighbours(std::size_t{kFacesAcross} * kFacesAcross, pairs);
}

// 0 to 1, by two numbers.
double random_share(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9E3779B1U ^ b * 0x85EBCA77U;
  h ^= h >> 15U;
  h *= 0x2C1B3C6DU;
  h ^= h >> 13U;
  return (h >> 8U) / 16777216.0;
}

// What a view shows of a face.
struct Shown {
  double step = 8;       ///< from pixel to pixel, in grey levels
  double contrast = 30;  ///< from face to face, in grey levels
  std::uint16_t pixels = 64;
  bool another_thing = false;
};

RecordsByView discounted(const std::function<Shown(std::uint32_t, std::uint32_t)>& shown) {
  RecordsByView by_view;
  for (std::uint32_t view = 0; view < kPhotos; ++view)
    for (std::uint32_t face = 0; face < kFacesAcross * kFacesAcross; ++face) {
      const Shown of_view = shown(view, face);
      FaceRecord record;
      record.face = face;
      record.quality = kQuality;
      record.visible = kWholeShare;
      record.pixels = of_view.pixels;
      const double level = 100 + of_view.contrast * random_share(face, of_view.another_thing ? 100 + view : 7);
      record.color.fill(static_cast<std::uint16_t>(256 * level));
      // Scatters by a tenth.
      record.disagreement =
          static_cast<std::uint16_t>(256 * of_view.step * (0.9 + 0.2 * random_share(face, 200 + view)));
      by_view[view].push_back(record);
    }
  discount_blurred(by_view, make_cells(by_view, PhotoColors({}, kPhotos), neighbours_of_grid()));
  return by_view;
}

float least_quality(const std::vector<FaceRecord>& records) {
  return std::ranges::min_element(records, {}, &FaceRecord::quality)->quality;
}
float most_quality(const std::vector<FaceRecord>& records) {
  return std::ranges::max_element(records, {}, &FaceRecord::quality)->quality;
}

TEST(Defocus, ABlurredPhotoCountsAsWhatItShows) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{2, 24} : Shown{};
  });
  for (const std::uint32_t view : {0U, 1U, 3U}) EXPECT_EQ(least_quality(by_view.at(view)), kQuality) << view;
  // Of the squared steps, 3 of 63 are left without noise, of which contrast explains (24 / 30)^2.
  const double share = 3.0 / 63 / 0.64, factor = std::exp2(share) - 1;
  EXPECT_NEAR(static_cast<double>(most_quality(by_view.at(2))), factor * static_cast<double>(kQuality), 1.0);
}

// Three of four photos are, and agree with each other.
TEST(Defocus, OneSharpPhotoIsEnough) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{} : Shown{2, 24};
  });
  EXPECT_EQ(least_quality(by_view.at(2)), kQuality);
  for (const std::uint32_t view : {0U, 1U, 3U}) EXPECT_LT(most_quality(by_view.at(view)), kQuality / 4);
}

TEST(Defocus, OnlyWhereItIs) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t face) {
    return view == 2 && face / kFacesAcross >= kFacesAcross / 2 ? Shown{2, 24} : Shown{};
  });
  const auto& records = by_view.at(2);
  EXPECT_EQ(records[kFacesAcross / 2].quality, kQuality);
  EXPECT_LT(records[kFacesAcross * (kFacesAcross - 1) + kFacesAcross / 2].quality, kQuality / 4);
}

// By angle, light and lens.
TEST(Defocus, SharpPhotosCountInFullThoughTheyDiffer) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) { return Shown{8 - 0.7 * view}; });
  for (const auto& [view, records] : by_view) EXPECT_EQ(least_quality(records), kQuality) << view;
}

TEST(Defocus, HazeAndGlareAreNoBlur) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{3, 10} : Shown{};
  });
  EXPECT_EQ(least_quality(by_view.at(2)), kQuality);
}

// A photo from half the distance, of a surface so smooth that twice as many pixels halve the steps between them.
TEST(Defocus, SmallStepsOfALargePictureAreNoBlur) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{3.9, 30, 256} : Shown{};
  });
  EXPECT_EQ(least_quality(by_view.at(2)), kQuality);
}

// A tree in front has more detail than the road that the others show.
TEST(Defocus, OtherThingsAreNotCompared) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{40, 90, 64, true} : Shown{};
  });
  for (const auto& [view, records] : by_view) EXPECT_EQ(least_quality(records), kQuality) << view;
}

TEST(Defocus, NoiseOfFlatSurfacesTellsNothing) {
  const RecordsByView by_view = discounted([](std::uint32_t view, std::uint32_t) {
    return view == 2 ? Shown{0.2, 3} : Shown{1.1, 3};
  });
  EXPECT_EQ(least_quality(by_view.at(2)), kQuality);
}

TEST(Defocus, IsTheSameForAnyNumberOfThreads) {
  std::vector<RecordsByView> results;
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(discounted([](std::uint32_t view, std::uint32_t face) {
      return Shown{8 - 6 * random_share(face / 300, view), 28};
    }));
  }
  for (const auto& [view, records] : results[0])
    for (std::size_t i = 0; i < records.size(); ++i) ASSERT_EQ(records[i].quality, results[1][view][i].quality);
}

}  // namespace
}  // namespace gpvc::labeling
