// Baking onto places of faces that the input gives.
#include <gtest/gtest.h>

#include <array>

#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

Color waves(double x, double y) {
  return {static_cast<float>(120 + 60 * std::sin(1.3 * x)), static_cast<float>(120 + 60 * std::cos(1.1 * y)),
          static_cast<float>(60 + 10 * x)};
}

AtlasOptions plain_options() {
  AtlasOptions options;
  options.seams = SeamLeveling::none;
  options.blend = Blending::none;
  options.align = PhotoAlignment::none;
  return options;
}

/// A layout with corners of its own for each face.
struct LayoutMaker {
  io::UvLayout layout;
  LayoutMaker(std::size_t faces, int width, int height) {
    layout.pages.push_back({"_0", "page_0", width, height});
    layout.face_texcoords.assign(faces, {});
    layout.face_page.assign(faces, io::kNoPage);
  }
  /// \param place(vertex of the mesh) texture coordinates
  template <typename Place>
  void put(const Mesh& mesh, std::size_t face, const Place& place) {
    layout.face_page[face] = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      layout.face_texcoords[face][i] = static_cast<std::uint32_t>(layout.texcoords.size());
      layout.texcoords.push_back(place(mesh.positions[mesh.faces[face][i]]));
    }
  }
};

/// As on the ground, north up: x of 0 .. size along u.
io::TexCoord from_above(const WorldPoint& p, double size) {
  return {static_cast<float>(p.x / size), static_cast<float>(1 - p.y / size)};
}
io::TexCoord mirrored(const WorldPoint& p, double size) {
  return {static_cast<float>(1 - p.x / size), static_cast<float>(1 - p.y / size)};
}

struct GivenLayoutScene : AtlasScene {
  /// A square of the ground of so many cells and one view of all of it, whose pixels are 1/60 of a cell.
  explicit GivenLayoutScene(int cells = 4, const Albedo& albedo = waves) {
    add_plane(cells, cells, 1.0);
    add_view(cells / 2.0, cells / 2.0, 10, 60 * cells + 40, 60 * cells + 40, 600);
    photograph(0, albedo);
  }

  TextureAtlas bake(const io::UvLayout& layout, const AtlasOptions& options = plain_options()) {
    graph = labeling::face_graph(mesh);
    if (candidates.first.empty()) candidates.first.assign(mesh.faces.size() + 1, 0);
    io::PhotoCache photos(scene, std::size_t{1} << 30);
    AtlasInput input{mesh, scene, photos, graph, labels, tags, candidates, coverage};
    input.layout = &layout;
    return build_atlas(input, options, nullptr);
  }
  UvFigures measure(const io::UvLayout& layout) const { return measure_uv(mesh, labeling::face_graph(mesh), layout); }
};

/// The middles of texels of a square page that shows the ground from above.
template <typename Visit>
void for_ground(const Image& page, double size, const Visit& visit) {
  for (int y = 0; y < page.height; ++y)
    for (int x = 0; x < page.width; ++x)
      visit(load(page.at(x, y)), size * (x + 0.5) / page.width, size * (page.height - y - 0.5) / page.height, x, y);
}

double worst(const Color& a, const Color& b) {
  return std::max(
      {std::abs(double{a.r} - double{b.r}), std::abs(double{a.g} - double{b.g}), std::abs(double{a.b} - double{b.b})});
}

TEST(GivenLayout, ShowsTheGroundWhereTheTextureCoordinatesHaveIt) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 200, 160);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  const TextureAtlas atlas = s.bake(made.layout);
  ASSERT_EQ(atlas.pages.size(), 1u);
  EXPECT_EQ(atlas.pages[0].width, 200);
  EXPECT_EQ(atlas.pages[0].height, 160);
  for_ground(atlas.pages[0], 4, [](const Color& c, double x, double y, int, int) {
    EXPECT_LT(worst(c, waves(x, y)), 2) << x << " " << y;
  });
}

