// Synthetic photos in bands: their truth, their files, and what a reader of scenes makes of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/cli/band_notes.h"
#include "app/cli/options.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/app/synth_files.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct RenderedBands {
  explicit RenderedBands(const synth::BandOptions& bands)
      : scene(synth::make_city({options.flight, options.faces})), view(synth::synth_flight(options.flight)[0]) {
    synth::SynthRenderer renderer(scene);
    samples = synth::band_photo(renderer, view.camera, view.pose, {}, nullptr, bands, photo);
    plain = renderer.photo(view.camera, view.pose);
  }
  cli::SynthOptions options = test::small_city({}, 240);
  synth::SynthScene scene;
  View view;
  Samples samples;
  synth::SynthPhoto photo, plain;
};

TEST(SynthBands, ColoursOfSixteenBitsAreThoseOfThePhoto) {
  const RenderedBands rendered({.count = 3});
  const Image& image = rendered.plain.image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(load_sample(rendered.samples.at(x, y) + 2 * c, SampleType::u16) / 257, image.at(x, y)[c], 0.52);
}

// Where a pixel shows one surface, whose excess of green has one sign, infrared follows from the colours whatever the light.
TEST(SynthBands, InfraredIsTheKnownFunctionOfTheColours) {
  const RenderedBands rendered({.count = 5, .type = SampleType::f32});
  std::size_t known = 0, right = 0, plants = 0;
  for (std::size_t i = 0; i < rendered.photo.surfaces.size(); ++i) {
    const std::uint32_t surface = rendered.photo.surfaces[i];
    if (surface >= rendered.scene.surfaces.size()) continue;
    const synth::Surface& s = rendered.scene.surfaces[surface];
    const auto at = [&](double nm) { return synth::surface_reflectance(s, s.origin, nm); };
    const double factor = (at(842) - 1.2 * std::max(0.0, at(560) - (at(668) + at(475)) / 2)) / at(668);
    EXPECT_NEAR(at(717), (at(668) + at(842)) / 2, 1e-12);
    const std::byte* pixel = rendered.samples.bytes.data() + i * rendered.samples.pixel_bytes();
    const auto band = [&](std::size_t b) { return static_cast<double>(load_sample(pixel + 4 * b, SampleType::f32)); };
    const double blue = band(0), green = band(1), red = band(2), infrared = band(3);
    const double expected = factor * red + 1.2 * std::max(0.0, green - (red + blue) / 2);
    ++known;
    right += std::abs(infrared - expected) < 1e-5 ? 1 : 0;
    plants += (infrared - red) / (infrared + red) > 0.2 ? 1 : 0;
  }
  EXPECT_GT(known, 10000u);
  EXPECT_GT(right, 95 * known / 100);
  EXPECT_GT(plants, known / 50);
  EXPECT_LT(plants, known / 2) << "NDVI varies";
}

TEST(SynthBands, InFilesOfTheirOwnAreFoundNamedAndRegistered) {
  const test::TemporaryFolder folder;
  cli::SynthOptions options = test::small_city(folder.path(), 240);
  options.bands = {.count = 5, .type = SampleType::u16, .apart = true};
  test::synthesize(options);
  const Scene scene = io::read_scene(folder.path() / "colmap", {});
  ASSERT_TRUE(scene.bands);
  EXPECT_EQ(scene.bands->bands, synth::bands_of(options.bands).bands);
  EXPECT_TRUE(scene.bands->radiometric);
  EXPECT_EQ(scene.bands->composite, (std::array<std::size_t, 3>{2, 1, 0}));
  ASSERT_EQ(scene.band_places.size(), 5u);
  const nlohmann::json truth = nlohmann::json::parse(test::read_file(folder.path() / "truth.json")).at("bands");
  for (std::size_t b = 0; b < 5; ++b) {
    const double right = truth[b].at("right_px"), down = truth[b].at("down_px");
    const auto& m = scene.band_places[b].file_from_photo;
    const bool whole = right == std::floor(right) && down == std::floor(down);
    EXPECT_NEAR(m[0] * 120 + m[1] * 80 + m[2] - 120, right, whole ? 1e-9 : 0.25) << b;
    EXPECT_NEAR(m[3] * 120 + m[4] * 80 + m[5] - 80, down, whole ? 1e-9 : 0.25) << b;
    EXPECT_LT(*scene.band_places[b].error_px, 0.3);
  }
  const std::vector<std::string> notes = cli::band_notes(scene);
  ASSERT_EQ(notes.size(), 6u);
  EXPECT_TRUE(test::contains(notes[0], "5 of u16: Blue (475 nm, reflectance), Green (560 nm"));
  EXPECT_TRUE(test::contains(notes[1], "Red, Green, Blue as red, green, blue, from "));
  EXPECT_TRUE(test::contains(notes[2], "_2.tif shows the same 1.00 px right and -1.00 px down"));
  EXPECT_EQ(cli::bands_json(scene).at("bands").size(), 5u);

  // What lies aside by whole pixels is what photos of a single lens hold.
  const test::TemporaryFolder stacked;
  options.out = stacked.path();
  options.bands.apart = false;
  test::synthesize(options);
  const Scene one = io::read_scene(stacked.path() / "colmap", {});
  EXPECT_TRUE(one.band_places.empty());
  io::PhotoCache cache(scene, 0), of_one(one, 0);
  const auto samples = cache.samples(ViewId{0}), expected = of_one.samples(ViewId{0});
  const auto excluded = cache.exclusion(ViewId{0});
  ASSERT_EQ(samples->bands, expected->bands);
  double interpolated = 0;
  std::size_t pixels = 0;
  for (int y = 0; y < samples->height; ++y)
    for (int x = 0; x < samples->width; ++x) {
      if (excluded->excludes(x, y)) continue;
      ++pixels;
      const auto difference = [&](std::size_t band) {
        return std::abs(load_sample(samples->at(x, y) + 2 * band, SampleType::u16) -
                        load_sample(expected->at(x, y) + 2 * band, SampleType::u16));
      };
      for (const std::size_t band : {0u, 1u, 2u}) EXPECT_EQ(difference(band), 0) << x << ' ' << y << ' ' << band;
      interpolated += static_cast<double>(difference(3)) / 32768;
    }
  EXPECT_GT(pixels, 230u * 150);
  EXPECT_LT(interpolated / static_cast<double>(pixels), 0.02);
}

}  // namespace
}  // namespace gpvc
