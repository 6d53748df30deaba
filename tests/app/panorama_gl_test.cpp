// A room of known colours, textured from equirectangular photos and from wide fisheyes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <variant>
#include <vector>

#include "app/checks/scene_fit.h"
#include "app/cli/view_lists.h"
#include "app/pipeline/pipeline.h"
#include "io/bilinear.h"
#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "io/vector.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

constexpr int kAround = 640, kDown = 320;
constexpr std::array<double, 3> kRoomHalf{2, 1.5, 1.2};  ///< the room's size about the origin, metres
constexpr int kWallCells = 12;                           ///< along each edge of a wall

/// Waves of a metre and more: 7 grey levels a pixel of a photo at most.
Rgb color_at(const WorldPoint& p) {
  return {128 + 60 * std::sin(2.1 * p.x + 3.3 * p.y), 128 + 60 * std::sin(3.1 * p.z - 2.2 * p.y + 1),
          128 + 60 * std::cos(2.7 * p.x + 2.3 * p.z)};
}

/// The walls, seen from inside.
Mesh room() {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (kWallCells + 1) + i); };
      for (int j = 0; j <= kWallCells; ++j)
        for (int i = 0; i <= kWallCells; ++i) {
          std::array<double, 3> p{};
          const auto a = static_cast<std::size_t>(axis), b = (a + 1) % 3, c = (a + 2) % 3;
          p[a] = side * kRoomHalf[a];
          p[b] = (2.0 * i / kWallCells - 1) * kRoomHalf[b];
          p[c] = (2.0 * j / kWallCells - 1) * kRoomHalf[c];
          mesh.positions.push_back({p[0], p[1], p[2]});
        }
      for (int j = 0; j < kWallCells; ++j)
        for (int i = 0; i < kWallCells; ++i)
          for (Triangle face : {Triangle{at(i, j), at(i + 1, j), at(i + 1, j + 1)},
                                Triangle{at(i, j), at(i + 1, j + 1), at(i, j + 1)}}) {
            if (side > 0) std::swap(face[1], face[2]);
            mesh.faces.push_back(face);
          }
    }
  return mesh;
}

using Quaternion = std::array<double, 4>;

std::array<double, 9> rotation_of(const Quaternion& q) {
  const auto [w, x, y, z] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

/// The wall that a ray from inside meets.
WorldPoint wall_at(const WorldPoint& from, const WorldPoint& d) {
  const std::array<double, 3> o{from.x, from.y, from.z}, v{d.x, d.y, d.z};
  double t = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a)
    if (v[a] != 0) t = std::min(t, (std::copysign(kRoomHalf[a], v[a]) - o[a]) / v[a]);
  return {from.x + t * d.x, from.y + t * d.y, from.z + t * d.z};
}

/// The photo of width x height pixels that is taken at `centre` with the rotation `r`; `ray` gives the direction, in the
/// camera's axes, that a position shows, or none of length 0.
template <class Ray>
Image photo_at(const WorldPoint& centre, const std::array<double, 9>& r, int width, int height, const Ray& ray) {
  Image image{width, height, 3, std::vector<std::uint8_t>(std::size_t{3} * pixel_index(0, height, width))};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const WorldPoint d = ray(x + 0.5, y + 0.5);
      if (d == WorldPoint{}) continue;
      const Rgb color =
          color_at(wall_at(centre, {r[0] * d.x + r[3] * d.y + r[6] * d.z, r[1] * d.x + r[4] * d.y + r[7] * d.z,
                                    r[2] * d.x + r[5] * d.y + r[8] * d.z}));
      for (std::size_t c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(color[c]));
    }
  return image;
}

WorldPoint panorama_ray(double x, double y) {
  const double longitude = (x / kAround - 0.5) * 2 * std::numbers::pi, down = (y / kDown - 0.5) * std::numbers::pi;
  return {std::cos(down) * std::sin(longitude), std::sin(down), std::cos(down) * std::cos(longitude)};
}

constexpr int kFisheyeSide = 400;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFisheyeReach = 100 * kDegree, kImageCircle = 94 * kDegree;  ///< at the edges; where it gets dark

WorldPoint fisheye_ray(double x, double y) {
  const double dx = x - kFisheyeSide / 2.0, dy = y - kFisheyeSide / 2.0, r = std::hypot(dx, dy),
               theta = r / (kFisheyeSide / 2.0) * kFisheyeReach;
  if (theta > kImageCircle) return {};
  return {std::sin(theta) * dx / r, std::sin(theta) * dy / r, std::cos(theta)};
}

constexpr std::array<WorldPoint, 2> kCentres{{{0.4, 0.3, 0.1}, {-0.7, -0.2, -0.3}}};
constexpr std::array<Quaternion, 2> kTurns{{{0.5, -0.5, 0.5, -0.5}, {0.8, 0.36, -0.48, 0}}};

