// Rules about which photos may texture which part of a mesh.
#include "app/pipeline/view_rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>

#include "app/cli/view_lists.h"
#include "app/pipeline/rule_regions.h"
#include "io/reference_system.h"
#include "io/vector.h"
#include "tests/app/photographed_city.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

using pipeline::ViewRule;
using test::City;

class Warnings : public results::Observer {
 public:
  void warning(const std::string& text, const std::vector<Cure>& /*cures*/ = {}) override { warnings.push_back(text); }
  std::vector<std::string> warnings;
};

class ViewRules : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }

  pipeline::Seen see(std::vector<ViewRule> rules, results::Observer& observer,
                     labeling::Outliers outliers = labeling::Outliers::none) {
    pipeline::Settings settings;
    settings.costs.outliers = outliers;
    settings.view_rules = std::move(rules);
    return pipeline::see({{city_->scene, city_->mesh, city_->views}, settings, photos_, observer});
  }
  static std::vector<std::uint32_t> views_of(const pipeline::Seen& seen, std::size_t face) {
    const auto views = seen.candidates.table.views_of(face);
    return {views.begin(), views.end()};
  }

  static inline std::unique_ptr<City> city_;
  io::PictureSource photos_{city_->scene, city_->pictures};
  Warnings heard_;
};

const io::Region kEast = io::GroundRegion{{{0, -40}, {40, -40}, {40, 40}, {0, 40}}};

TEST_F(ViewRules, FacesInsideLoseForbiddenViewsAndOthersNone) {
  const pipeline::Seen all = see({}, heard_), some = see({{kEast, false, {ViewId{0}, ViewId{3}}, "rule"}}, heard_);
  const std::vector<std::uint8_t> inside = io::faces_in(kEast, city_->mesh);
  std::size_t touched = 0, cheaper = 0;
  for (std::size_t f = 0; f < inside.size(); ++f) {
    if (inside[f] == 0) {
      ASSERT_EQ(views_of(some, f), views_of(all, f)) << f;
      const auto before = all.candidates.table.costs_of(f), after = some.candidates.table.costs_of(f);
      ASSERT_TRUE(std::ranges::equal(before, after)) << f;
      continue;
    }
    for (const std::uint32_t view : views_of(some, f)) {
      ASSERT_NE(view, 0u);
      ASSERT_NE(view, 3u);
    }
    touched += views_of(some, f) != views_of(all, f);
    if (some.candidates.tags[f] != all.candidates.tags[f]) continue;
    // A view is compared with the best of those that are left: it may only cost less than before.
    const std::vector<std::uint32_t> before = views_of(all, f), after = views_of(some, f);
    for (std::size_t i = 0; i < after.size(); ++i) {
      const auto at = static_cast<std::size_t>(std::ranges::find(before, after[i]) - before.begin());
      ASSERT_LT(at, before.size());
      const float was = all.candidates.table.costs_of(f)[at], is = some.candidates.table.costs_of(f)[i];
      ASSERT_LE(is, was);
      cheaper += is < was;
    }
  }
  EXPECT_GT(touched, 200u);
  EXPECT_GT(cheaper, 50u);
}

// Photos are compared with each other before the rules are applied, so what a rule refuses still tells outliers around it.
TEST_F(ViewRules, OutliersOfOtherFacesStayTheSame) {
  constexpr auto kClamp = labeling::Outliers::clamp;
  const pipeline::Seen all = see({}, heard_, kClamp);
  const pipeline::Seen some = see({{kEast, false, {ViewId{0}, ViewId{3}}, "rule"}}, heard_, kClamp);
  ASSERT_GT(all.candidates.rejected, 0u);
  const std::vector<std::uint8_t> inside = io::faces_in(kEast, city_->mesh);
  for (std::size_t f = 0; f < inside.size(); ++f) {
    if (inside[f] != 0) continue;
    ASSERT_EQ(views_of(some, f), views_of(all, f)) << f;
    ASSERT_EQ(some.candidates.tags[f], all.candidates.tags[f]) << f;
    ASSERT_TRUE(std::ranges::equal(all.candidates.table.costs_of(f), some.candidates.table.costs_of(f))) << f;
  }
}

TEST_F(ViewRules, AllowedViewsAreTheOnlyOnes) {
  const pipeline::Seen seen = see({{kEast, true, {ViewId{1}, ViewId{2}}, "rule"}}, heard_);
  const std::vector<std::uint8_t> inside = io::faces_in(kEast, city_->mesh);
  std::size_t ones = 0;
  for (std::size_t f = 0; f < inside.size(); ++f)
    for (const std::uint32_t view : views_of(seen, f)) {
      if (inside[f] != 0) {
        ASSERT_TRUE(view == 1 || view == 2) << view;
        ++ones;
      }
    }
  EXPECT_GT(ones, 200u);
}

