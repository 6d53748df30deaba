// Photos with bands of known truth, from pictures to pages, files, edits and orthophotos.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <vector>

#include "app/evaluate/bands.h"
#include "app/pipeline/pipeline.h"
#include "app/pipeline/texture_files.h"
#include "app/synth/band_photos.h"
#include "app/synth/city.h"
#include "io/images.h"
#include "io/mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

/// A small city and photos of it in bands, in memory.
struct BandCity {
  explicit BandCity(const synth::BandOptions& bands) {
    synth::FlightOptions flight;
    flight.photos = 8;
    flight.width = 480;
    flight.height = 320;
    flight.size_m = 40;
    made = synth::make_city({flight, 4000});
    synth::SynthRenderer renderer(made);
    scene.views = synth::synth_flight(flight);
    scene.bands = synth::bands_of(bands);
    scene.bands->black = 0;
    scene.bands->white = synth::sample_of_white(bands);
    for (const View& view : scene.views) {
      synth::SynthPhoto photo;
      Samples samples = synth::band_photo(renderer, view.camera, view.pose, {}, nullptr, bands, photo);
      Image picture = io::picture_of(samples, *scene.bands);
      pictures.push_back({std::move(picture), std::nullopt, std::move(samples)});
    }
    mesh = made.mesh;
    views = checks::all_views(scene);
  }
  pipeline::TexturedMesh texture(const pipeline::Settings& settings) {
    io::PictureSource photos(scene, pictures);
    results::Observer silent;
    return pipeline::texture({{scene, mesh, views}, settings, photos, silent});
  }
  synth::SynthScene made;
  Scene scene;
  Mesh mesh;
  std::vector<io::Picture> pictures;
  std::vector<ViewId> views;
};

float sample_at(const Samples& samples, int x, int y, std::size_t band) {
  return load_sample(samples.at(x, y) + band * bytes_of(samples.type), samples.type);
}

double ndvi(double infrared, double red) { return (infrared - red) / (infrared + red); }

/// Texels around a texel that pixels of other faces reach: half a texel, as much of a pixel, and two for what is interpolated.
constexpr double kReach = 3;

/// Of a point in a triangle from its edges.
double least_distance(const std::array<std::array<double, 2>, 3>& corners, double x, double y) {
  double least = 1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % 3];
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    least = std::min(least, std::abs(dx * (y - a[1]) - dy * (x - a[0])) / std::hypot(dx, dy));
  }
  return least;
}

/// How far NDVI of pages is from the truth at the middles of faces that some photo shows whole, with pixels that
/// show nothing else, ascending.
std::vector<double> ndvi_errors(const BandCity& city, const pipeline::TexturedMesh& textured) {
  const io::TexturedModel& model = textured.atlas.model;
  std::vector<double> errors;
  for (std::uint32_t f = 0; f < city.mesh.faces.size(); ++f) {
    if (textured.tags[f] != labeling::FaceTag::seen) continue;
    const Samples& page = textured.atlas.samples[model.face_page[f]].samples;
    double u = 0, v = 0;
    WorldPoint middle;
    std::array<std::array<double, 2>, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const io::TexCoord& at = model.texcoords[model.face_texcoords[f][i]];
      corners[i] = {double{at.u} * page.width, double{at.v} * page.height};
      u += corners[i][0] / 3;
      v += corners[i][1] / 3;
      const WorldPoint& p = city.mesh.positions[city.mesh.faces[f][i]];
      middle = {middle.x + p.x / 3, middle.y + p.y / 3, middle.z + p.z / 3};
    }
    if (least_distance(corners, u, v) < kReach) continue;
    const synth::Surface& surface = city.made.surfaces[city.made.face_surface[f]];
    // Where the pattern changes within a pixel, the pixel has a mean of it.
    const auto truth = [&](double dx, double dy, double dz) {
      const WorldPoint p{middle.x + dx, middle.y + dy, middle.z + dz};
      return ndvi(synth::surface_reflectance(surface, p, 842), synth::surface_reflectance(surface, p, 668));
    };
    constexpr double kHalfPixel = 0.06;  // m
    double least = truth(0, 0, 0), most = least;
    for (int d = 0; d < 6; ++d) {
      const double along = d % 2 == 0 ? kHalfPixel : -kHalfPixel;
      const double value = truth(d / 2 == 0 ? along : 0, d / 2 == 1 ? along : 0, d / 2 == 2 ? along : 0);
      least = std::min(least, value);
      most = std::max(most, value);
    }
    if (most - least > 0.004) continue;
    const int x = std::clamp(static_cast<int>(u), 0, page.width - 1),
              y = std::clamp(static_cast<int>(v), 0, page.height - 1);
    const double found = ndvi(double{sample_at(page, x, y, 3)}, double{sample_at(page, x, y, 2)});
    errors.push_back(std::abs(found - truth(0, 0, 0)));
  }
  std::ranges::sort(errors);
  return errors;
}

