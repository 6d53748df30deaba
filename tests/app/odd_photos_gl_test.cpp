// Single photos that do not belong to their poses, in a scene whose few faces tell of each photo by a few hundred steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/pipeline/pipeline.h"
#include "tests/app/photographed_city.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

using test::City;
using test::contains;

class OddPhotosWarnings : public results::Observer {
 public:
  void warning(const std::string& text, const std::vector<Cure>&) override { warnings.push_back(text); }
  std::vector<std::string> warnings;
};

class OddPhotos : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(8000, 600, 15); }
  static void TearDownTestSuite() { city_.reset(); }

  // What is said of the city with some pictures spoiled. The views `odd` have no candidates.
  static std::string said_of(const std::vector<std::uint32_t>& odd,
                             const std::function<void(std::vector<io::Picture>&)>& spoil) {
    std::vector<io::Picture> pictures = city_->pictures;
    spoil(pictures);
    io::PictureSource photos(city_->scene, pictures);
    OddPhotosWarnings observer;
    const pipeline::Seen seen =
        pipeline::see({{city_->scene, city_->mesh, city_->views}, pipeline::Settings{}, photos, observer});
    for (const labeling::ViewAgreement& each : seen.candidates.agreement)
      EXPECT_EQ(each.by_chance, std::ranges::find(odd, index(each.view)) != odd.end())
          << index(each.view) << ": " << each.correlation << " where chance gives " << each.chance;
    for (const std::uint32_t view : odd)
      EXPECT_EQ(std::ranges::find(seen.candidates.table.views, view), seen.candidates.table.views.end());
    return observer.warnings.empty() ? "" : observer.warnings[0];
  }
  static const std::string& name(std::size_t view) { return city_->scene.views[view].name; }
  static std::unique_ptr<City> city_;
};
std::unique_ptr<City> OddPhotos::city_;

void reverse_pixels(Image& image, int rows_of) {
  // Of the whole, or row by row.
  const auto channels = static_cast<std::size_t>(image.channels);
  const std::size_t run = pixel_index(0, rows_of, image.width);
  for (std::size_t begin = 0; begin < image.pixels.size(); begin += run * channels) {
    const auto first = image.pixels.begin() + static_cast<std::ptrdiff_t>(begin);
    std::reverse(first, first + static_cast<std::ptrdiff_t>(run * channels));
  }
  for (std::size_t i = 0; i < image.pixels.size(); i += channels) std::swap(image.pixels[i], image.pixels[i + 2]);
}

TEST_F(OddPhotos, NoneIsFoundWhereAllAreRight) {
  EXPECT_EQ(said_of({}, [](auto&) {}), "");
}

TEST_F(OddPhotos, TwoAtEachOthersPosesAreNamedWithTheirCameras) {
  const std::string said =
      said_of({0, 7}, [](std::vector<io::Picture>& pictures) { std::swap(pictures[0].image, pictures[7].image); });
  EXPECT_TRUE(contains(said, name(0) + " shows what " + name(7) + "'s camera sees")) << said;
  EXPECT_TRUE(contains(said, name(7) + " shows what " + name(0) + "'s camera sees")) << said;
}

TEST_F(OddPhotos, OneUpsideDownIsNamed) {
  const std::string said = said_of(
      {7}, [](std::vector<io::Picture>& pictures) { reverse_pixels(pictures[7].image, pictures[7].image.height); });
  EXPECT_TRUE(contains(said, name(7) + " would agree if it were turned by 180 degrees")) << said;
}

TEST_F(OddPhotos, ACopyOfAnotherIsNamed) {
  const std::string said = said_of({7}, [](std::vector<io::Picture>& pictures) { pictures[7] = pictures[0]; });
  EXPECT_TRUE(contains(said, name(7) + " shows the same as " + name(0))) << said;
}

TEST_F(OddPhotos, OneMirroredIsNamed) {
  const std::string said =
      said_of({7}, [](std::vector<io::Picture>& pictures) { reverse_pixels(pictures[7].image, 1); });
  EXPECT_TRUE(contains(said, name(7) + " would agree if it were mirrored")) << said;
}

TEST_F(OddPhotos, ThoseWithTheSunElsewhereAreNamed) {
  synth::FlightOptions flight;
  flight.size_m = 50;  // as of the fixture
  const synth::SynthScene scene = synth::make_city({flight, 8000});
  synth::SynthRenderer renderer(scene);
  synth::Shot later;
  later.towards_sun = {-0.8, 0.36, 0.48};
  const std::string said = said_of({}, [&](std::vector<io::Picture>& pictures) {
    for (const std::size_t view : {2u, 9u}) {
      const View& at = city_->scene.views[view];
      pictures[view].image = renderer.photo(at.camera, at.pose, later).image;
    }
  });
  EXPECT_TRUE(contains(said, "2 of 15 photos show other colours than the others at ")) << said;
  EXPECT_TRUE(contains(said, name(2) + ", " + name(9) + "; were they taken on another day")) << said;
}

}  // namespace
}  // namespace gpvc