TEST(GivenLayout, KeepsTextureCoordinatesBitForBit) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 100, 100);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4.3); });
  for (const io::TexCoord& t : made.layout.texcoords) made.layout.obj_texcoords.push_back({double{t.u} + 1e-12, 0.5});
  const TextureAtlas atlas = s.bake(made.layout);
  ASSERT_EQ(atlas.model.texcoords.size(), made.layout.texcoords.size());
  for (std::size_t i = 0; i < made.layout.texcoords.size(); ++i) {
    EXPECT_EQ(atlas.model.texcoords[i].u, made.layout.texcoords[i].u);
    EXPECT_EQ(atlas.model.texcoords[i].v, made.layout.texcoords[i].v);
  }
  EXPECT_EQ(atlas.model.face_texcoords, made.layout.face_texcoords);
  EXPECT_EQ(atlas.model.face_page, made.layout.face_page);
  EXPECT_EQ(atlas.model.obj_texcoords, made.layout.obj_texcoords);
}

TEST(GivenLayout, MakesTheSamePageAgainFromAFreeAtlas) {
  GivenLayoutScene s;
  s.add_view(3.0, 1.5, 10, 300, 300, 600);
  s.photograph(1, waves, [](int, int, Color c) { return 0.9f * c; });
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) s.labels[f] = ViewId{f % 8 < 4 ? 1u : 0u};
  for (const AtlasOptions& options : {plain_options(), AtlasOptions{}}) {
    const TextureAtlas first = s.build(options);
    ASSERT_EQ(first.pages.size(), 1u);
    io::UvLayout layout;
    layout.texcoords = first.model.texcoords;
    layout.face_texcoords = first.model.face_texcoords;
    layout.face_page = first.model.face_page;
    layout.pages = {{"_0", "page_0", first.pages[0].width, first.pages[0].height}};
    const TextureAtlas again = s.bake(layout, options);
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
      for (double a = 0.1; a < 1; a += 0.1)
        for (double b = 0.1; a + b < 1; b += 0.1) {
          const io::TexCoord at = texcoord_at(first.model, f, a, b);
          sum += std::pow(worst(lookup(first.pages[0], at), lookup(again.pages[0], at)), 2);
          ++count;
        }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(count)), 1.0) << "48 dB";
  }
}

TEST(GivenLayout, AveragesOverTexelsLargerThanPixels) {
  // Stripes of two pixels, whose mean is grey, and which texels of eight pixels would catch at random.
  const auto stripes = [](double x, double) {
    const float c = std::fmod(x * 60, 4.0) < 2 ? 40 : 200;
    return Color{c, c, c};
  };
  GivenLayoutScene s(4, stripes);
  LayoutMaker made(s.mesh.faces.size(), 29, 29);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [](const Color& c, double, double, int x, int y) {
    EXPECT_LT(worst(c, {120, 120, 120}), 25) << x << " " << y;
  });
}

TEST(GivenLayout, BlendsMeansOfTexelsLargerThanPixels) {
  // As above, with another photo that is blended: what is added to a texel is a mean, too.
  const auto stripes = [](double x, double) {
    const float c = std::fmod(x * 60, 4.0) < 2 ? 40 : 200;
    return Color{c, c, c};
  };
  GivenLayoutScene s(4, stripes);
  s.add_view(2.02, 2.0, 10, 280, 280, 600);
  s.photograph(1, stripes);
  s.candidates.first = {0};
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    s.candidates.views.insert(s.candidates.views.end(), {0, 1});
    s.candidates.costs.insert(s.candidates.costs.end(), {0.01f, 0.012f});
    s.candidates.first.push_back(s.candidates.views.size());
  }
  LayoutMaker made(s.mesh.faces.size(), 29, 29);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  AtlasOptions options = plain_options();
  options.blend = Blending::coarse;
  const TextureAtlas atlas = s.bake(made.layout, options);
  EXPECT_EQ(atlas.statistics.blended_faces, s.mesh.faces.size());
  const TextureAtlas alone = s.bake(made.layout, plain_options());
  double sum = 0;
  for (std::size_t i = 0; i < atlas.pages[0].pixels.size(); ++i)
    sum += std::pow(atlas.pages[0].pixels[i] - alone.pages[0].pixels[i], 2);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(atlas.pages[0].pixels.size())), 3) << "the photos show the same";
}

TEST(GivenLayout, AveragesAlongOneAxisOfStretchedFaces) {
  const auto stripes = [](double x, double y) {
    const float c = std::fmod(x * 60, 4.0) < 2 ? 40 : 200;
    return Color{c, c, static_cast<float>(60 + 40 * y)};
  };
  GivenLayoutScene s(4, stripes);
  LayoutMaker made(s.mesh.faces.size(), 17, 240);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [](const Color& c, double, double y, int, int) {
    EXPECT_LT(worst(c, {120, 120, static_cast<float>(60 + 40 * y)}), 20) << "sharp along y";
  });
}

