#include <gtest/gtest.h>

#include <cmath>

#include "app/pipeline/render_model.h"

namespace gpvc::pipeline {
namespace {

constexpr std::array<std::uint8_t, 3> kBackground{10, 20, 30};

// Differs from pixel to pixel and under every flip.
Image noise_page(int width, int height) {
  Image page{width, height, 3, {}};
  std::uint32_t state = 12345;
  for (int i = 0; i < width * height * 3; ++i) {
    state = state * 1664525u + 1013904223u;
    page.pixels.push_back(static_cast<std::uint8_t>(state >> 24));
  }
  return page;
}

Camera camera_of(int width, int height, double cx, double cy) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 50;
  camera.fy = 60;
  camera.cx = cx;
  camera.cy = cy;
  return camera;
}

// A rectangle of pixels of the camera, `depth` in front of it, facing it, with texture corners (0,0) to
// (1,1).
struct Billboard {
  Mesh mesh;
  io::TexturedModel model;

  void add(const Camera& camera, const Pose& pose, double x0, double y0, double x1, double y1, double depth,
           std::uint32_t page) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, y] : {std::pair{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}) {
      const double c[3] = {(x - camera.cx) / camera.fx * depth, (y - camera.cy) / camera.fy * depth, depth};
      const auto& r = pose.rotation;
      mesh.positions.push_back({r[0] * c[0] + r[3] * c[1] + r[6] * c[2] + pose.centre.x,
                                r[1] * c[0] + r[4] * c[1] + r[7] * c[2] + pose.centre.y,
                                r[2] * c[0] + r[5] * c[1] + r[8] * c[2] + pose.centre.z});
    }
    for (const io::TexCoord uv : {io::TexCoord{0, 0}, {1, 0}, {1, 1}, {0, 1}}) model.texcoords.push_back(uv);
    // Counter-clockwise for the eye, y being down: top left, bottom left, bottom right, top right.
    for (const Triangle t : {Triangle{0, 3, 2}, Triangle{0, 2, 1}}) {
      mesh.faces.push_back({first + t[0], first + t[1], first + t[2]});
      model.face_texcoords.push_back({first + t[0], first + t[1], first + t[2]});
      model.face_page.push_back(page);
    }
    model.mesh = &mesh;
  }
};

RenderResult render(const Billboard& scene, const std::vector<Image>& pages, const Camera& camera, const Pose& pose,
                    bool mipmaps = false, bool cull = true) {
  return render_model(scene.model, pages, camera, pose, {mipmaps, cull, kBackground});
}

// Largest difference of a channel.
int difference(const Image& a, const Image& b) {
  if (a.pixels.size() != b.pixels.size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) largest = std::max(largest, std::abs(a.pixels[i] - b.pixels[i]));
  return largest;
}

// Two and a half pages across, one and a quarter down: each pixel shows the texel of a frame tiled by the page.
TEST(RenderModel, PagesRepeatBeyondTheirRim) {
  const Image page = noise_page(16, 16);
  const Camera camera = camera_of(40, 20, 20, 10);
  Billboard quad;
  quad.add(camera, {}, 0, 0, 40, 20, 3, 0);
  for (io::TexCoord& t : quad.model.texcoords) t = {2.5f * t.u - 1, 1.25f * t.v + 3};
  const RenderResult result = render(quad, {page}, camera, {});
  int largest = 0;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x)
      for (int c = 0; c < 3; ++c)
        largest = std::max(largest, std::abs(result.image.at(x, y)[c] - page.at(x % 16, y % 16)[c]));
  EXPECT_LE(largest, 1);
}

TEST(RenderModel, FrameFillingQuadReproducesItsTexture) {
  const Image page = noise_page(96, 64);
  const Camera camera = camera_of(96, 64, 48, 32);
  Billboard quad;
  quad.add(camera, {}, 0, 0, 96, 64, 3, 0);
  const RenderResult result = render(quad, {page}, camera, {});
  // Texel centres fall on pixel centres. Texture coordinates are floats: rounding may turn one grey level over.
  EXPECT_LE(difference(result.image, page), 1);
  EXPECT_EQ(std::count(result.textured.begin(), result.textured.end(), 255), 96 * 64);
}

TEST(RenderModel, TurnedFarCameraWithPrincipalPointOffCentreSeesTheSame) {
  const Image page = noise_page(96, 64);
  const Camera camera = camera_of(96, 64, 11.25, 70.5);
  // 3-4-5 and 5-12-13 triangles: an exact rotation.
  Pose pose;
  pose.rotation = {0.6, 0, -0.8, -0.8 * 5 / 13, 12.0 / 13, -0.6 * 5 / 13, 0.8 * 12 / 13, 5.0 / 13, 0.6 * 12 / 13};
  pose.centre = {4.5e5, 5.2e6, 120};
  Billboard quad;
  quad.add(camera, pose, 0, 0, 96, 64, 40, 0);
  const RenderResult result = render(quad, {page}, camera, pose);
  // Coordinates of 5e6 are stored to 2^-30 m: 1e-9 / 40 * 60 px, nothing to see.
  EXPECT_LE(difference(result.image, page), 1);
}

