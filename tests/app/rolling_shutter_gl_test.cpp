// A box on the ground, photographed by cameras that move while they are read out.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "app/checks/nearness.h"
#include "app/pipeline/pipeline.h"
#include "io/bilinear.h"
#include "io/photos.h"
#include "io/vector.h"

namespace gpvc {
namespace {

constexpr double kGround = 12, kBox = 3, kRoof = 2;  ///< half edges of the squares and the roof's height, metres

/// Waves of two metres and more. Photos have 5 cm a pixel, which is 6 grey levels at most.
Rgb ground_color(const WorldPoint& p) {
  return {128 + 50 * std::sin(1.6 * p.x + 2.2 * p.y), 128 + 50 * std::sin(2.3 * p.y - 1.4 * p.x + p.z),
          128 + 50 * std::cos(1.9 * p.x + 1.2 * p.z)};
}

/// A square grid of faces at a height, with its front up.
void add_square(double half, double height, double hole, Mesh& mesh) {
  constexpr int kCells = 48;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (kCells + 1) + i); };
  const auto coordinate = [&](int i) { return (2.0 * i / kCells - 1) * half; };
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) mesh.positions.push_back({coordinate(i), coordinate(j), height});
  const auto in_hole = [&](int i) { return std::abs(coordinate(i) + half / kCells) < hole; };
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      if (in_hole(i) && in_hole(j)) continue;
      mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
}

/// The ground, without what lies under the box, and the roof; walls are left out, and seen through to the ground.
Mesh box_on_ground() {
  Mesh mesh;
  add_square(kGround, 0, kBox, mesh);
  add_square(kBox, kRoof, 0, mesh);
  return mesh;
}

/// Where a ray meets the roof or the plane of the ground.
WorldPoint hit(const WorldPoint& from, const WorldPoint& direction) {
  const WorldPoint roof = from + (kRoof - from.z) / direction.z * direction;
  if (std::max(std::abs(roof.x), std::abs(roof.y)) <= kBox) return roof;
  return from + -from.z / direction.z * direction;
}

/// The photo, row by row: at time t the camera stands at centre + t step in its axes and is turned by exp(-t turn). Both
/// of its turns and steps are about and along one axis, so that they need no library.
Image photo_of(const View& view) {
  const Camera& k = view.camera;
  const Motion& m = k.distortion.motion;
  Image image{k.width, k.height, 3, std::vector<std::uint8_t>(pixel_index(0, k.height, k.width) * 3)};
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const double time = m.down * ((y + 0.5) / k.height - 0.5), c = std::cos(time * m.turn[2]),
                   s = std::sin(time * m.turn[2]);
      const double u = (x + 0.5 - k.cx) / k.fx, v = (y + 0.5 - k.cy) / k.fy;
      const WorldPoint centre =
          view.pose.centre + to_world_axes(view.pose, {time * m.step[0], time * m.step[1], time * m.step[2]});
      const Rgb color = ground_color(hit(centre, to_world_axes(view.pose, {c * u + s * v, c * v - s * u, 1})));
      for (std::size_t i = 0; i < 3; ++i) image.at(x, y)[i] = static_cast<std::uint8_t>(std::lround(color[i]));
    }
  return image;
}

/// Four cameras 15 m above the ground, which look down; over a photo they fly 0.6 m and turn by 0.02.
Scene flight() {
  Scene scene;
  for (int n = 0; n < 4; ++n) {
    View view;
    view.name = std::to_string(n);
    view.camera = {480, 480, 300, 300, 240, 240, {}};
    view.camera.distortion.motion = {
        .down = 1, .turn = {0, 0, n % 2 ? 0.02 : -0.02}, .step = {0.3, n < 2 ? 0.6 : -0.6, 0}};
    view.pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, {n % 2 ? 3.0 : -3.0, n < 2 ? 3.0 : -3.0, 15}};
    scene.views.push_back(view);
  }
  return scene;
}

/// The mean difference, in grey levels, between the textured mesh and the colours of its points.
/// \param as_it_is cameras do not learn how far the mesh is
double color_error(Scene scene, Mesh mesh, const std::vector<io::Picture>& pictures, bool as_it_is) {
  io::PictureSource photos(scene, pictures);
  results::Observer silent;
  const std::vector<ViewId> views = checks::all_views(scene);
  const pipeline::TexturedMesh textured = as_it_is ? pipeline::texture({{scene, mesh, views}, {}, photos, silent})
                                                   : pipeline::texture(scene, mesh, {}, photos, silent);
  const io::TexturedModel& model = textured.atlas.model;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (textured.tags[f] != labeling::FaceTag::seen) continue;
    WorldPoint p;
    double u = 0, v = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      p = p + 1.0 / 3 * mesh.positions[mesh.faces[f][i]];
      const io::TexCoord& t = model.texcoords[model.face_texcoords[f][i]];
      u += static_cast<double>(t.u) / 3;
      v += static_cast<double>(t.v) / 3;
    }
    const Image& page = textured.atlas.pages.at(model.face_page[f]);
    const Rgb shown = bilinear(page, u * page.width, v * page.height), expected = ground_color(p);
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(shown[c] - expected[c]);
    count += 3;
  }
  EXPECT_GT(count, mesh.faces.size() * 2);
  return sum / static_cast<double>(count);
}

// Without the movement photos are off by up to 300 px / 15 m * 0.3 m + 240 px * 0.01 = 8 px at their edges.
TEST(RollingShutter, IsUndoneInTheTexture) {
  const Scene scene = flight();
  const Mesh mesh = box_on_ground();
  std::vector<io::Picture> pictures;
  for (const View& view : scene.views) pictures.push_back({photo_of(view)});
  Scene ignored = scene;
  for (View& view : ignored.views) view.camera.distortion.motion = {};
  const double with = color_error(scene, mesh, pictures, false), turn_alone = color_error(scene, mesh, pictures, true),
               without = color_error(ignored, mesh, pictures, true);
  RecordProperty("with", std::to_string(with));
  RecordProperty("turn_alone", std::to_string(turn_alone));
  RecordProperty("without", std::to_string(without));
  EXPECT_LT(with, 0.15 * without) << with << ' ' << turn_alone << ' ' << without;
  EXPECT_LT(with, 0.3 * turn_alone);
}

// A slope from 10 to 20 metres: 1 / Z is a plane of it, and of a mesh whose rays all lie in one direction, its mean.
TEST(RollingShutter, TakesTheNearnessOfAPlaneExactly) {
  Mesh mesh;
  mesh.positions = {{-50, -50, 60}, {50, -50, 60}, {50, 50, -40}, {-50, 50, -40}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};  // z = 10 - y
  Scene scene = flight();
  scene.views.resize(2);
  for (View& view : scene.views) view.pose.centre = {0, 0, 25};
  scene.views[1].camera.distortion.motion.step = {};
  checks::set_nearness(scene, mesh);
  // A point at depth Z has z = 25 - Z and y = -(Y / Z) Z, so 25 - Z = 10 + (Y / Z) Z, and 1 / Z = (1 + Y / Z) / 15.
  const auto& nearness = scene.views[0].camera.distortion.motion.nearness;
  EXPECT_NEAR(nearness[0], 0, 1e-8);  // depths are floats
  EXPECT_NEAR(nearness[1], 1.0 / 15, 1e-8);
  EXPECT_NEAR(nearness[2], 1.0 / 15, 1e-8);
  EXPECT_EQ(scene.views[1].camera.distortion.motion.nearness, Motion{}.nearness);  // which needs none
}

}  // namespace
}  // namespace gpvc
