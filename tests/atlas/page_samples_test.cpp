// Photos of any depth and any number of bands: what their pages hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "atlas/sampling/layers.h"
#include "io/photos.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

constexpr int kEdge = 160;  ///< of a photo, pixels; a face of the plane has sixteen, and a texel is a pixel

/// Samples and pictures in memory.
class BandPhotos final : public io::PhotoSource {
 public:
  explicit BandPhotos(const BandSet& set) : set_(set) {}
  /// sample(x, y, band) of each pixel. The picture is the composite.
  template <typename Sample>
  void add(const Sample& sample) {
    Samples samples{kEdge, kEdge, set_.bands.size(), set_.type, {}};
    samples.bytes.resize(samples.pixel_bytes() * kEdge * kEdge);
    Image image{kEdge, kEdge, 3, {}};
    for (int y = 0; y < kEdge; ++y)
      for (int x = 0; x < kEdge; ++x) {
        for (std::size_t b = 0; b < samples.bands; ++b)
          store_sample(samples.at(x, y) + b * bytes_of(set_.type), set_.type, static_cast<float>(sample(x, y, b)));
        for (const std::size_t b : set_.composite) {
          const double value = double{load_sample(samples.at(x, y) + b * bytes_of(set_.type), set_.type)};
          image.pixels.push_back(to_grey_level(static_cast<float>((value - set_.black) / set_.units_per_level())));
        }
      }
    images_.push_back(std::make_shared<const Image>(std::move(image)));
    samples_.push_back(std::make_shared<const Samples>(std::move(samples)));
  }
  std::shared_ptr<const Image> photo(ViewId view) override { return images_.at(index(view)); }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId) override { return nullptr; }
  std::shared_ptr<const Samples> samples(ViewId view) override { return samples_.at(index(view)); }
  const Samples& of(std::size_t view) const { return *samples_[view]; }

 private:
  BandSet set_;
  std::vector<std::shared_ptr<const Image>> images_;
  std::vector<std::shared_ptr<const Samples>> samples_;
};

BandSet band_set(SampleType type, std::size_t bands, double white) {
  BandSet set;
  set.type = type;
  for (std::size_t b = 0; b < bands; ++b) set.bands.push_back({.name = "B" + std::to_string(b + 1)});
  for (std::size_t& b : set.composite) b = std::min(b, bands - 1);
  set.white = white;
  set.radiometric = true;
  return set;
}

/// A plane of ten squares a side under one view, or under two that have half of it each.
struct BandScene : AtlasScene {
  explicit BandScene(const BandSet& set, std::size_t views = 1) {
    add_plane(10, 10, 1.0);
    for (std::size_t v = 0; v < views; ++v) add_view(5, 5, 10, kEdge, kEdge, kEdge);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      labels[f] = ViewId{static_cast<std::uint32_t>(f * views / mesh.faces.size())};
    scene.bands = set;
    graph = labeling::face_graph(mesh);
    candidates.first.assign(mesh.faces.size() + 1, 0);
  }
  TextureAtlas bake(io::PhotoSource& photos, const AtlasOptions& options, const BakeOptions& space = {}) {
    const AtlasInput input{mesh, scene, photos, graph, labels, tags, candidates, coverage};
    return bake_atlas(plan_atlas(input, options), input, nullptr, space);
  }
};

float band_at(const Samples& samples, int x, int y, std::size_t band) {
  return load_sample(samples.at(x, y) + band * bytes_of(samples.type), samples.type);
}

/// Calls visit(x, y) for the texels in charts.
template <typename Visit>
std::size_t for_chart_texels(const PageSamples& page, const Visit& visit) {
  std::size_t count = 0;
  for (int y = 0; y < page.samples.height; ++y)
    for (int x = 0; x < page.samples.width; ++x)
      if (page.charts[pixel_index(x, y, page.samples.width)] != 0) {
        visit(x, y);
        ++count;
      }
  return count;
}

double noise(int x, int y, std::size_t band) {
  const auto mixed = static_cast<std::uint32_t>(x * 7919 + y * 104729) + static_cast<std::uint32_t>(band) * 15485863u;
  return static_cast<double>(mixed * 2654435761u >> 8 & 0xFFFF) / 65535;
}

/// Bands 0 and 1 tell the pixel, the others are noise.
double place_and_noise(int x, int y, std::size_t band, double unit) {
  return band == 0 ? x * unit : band == 1 ? y * unit : std::round(noise(x, y, band) * 1.3 / unit) * unit;
}

class Depths : public testing::TestWithParam<std::pair<SampleType, std::size_t>> {};