TEST(GivenLayout, MirrorsWhatIsMirrored) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return mirrored(p, 4); });
  const UvFigures figures = s.measure(made.layout);
  EXPECT_EQ(figures.islands, 1u);
  EXPECT_EQ(figures.mirrored_islands, 1u);
  EXPECT_EQ(figures.overlapping_texels, 0u);
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [](const Color& c, double x, double y, int, int) {
    EXPECT_LT(worst(c, waves(4 - x, y)), 2) << x << " " << y;
  });
}

TEST(GivenLayout, TellsIslandsThatLieOverEachOtherApart) {
  // The left half of the ground, and the right half mirrored over it.
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 64, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const bool left = f % 8 < 4;
    made.put(s.mesh, f, [&](const WorldPoint& p) {
      return io::TexCoord{static_cast<float>(left ? p.x / 2 : (4 - p.x) / 2), static_cast<float>(1 - p.y / 4)};
    });
  }
  const UvFigures figures = s.measure(made.layout);
  EXPECT_EQ(figures.islands, 2u);
  EXPECT_EQ(figures.mirrored_islands, 1u);
  EXPECT_EQ(figures.overlapping_faces, s.mesh.faces.size());
  EXPECT_NEAR(static_cast<double>(figures.overlapping_texels), 64 * 128, 64 * 128 * 0.07)
      << "all but those on edges, diagonals among them";
  const TextureAtlas atlas = s.bake(made.layout);
  const auto& page = atlas.pages[0];
  for (int y = 0; y < page.height; ++y)
    for (int x = 0; x < page.width; ++x) {
      const double along = 2 * (x + 0.5) / 64, up = 4 * (127.5 - y) / 128;
      const Color c = load(page.at(x, y));
      EXPECT_TRUE(worst(c, waves(along, up)) < 3 || worst(c, waves(4 - along, up)) < 3) << "one of them, not a mixture";
    }
}

TEST(GivenLayout, LeavesNeighbouringIslandsTheirTexels) {
  // Both halves of the ground change their places: a red island and a green one with no texel between.
  const auto halves = [](double x, double) { return x < 2 ? Color{220, 20, 20} : Color{20, 220, 20}; };
  GivenLayoutScene s(4, halves);
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const double shift = f % 8 < 4 ? 2 : -2;
    made.put(s.mesh, f, [&](const WorldPoint& p) { return from_above({p.x + shift, p.y, 0}, 4); });
  }
  EXPECT_EQ(s.measure(made.layout).overlapping_texels, 0u);
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [&](const Color& c, double x, double y, int column, int) {
    if (column == 0 || column == 127) return;  // beside the cut of the ground, where the photo blends both
    EXPECT_LT(worst(c, halves(x < 2 ? 3 : 1, y)), 3) << column;
  });
}

TEST(GivenLayout, PadsIslandsAndFillsTheBackground) {
  GivenLayoutScene s(4, [](double, double) { return Color{200, 100, 50}; });
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above({p.x + 4, p.y + 4, 0}, 12); });
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [](const Color& c, double, double, int x, int y) {
    EXPECT_LT(worst(c, {200, 100, 50}), 2) << x << " " << y;
  });
  EXPECT_LT(atlas.statistics.chart_texels, 48u * 48u);
  EXPECT_GT(atlas.statistics.padded_texels, atlas.statistics.chart_texels + 4u * 40u * 8u);
}

TEST(GivenLayout, CountsFacesThatItDoesNotServe) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 2; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  made.put(s.mesh, 5, [](const WorldPoint&) { return io::TexCoord{0.5f, 0.5f}; });
  const UvFigures figures = s.measure(made.layout);
  EXPECT_EQ(figures.faces_without, 2u);
  EXPECT_EQ(figures.flat_faces, 1u);
  const TextureAtlas atlas = s.bake(made.layout);
  EXPECT_EQ(atlas.model.face_page[0], io::kNoPage);
  EXPECT_EQ(atlas.model.face_page[5], 0u) << "its texture coordinates stay";
  EXPECT_LT(worst(lookup(atlas.pages[0], {0.5f, 0.3f}), waves(2, 2.8)), 3);
}

