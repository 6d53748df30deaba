#include <gtest/gtest.h>

#include "atlas/baking/partial_sources.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

constexpr double kFocal = 300, kHeight = 10;

Color ground(double x, double y) {
  return {static_cast<float>(90 + 5 * x), static_cast<float>(120 + 20 * std::sin(2 * y)), 60};
}
constexpr Color kOccluder{255, 0, 255};

bool in_rectangle(const WorldPoint& p, double x0, double y0, double x1, double y1) {
  return p.x >= x0 && p.x <= x1 && p.y >= y0 && p.y <= y1;
}

/// A large square of ground (two faces). In each view given rectangles of it are hidden by an occluder, in the photo as
/// well as in the coverage. Coverage is computed here, without GL.
struct HiddenGround {
  AtlasScene s;
  struct Box {
    double x0, y0, x1, y1;
  };
  std::vector<std::vector<Box>> hidden;

  /// \param zoom of the views after the first
  explicit HiddenGround(std::vector<std::vector<Box>> boxes, double shift = 0, double zoom = 1)
      : hidden(std::move(boxes)) {
    s.add_plane(1, 1, 8.0);
    s.tags.assign(2, labeling::FaceTag::partial);
    for (std::size_t v = 0; v < hidden.size(); ++v) {
      const double by = v == 0 ? 1 : zoom;
      s.add_view(3.5 + double(v), 4.2 + (v == 0 ? 2 * shift : -shift), kHeight, static_cast<int>(420 * by),
                 static_cast<int>(400 * by), kFocal * by);
      s.photograph(v, ground, [&, v](int x, int y, Color c) { return is_hidden(v, x, y) ? kOccluder : c; });
      for (std::uint32_t face = 0; face < 2; ++face) cover(face, v);
    }
    s.candidates.first = {0};
    for (int face = 0; face < 2; ++face) {
      for (std::uint32_t v = 0; v < hidden.size(); ++v) {
        s.candidates.views.push_back(v);
        s.candidates.costs.push_back(0.1f * static_cast<float>(v + 1));
      }
      s.candidates.first.push_back(s.candidates.views.size());
    }
  }

  bool is_hidden(std::size_t v, int x, int y) const {
    const WorldPoint p = AtlasScene::on_ground(s.scene.views[v], {x + 0.5, y + 0.5});
    for (const Box& b : hidden[v])
      if (in_rectangle(p, b.x0, b.y0, b.x1, b.y1)) return true;
    return false;
  }

  /// Bits of the pixels whose centres lie in the face and are not hidden.
  void cover(std::uint32_t face, std::size_t v) {
    const View& view = s.scene.views[v];
    visibility::FaceCoverage entry{FaceId{face},
                                   ViewId{static_cast<std::uint32_t>(v)},
                                   0,
                                   0,
                                   view.camera.width,
                                   view.camera.height,
                                   0,
                                   0.5f,
                                   s.coverage.words.size()};
    const std::size_t bits = static_cast<std::size_t>(entry.width) * static_cast<std::size_t>(entry.height);
    s.coverage.words.resize(s.coverage.words.size() + (bits + 63) / 64, 0);
    for (int y = 0; y < entry.height; ++y) {
      for (int x = 0; x < entry.width; ++x) {
        const WorldPoint p = AtlasScene::on_ground(view, {x + 0.5, y + 0.5});
        // Face 0 lies below the diagonal y = x, face 1 above.
        if (!in_rectangle(p, 0, 0, 8, 8) || (p.y > p.x) != (face == 1) || is_hidden(v, x, y)) continue;
        const std::size_t bit = static_cast<std::size_t>(y * entry.width + x);
        s.coverage.words[entry.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
        ++entry.visible;
      }
    }
    s.coverage.entries.push_back(entry);
  }

  /// Squares' diagonals: face 0 is (0,0) (8,0) (8,8), face 1 is (0,0) (8,8) (0,8).
  static std::array<double, 2> first_weights(const WorldPoint& p) {
    return p.y <= p.x ? std::array{1 - p.x / 8, (p.x - p.y) / 8} : std::array{1 - p.y / 8, p.x / 8};
  }

  /// The origin of the texture's colour at each point.
  std::vector<PointOrigin> origins(std::span<const WorldPoint> points, const AtlasOptions& options) {
    s.graph = labeling::face_graph(s.mesh);
    io::PhotoCache photos(s.scene, 0);
    const AtlasInput input{s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage};
    const AtlasPlan plan = plan_atlas(input, options);
    const TextureOrigins all(plan, input);
    std::vector<PointOrigin> result;
    for (const WorldPoint& p : points) {
      const auto [a, b] = first_weights(p);
      result.push_back(all.at(FaceId{p.y > p.x ? 1u : 0u}, b, 1 - a - b));
    }
    return result;
  }

  Color texture_at(const TextureAtlas& atlas, const WorldPoint& p) const {
    const std::size_t face = p.y > p.x ? 1 : 0;
    const auto [a, b] = first_weights(p);
    return lookup(atlas.pages[atlas.model.face_page[face]], texcoord_at(atlas.model, face, a, b));
  }
};

double error(const Color& got, const Color& truth) {
  const Color d = got - truth;
  return std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b)});
}

