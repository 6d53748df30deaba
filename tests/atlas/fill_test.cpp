#include <gtest/gtest.h>

#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

Color ramp(double x, double y) {
  return {static_cast<float>(60 + 10 * x), static_cast<float>(80 + 8 * y), static_cast<float>(200 - 6 * x - 4 * y)};
}

Color color_of(const TextureAtlas& atlas, std::size_t face, double a, double b) {
  return lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, a, b));
}

/// Linear colours are harmonic on a regular grid: the hole must be indistinguishable from its surroundings.
TEST(Fill, HoleContinuesALinearRamp) {
  AtlasScene s;
  s.add_plane(12, 12, 1.0);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    if (std::abs(p.x - 6) < 3 && std::abs(p.y - 6) < 2) s.leave_unseen(f);
  }
  s.add_view(6, 6, 10, 600, 600, 400);
  s.photograph(0, ramp);
  const TextureAtlas atlas = s.build(AtlasOptions{});
  EXPECT_EQ(atlas.statistics.filled_faces, 48u);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    for (const auto& [a, b] : {std::pair(1.0, 0.0), std::pair(0.0, 1.0), std::pair(0.0, 0.0), std::pair(0.4, 0.3)}) {
      const WorldPoint p = point_at(s.mesh, f, a, b);
      const Color d = color_of(atlas, f, a, b) - ramp(p.x, p.y);
      EXPECT_LE(std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b)}), 2.0) << "face " << f;
    }
  }
}

/// A lookup in a filled face reads only the face's own four texels.
TEST(Fill, BlocksDoNotBleedIntoEachOther) {
  AtlasScene s;
  s.add_plane(2, 1, 1.0);
  s.mesh.positions[2].x += 5;  // the right square lies apart: two components
  std::vector<WorldPoint> moved;
  for (std::size_t f = 2; f < 4; ++f)
    for (auto& v : s.mesh.faces[f]) {
      moved.push_back(s.mesh.positions[v]);
      v = static_cast<std::uint32_t>(5 + moved.size());
    }
  for (auto& p : moved) p.x += 3;
  s.mesh.positions.insert(s.mesh.positions.end(), moved.begin(), moved.end());
  // Face 0 is red, and so its unseen neighbour must be; face 2 is green, and so is its unseen neighbour.
  s.mesh.faces[3] = {s.mesh.faces[2][0], s.mesh.faces[2][2], s.mesh.faces[3][2]};
  s.labels = {ViewId{0}, kNoView, ViewId{0}, kNoView};
  s.tags = {labeling::FaceTag::seen, labeling::FaceTag::unseen, labeling::FaceTag::seen, labeling::FaceTag::unseen};
  s.add_view(3, 0.5, 10, 1000, 400, 400);
  s.photograph(0, [](double x, double) { return x < 2.5 ? Color{240, 0, 0} : Color{0, 240, 0}; });
  const TextureAtlas atlas = s.build(AtlasOptions{});
  for (int i = 0; i <= 8; ++i) {
    for (int j = 0; i + j <= 8; ++j) {
      // Texture coordinates are floats: an error of 2^-24 of the page is a few millionths of a texel.
      EXPECT_LT(color_of(atlas, 1, i / 8.0, j / 8.0).g, 0.01);
      EXPECT_LT(color_of(atlas, 3, i / 8.0, j / 8.0).r, 0.01);
      EXPECT_GT(color_of(atlas, 1, i / 8.0, j / 8.0).r, 230);
      EXPECT_GT(color_of(atlas, 3, i / 8.0, j / 8.0).g, 230);
    }
  }
}

TEST(Fill, ComponentNoViewShowsTakesTheMeanColor) {
  AtlasScene s;
  s.add_plane(4, 4, 1.0);
  const std::size_t seen = s.mesh.faces.size();
  s.add_plane(2, 2, 1.0, -5);
  for (std::size_t f = seen; f < s.mesh.faces.size(); ++f) s.leave_unseen(f);
  s.add_view(2, 2, 10, 500, 500, 400);
  s.photograph(0, [](double, double) { return Color{90, 120, 30}; });
  const TextureAtlas atlas = s.build(AtlasOptions{});
  const Color c = color_of(atlas, seen + 1, 0.3, 0.3);
  EXPECT_EQ(c.r, 90);
  EXPECT_EQ(c.g, 120);
  EXPECT_EQ(c.b, 30);
}

TEST(Fill, NothingSeenAtAllStillGivesEveryFaceATexture) {
  AtlasScene s;
  s.add_plane(3, 3, 1.0);
  s.labels.assign(s.labels.size(), kNoView);
  s.tags.assign(s.tags.size(), labeling::FaceTag::unseen);
  const TextureAtlas atlas = s.build(AtlasOptions{});
  ASSERT_EQ(atlas.pages.size(), 1u);
  EXPECT_EQ(atlas.model.face_texcoords.size(), s.mesh.faces.size());
  EXPECT_GT(color_of(atlas, 4, 0.3, 0.3).r, 100);
}

}  // namespace
}  // namespace gpvc::atlas
