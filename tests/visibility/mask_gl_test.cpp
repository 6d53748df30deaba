// Masked pixels count as outside the photo, sample by sample.
#include <gtest/gtest.h>

#include <memory>

#include "io/images.h"
#include "io/photos.h"
#include "tests/support/temporary_folder.h"
#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

constexpr int kWidth = 160, kHeight = 120;

class MaskGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }
  /// A view whose mask is black inside a circle.
  View masked(View view, double x0, double y0, double radius) {
    Image mask{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 255)};
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (std::hypot(x + 0.5 - x0, y + 0.5 - y0) < radius) *mask.at(x, y) = 0;
    view.mask = folder_.path() / ("mask " + std::to_string(masks_++) + ".png");
    io::write_image(view.mask, mask, io::ImageFormat::png, 0);
    return view;
  }
  /// Classifies with the view's mask, if it has one.
  static ViewVisibility classify(VisibilityStage& stage, const View& view) {
    const std::optional<io::PhotoExclusion> excluded = io::read_exclusion(view);
    return stage.classify(view, ViewId{0}, excluded ? &*excluded : nullptr);
  }
  static bool excluded(const io::PhotoExclusion& exclusion, const Camera& camera, int x, int y) {
    const auto p = photo_from_pixel(camera, {x + 0.5, y + 0.5});
    return !p || p->x < 0 || p->y < 0 || p->x > kWidth || p->y > kHeight ||
           exclusion.excludes(std::min(static_cast<int>(p->x), kWidth - 1),
                              std::min(static_cast<int>(p->y), kHeight - 1));
  }
  /// Owners of every pixel from the oracle, which knows no mask; from these, what the mask leaves.
  void expect_masked(const Mesh& mesh, const View& view, const ViewVisibility& found) {
    const oracle::Answer plain = oracle::classify(mesh, view);
    const io::PhotoExclusion exclusion = *io::read_exclusion(view);
    std::vector<std::size_t> owned(mesh.faces.size()), left(mesh.faces.size());
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const std::uint32_t owner = plain.owners[static_cast<std::size_t>(y * kWidth + x)];
        const bool out = excluded(exclusion, view.camera, x, y);
        if (out) {
          EXPECT_EQ(found.ivm.at(x, y), kNoFace);
        }
        if (owner >= owned.size()) continue;
        ++owned[owner];
        left[owner] += out ? 0 : 1;
      }
    std::size_t cut = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      if (plain.tied[f] || owned[f] == 0) continue;
      cut += left[f] < owned[f] ? 1 : 0;
      // Owners may be seen from behind.
      const bool hidden = left[f] == 0 || plain.classes[f] == FaceClass::hidden;
      FaceClass expected = hidden ? FaceClass::hidden : FaceClass::partial;
      if (left[f] == owned[f]) expected = plain.classes[f];
      EXPECT_EQ(static_cast<int>(found.classes[f]), static_cast<int>(expected)) << "face " << f;
    }
    EXPECT_GT(cut, 20u);
    for (const FaceCoverage& entry : found.coverage.entries) {
      const std::size_t f = index(entry.face);
      if (plain.tied[f] || owned[f] == 0) continue;
      EXPECT_EQ(entry.visible, left[f]) << "face " << f;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          if (excluded(exclusion, view.camera, x, y)) {
            ASSERT_FALSE(found.coverage.sees(entry, x, y)) << "face " << f << " at " << x << ", " << y;
          }
    }
  }
  test::TemporaryFolder folder_;
  int masks_ = 0;
  std::unique_ptr<GraphicsDevice> device_;
};

TEST_F(MaskGl, TakesExcludedPixelsFromEveryFace) {
  const View view = scenes::view_of(kWidth, kHeight, 150);
  for (const double size : {12.0, 60.0}) {
    const Mesh mesh = scenes::soup(view.camera, size < 50 ? 600 : 120, size, 5);
    VisibilityStage stage(mesh, {}, device_.get());
    const View one = masked(view, 60, 50, 35);
    expect_masked(mesh, one, classify(stage, one));
  }
}