TEST(Partial, HiddenTexelsComeFromTheOtherView) {
  HiddenGround g({{{3, 1, 5, 3}}, {{1, 5, 3, 7}}});
  for (const auto seams : {SeamLeveling::none, SeamLeveling::full}) {
    AtlasOptions options;
    options.seams = seams;
    const TextureAtlas atlas = g.s.build(options);
    double worst = 0;
    for (double x = 0.1; x < 8; x += 0.05)
      for (double y = 0.1; y < 8; y += 0.05)
        if (std::abs(x - y) > 0.05) worst = std::max(worst, error(g.texture_at(atlas, {x, y, 0}), ground(x, y)));
    EXPECT_LE(worst, 3.0);
  }
}

TEST(Partial, OccluderColorNeverAppearsNorDoesBackground) {
  HiddenGround g({{{3, 1, 5, 3}, {0, 6, 8, 6.5}}, {{3.5, 1, 6, 3}}});
  const TextureAtlas atlas = g.s.build(AtlasOptions{});
  for (const Image& page : atlas.pages) {
    for (std::size_t i = 0; i < page.pixels.size(); i += 3) {
      ASSERT_LT(page.pixels[i + 2], 75) << "occluder";  // its blue is 255, the ground's 60
      ASSERT_GT(page.pixels[i + 1], 85) << "occluder or black";
    }
  }
}

TEST(Partial, OriginsAreThePlacesThatColorsComeFrom) {
  HiddenGround g({{{3, 1, 5, 3}, {6, 1, 7, 2}}, {{1, 5, 3, 7}, {6, 1, 7, 2}}});
  std::vector<WorldPoint> points;
  for (double x = 0.15; x < 8; x += 0.2)
    for (double y = 0.1; y < 8; y += 0.2)
      if (std::abs(x - y) > 0.07) points.push_back({x, y, 0});
  const std::vector<PointOrigin> origins = g.origins(points, AtlasOptions{});
  const TextureAtlas atlas = g.s.build(AtlasOptions{});
  std::array<int, 3> of{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const WorldPoint& p = points[i];
    const bool in_both = in_rectangle(p, 6.1, 1.1, 6.9, 1.9);
    EXPECT_TRUE(!in_both || origins[i].first == kNoView) << p.x << ' ' << p.y;
    for (const auto& [view, at] :
         {std::pair(origins[i].first, origins[i].first_at), {origins[i].second, origins[i].second_at}}) {
      if (view == kNoView) continue;
      EXPECT_FALSE(g.is_hidden(index(view), static_cast<int>(at.x), static_cast<int>(at.y)));
      const WorldPoint q = AtlasScene::on_ground(g.s.scene.views[index(view)], at);
      EXPECT_NEAR(q.x, p.x, 1e-3);
      EXPECT_NEAR(q.y, p.y, 1e-3);
    }
    ++of[origins[i].first == kNoView ? 2 : index(origins[i].first)];
  }
  EXPECT_GT(of[0], 100);
  EXPECT_GT(of[1], 30);
  EXPECT_GT(of[2], 10);
}