TEST(GivenLayout, ContinuesColoursIntoUnseenFaces) {
  GivenLayoutScene s(4, [](double x, double) { return Color{static_cast<float>(40 + 40 * x), 90, 90}; });
  for (const std::size_t face : {10u, 11u, 12u, 13u}) s.leave_unseen(face);
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  const TextureAtlas atlas = s.bake(made.layout);
  EXPECT_EQ(atlas.statistics.filled_faces, 4u);
  for_ground(atlas.pages[0], 4, [](const Color& c, double x, double y, int, int) {
    EXPECT_LT(worst(c, {static_cast<float>(40 + 40 * x), 90, 90}), 14) << x << " " << y;
  });
}

// Columns of the ground lie on the page as 0, 2, 1, 3, without a texel between them.
TEST(GivenLayout, ContinuesNoColoursOfIslandsThatTouch) {
  const Color red{200, 40, 40}, blue{40, 40, 200};
  GivenLayoutScene s(4, [&](double x, double) { return x < 2 ? red : blue; });
  for (const std::size_t face : {8u, 9u, 16u, 17u}) s.leave_unseen(face);  // in the middle of column 0
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const std::size_t column = f / 2 % 4;
    const double slot = std::array{0.0, 2.0, 1.0, 3.0}[column];
    made.put(s.mesh, f, [&](const WorldPoint& p) {
      return io::TexCoord{static_cast<float>((slot + p.x - static_cast<double>(column)) / 4),
                          static_cast<float>(1 - p.y / 4)};
    });
  }
  const TextureAtlas atlas = s.bake(made.layout);
  EXPECT_EQ(atlas.statistics.filled_faces, 4u);
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 32; ++x) EXPECT_LT(worst(load(atlas.pages[0].at(x, y)), red), 5) << x << " " << y;
}

// The right half of the ground lies over the left one, turned about: texels around the hole are the left half's, those in it the
// right half's, as the lowest face decides.
TEST(GivenLayout, ContinuesColoursThatAnIslandShowsWithAnother) {
  const Color red{200, 40, 40}, blue{40, 40, 200};
  GivenLayoutScene s(4, [&](double, double y) { return y > 0.4 && y < 3.6 ? red : blue; });
  for (const std::size_t face : {14u, 15u, 16u, 17u}) s.leave_unseen(face);
  LayoutMaker made(s.mesh.faces.size(), 128, 128);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const bool left = f / 2 % 4 < 2;
    made.put(s.mesh, f, [&](const WorldPoint& p) {
      const double x = left ? p.x : 4 - p.x, y = left ? p.y : 4 - p.y;
      return io::TexCoord{static_cast<float>(x / 2), static_cast<float>(1 - y / 4)};
    });
  }
  const TextureAtlas atlas = s.bake(made.layout);
  EXPECT_EQ(atlas.statistics.filled_faces, 4u);
  for_ground(atlas.pages[0], 4, [&](const Color& c, double, double y, int column, int row) {
    if (y < 0.6 || y > 3.4) return;
    EXPECT_LT(worst(c, red), 5) << column << " " << row;
  });
}