// Texels that are pixels of the photo hold its samples, in each band and to the last bit.
TEST_P(Depths, PagesHoldThePhotosSamples) {
  const auto [type, bands] = GetParam();
  const double unit = type == SampleType::f32 ? 1e-3 : 1;
  const double most = type == SampleType::f32 ? 1.3 : type == SampleType::u16 ? 65535 : 255;
  const BandSet set = band_set(type, bands, most);
  BandPhotos photos(set);
  photos.add([&](int x, int y, std::size_t b) {
    return b < 2 ? place_and_noise(x, y, b, unit) : std::round(noise(x, y, b) * most / unit) * unit;
  });
  BandScene s(set);
  const TextureAtlas atlas = s.bake(photos, AtlasOptions{});
  ASSERT_EQ(atlas.samples.size(), atlas.pages.size());
  std::set<std::pair<int, int>> seen;
  for (const PageSamples& page : atlas.samples) {
    ASSERT_EQ(page.samples.bands, bands);
    ASSERT_EQ(page.samples.type, type);
    for_chart_texels(page, [&](int x, int y) {
      const int px = static_cast<int>(std::lround(double{band_at(page.samples, x, y, 0)} / unit)),
                py = static_cast<int>(std::lround(double{band_at(page.samples, x, y, 1)} / unit));
      ASSERT_TRUE(px >= 0 && py >= 0 && px < kEdge && py < kEdge);
      seen.insert({px, py});
      ASSERT_EQ(std::memcmp(page.samples.at(x, y), photos.of(0).at(px, py), page.samples.pixel_bytes()), 0)
          << px << " " << py;
    });
  }
  EXPECT_EQ(seen.size(), std::size_t{kEdge} * kEdge);
}

INSTANTIATE_TEST_SUITE_P(All, Depths,
                         testing::Values(std::pair(SampleType::u8, std::size_t{4}),
                                         std::pair(SampleType::u16, std::size_t{2}),
                                         std::pair(SampleType::u16, std::size_t{5}),
                                         std::pair(SampleType::f32, std::size_t{10})));

// The picture of 8 bits is that of the same photos without bands.
TEST(Bands, LeaveThePicturesPagesAsTheyAre) {
  const BandSet set = band_set(SampleType::u16, 5, 65535);
  BandPhotos photos(set);
  for (int v = 0; v < 2; ++v)
    photos.add([&](int x, int y, std::size_t b) { return 20000 + 900 * v + 20000 * noise(x / 8, y / 8, b); });
  BandScene with(set, 2), without(set, 2);
  without.scene.bands.reset();
  const TextureAtlas a = with.bake(photos, AtlasOptions{}), b = without.bake(photos, AtlasOptions{});
  EXPECT_TRUE(b.samples.empty());
  ASSERT_EQ(a.pages.size(), b.pages.size());
  for (std::size_t p = 0; p < a.pages.size(); ++p) EXPECT_EQ(a.pages[p].pixels, b.pages[p].pixels);
}

// Quantities of two photos that differ in brightness: the picture is levelled, they are what the photos have.
TEST(Bands, QuantitiesAreNeitherLevelledNorMixed) {
  const BandSet set = band_set(SampleType::f32, 3, 1.0);
  BandPhotos photos(set);
  for (int v = 0; v < 2; ++v)
    photos.add([v](int, int, std::size_t b) { return (v == 0 ? 0.3 : 0.4) + 0.05 * double(b); });
  BandScene s(set, 2);
  const TextureAtlas atlas = s.bake(photos, AtlasOptions{});
  EXPECT_GT(atlas.statistics.seam_step_before, 10);
  EXPECT_LT(atlas.statistics.seam_step_after, 2);
  std::map<float, std::size_t> found;
  for (const PageSamples& page : atlas.samples)
    for_chart_texels(page, [&](int x, int y) {
      const float first = band_at(page.samples, x, y, 0);
      ++found[first];
      EXPECT_EQ(band_at(page.samples, x, y, 2), first == 0.3f ? 0.4f : 0.5f);
    });
  ASSERT_EQ(found.size(), 2u);
  EXPECT_GT(found[0.3f], 8000u);
  EXPECT_GT(found[0.4f], 8000u);
}

