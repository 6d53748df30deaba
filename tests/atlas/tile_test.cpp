// Charts and pages that end at the borders of tiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

Color slopes(double x, double y) {
  return {static_cast<float>(60 + 5 * x), static_cast<float>(70 + 6 * y), static_cast<float>(200 - 4 * x - 3 * y)};
}

// A plane of 20 x 8 m under two views, some of whose faces no view shows; four tiles side by side.
struct TiledPlane {
  AtlasScene s;
  std::vector<std::uint32_t> tile;

  TiledPlane() {
    s.add_plane(40, 16, 0.5);
    for (std::size_t v = 0; v < 2; ++v) {
      s.add_view(5 + 10 * double(v), 4, 10, 1000, 600, 300);
      s.photograph(v, slopes);
    }
    for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
      const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
      tile.push_back(static_cast<std::uint32_t>(p.x / 5));
      s.labels[f] = ViewId{p.x < 8 ? 0u : 1u};
      if (f % 97 == 5) s.leave_unseen(f);
    }
  }

  TextureAtlas build() {
    s.graph = labeling::face_graph(s.mesh);
    s.candidates.first.assign(s.mesh.faces.size() + 1, 0);
    io::PhotoCache photos(s.scene, std::size_t{1} << 30);
    AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
    input.tile = tile;
    return build_atlas(input, {}, nullptr);
  }
};

TEST(Tiles, APageHoldsFacesOfOneTile) {
  TiledPlane plane;
  const TextureAtlas atlas = plane.build();
  std::map<std::uint32_t, std::set<std::uint32_t>> tiles_of;
  std::uint32_t last = 0;
  for (std::size_t f = 0; f < plane.tile.size(); ++f) {
    ASSERT_NE(atlas.model.face_page[f], io::kNoPage);
    tiles_of[atlas.model.face_page[f]].insert(plane.tile[f]);
  }
  EXPECT_EQ(tiles_of.size(), 4u);
  for (const auto& [page, tiles] : tiles_of) {
    EXPECT_EQ(tiles.size(), 1u) << "page " << page;
    EXPECT_GE(*tiles.begin(), last) << "pages ascend by tile";
    last = *tiles.begin();
  }
}

TEST(Tiles, EveryFaceHasThePhotosColours) {
  TiledPlane plane;
  const TextureAtlas atlas = plane.build();
  for (std::size_t f = 0; f < plane.tile.size(); ++f) {
    if (plane.s.labels[f] == kNoView) continue;
    const WorldPoint p = point_at(plane.s.mesh, f, 0.2, 0.5);
    const Color found = lookup(atlas.pages[atlas.model.face_page[f]], texcoord_at(atlas.model, f, 0.2, 0.5)),
                truth = slopes(p.x, p.y);
    // Photos and pages are rounded to whole grey levels, and both are interpolated.
    for (const double difference : {found.r - truth.r, found.g - truth.g, found.b - truth.b})
      ASSERT_LE(std::abs(difference), 2) << "face " << f << " of tile " << plane.tile[f];
  }
}

TEST(Tiles, RefusesTilesForOtherFaces) {
  TiledPlane plane;
  plane.tile.pop_back();
  EXPECT_THROW(plane.build(), std::invalid_argument);
}

}  // namespace
}  // namespace gpvc::atlas