class BandDepths : public testing::TestWithParam<SampleType> {};

TEST_P(BandDepths, VegetationIndicesOfPagesAreTheTruth) {
  BandCity city({.count = 5, .type = GetParam()});
  const pipeline::TexturedMesh textured = city.texture({});
  ASSERT_EQ(textured.atlas.samples.size(), textured.atlas.pages.size());
  const std::vector<double> errors = ndvi_errors(city, textured);
  ASSERT_GT(errors.size(), 500u);
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  EXPECT_LT(mean, 0.005);
  EXPECT_LT(errors[errors.size() * 99 / 100], 0.02);
}

INSTANTIATE_TEST_SUITE_P(All, BandDepths, testing::Values(SampleType::u16, SampleType::f32));

/// The photos as files, one TIFF each.
void write_photos(BandCity& city, const fs::path& folder) {
  for (std::size_t v = 0; v < city.scene.views.size(); ++v) {
    city.scene.views[v].photo = folder / (std::to_string(v) + ".tif");
    io::write_samples(city.scene.views[v].photo, *city.pictures[v].samples, *city.scene.bands);
  }
}

std::vector<Samples> page_samples(const fs::path& folder) {
  std::vector<Samples> pages;
  for (fs::path file; fs::exists(file = folder / ("model_" + std::to_string(pages.size()) + ".tif"));)
    pages.push_back(io::read_samples(file));
  return pages;
}

pipeline::TexturedFiles texture_files(BandCity& city, const pipeline::Settings& settings, const fs::path& out,
                                      const fs::path& from = {}) {
  io::PhotoCache photos(city.scene);
  results::Observer silent;
  results::OutputFolder folder(out);
  const pipeline::Run run{{city.scene, city.mesh, city.views}, settings, photos, silent};
  pipeline::TexturedFiles files =
      from.empty() ? pipeline::texture_into(run, folder) : pipeline::retexture_into(from, run, folder);
  folder.publish();
  return files;
}

// Files hold what the pages in memory hold, and each photo is decoded as often as one without bands.
TEST(BandFiles, HoldAllBandsAndAreReadAgain) {
  const test::TemporaryFolder folder;
  BandCity city({.count = 5, .type = SampleType::u16});
  const pipeline::TexturedMesh memory = city.texture({});
  write_photos(city, folder.path());
  texture_files(city, {}, folder.path() / "out");
  const std::vector<Samples> pages = page_samples(folder.path() / "out");
  ASSERT_EQ(pages.size(), memory.atlas.samples.size());
  for (std::size_t p = 0; p < pages.size(); ++p) EXPECT_EQ(pages[p].bytes, memory.atlas.samples[p].samples.bytes);
  const BandSet read = io::read_band_set(folder.path() / "out" / "model_0.tif");
  EXPECT_EQ(read.bands, city.scene.bands->bands);
  EXPECT_EQ(read.type, SampleType::u16);

  io::LoadedModel model = io::read_textured_model(folder.path() / "out" / "model.obj");
  model.model.mesh = &model.mesh;
  io::PhotoCache photos(city.scene);
  evaluate::EvaluateOptions options;
  options.model = folder.path() / "out" / "model.obj";
  options.reduction = 2;
  const evaluate::Evaluation scores = evaluate::evaluate_model(city.scene, photos, model, options, [](auto, auto) {});
  ASSERT_EQ(scores.bands.size(), 5u);
  for (const evaluate::BandScore& band : scores.bands) {
    EXPECT_LT(band.mean.ncc_error, 0.05) << band.band;
    EXPECT_GT(band.mean.raw_psnr, 25) << band.band;
    EXPECT_GT(band.rms, 0);
  }
  // Samples are those of their page, whatever it is called: pages of materials and tiles have names.
  for (const char* extension : {".jpg", ".tif"})
    fs::rename(folder.path() / "out" / ("model_0" + std::string(extension)),
               folder.path() / "out" / ("model.1001" + std::string(extension)));
  std::string materials = test::read_file(folder.path() / "out" / "model.mtl");
  materials.replace(materials.find("model_0.jpg"), 11, "model.1001.jpg");
  std::ofstream(folder.path() / "out" / "model.mtl") << materials;
  io::LoadedModel renamed = io::read_textured_model(options.model);
  renamed.model.mesh = &renamed.mesh;
  const auto again = evaluate::evaluate_model(city.scene, photos, renamed, options, [](auto, auto) {});
  ASSERT_EQ(again.bands.size(), 5u);
  EXPECT_EQ(again.bands[4].rms, scores.bands[4].rms);
}