/// All pixels of a view that see a face, except those in a strip of the ground.
void cover(GivenLayoutScene& s, std::uint32_t face, std::uint32_t v, double hidden_from, double hidden_to) {
  const View& view = s.scene.views[v];
  visibility::FaceCoverage entry{
      FaceId{face}, ViewId{v}, 0, 0, view.camera.width, view.camera.height, 0, 0.5f, s.coverage.words.size()};
  const std::size_t bits = static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
  s.coverage.words.resize(s.coverage.words.size() + (bits + 63) / 64, 0);
  for (int y = 0; y < entry.height; ++y)
    for (int x = 0; x < entry.width; ++x) {
      const WorldPoint p = AtlasScene::on_ground(view, {x + 0.5, y + 0.5});
      if (p.x < 0 || p.y < 0 || p.x > 4 || p.y > 4 || (p.y > p.x) != (face == 1)) continue;
      if (p.x >= hidden_from && p.x <= hidden_to) continue;
      const auto bit = static_cast<std::size_t>(y * entry.width + x);
      s.coverage.words[entry.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
      ++entry.visible;
    }
  s.coverage.entries.push_back(entry);
}

TEST(GivenLayout, TakesEachTexelOfAPartialFaceFromAViewThatShowsIt) {
  GivenLayoutScene s(4);
  s.mesh = test::grid_mesh(1, 1, 4.0);
  s.labels.assign(2, ViewId{0});
  s.tags.assign(2, labeling::FaceTag::partial);
  s.add_view(2.0, 2.0, 10, 280, 280, 600);
  constexpr Color kWire{255, 0, 255};
  // What hides the ground is in the photos: in the first one in the middle, in the second one further right.
  const auto painted = [&](std::uint32_t v, double from, double to) {
    s.photograph(v, [=](double x, double y) { return x >= from && x <= to ? kWire : waves(x, y); });
    for (std::uint32_t face = 0; face < 2; ++face) cover(s, face, v, from, to);
  };
  painted(0, 1.0, 1.8);
  painted(1, 1.6, 2.6);
  s.candidates.first = {0, 2, 4};
  s.candidates.views = {0, 1, 0, 1};
  s.candidates.costs = {0.1f, 0.2f, 0.1f, 0.2f};
  LayoutMaker made(2, 128, 128);
  for (std::size_t f = 0; f < 2; ++f) made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  const TextureAtlas atlas = s.bake(made.layout);
  for_ground(atlas.pages[0], 4, [&](const Color& c, double x, double y, int, int) {
    EXPECT_GT(worst(c, kWire), 60) << "no wire at " << x << " " << y;
    if (x < 1.5 || x > 1.9) {
      EXPECT_LT(worst(c, waves(x, y)), 4) << x << " " << y;
    }
  });
}

TEST(GivenLayout, SplitsPagesByNumberAndMemory) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 100, 100);
  made.layout.pages.push_back({"_1", "page_1", 60, 80});
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
    made.layout.face_page[f] = f % 8 < 4 ? 0 : 1;
  }
  s.leave_unseen(9);
  const TextureAtlas atlas = s.bake(made.layout);
  ASSERT_EQ(atlas.pages.size(), 2u);
  EXPECT_EQ(atlas.pages[1].width, 60);
  EXPECT_EQ(atlas.pages[1].height, 80);
  EXPECT_LT(worst(lookup(atlas.pages[0], {0.1f, 0.5f}), waves(0.4, 2)), 4);
  EXPECT_LT(worst(lookup(atlas.pages[1], {0.9f, 0.5f}), waves(3.6, 2)), 4);
  // One page at a time, spilled while the unseen face waits: the same bytes.
  s.graph = labeling::face_graph(s.mesh);
  io::PhotoCache photos(s.scene, std::size_t{1} << 30);
  AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
  input.layout = &made.layout;
  BakeOptions little;
  little.page_bytes = 1;
  little.scratch_folder = s.folder.path();
  const TextureAtlas again = bake_atlas(plan_atlas(input, plain_options()), input, nullptr, little);
  for (std::size_t p = 0; p < 2; ++p) EXPECT_EQ(again.pages[p].pixels, atlas.pages[p].pixels);
}

TEST(GivenLayout, RefusesWhatContradictsIt) {
  GivenLayoutScene s;
  LayoutMaker made(s.mesh.faces.size(), 100, 100);
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f)
    made.put(s.mesh, f, [](const WorldPoint& p) { return from_above(p, 4); });
  AtlasOptions limited = plain_options();
  limited.max_pages = 1;
  EXPECT_THROW(s.bake(made.layout, limited), std::invalid_argument);
  const auto spoilt = [&](const auto& spoil) {
    io::UvLayout layout = made.layout;
    spoil(layout);
    EXPECT_THROW(s.bake(layout), std::invalid_argument);
  };
  spoilt([](io::UvLayout& l) { l.face_page.pop_back(); });
  spoilt([](io::UvLayout& l) { l.face_page[3] = 7; });
  spoilt([](io::UvLayout& l) { l.face_texcoords[3][1] = 1000000; });
  spoilt([](io::UvLayout& l) { l.texcoords[3].u = 1.5f; });
  spoilt([](io::UvLayout& l) { l.texcoords[3].v = std::nanf(""); });
  spoilt([](io::UvLayout& l) { l.pages[0].width = 0; });
}

}  // namespace
}  // namespace gpvc::atlas
