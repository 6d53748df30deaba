// What photos tell of single faces, beside what the labeling makes of all of them.
#include "app/pipeline/judgement.h"

#include <gtest/gtest.h>

#include "app/query/index.h"
#include "app/query/photos.h"
#include "io/photos.h"
#include "labeling/view_choice.h"
#include "tests/app/photographed_city.h"

namespace gpvc {
namespace {

using labeling::ViewFate;
using test::City;

class JudgementTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }
  static checks::Input input() { return {city_->scene, city_->mesh, city_->views}; }
  static std::unique_ptr<City> city_;
};
std::unique_ptr<City> JudgementTest::city_;

TEST_F(JudgementTest, SingleFacesHaveTheCandidatesAndCostsOfTheLabeling) {
  const checks::Input of = input();
  pipeline::Settings settings;
  // No photo but the first three in a corner of the city.
  settings.view_rules = {{io::BoxRegion{{0, 0, -100}, {100, 100, 100}}, true, {ViewId{0}, ViewId{1}, ViewId{2}}}};
  io::PhotoCache photos(city_->scene);
  results::Observer silent;
  const pipeline::Run run{of, settings, photos, silent};
  const pipeline::Seen seen = pipeline::see(run);
  const pipeline::Judgement judgement = pipeline::judge(run);
  const auto allowed = pipeline::allowed_views(judgement.rules, city_->mesh, city_->scene.views.size(), silent);
  std::map<ViewFate, std::size_t> fates;
  for (std::uint32_t f = 0; f < city_->mesh.faces.size(); ++f) {
    std::vector<labeling::ViewOfFace> views;
    for (const ViewId view : city_->views)
      if (const auto record = labeling::record_of(judgement.statistics[index(view)], FaceId{f}))
        views.push_back({view, *record});
    const auto choices =
        labeling::choose_views(views, judgement.costs, [&](ViewId view) { return allowed(FaceId{f}, view); });
    std::vector<std::uint32_t> candidates;
    std::vector<float> costs;
    for (std::size_t n = 0; n < views.size(); ++n) {
      ++fates[choices[n].fate];
      if (choices[n].fate != ViewFate::candidate) continue;
      candidates.push_back(static_cast<std::uint32_t>(index(views[n].view)));
      costs.push_back(static_cast<float>(choices[n].cost.total()));
    }
    ASSERT_TRUE(std::ranges::equal(candidates, seen.candidates.table.views_of(f))) << "face " << f;
    ASSERT_TRUE(std::ranges::equal(costs, seen.candidates.table.costs_of(f))) << "face " << f;
  }
  for (const ViewFate fate : {ViewFate::candidate, ViewFate::refused, ViewFate::outlier, ViewFate::not_needed})
    EXPECT_GT(fates[fate], 5U) << name_of(labeling::kViewFateNames, fate);
}

TEST_F(JudgementTest, TheIndexAgreesWithAnswersAboutSingleFaces) {
  const checks::Input of = input();
  pipeline::Settings settings;
  io::PhotoCache photos(city_->scene);
  results::Observer silent;
  const pipeline::Run run{of, settings, photos, silent};
  const pipeline::Judgement judgement = pipeline::judge(run);
  const query::PhotoIndex found = query::index_faces(run, &judgement);
  const query::PhotoFinder finder(of, photos, &judgement);
  ASSERT_EQ(found.first.size(), city_->mesh.faces.size() + 1);
  ASSERT_EQ(found.first.back(), found.views.size());
  std::size_t compared = 0;
  for (std::uint32_t f = 0; f < city_->mesh.faces.size(); f += 7) {
    std::map<std::uint32_t, std::size_t> entry;
    for (std::size_t at = found.first[f]; at < found.first[f + 1]; ++at) entry[found.views[at]] = at;
    for (const query::PhotoOfPoint& photo : finder.photos_of(finder.middle(FaceId{f})).photos) {
      const auto view = static_cast<std::uint32_t>(index(photo.view));
      const bool sees = photo.found != visibility::FaceClass::hidden;
      ASSERT_EQ(entry.contains(view), sees) << "face " << f << ", view " << view;
      if (!sees) continue;
      const std::size_t at = entry[view];
      EXPECT_EQ(found.classes[at], static_cast<std::uint8_t>(photo.found));
      EXPECT_EQ(found.shares[at], static_cast<float>(photo.visible_share));
      EXPECT_NEAR(found.gsd[at], photo.sharpness.gsd, 1e-5);
      if (photo.cost) {
        EXPECT_EQ(found.costs[at], static_cast<float>(photo.cost->total()));
      }
      ++compared;
    }
  }
  EXPECT_GT(compared, 300U);
}

}  // namespace
}  // namespace gpvc