/// A texel of another view's photo takes a sample for each of the photo's pixels along its edge, rounded.
TEST(Partial, TexelsTakeASampleForEachPixel) {
  for (const auto& [zoom, samples] : {std::pair(1.3, 1), {2.0, 2}, {2.7, 3}}) {
    HiddenGround g({{{3, 1, 5, 3}}, {}}, 0, zoom);
    g.s.photograph(1, ground, [](int x, int y, Color c) { return (x / 2 + y / 3) % 2 == 0 ? c : 0.5f * c; });
    AtlasOptions options;
    options.seams = SeamLeveling::none;
    options.blend = Blending::none;
    const TextureAtlas atlas = g.s.build(options);
    const Image photo = *io::PhotoCache(g.s.scene, 0).photo(ViewId{1});
    // Face 0 is (0, 0) (8, 0) (8, 8) on the ground. Texels in the middle of what is hidden.
    const Image& page = atlas.pages[atlas.model.face_page[0]];
    TexelTriangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const io::TexCoord t = atlas.model.texcoords[atlas.model.face_texcoords[0][k]];
      corners[k] = {double{t.u} * page.width, double{t.v} * page.height};
    }
    const auto sample_at = [&](double x, double y) {
      const std::array<double, 3> share = shares_at(corners, x, y);
      const WorldPoint p = point_at(g.s.mesh, 0, share[0], share[1]);
      const View& view = g.s.scene.views[1];
      const PixelPoint at = pixel_from_camera(view.camera, camera_from_world(view.pose, p));
      return sample_bicubic(photo, at.x, at.y);
    };
    int looked_at = 0;
    float worst = 0;
    for (int y = 0; y < page.height; ++y)
      for (int x = 0; x < page.width; ++x) {
        const std::array<double, 3> share = shares_at(corners, x + 0.5, y + 0.5);
        const WorldPoint p = point_at(g.s.mesh, 0, share[0], share[1]);
        if (!in_rectangle(p, 3.5, 1.5, 4.5, 2.5)) continue;
        Color mean;
        for (int i = 0; i < samples * samples; ++i)
          mean = mean + (1.0f / static_cast<float>(samples * samples)) *
                            sample_at(x + (i % samples + 0.5) / samples, y + (i / samples + 0.5) / samples);
        const std::uint8_t* texel = page.at(x, y);
        worst = std::max(worst, std::abs(static_cast<float>(texel[0]) - mean.r));
        ++looked_at;
      }
    EXPECT_GT(looked_at, 500);
    EXPECT_LE(worst, 1.0f) << samples;
  }
}

/// If every view has an occluder close by, a view in which no neighbouring pixel is hidden is preferred, because
/// resampling blends neighbouring pixels in.
TEST(Partial, TexelsBesideAnOccluderComeFromAViewWhereItIsAPixelOrTwoAway) {
  // A pixel is a thirtieth of a unit wide. The first view is the cheaper one.
  HiddenGround g({{{3, 1, 5, 3}}, {{5.12, 1, 6, 3}}});
  const std::vector<WorldPoint> points{{5.02, 2, 0}, {5.06, 2, 0}, {4.9, 2, 0}, {5.2, 2, 0}};
  const auto origins = g.origins(points, AtlasOptions{});
  EXPECT_EQ(origins[0].first, ViewId{1}) << "beside the occluder in one, two or three pixels off in the other";
  EXPECT_EQ(origins[2].first, ViewId{1}) << "hidden in the first";
  EXPECT_EQ(origins[3].first, ViewId{0}) << "hidden in the second";
}

/// Where the face's edge crosses a pixel whose centre lies outside, the neighbouring pixel's coverage decides.
TEST(Partial, TexelsUpToTheEdgeOfAFaceAreNotFilled) {
  // Centres lie 0.2 of a pixel off the diagonal in the first view and 0.1 beyond it in the second. Hidden in the first:
  // a piece of the diagonal.
  HiddenGround g({{{3, 3, 5, 5}}, {}}, 0.1 * kHeight / kFocal);
  std::vector<WorldPoint> points;
  for (const double off : {-0.012, -0.006, 0.006, 0.012})
    for (double x = 3.2; x < 4.8; x += 0.0137) points.push_back({x, x + off, 0});
  for (const PointOrigin& origin : g.origins(points, AtlasOptions{})) EXPECT_EQ(origin.first, ViewId{1});
}

/// Hidden places are filled smoothly from their surroundings, which comes close to the truth on smooth ground.
TEST(Partial, TexelsNoViewShowsAreFilledFromTheirSurroundings) {
  HiddenGround g({{{3, 3.2, 5, 4.8}}, {{2.8, 3, 5.2, 5}}});
  const TextureAtlas atlas = g.s.build(AtlasOptions{});
  double worst = 0;
  for (double x = 3.2; x < 4.8; x += 0.05)
    for (double y = 3.3; y < 4.7; y += 0.05)
      worst = std::max(worst, error(g.texture_at(atlas, {x, y, 0}), ground(x, y)));
  EXPECT_LE(worst, 30.0);
  EXPECT_GT(worst, 0.0);
}

/// A flat face behind a mast, in photos of a megapixel: each takes two bits for every pixel, in rows of
/// 16 words, while sources are chosen.
TEST(Partial, ClearancesCountWhileSourcesAreChosen) {
  Chart chart;
  chart.faces = {1};
  visibility::CoverageTable table;
  const auto add_views = [&](std::uint32_t end) {
    for (std::uint32_t face = 0; face < 3; ++face)
      for (std::uint32_t view = 0; view < end; ++view)
        table.entries.push_back({FaceId{face}, ViewId{view}, 0, 0, 1000, 1000, 990000, 0.99f, 0});
  };
  const auto bytes = [&](int margin_px) { return choosing_bytes(chart, CoverageIndex(table), margin_px); };
  constexpr std::size_t kOfView = 2 * 1000 * 16 * sizeof(std::uint64_t);
  const std::size_t without = bytes(3);
  add_views(8);
  EXPECT_EQ(bytes(3), without + 8 * kOfView) << "those of other faces do not count";
  EXPECT_EQ(bytes(0), without) << "without a margin nothing is looked for";
  table.entries.clear();
  add_views(100);
  EXPECT_EQ(bytes(3), without + 64 * kOfView) << "as many views as are looked at";
}