// Colours of 16 bits are levelled and blended as those of 8 are: the page of 8 bits is theirs, rounded.
TEST(Bands, ColorsAreCorrectedAsThePictureIs) {
  BandSet set = band_set(SampleType::u16, 3, 65535);
  set.radiometric = false;
  BandPhotos photos(set);
  for (int v = 0; v < 2; ++v)
    photos.add([v](int x, int y, std::size_t b) {
      // Whole levels of the picture, so that both are made of the same colours.
      return 257 * std::round((v == 0 ? 1.0 : 0.85) * (70 + 90 * noise(x / 16, y / 16, b)));
    });
  BandScene s(set, 2);
  s.candidates.first.clear();
  s.candidates.first.push_back(0);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    for (std::uint32_t v = 0; v < 2; ++v) {
      s.candidates.views.push_back(v);
      s.candidates.costs.push_back(ViewId{v} == s.labels[f] ? 0.0f : 0.02f);
    }
    s.candidates.first.push_back(s.candidates.views.size());
  }
  const TextureAtlas atlas = s.bake(photos, AtlasOptions{});
  EXPECT_GT(atlas.statistics.blended_faces, 150u);
  EXPECT_GT(atlas.statistics.seam_step_before, 5);
  std::size_t fractions = 0, texels = 0;
  for (std::size_t p = 0; p < atlas.samples.size(); ++p)
    texels += for_chart_texels(atlas.samples[p], [&](int x, int y) {
      for (std::size_t b = 0; b < 3; ++b) {
        const double level = double{band_at(atlas.samples[p].samples, x, y, b)} / 257;
        // A level is rounded once when it is painted and once when it is blended.
        ASSERT_NEAR(level, atlas.pages[p].at(x, y)[b], 1.01);
        fractions += std::abs(level - std::round(level)) > 0.1 ? 1 : 0;
      }
    });
  EXPECT_GT(fractions, texels);  // of three a texel
}

// What lies between pixels stays between their values: a quantity that is never negative does not become so.
TEST(Bands, QuantitiesDoNotOvershoot) {
  const BandSet set = band_set(SampleType::f32, 4, 1.0);
  BandPhotos photos(set);
  photos.add([](int x, int y, std::size_t b) { return (x / 5 + y / 7 + static_cast<int>(b)) % 2 == 0 ? 0.0 : 1.0; });
  BandScene s(set);
  s.scene.views[0].camera.cx += 0.37;
  s.scene.views[0].camera.distortion.k1 = 0.02;
  const TextureAtlas atlas = s.bake(photos, AtlasOptions{});
  std::size_t between = 0;
  for (const PageSamples& page : atlas.samples)
    for_chart_texels(page, [&](int x, int y) {
      for (std::size_t b = 0; b < 4; ++b) {
        const float value = band_at(page.samples, x, y, b);
        ASSERT_TRUE(value >= 0 && value <= 1);
        between += value > 0 && value < 1 ? 1 : 0;
      }
    });
  EXPECT_GT(between, 1000u);
}

// Little memory, several pages, holes that are filled across them: the same bytes as with all of it.
TEST(Bands, AreTheSameInLittleMemory) {
  const BandSet set = band_set(SampleType::u16, 5, 65535);
  BandPhotos photos(set);
  for (int v = 0; v < 2; ++v)
    photos.add([&](int x, int y, std::size_t b) { return 65535 * noise(x / 4 + v, y / 4, b); });
  BandScene s(set, 2);
  for (std::size_t f = 40; f < 150; f += 7) s.leave_unseen(f);
  const AtlasOptions options{.page_size = 96};
  const TextureAtlas whole = s.bake(photos, options);
  ASSERT_GT(whole.pages.size(), 2u);
  const test::TemporaryFolder folder;
  // Pages that wait for colours are spilled, or come back from the work that the run keeps.
  io::WorkStore store(folder.path() / "work");
  for (io::WorkStore* kept : {static_cast<io::WorkStore*>(nullptr), &store}) {
    const TextureAtlas little = s.bake(
        photos, options,
        {.page_bytes = 1, .batch_bytes = 1, .scratch_folder = folder.path(), .kept = {.store = kept, .key = {}}});
    ASSERT_EQ(little.samples.size(), whole.samples.size());
    for (std::size_t p = 0; p < whole.samples.size(); ++p) {
      EXPECT_EQ(little.pages[p].pixels, whole.pages[p].pixels);
      EXPECT_EQ(little.samples[p].samples.bytes, whole.samples[p].samples.bytes) << p;
    }
  }
}

// Unseen faces continue what is around them, in every band.
TEST(Bands, HolesAreFilledInEveryBand) {
  const BandSet set = band_set(SampleType::f32, 5, 1.0);
  BandPhotos photos(set);
  photos.add([](int, int, std::size_t b) { return 0.1 + 0.15 * double(b); });
  BandScene s(set);
  for (std::size_t f = 80; f < 90; ++f) s.leave_unseen(f);
  const TextureAtlas atlas = s.bake(photos, AtlasOptions{});
  for (const PageSamples& page : atlas.samples)
    for_chart_texels(page, [&](int x, int y) {
      for (std::size_t b = 0; b < 5; ++b) ASSERT_NEAR(band_at(page.samples, x, y, b), 0.1 + 0.15 * double(b), 1e-6);
    });
}

}  // namespace
}  // namespace gpvc::atlas
