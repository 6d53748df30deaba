// Item buffers of tiny scenes.
#include "visibility/gl/ivm_gl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "io/photos.h"
#include "tests/visibility/visibility_oracle.h"
#include "tests/visibility/visibility_scenes.h"
#include "visibility/device.h"

namespace gpvc::visibility {
namespace {

class IvmGl : public testing::Test {
 protected:
  void SetUp() override {
    if (list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    device_ = std::make_unique<GraphicsDevice>();
  }
  std::vector<FaceId> draw(const Mesh& mesh, const View& view, int largest_tile = 0) {
    IvmRenderer renderer(mesh, {.largest_tile = largest_tile});
    std::vector<FaceId> faces;
    renderer.render(view.camera, view.pose, {&faces});
    return faces;
  }
  /// Rows of face numbers, '.' for none.
  std::vector<std::string> picture(const Mesh& mesh, const View& view) {
    const std::vector<FaceId> faces = draw(mesh, view);
    std::vector<std::string> rows;
    for (std::size_t p = 0; p < faces.size(); ++p) {
      if (p % static_cast<std::size_t>(view.camera.width) == 0) rows.emplace_back();
      rows.back() += faces[p] == kNoFace ? '.' : static_cast<char>('0' + static_cast<int>(index(faces[p])));
    }
    return rows;
  }
  std::unique_ptr<GraphicsDevice> device_;
};

using Picture = std::vector<std::string>;

TEST_F(IvmGl, TopRowComesFirst) {
  const View view = scenes::view_of(6, 4, 4);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{0.2, 0.2, 5}, {0.2, 3.9, 5}, {3.9, 0.2, 5}}});
  EXPECT_EQ(picture(mesh, view), (Picture{"0000..",  //
                                          "000...",  //
                                          "00....",  //
                                          "0....."}));
}

TEST_F(IvmGl, NearerFaceWinsInAnyOrderAndFromBothSides) {
  const View view = scenes::view_of(6, 4, 4);
  for (const bool turned : {false, true})
    for (const std::size_t first : {0U, 1U}) {
      Mesh mesh;
      const std::array<double, 3> a{-3, -3, 0}, b{-3, 24, 0}, c{24, -3, 0};
      const auto add = [&](double depth) {
        auto p = a, q = b, r = c;
        p[2] = q[2] = r[2] = depth;
        if (turned) std::swap(q, r);
        scenes::add_at_pixels(mesh, view.camera, {{p, q, r}});
      };
      add(first == 0 ? 5 : 7);
      add(first == 0 ? 7 : 5);
      EXPECT_EQ(picture(mesh, view), Picture(4, std::string(6, static_cast<char>('0' + static_cast<int>(first)))));
    }
}

TEST_F(IvmGl, EqualDepthKeepsTheLowerFace) {
  const View view = scenes::view_of(6, 4, 4);
  Mesh mesh;
  for (int i = 0; i < 3; ++i) scenes::add_at_pixels(mesh, view.camera, {{{-3, -3, 5.5}, {-3, 24, 6.5}, {24, -3, 4.5}}});
  EXPECT_EQ(picture(mesh, view), Picture(4, "000000"));
}

TEST_F(IvmGl, OffCentrePrincipalPointMovesTheImageAsAWhole) {
  // The same scene, the principal point moved by whole pixels: the picture moves with it.
  const View centred = scenes::view_of(12, 8, 7, 6, 4);
  View moved = centred;
  moved.camera.cx = 9;
  moved.camera.cy = 2;
  Mesh mesh;
  scenes::add_at_pixels(mesh, centred.camera, {{{1.2, 2.3, 5}, {2.2, 7.1, 7}, {8.7, 4.1, 6}}});
  const std::vector<FaceId> a = draw(mesh, centred), b = draw(mesh, moved);
  std::size_t covered = 0;
  for (std::size_t y = 2; y < 8; ++y)
    for (std::size_t x = 0; x < 9; ++x) {
      EXPECT_EQ(a[y * 12 + x], b[(y - 2) * 12 + x + 3]) << x << ", " << y;
      covered += a[y * 12 + x] != kNoFace;
    }
  EXPECT_GT(covered, 10U);
}

TEST_F(IvmGl, FacesAreClippedAtTheCameraPlane) {
  const View view = scenes::view_of(6, 6, 3);
  // A floor below the camera that begins behind it, and a wall wholly behind it.
  Mesh mesh;
  scenes::add_face(mesh, {-100, 1, -100}, {100, 1, -100}, {0, 1, 1e5});
  scenes::add_face(mesh, {-100, -100, -5}, {100, -100, -5}, {0, 100, -5});
  EXPECT_EQ(picture(mesh, view), (Picture{"......", "......", "......", "000000", "000000", "000000"}));
}

TEST_F(IvmGl, TilesFitTogether) {
  const View view = scenes::view_of(150, 101, 100);
  const Mesh mesh = scenes::soup(view.camera, 400, 12, 4);
  const std::vector<FaceId> whole = draw(mesh, view);
  const oracle::Answer expected = oracle::classify(mesh, view);
  for (const int tile : {64, 33, 7}) {
    const std::vector<FaceId> tiled = draw(mesh, view, tile);
    ASSERT_EQ(tiled.size(), whole.size());
    std::size_t different = 0;
    for (std::size_t p = 0; p < whole.size(); ++p) different += tiled[p] != whole[p];
    // Vertices snap a little differently in another viewport: pixels on edges may change hands.
    EXPECT_LT(different, whole.size() / 200) << tile;
  }
  std::size_t wrong = 0;
  for (std::size_t p = 0; p < whole.size(); ++p) wrong += index(whole[p]) != expected.owners[p];
  EXPECT_LT(wrong, whole.size() / 200);
}

TEST_F(IvmGl, StagedReadsBringTheSameBits) {
  // Views of two sizes with one renderer, so that its memory grows and is used again.
  const View small = scenes::view_of(61, 40, 50), large = scenes::view_of(150, 101, 100);
  const Mesh mesh = scenes::soup(large.camera, 400, 12, 4);
  for (const int tile : {0, 64, 33}) {
    IvmRenderer direct(mesh, {.largest_tile = tile}), staged(mesh, {.largest_tile = tile, .staged_reads = true});
    for (const View* view : {&small, &large, &small}) {
      std::vector<FaceId> faces, staged_faces;
      std::vector<float> depths, staged_depths;
      direct.render(view->camera, view->pose, {&faces, &depths});
      staged.render(view->camera, view->pose, {&staged_faces, &staged_depths});
      ASSERT_NE(std::count(faces.begin(), faces.end(), kNoFace), static_cast<std::ptrdiff_t>(faces.size()));
      EXPECT_EQ(staged_faces, faces) << tile;
      EXPECT_EQ(staged_depths, depths) << tile;
    }
  }
}

TEST_F(IvmGl, ImagesAboveTheViewportLimitAreTiled) {
  // One row more than any viewport here, thin so that it is cheap.
  const int height = 20000;
  const View view = scenes::view_of(8, height, 10);
  Mesh mesh;
  scenes::add_at_pixels(mesh, view.camera, {{{-20, -10, 5}, {-20, 40000, 5}, {60, -10, 5}}});
  const std::vector<FaceId> faces = draw(mesh, view);
  ASSERT_EQ(faces.size(), 8U * static_cast<std::size_t>(height));
  for (const FaceId face : faces) ASSERT_EQ(index(face), 0U);
}

}  // namespace
}  // namespace gpvc::visibility