/// Coverage of every other pixel: a place that is decided by another pixel than its own mostly has another sight.
TEST(Partial, InnerPartsOfRowsHaveTheSightThatIsFoundForEachPlace) {
  visibility::CoverageTable table;
  table.entries.push_back({FaceId{0}, ViewId{0}, 100, 50, 63, 40, 1260, 0.5f, 0});
  table.words.assign(63 * 40 / 64 + 1, 0x5555555555555555u);
  for (const bool mirrored : {false, true}) {
    TexelSource source{0, ViewId{0}, &table.entries[0], {{1.1, 0.2, 95, -0.1, 0.9, 52, 1e-4, 2e-4, 1}}, {}, {}};
    source.outline = TexelTriangle{{{3.3, 2.1}, {60.7, 9.4}, {21.5, 38.2}}};
    if (mirrored) std::swap((*source.outline)[0], (*source.outline)[1]);
    int inner = 0, shown = 0;
    for (double y = -5.3; y < 60; y += 0.37) {
      const InnerRow row = inner_row(source, y);
      for (double x = -5.1; x < 80; x += 0.29) {
        const Sight sight = sight_at(source, table, x, y);
        ASSERT_EQ(sight_at(source, table, row, x, y), sight) << x << ", " << y;
        inner += row.has(x);
        shown += sight != Sight::hidden;
      }
    }
    EXPECT_GT(inner, 5000);
    EXPECT_GT(shown, 2500);
    source.outline.reset();
    EXPECT_FALSE(inner_row(source, 10.5).has(20.5)) << "a corner lies behind the camera";
  }
}

TEST(Partial, WithoutAnyCoverageFacesTakeTheirNeighboursColors) {
  HiddenGround g(std::vector<std::vector<HiddenGround::Box>>(1));
  g.s.coverage = {};
  // A second square to the right that the view sees whole.
  g.s.mesh.positions.push_back({10, 0, 0});
  g.s.mesh.positions.push_back({10, 8, 0});
  g.s.mesh.faces.push_back({1, 4, 5});
  g.s.mesh.faces.push_back({1, 5, 3});
  g.s.labels.assign(4, ViewId{0});
  g.s.tags = {labeling::FaceTag::partial, labeling::FaceTag::partial, labeling::FaceTag::seen, labeling::FaceTag::seen};
  g.s.candidates.first.assign(5, 0);
  const TextureAtlas atlas = g.s.build(AtlasOptions{});
  const Color c = g.texture_at(atlas, {6, 3, 0});
  EXPECT_NEAR(c.r, 130, 12);  // the ground at the shared border, x = 8
  EXPECT_NEAR(c.b, 60, 5);
}

TEST(Partial, ExposureIsLevelledWithinAFace) {
  HiddenGround g({{{3, 1, 5, 3}}, {{1, 5, 3, 7}}});
  // A strip of faces to the left, labelled with the second view, makes a seam from which both gains follow.
  g.s.mesh.positions.push_back({-1, 0, 0});
  g.s.mesh.positions.push_back({-1, 8, 0});
  g.s.mesh.faces.push_back({0, 2, 5});
  g.s.mesh.faces.push_back({0, 5, 4});
  g.s.labels = {ViewId{0}, ViewId{0}, ViewId{1}, ViewId{1}};
  g.s.tags = {labeling::FaceTag::partial, labeling::FaceTag::partial, labeling::FaceTag::seen, labeling::FaceTag::seen};
  g.s.candidates.first.resize(3);
  g.s.candidates.first.push_back(g.s.candidates.first.back());
  g.s.candidates.first.push_back(g.s.candidates.first.back());
  g.s.photograph(1, ground, [&](int x, int y, Color c) { return 1.3f * (g.is_hidden(1, x, y) ? kOccluder : c); });
  AtlasOptions options;
  options.seams = SeamLeveling::full;
  const TextureAtlas atlas = g.s.build(options);
  // The brightness is the same inside the patch from view 1 and just outside it, where view 0 gives the colour.
  const double inside = g.texture_at(atlas, {4.9, 2, 0}).r / ground(4.9, 2).r;
  const double outside = g.texture_at(atlas, {5.4, 2, 0}).r / ground(5.4, 2).r;
  EXPECT_NEAR(inside / outside, 1.0, 0.03);
}

}  // namespace
}  // namespace gpvc::atlas
