// Photos whose poses are a little wrong: whole runs, tiles and changed results bring them into line alike.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "app/pipeline/edit_files.h"
#include "app/synth/synth_scene.h"
#include "app/tiles/make_job.h"
#include "app/tiles/units.h"
#include "tests/app/photographed_city.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

class AlignedPhotos : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    city_ = std::make_unique<test::City>(std::size_t{6000}, 800, 8);
    city_->scene.views = synth::with_errors(city_->scene.views, {.pose_px = 1.5}, 1);
    whole_ = std::make_unique<pipeline::TexturedMesh>(texture(atlas::PhotoAlignment::local));
  }
  static void TearDownTestSuite() {
    whole_.reset();
    city_.reset();
  }
  static checks::Input input() { return {city_->scene, city_->mesh, city_->views}; }
  static pipeline::TexturedMesh texture(atlas::PhotoAlignment align) {
    io::PictureSource photos(city_->scene, city_->pictures);
    results::Observer observer;
    pipeline::Settings settings;
    settings.atlas.align = align;
    return pipeline::texture({input(), settings, photos, observer});
  }
  /// Root mean square over the nodes of all views.
  static double difference(std::span<const ShiftField> a, std::span<const ShiftField> b) {
    double squares = 0, count = 0;
    for (std::size_t v = 0; v < a.size(); ++v)
      for (std::size_t i = 0; i < std::min(a[v].nodes.size(), b[v].nodes.size()); ++i, ++count)
        squares += std::pow(std::hypot(double{a[v].nodes[i][0]} - double{b[v].nodes[i][0]},
                                       double{a[v].nodes[i][1]} - double{b[v].nodes[i][1]}),
                            2);
    return std::sqrt(squares / count);
  }

  static inline std::unique_ptr<test::City> city_;
  static inline std::unique_ptr<pipeline::TexturedMesh> whole_;
};

TEST_F(AlignedPhotos, FitEachOtherAtCuts) {
  const pipeline::TexturedMesh none = texture(atlas::PhotoAlignment::none);
  const atlas::CutMisfit before = none.atlas.statistics.cuts, after = whole_->atlas.statistics.cuts;
  EXPECT_TRUE(none.atlas.alignment.empty());
  ASSERT_EQ(whole_->atlas.alignment.size(), city_->views.size());
  EXPECT_GE(before.matched, 20u) << "the city is small";
  EXPECT_GT(before.median_px, 1);
  EXPECT_LT(after.median_px, 0.4 * before.median_px);
  EXPECT_GT(whole_->atlas.statistics.alignment.affine_share, 0.9) << "errors of poses";
}

TEST_F(AlignedPhotos, AreTheSameForAnyNumberOfThreads) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const pipeline::TexturedMesh alone = texture(atlas::PhotoAlignment::local);
  EXPECT_EQ(alone.atlas.alignment, whole_->atlas.alignment);
  ASSERT_EQ(alone.atlas.pages.size(), whole_->atlas.pages.size());
  for (std::size_t p = 0; p < alone.atlas.pages.size(); ++p)
    EXPECT_EQ(alone.atlas.pages[p].pixels, whole_->atlas.pages[p].pixels);
}

// Tiles have nearly the labels of a whole run, and so nearly its matches.
TEST_F(AlignedPhotos, HaveOneFieldEachInAllTiles) {
  test::TemporaryFolder made;
  const tiles::JobFolder folder(made.path());
  tiles::JobSettings settings;
  settings.tiles.faces_per_tile = 1000;
  settings.views_per_unit = 2;
  results::Observer observer;
  tiles::make_job(folder, input(), settings, "test", observer);
  tiles::UnitRunner runner(folder, {}, observer);
  for (const tiles::Unit& unit : runner.units()) EXPECT_EQ(runner.run(unit), tiles::UnitResult::done) << unit.name;
  const auto fields =
      folder.get<std::vector<ShiftField>>(tiles::kLevelUnit, "alignment", [](const auto&) { return true; });
  ASSERT_EQ(fields.size(), city_->views.size());
  std::vector<ShiftField> none = fields;
  for (ShiftField& field : none) field.nodes.assign(field.nodes.size(), {0, 0});
  EXPECT_GT(difference(fields, none), 0.6);
  EXPECT_LT(difference(fields, whole_->atlas.alignment), 0.4);
}

TEST_F(AlignedPhotos, StayWhereTheyWereInAChangedResult) {
  test::TemporaryFolder out;
  pipeline::Settings settings;
  settings.editable = true;
  const auto run = [&](const fs::path& from, const fs::path& to) {
    io::PhotoCache photos(city_->scene);
    results::Observer observer;
    results::OutputFolder folder(to, true, "texture");
    if (from.empty())
      pipeline::texture_into({input(), settings, photos, observer}, folder);
    else
      pipeline::retexture_into(from, {input(), settings, photos, observer}, folder);
    folder.publish();
    return pipeline::read_edit_model(to);
  };
  const pipeline::EditModel first = run({}, out.path() / "first");
  EXPECT_EQ(first.alignment, whole_->atlas.alignment);
  const io::Region block = io::GroundRegion{{{2, 2}, {14, 2}, {14, 14}, {2, 14}}};
  settings.view_rules = {{block, false, {ViewId{0}, ViewId{1}}, "rule"}};
  const pipeline::EditModel changed = run(out.path() / "first", out.path() / "second");
  EXPECT_NE(changed.labels, first.labels);
  EXPECT_EQ(changed.alignment, first.alignment);
}

}  // namespace
}  // namespace gpvc