TEST_F(ViewRules, FacesWithoutAViewAreCountedInAWarningAndFilled) {
  const pipeline::Seen all = see({}, heard_);
  heard_.warnings.clear();
  pipeline::Settings settings;
  settings.view_rules = {{kEast, false, city_->views, "rule"}};
  const pipeline::TexturedMesh textured =
      pipeline::texture({{city_->scene, city_->mesh, city_->views}, settings, photos_, heard_});
  const std::vector<std::uint8_t> inside = io::faces_in(kEast, city_->mesh);
  std::size_t lost = 0;
  for (std::size_t f = 0; f < inside.size(); ++f) {
    if (inside[f] == 0) continue;
    EXPECT_EQ(textured.tags[f], labeling::FaceTag::unseen);
    EXPECT_EQ(textured.selection.labels[f], kNoView);
    lost += all.candidates.tags[f] != labeling::FaceTag::unseen;
  }
  ASSERT_GT(lost, 500u);
  const std::string expected = results::readable_count(lost) + " faces are filled, the first of them face ";
  EXPECT_TRUE(std::ranges::any_of(heard_.warnings, [&](const std::string& w) { return w.starts_with(expected); }))
      << expected;
}

TEST_F(ViewRules, RegionsWithoutAFaceAreWarnedOf) {
  see({{io::BoxRegion{{1000, 0, 0}, {1001, 1, 1}}, false, {ViewId{0}}, "rules.csv: line 7"}}, heard_);
  ASSERT_FALSE(heard_.warnings.empty());
  EXPECT_EQ(heard_.warnings.front(), "rules.csv: line 7: no face of the mesh lies in its region");
}

TEST(ViewRuleTable, RulesAboutAFaceAllHold) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}};
  mesh.faces.assign(4, {0, 0, 0});
  const auto faces = [](std::uint32_t first, std::uint32_t last) { return io::FaceRegion{{{first, last}}}; };
  const std::vector<ViewRule> rules{{faces(0, 2), true, {ViewId{0}, ViewId{1}}, ""},
                                    {faces(1, 3), false, {ViewId{1}}, ""},
                                    {faces(2, 2), true, {ViewId{2}}, ""}};
  const pipeline::ViewRuleTable table(rules, mesh, 3);
  const auto allowed = [&](std::uint32_t face) {
    std::string views;
    for (std::uint32_t v = 0; v < 3; ++v) views += table.allows(FaceId{face}, ViewId{v}) ? std::to_string(v) : "";
    return views;
  };
  EXPECT_EQ(allowed(0), "01");
  EXPECT_EQ(allowed(1), "0");
  EXPECT_EQ(allowed(2), "");
  EXPECT_EQ(allowed(3), "02");
  EXPECT_EQ(table.faces(), 4u);
  EXPECT_EQ(table.faces_of_rules(), (std::vector<std::size_t>{3, 3, 1}));
}

// A rectangle of a photo means the faces that the photo shows there, not those behind them.
TEST_F(ViewRules, ARectangleOfAPhotoMeansWhatIsSeenThere) {
  const View& view = city_->scene.views[0];
  const PhotoPoint low{view.camera.width * 0.25, view.camera.height * 0.25},
      high{view.camera.width * 0.75, view.camera.height * 0.75};
  const checks::Input input{city_->scene, city_->mesh, city_->views};
  std::vector<std::uint8_t> inside(city_->mesh.faces.size(), 0);
  for (const auto& [first, last] : pipeline::faces_shown(input, std::array{ViewId{0}}, low, high).ranges)
    for (std::uint32_t f = first; f <= last; ++f) inside[f] = 1;
  const visibility::ViewVisibility seen =
      visibility::VisibilityStage(city_->mesh, {visibility::Gpvc{.drawing = visibility::Drawing::native}})
          .classify(view, ViewId{0}, nullptr);
  std::size_t shown = 0, elsewhere = 0;
  for (std::size_t f = 0; f < inside.size(); ++f) {
    WorldPoint middle{};
    for (const std::uint32_t v : city_->mesh.faces[f]) middle = middle + (1.0 / 3) * city_->mesh.positions[v];
    const auto at = photo_from_pixel(view.camera, pixel_from_camera(view.camera, camera_from_world(view.pose, middle)));
    const bool is_full = seen.classes[f] == visibility::FaceClass::full;
    constexpr double kBorder = 12;  // faces that reach across it
    if (seen.classes[f] == visibility::FaceClass::hidden) {
      ASSERT_EQ(inside[f], 0) << f << " is hidden";
    } else if (is_full && at && at->x > low.x + kBorder && at->x < high.x - kBorder && at->y > low.y + kBorder &&
               at->y < high.y - kBorder) {
      ASSERT_EQ(inside[f], 1) << f;
      ++shown;
    } else if (is_full && (!at || at->x < low.x - kBorder || at->x > high.x + kBorder || at->y < low.y - kBorder ||
                           at->y > high.y + kBorder)) {
      ASSERT_EQ(inside[f], 0) << f;
      ++elsewhere;
    }
  }
  EXPECT_GT(shown, 50u);
  EXPECT_GT(elsewhere, 50u);
}

