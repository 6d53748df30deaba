// What `gpvc compare` makes of its arguments and of its figures.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <string>
#include <vector>

#include "app/compare/bias_sweep.h"
#include "app/compare/compare_modes.h"
#include "app/compare/compare_report.h"
#include "app/compare/compare_views.h"
#include "app/evaluate/oracle_check.h"
#include "io/images.h"
#include "tests/support/grid_mesh.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

std::vector<std::string> names_of(const std::string& list, const std::vector<double>& epsilons) {
  std::vector<std::string> names;
  for (const compare::ComparedMode& mode : compare::compared_modes(list, [&](const std::string&) { return epsilons; }))
    names.push_back(mode.name);
  return names;
}

TEST(CompareModes, RunsBiasedModesOncePerEpsilon) {
  EXPECT_EQ(names_of("none, ray:dense,gpvc", {1e-5, 0.01}),
            (std::vector<std::string>{"none", "ray:dense:1e-05", "ray:dense:0.01", "gpvc"}));
  EXPECT_EQ(names_of("shadow-map:spc:0.5,shadow-map:spc", {0.5, 0.25}),
            (std::vector<std::string>{"shadow-map:spc:0.5", "shadow-map:spc:0.25"}));
  EXPECT_EQ(names_of(compare::default_modes(), {1e-5, 1e-4, 1e-3, 1e-2}).size(), 4u * 4u + 4u);
}

TEST(CompareModes, TellsFamilyEpsilonAndCorrection) {
  const auto modes = compare::compared_modes("shadow-map:apc:0.001,gpvc:uncorrected,gpvc:paper,gpvc:ves",
                                             [](const std::string&) { return std::vector<double>(); });
  ASSERT_EQ(modes.size(), 4u);
  EXPECT_EQ(modes[0].family, "shadow-map:apc");
  EXPECT_EQ(modes[0].epsilon, 0.001);
  using visibility::PaperGpvc, visibility::CoverageCorrection;
  EXPECT_EQ(std::get<visibility::ShadowMap>(modes[0].visibility.method).projection, visibility::Projection::apc);
  EXPECT_EQ(std::get<PaperGpvc>(modes[1].visibility.method).correction, CoverageCorrection::off);
  EXPECT_EQ(std::get<PaperGpvc>(modes[2].visibility.method).correction, CoverageCorrection::paper);
  EXPECT_EQ(std::get<visibility::Gpvc>(modes[3].visibility.method).sampling, visibility::Sampling::ves);
  EXPECT_FALSE(modes[3].epsilon);
}

TEST(CompareModes, RefusesWhatIsNoMode) {
  EXPECT_THROW(names_of("gpvc,shadow", {1e-3}), std::invalid_argument);
  EXPECT_THROW(names_of(" , ", {1e-3}), std::invalid_argument);
  EXPECT_THROW(names_of("none:1e-3", {1e-3}), std::invalid_argument);
}

// The numbers are powers of ten around what they have to bracket.
TEST(BiasScale, SweepsFromRoundingToAHundredthOfTheDepth) {
  Mesh mesh;  // 80 to 120 m before the camera
  for (int n = 0; n <= 40; ++n) mesh.positions.push_back({0.1 * n, 0, 80.0 + n});
  Scene scene;
  scene.views.emplace_back();
  scene.views[0].camera = {};
  scene.views[0].camera.width = scene.views[0].camera.height = 100;
  scene.views[0].camera.fx = scene.views[0].camera.fy = 100;
  scene.views[0].camera.cx = scene.views[0].camera.cy = 50;
  const std::vector<ViewId> used{ViewId{0}};
  const compare::BiasScale scale(mesh, scene, used);
  EXPECT_DOUBLE_EQ(scale.per_share("ray:dense"), 100);
  EXPECT_DOUBLE_EQ(scale.per_share("shadow-map:apc"), 1e-8);
  EXPECT_DOUBLE_EQ(scale.per_share("shadow-map:spc"), 120.0 * 80 / 40 / 100);
  EXPECT_EQ(scale.sweep("shadow-map:apc"), (std::vector<double>{1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10}));
  EXPECT_EQ(scale.sweep("shadow-map:spc"), (std::vector<double>{1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}));
  EXPECT_EQ(scale.sweep("ray:sparse"), (std::vector<double>{1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0}));
}