/// Two photos of the room, as COLMAP lists them.
template <class Ray>
void write_scene(const test::TemporaryFolder& folder, const std::string& camera, int width, int height,
                 const Ray& ray) {
  std::string images;
  std::filesystem::create_directory(folder.path() / "images");
  for (std::size_t n = 0; n < 2; ++n) {
    const auto r = rotation_of(kTurns[n]);
    const WorldPoint& c = kCentres[n];
    io::write_image(folder.path() / fmt::format("images/{}.png", n), photo_at(c, r, width, height, ray),
                    io::ImageFormat::png, 0);
    images += fmt::format("{} {} {} {} {} {} {} {} 1 {}.png\n\n", n + 1, kTurns[n][0], kTurns[n][1], kTurns[n][2],
                          kTurns[n][3], -(r[0] * c.x + r[1] * c.y + r[2] * c.z),
                          -(r[3] * c.x + r[4] * c.y + r[5] * c.z), -(r[6] * c.x + r[7] * c.y + r[8] * c.z), n);
  }
  folder.write("cameras.txt", "1 " + camera + "\n");
  folder.write("images.txt", images);
}

Scene panorama_scene(const test::TemporaryFolder& folder) {
  write_scene(folder, fmt::format("EQUIRECTANGULAR {0} {1} {0} {1}", kAround, kDown), kAround, kDown, panorama_ray);
  return io::read_scene(folder.path(), {});
}

/// Faces that some view sees whole have the walls' colours.
void expect_colors(const Mesh& mesh, const pipeline::TexturedMesh& textured) {
  const io::TexturedModel& model = textured.atlas.model;
  double sum = 0, worst = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (textured.tags[f] != labeling::FaceTag::seen) continue;
    for (const auto& [a, b] : {std::pair(1 / 3.0, 1 / 3.0), std::pair(0.8, 0.1), std::pair(0.1, 0.8)}) {
      const std::array<double, 3> weights{a, b, 1 - a - b};
      WorldPoint p;
      double u = 0, v = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        p = p + weights[i] * mesh.positions[mesh.faces[f][i]];
        const io::TexCoord& t = model.texcoords[model.face_texcoords[f][i]];
        u += weights[i] * static_cast<double>(t.u);
        v += weights[i] * static_cast<double>(t.v);
      }
      const Image& page = textured.atlas.pages.at(model.face_page[f]);
      const Rgb shown = bilinear(page, u * page.width, v * page.height), expected = color_at(p);
      for (std::size_t c = 0; c < 3; ++c) {
        const double error = std::abs(shown[c] - expected[c]);
        sum += error;
        worst = std::max(worst, error);
        ++count;
      }
    }
  }
  // A pixel is 7 levels wide at most. A panorama whose sides do not meet, or a view turned the wrong way, is off by 100.
  EXPECT_LT(sum / static_cast<double>(count), 1);
  EXPECT_LT(worst, 7);
}

TEST(PanoramaTexture, ShowsTheWallsInTheirColours) {
  const test::TemporaryFolder folder;
  Scene scene = panorama_scene(folder);
  ASSERT_EQ(scene.views.size(), 12);
  // The photo's name means all of its views.
  for (const char* name : {"0.png", "0"}) {
    const std::vector<ViewId> others = cli::used_views(scene.views, "", name);
    ASSERT_EQ(others.size(), 6) << name;
    EXPECT_EQ(scene.views[index(others[0])].name, "1/back.png");
  }
  EXPECT_EQ(cli::used_views(scene.views, "1/up.png,0/*", "").size(), 7);
  EXPECT_THROW(cli::used_views(scene.views, "front.png", ""), cli::UsageError);
  // Every second photo, which is the second panorama whole.
  const std::vector<ViewId> held = cli::held_out_views(scene, checks::all_views(scene), "2");
  ASSERT_EQ(held.size(), 6);
  for (const ViewId id : held) EXPECT_EQ(io::photo_name(scene.views[index(id)]), "1.png");
  Mesh mesh = room();
  io::PhotoCache photos(scene, std::size_t{1} << 24);
  results::Observer silent;
  const pipeline::TexturedMesh textured = pipeline::texture(scene, mesh, {}, photos, silent);
  // Frames overlap, so that every face lies whole in one.
  const auto [seen, partial, unseen, background] = checks::count_tags(textured.tags);
  EXPECT_EQ(seen, mesh.faces.size());
  EXPECT_EQ(partial + unseen, 0);
  EXPECT_GE(std::set<ViewId>(textured.selection.labels.begin(), textured.selection.labels.end()).size(), 6);

  expect_colors(mesh, textured);
}