TEST_F(ViewRules, PlacesAreThoseOfTheMeshsFile) {
  Mesh moved = city_->mesh;
  moved.file_positions = moved.positions;
  for (WorldPoint& p : moved.file_positions) p = {p.x + 4e5, p.y + 5e6, p.z};
  const io::Region there =
      io::GroundRegion{{{4e5, 5e6 - 40}, {4e5 + 40, 5e6 - 40}, {4e5 + 40, 5e6 + 40}, {4e5, 5e6 + 40}}};
  EXPECT_EQ(io::faces_in(pipeline::region_of(there, moved), moved), io::faces_in(kEast, city_->mesh));
}

TEST_F(ViewRules, GeoJsonIsBroughtToTheScenesSystem) {
  Scene scene = city_->scene;
  scene.srs = "EPSG:25832";
  scene.offset = {5e5, 53e5, 0};
  const checks::Input input{scene, city_->mesh, city_->views};
  const io::GroundRegion utm{{{5e5, 53e5 - 40}, {5e5 + 40, 53e5 - 40}, {5e5 + 40, 53e5 + 40}, {5e5, 53e5 + 40}}};
  const std::vector<std::uint8_t> expected = io::faces_in(kEast, city_->mesh);
  EXPECT_EQ(io::faces_in(pipeline::region_of(utm, "urn:ogc:def:crs:EPSG::25832", input), city_->mesh), expected);
  // The middle meridian of zone 32: x = 0 is at 9 degrees east.
  std::vector<WorldPoint> corners;
  for (const auto& [x, y] : utm.corners) corners.push_back({x, y, 0});
  io::transform_points("EPSG:25832", io::kGeoJsonSystem, corners);
  EXPECT_NEAR(corners[0].x, 9, 1e-9);
  io::GroundRegion degrees;
  for (const WorldPoint& p : corners) degrees.corners.push_back({p.x, p.y});
  EXPECT_EQ(io::faces_in(pipeline::region_of(degrees, io::kGeoJsonSystem, input), city_->mesh), expected);
  const checks::Input nowhere{city_->scene, city_->mesh, city_->views};
  EXPECT_EQ(
      io::faces_in(pipeline::region_of(std::get<io::GroundRegion>(kEast), io::kGeoJsonSystem, nowhere), city_->mesh),
      expected);
  EXPECT_THROW(pipeline::region_of(utm, "EPSG:25832", nowhere), pipeline::RegionError);
  EXPECT_THROW(pipeline::region_of(utm, "EPSG:99999999", input), pipeline::RegionError);
}

TEST(ViewRuleFile, NamesAndGlobsBecomeViews) {
  const test::TemporaryFolder folder;
  Scene scene;
  std::vector<View>& views = scene.views;
  views.resize(4);
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(10, Triangle{0, 1, 2})};
  const char* names[] = {"a/east_1.jpg", "a/east_2.jpg", "b/nadir_1.jpg", "b/nadir_2.jpg"};
  for (std::size_t v = 0; v < views.size(); ++v) views[v].name = names[v];
  const auto read = [&](const std::string& text) {
    return cli::read_rules(folder.write("rules.csv", text), {scene, mesh, {}});
  };
  const std::vector<ViewRule> rules =
      read("faces,0-9,allow,*nadir*;east_2\n# next\nbox,0 0 0 1 1 1,forbid,a/east_1.jpg\n");
  ASSERT_EQ(rules.size(), 2u);
  EXPECT_EQ(rules[0].views, (std::vector<ViewId>{ViewId{1}, ViewId{2}, ViewId{3}}));
  EXPECT_TRUE(rules[0].allow);
  EXPECT_EQ(rules[1].views, std::vector<ViewId>{ViewId{0}});
  EXPECT_EQ(rules[1].name, (folder.path() / "rules.csv").string() + ": line 3");
  const auto refused = [&](const std::string& text) { return test::input_error([&] { read(text); }); };
  EXPECT_TRUE(
      test::contains(refused("faces,0-9,allow,nadir_3.jpg"), "rules.csv: line 1: the scene has no view 'nadir_3.jpg'"));
  EXPECT_TRUE(test::contains(refused("\nfaces,0-10,allow,*"), "rules.csv: line 2: expected faces of 0 to 9, found 10"));
}

}  // namespace
}  // namespace gpvc