TEST(Confusion, CountsByTheOraclesClass) {
  evaluate::Confusion agreement;
  agreement.pairs = {{{90, 6, 4, 0}, {1, 8, 1, 0}, {2, 0, 18, 0}}};  // rows hidden, partial, full
  EXPECT_DOUBLE_EQ(agreement.share(visibility::FaceClass::hidden), 0.9);
  EXPECT_DOUBLE_EQ(agreement.share(visibility::FaceClass::partial), 0.8);
  EXPECT_DOUBLE_EQ(agreement.share(visibility::FaceClass::full), 0.9);
  EXPECT_DOUBLE_EQ(agreement.missed_full(), 1 - 0.9);
  EXPECT_DOUBLE_EQ(agreement.false_full(), 5.0 / 23.0);
  EXPECT_DOUBLE_EQ(agreement.accuracy(), 116.0 / 130.0);
}

Image flat_image(std::uint8_t grey, int channels) {
  return {100, 100, channels, std::vector<std::uint8_t>(100 * 100 * static_cast<std::size_t>(channels), grey)};
}

class GreyPhotos final : public io::PhotoSource {
 public:
  std::shared_ptr<const Image> photo(ViewId) override { return std::make_shared<const Image>(flat_image(90, 3)); }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId) override { return nullptr; }
};

// Windows are half as wide and high as the photo of 10 x 10 units. Models differ all over it.
TEST(ModelViews, CropsShowWhatTheMeshCoversByHalf) {
  const test::TemporaryFolder folder;
  Scene scene;
  scene.views.resize(1);
  View& view = scene.views[0];
  view.camera = {100, 100, 100, 100, 50, 50, {}};
  view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
  view.pose.centre = {5, 5, 10};
  const std::vector<ViewId> views{ViewId{0}};
  constexpr std::uint8_t kGreys[] = {50, 150};
  std::vector<compare::ShownModel> models(2);
  for (std::size_t n = 0; n < models.size(); ++n) {
    models[n].thumbnails = {flat_image(kGreys[n], 1)};
    models[n].renders = {folder.path() / (std::to_string(n) + ".png")};
    io::write_image(models[n].renders[0], flat_image(kGreys[n], 3), io::ImageFormat::png, 90);
  }
  GreyPhotos photos;
  const auto crops_of = [&](double edge) {
    const Mesh mesh = test::grid_mesh(1, 1, edge);
    const compare::ModelViewsOptions options{.scored = {}, .cropped = views, .renders = folder.path()};
    return compare::ModelViews({scene, mesh, views}, photos, options, {}).crops(models, 1);
  };
  EXPECT_EQ(crops_of(10).size(), 1u);
  EXPECT_TRUE(crops_of(2).empty()) << "a sixth of a window at most";
}

compare::Json small_report() {
  const auto mode = [](const char* name, const char* family, compare::Json epsilon, double agreement, double wrong) {
    return compare::Json{
        {"name", name},
        {"kind", "mode"},
        {"family", family},
        {"depth_share", epsilon.is_null() ? compare::Json() : compare::Json(epsilon.get<double>() / 100)},
        {"epsilon", std::move(epsilon)},
        {"status", "ok"},
        {"oracle", {{"agreement", agreement}}},
        {"truth", {{"all", {{"textured", 1.0}, {"wrong", wrong}}}, {"origin", {{"all", {{"right", 1 - wrong}}}}}}}};
  };
  compare::Json report{{"scene", {{"name", "here"}, {"faces", 1234567}, {"views", 5}, {"used_views", 4}}},
                       {"program", {{"version", "1"}, {"device", {{"renderer", "a </script> device"}}}}},
                       {"settings", {{"scored", {{"held_out", true}}}}},
                       {"findings", compare::Json::array()}};
  report["modes"] = compare::Json::array({mode("ray:dense:0.1", "ray:dense", 0.1, 0.5, 0.25),
                                          mode("ray:dense:0.01", "ray:dense", 0.01, 0.75, 0.5),
                                          mode("gpvc", "gpvc", nullptr, 1.0, 0.0)});
  return report;
}