TEST(PanoramaTexture, OfTheOpenSkyIsNoReasonForDoubt) {
  const test::TemporaryFolder folder;
  Scene scene = panorama_scene(folder);
  Mesh floor = room();
  std::erase_if(floor.faces, [&](const Triangle& face) {
    return std::ranges::any_of(face, [&](std::uint32_t v) { return floor.positions[v].z > -kRoomHalf[2]; });
  });
  struct Warnings : results::Observer {
    void warning(const std::string& text, const std::vector<Cure>& /*cures*/ = {}) override { all += text + '\n'; }
    std::string all;
  } warnings;
  io::PhotoCache photos(scene, std::size_t{1} << 24);
  pipeline::texture(scene, floor, {}, photos, warnings);
  EXPECT_EQ(warnings.all.find("no face"), std::string::npos) << warnings.all;
}

// Around the image circle, which does not reach the edges, the photos are dark.
TEST(FisheyeTexture, ShowsTheWallsToTheEdge) {
  const test::TemporaryFolder folder;
  write_scene(folder,
              fmt::format("OPENCV_FISHEYE {0} {0} {1} {1} {2} {2} 0 0 0 0", kFisheyeSide,
                          kFisheyeSide / 2.0 / kFisheyeReach, kFisheyeSide / 2.0),
              kFisheyeSide, kFisheyeSide, fisheye_ray);
  Mesh mesh = room();
  std::array<std::size_t, 2> seen{};
  for (const bool whole : {true, false}) {
    Scene scene = io::read_scene(folder.path(), {.whole_fisheyes = whole});
    ASSERT_EQ(scene.views.size(), whole ? 2 : 10);
    io::PhotoCache photos(scene, std::size_t{1} << 24);
    results::Observer silent;
    const pipeline::TexturedMesh textured = pipeline::texture(scene, mesh, {}, photos, silent);
    seen[whole ? 0 : 1] = checks::count_tags(textured.tags)[0];
    expect_colors(mesh, textured);
  }
  // A frame shows a third of the sphere at most, the whole photo (1 - cos 94 degrees) / 2 = 0.53 of it.
  EXPECT_GT(seen[1], seen[0] * 5 / 4);
  EXPECT_GT(seen[1], mesh.faces.size() * 8 / 10);
}

// Whatever view shows it, and to its left and right rim, beyond which views go on.
TEST(PanoramaRules, MeanPlacesOfItsFile) {
  const test::TemporaryFolder folder;
  const Scene scene = panorama_scene(folder);
  const Mesh mesh = room();
  const std::vector<ViewId> views = checks::all_views(scene);
  const auto r = rotation_of(kTurns[0]);
  constexpr double kTop = 100, kBottom = 220, kWide = 160, kBorder = 24;  // faces are less than twice as wide
  for (const double left : {0.0, 300.0, kAround - kWide}) {
    const bool at_rim = left == 0 || left + kWide == kAround;
    const auto rules = cli::read_rules(folder.write("rules.csv", fmt::format("photo,0.png {} {} {} {},forbid,1.png\n",
                                                                             left, kTop, left + kWide, kBottom)),
                                       {scene, mesh, views});
    ASSERT_EQ(rules.size(), 1u);
    std::vector<bool> in_region(mesh.faces.size(), false);
    for (const auto& [first, last] : std::get<io::FaceRegion>(rules[0].region).ranges)
      for (std::uint32_t f = first; f <= last; ++f) in_region[f] = true;
    std::size_t inside = 0, outside = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto [a, b, c] = mesh.faces[f];
      const WorldPoint middle = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1.0 / 3);
      const WorldPoint d = middle - kCentres[0];
      const WorldPoint ray{r[0] * d.x + r[1] * d.y + r[2] * d.z, r[3] * d.x + r[4] * d.y + r[5] * d.z,
                           r[6] * d.x + r[7] * d.y + r[8] * d.z};
      const double x = (std::atan2(ray.x, ray.z) / (2 * std::numbers::pi) + 0.5) * kAround,
                   y = (std::atan2(ray.y, std::hypot(ray.x, ray.z)) / std::numbers::pi + 0.5) * kDown;
      // How far it lies inside, negative outside.
      const double depth = std::min({x - left, left + kWide - x, y - kTop, kBottom - y});
      if (std::abs(depth) < kBorder || (at_rim && std::min(x, kAround - x) < kBorder)) continue;
      ++(depth > 0 ? inside : outside);
      ASSERT_EQ(in_region[f], depth > 0) << "face " << f << " at " << x << ", " << y << ", rectangle from " << left;
    }
    EXPECT_GT(inside, 10u);
    EXPECT_GT(outside, 200u);
  }
}

}  // namespace
}  // namespace gpvc