TEST(RenderModel, PixelsBelongToTheFaceOverTheirCentre) {
  const Camera camera = camera_of(16, 8, 8, 4);
  Image page{1, 1, 3, {200, 100, 50}};
  Billboard quad;
  quad.add(camera, {}, 3.4, 1.6, 9.6, 6.4, 2, 0);  // columns 3..8 or 9 by their centres: 3.5 .. 9.5
  const RenderResult result = render(quad, {page}, camera, {});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) {
      const bool inside = x >= 3 && x <= 9 && y >= 2 && y <= 5;
      EXPECT_EQ(result.textured[static_cast<std::size_t>(y * 16 + x)], inside ? 255 : 0) << x << ' ' << y;
      EXPECT_EQ(result.image.at(x, y)[0], inside ? 200 : kBackground[0]) << x << ' ' << y;
    }
}

TEST(RenderModel, BackFacesGoOnlyWhenCulled) {
  const Image page = noise_page(16, 16);
  const Camera camera = camera_of(16, 16, 8, 8);
  Billboard quad;
  quad.add(camera, {}, 0, 0, 16, 16, 1, 0);
  for (Triangle& t : quad.mesh.faces) std::swap(t[1], t[2]);
  for (Triangle& t : quad.model.face_texcoords) std::swap(t[1], t[2]);
  const RenderResult culled = render(quad, {page}, camera, {}, false, true);
  EXPECT_EQ(std::count(culled.textured.begin(), culled.textured.end(), 255), 0);
  const RenderResult shown = render(quad, {page}, camera, {}, false, false);
  EXPECT_LE(difference(shown.image, page), 1);
}

TEST(RenderModel, NearerFaceHidesTheOtherInAnyOrderAndWithoutTexture) {
  const Camera camera = camera_of(16, 16, 8, 8);
  const std::vector<Image> pages{{1, 1, 3, {255, 0, 0}}, {1, 1, 3, {0, 255, 0}}};
  constexpr std::uint32_t kUntextured = 0xFFFFFFFFu;
  Billboard scene;
  scene.add(camera, {}, 0, 0, 16, 16, 5, 1);
  scene.add(camera, {}, 0, 0, 8, 16, 4.999, 0);
  scene.add(camera, {}, 0, 0, 16, 8, 4.998, kUntextured);
  const RenderResult result = render(scene, pages, camera, {});
  EXPECT_EQ(result.image.at(2, 12)[0], 255);
  EXPECT_EQ(result.image.at(12, 12)[1], 255);
  for (int x : {2, 12}) {
    EXPECT_EQ(result.image.at(x, 2)[2], kBackground[2]);
    EXPECT_EQ(result.textured[static_cast<std::size_t>(2 * 16 + x)], 0);
  }
}

TEST(RenderModel, FloorUnderTheCameraEndsAtTheHorizon) {
  // A floor one unit below, from 20 behind the camera to 20 ahead; texture v runs along it from behind to ahead. Each
  // face crosses the camera plane.
  const Camera camera = camera_of(64, 64, 32, 32);
  Image page{2, 256, 3, {}};
  for (int row = 0; row < 256; ++row)
    for (int i = 0; i < 6; ++i) page.pixels.push_back(static_cast<std::uint8_t>(row));
  Billboard floor;
  floor.mesh.positions = {{-30, 1, -20}, {30, 1, -20}, {30, 1, 20}, {-30, 1, 20}};
  floor.model.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  floor.mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  floor.model.face_texcoords = floor.mesh.faces;
  floor.model.face_page = {0, 0};
  floor.model.mesh = &floor.mesh;
  const RenderResult result = render(floor, {page}, camera, {}, false, false);
  for (int y = 0; y < 64; ++y) {
    const double below = y + 0.5 - camera.cy;
    const double z = below > 0 ? camera.fy / below : 1e9;
    const std::size_t pixel = static_cast<std::size_t>(y * 64 + 32);
    EXPECT_EQ(result.textured[pixel], z < 20 ? 255 : 0) << y;
    if (z >= 20) continue;
    const double texel = (z + 20) / 40 * 256 - 0.5;
    EXPECT_NEAR(result.image.at(32, y)[0], std::min(texel, 255.0), 1.0) << y;
  }
}

TEST(RenderModel, MipmapsAverageWhatIsSmallerThanAPixel) {
  // A fine chequerboard seen 16 times reduced is grey; looked up in level 0 it is black or white.
  Image page{256, 256, 3, {}};
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x)
      for (int c = 0; c < 3; ++c) page.pixels.push_back((x + y) % 2 == 0 ? 255 : 0);
  const Camera camera = camera_of(16, 16, 8, 8);
  Billboard quad;
  quad.add(camera, {}, 0, 0, 16, 16, 2, 0);
  const RenderResult smooth = render(quad, {page}, camera, {}, true);
  for (int y = 2; y < 14; ++y)
    for (int x = 2; x < 14; ++x) EXPECT_NEAR(smooth.image.at(x, y)[0], 127.5, 2.0);
}

}  // namespace
}  // namespace gpvc::pipeline