// The one picked beforehand bridges about a ten-thousandth of the depth; the best one is each measure's own.
TEST(OpeningTable, SetsEachModeBeforehandAndAtItsBestBesideGpvc) {
  compare::Json report = small_report();
  const compare::Json table = compare::opening_table(report);
  ASSERT_EQ(table["columns"].size(), 3u) << "the measures that are known";
  ASSERT_EQ(table["rows"].size(), 3u);
  EXPECT_EQ(table["rows"][0], (compare::Json{"gpvc", "100.000", "100.000"}));
  EXPECT_EQ(table["rows"][1], (compare::Json{"ray:dense, picked beforehand: 0.01", "75.000", "50.000"}));
  EXPECT_EQ(table["rows"][2], (compare::Json{"ray:dense, best afterwards", "75.000 at 0.01", "75.000 at 0.1"}));
  EXPECT_EQ(compare::best_and_worst(report)[0]["best"], "ray:dense:0.01");
  EXPECT_EQ(compare::best_and_worst(report)[0]["worst"], "ray:dense:0.1");
  // Less is better of errors.
  for (compare::Json& mode : report["modes"]) {
    mode.erase("oracle");
    mode.erase("truth");
    mode["score"]["one_minus_ncc"] = mode["name"] == "ray:dense:0.1" ? 0.2 : 0.3;
  }
  EXPECT_EQ(compare::best_and_worst(report)[0]["best"], "ray:dense:0.1");
  EXPECT_EQ(compare::opening_table(report)["rows"][2][1], "0.2000 at 0.1");
}

TEST(Findings, CountEpsilonsAndListNone) {
  const auto findings = compare::findings_of(small_report());
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(
      findings[0],
      "By classes that agree with the oracle, 0 of 2 pairs of a mode and its epsilon are ahead of gpvc, 0 tie with "
      "it, and 2 are behind.");
}

TEST(Contest, CallsDifferencesWithinChanceATie) {
  compare::Json report = small_report();
  report["modes"][0]["against_gpvc"] = {{"right", {{"ahead", 0.0004}, {"noise", 0.0002}}},
                                        {"error", {{"ahead", 0.005}, {"noise", 0.002}}}};
  report["modes"][1]["against_gpvc"] = {{"right", {{"ahead", -0.0005}, {"noise", 0.0002}}},
                                        {"error", {{"ahead", -0.0001}, {"noise", 0.002}}}};
  for (compare::Json& mode : report["modes"])
    if (mode["epsilon"].is_number()) mode["against_gpvc"]["faithful"] = {{"ahead", -0.25}, {"noise", 0.001}};
  const auto findings = compare::contest_findings(report);
  ASSERT_EQ(findings.size(), 4u);
  EXPECT_EQ(
      findings[0],
      "By seen area textured rightly, 0 of 2 pairs of a mode and its epsilon are ahead of gpvc, 1 ties with it, and "
      "1 is behind.");
  EXPECT_EQ(findings[3],
            "By error of renders, 1 of 2 pairs of a mode and its epsilon is ahead of gpvc, 1 ties with it, and 0 are "
            "behind.");
  const compare::Json table = compare::contest_table(report);
  EXPECT_EQ(table["columns"].size(), 5u);
  ASSERT_EQ(table["rows"].size(), 2u) << "modes with a bias alone";
  EXPECT_EQ(table["rows"][1][1], "-0.0500 \u00b1 0.0200, behind");
  EXPECT_EQ(table["rows"][0][2], "-25.0000 \u00b1 0.1000, behind");
  EXPECT_EQ(table["rows"][0][3], "-50.0000, behind");
  // An agreement that is the same to the last pair is a tie; one pair more is not.
  report["modes"][0]["oracle"]["agreement"] = 1.0;
  EXPECT_NE(compare::contest_findings(report)[2].find("1 ties with it"), std::string::npos);
  report["modes"].erase(2);
  EXPECT_TRUE(compare::contest_table(report).is_null()) << "without gpvc there is nothing to compare with";
}

TEST(ReportMarkdown, GivesEveryModeARowAndLeavesOutWhatIsUnknown) {
  compare::Json report = small_report();
  report["modes"][0]["status"] = "failed";
  report["modes"][0]["error"] = "a | b";
  report["findings"] = compare::findings_of(report);
  const std::string text = compare::report_markdown(report);
  EXPECT_NE(text.find("1 234 567 faces"), std::string::npos) << text;
  EXPECT_NE(text.find("| ray:dense:0.1 (failed: a \\| b) | 50.000 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| gpvc | 100.000 |"), std::string::npos) << text;
  EXPECT_EQ(text.find("PSNR"), std::string::npos) << text;
}

TEST(ReportPage, KeepsDataInsideItsElement) {
  const std::string page = compare::page_with(small_report());
  EXPECT_NE(page.find("a \\u003c/script> device"), std::string::npos);
  EXPECT_EQ(page.find("placed here"), std::string::npos);
}

}  // namespace
}  // namespace gpvc