TEST_F(MaskGl, FollowsTheLens) {
  View view = scenes::view_of(kWidth, kHeight, 150);
  view.camera.distortion.k1 = -0.2;
  limit_distortion(view.camera);
  const Mesh mesh = scenes::soup(view.camera, 1500, 12, 6);
  VisibilityStage stage(mesh, {}, device_.get());
  const View one = masked(view, 40, 30, 30);
  const ViewVisibility found = classify(stage, one);
  const io::PhotoExclusion exclusion = *io::read_exclusion(one);
  const ViewVisibility plain = classify(stage, view);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      EXPECT_EQ(found.ivm.at(x, y), excluded(exclusion, view.camera, x, y) ? kNoFace : plain.ivm.at(x, y));
}

// Faces without a pixel centre are sampled inside pixels.
TEST_F(MaskGl, TakesSubPixelSamplesToo) {
  const View view = scenes::view_of(kWidth, kHeight, 150);
  const Mesh mesh = scenes::soup(view.camera, 3000, 0.4, 8);
  VisibilityStage stage(mesh, {}, device_.get());
  const ViewVisibility plain = classify(stage, view);
  const View all = masked(view, 0, 0, 1000), most = masked(view, 100, 60, 50);
  for (const FaceClass c : classify(stage, all).classes) EXPECT_EQ(c, FaceClass::hidden);
  const ViewVisibility found = classify(stage, most);
  std::size_t hidden = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const WorldPoint& p = mesh.positions[mesh.faces[f][0]];
    const PixelPoint at = pixel_from_camera(view.camera, {p.x, p.y, p.z});
    const double distance = std::hypot(at.x - 100, at.y - 60);
    // A face is below a pixel wide, a pixel's diagonal is 1.5 px.
    if (distance < 47) {
      EXPECT_EQ(found.classes[f], FaceClass::hidden);
    } else if (distance > 53) {
      EXPECT_EQ(found.classes[f], plain.classes[f]);
    }
    hidden += distance < 47 && plain.classes[f] != FaceClass::hidden ? 1 : 0;
  }
  EXPECT_GT(hidden, 100u);
}

TEST_F(MaskGl, OfAnotherSizeIsRefused) {
  const View view = scenes::view_of(kWidth, kHeight, 150);
  const Mesh mesh = scenes::soup(view.camera, 10, 12, 5);
  VisibilityStage stage(mesh, {}, device_.get());
  const io::PhotoExclusion smaller{kWidth, kHeight - 1, 3, std::vector<std::uint64_t>(3 * (kHeight - 1))};
  EXPECT_THROW(stage.classify(view, ViewId{0}, &smaller), std::invalid_argument);
}

// One stage, mask after mask; the shader's copy must follow.
TEST_F(MaskGl, IsNotRememberedFromTheViewBefore) {
  const View view = scenes::view_of(kWidth, kHeight, 150);
  const Mesh mesh = scenes::soup(view.camera, 1500, 8, 9);
  VisibilityStage cpu(mesh, {PaperGpvc{.classifier = Classifier::cpu}}, device_.get());
  VisibilityStage gpu(mesh, {PaperGpvc{.classifier = Classifier::gpu}}, device_.get());
  std::vector<std::vector<FaceClass>> answers;
  for (const View& one : {view, masked(view, 40, 40, 30), masked(view, 100, 70, 40), view}) {
    answers.push_back(classify(cpu, one).classes);
    EXPECT_EQ(classify(gpu, one).classes, answers.back());
  }
  EXPECT_EQ(answers[0], answers[3]);
  EXPECT_NE(answers[1], answers[2]);
  EXPECT_NE(answers[0], answers[1]);
}

}  // namespace
}  // namespace gpvc::visibility