// As PNG instead of TIFF: the same samples, which are scored and changed by rules like those of TIFFs.
TEST(BandFiles, OfPngHoldWhatTiffsHold) {
  const test::TemporaryFolder folder;
  BandCity city({.count = 4, .type = SampleType::u16});
  write_photos(city, folder.path());
  pipeline::Settings settings;
  settings.editable = true;
  settings.output.texture = io::ImageFormat::png;
  const fs::path tif = folder.path() / "tif", png = folder.path() / "png", changed = folder.path() / "changed";
  texture_files(city, settings, tif);
  settings.output.band_format = io::SampleFormat::png;
  texture_files(city, settings, png);
  const std::vector<Samples> pages = page_samples(tif);
  ASSERT_FALSE(pages.empty());
  EXPECT_TRUE(page_samples(png).empty());
  for (std::size_t p = 0; p < pages.size(); ++p) {
    const std::string name = "model_" + std::to_string(p);
    EXPECT_EQ(test::read_file(png / (name + ".png")), test::read_file(tif / (name + ".png")));
    const auto found = pipeline::samples_beside(png / (name + ".png"), pages[p].width, pages[p].height);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->file, png / (name + "_bands.png"));
    EXPECT_EQ(found->samples.bytes, pages[p].bytes);
    EXPECT_EQ(io::read_band_set(found->file).bands, city.scene.bands->bands);
  }
  texture_files(city, settings, changed, png);
  EXPECT_EQ(test::read_file(changed / "model_0_bands.png"), test::read_file(png / "model_0_bands.png"));
}

TEST(BandFiles, OfPngAreRefusedBeforeAnyWorkWhereItCannotHoldThem) {
  const test::TemporaryFolder folder;
  pipeline::Settings settings;
  settings.output.band_format = io::SampleFormat::png;
  for (const auto& [bands, kinds] :
       {std::pair{synth::BandOptions{.count = 5, .type = SampleType::u16}, "5 bands of u16"},
        std::pair{synth::BandOptions{.count = 3, .type = SampleType::f32}, "3 bands of f32"}}) {
    BandCity city(bands);
    write_photos(city, folder.path());
    try {
      texture_files(city, settings, folder.path() / "out");
      ADD_FAILURE() << kinds;
    } catch (const InputError& error) {
      EXPECT_TRUE(
          test::contains(error.what(), "0.tif: holds " + std::string(kinds) + ", and a PNG holds 1 to 4 of u8 or u16"))
          << error.what();
    }
    EXPECT_FALSE(fs::exists(folder.path() / "out" / "run.json"));
  }
}

// A rule that forbids a photo changes the faces that it textured; all other texels, and the files of kept pages, stay.
TEST(BandFiles, AreChangedByRulesAsPagesAre) {
  const test::TemporaryFolder folder;
  BandCity city({.count = 5, .type = SampleType::f32});
  write_photos(city, folder.path());
  pipeline::Settings settings;
  settings.editable = true;
  settings.atlas.page_size = 512;
  const fs::path first = folder.path() / "first", second = folder.path() / "second";
  const pipeline::TexturedFiles before = texture_files(city, settings, first);
  settings.view_rules.push_back({io::GroundRegion{{{2, 2}, {14, 2}, {14, 14}, {2, 14}}}, false, {ViewId{0}}, "rule"});
  texture_files(city, settings, second, first);
  const std::vector<Samples> old = page_samples(first), made = page_samples(second);
  ASSERT_GE(made.size(), old.size() - 1);
  std::size_t same = 0;
  for (const Samples& page : made)
    same += std::ranges::any_of(old, [&](const Samples& other) { return other.bytes == page.bytes; }) ? 1 : 0;
  EXPECT_GT(same, 0u);
  EXPECT_LT(same, made.size());
  for (const Samples& page : made) EXPECT_EQ(page.bands, 5u);
}

}  // namespace
}  // namespace gpvc
