// Parts of a mesh textured one after the other, each with a border of faces that only leveling uses.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

Color waves(double x, double y) {
  return {static_cast<float>(110 + 30 * std::sin(2 * x) * std::cos(1.7 * y)),
          static_cast<float>(100 + 20 * std::cos(1.3 * x + y)), static_cast<float>(80 + 2 * x + 3 * y)};
}

/// A plane of 20 x 8 m, cut into a left and a right part at x = 10. Below y = 4 the cut is a seam between views 1 and 2,
/// above it runs through faces of view 1. Photos differ by gains, and by stripes that gains do not explain.
struct CutPlane {
  static constexpr double kCut = 10;
  AtlasScene s;
  std::vector<bool> left;      ///< per face
  std::vector<double> middle;  ///< per face, x of its centroid

  CutPlane() {
    s.add_plane(40, 16, 0.5);
    constexpr double kGains[] = {1.25, 0.8, 1.15, 0.9};
    for (std::size_t v = 0; v < 4; ++v) {
      s.add_view(2.5 + 5 * double(v), 4, 10, 1200, 400, 300);
      s.photograph(v, waves, [v, gain = static_cast<float>(kGains[v])](int, int y, Color c) {
        const float stripe = static_cast<float>(6 * std::sin(0.06 * y + 2 * double(v)));
        return gain * c + Color{stripe, stripe, stripe};
      });
    }
    for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
      const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
      left.push_back(p.x < kCut);
      middle.push_back(p.x);
      s.labels[f] = ViewId{p.y > 4 && p.x > kCut && p.x < 12 ? 1u : static_cast<std::uint32_t>(p.x / 5)};
    }
  }

  /// The left or the right part with a border of this width.
  TextureAtlas build_part(bool which, double width, const AtlasOptions& options = {}) {
    std::vector<ViewId> labels = s.labels;
    std::vector<labeling::FaceTag> tags = s.tags;
    s.border.assign(labels.size(), 0);
    for (std::size_t f = 0; f < labels.size(); ++f) {
      if (left[f] == which) continue;
      s.border[f] = 1;
      if (std::abs(middle[f] - kCut) > width) s.leave_unseen(f);
    }
    TextureAtlas atlas = s.build(options);
    s.labels = std::move(labels);
    s.tags = std::move(tags);
    s.border.clear();
    return atlas;
  }

  /// Largest difference of colours across the cut, at the middles of its edges, in grey levels.
  double largest_step(const TextureAtlas& of_left, const TextureAtlas& of_right) const {
    double largest = 0;
    for (const auto& [f, g] : s.graph.edges) {
      if (left[f] == left[g] || s.tags[f] != labeling::FaceTag::seen || s.tags[g] != labeling::FaceTag::seen) continue;
      const auto color = [&](std::uint32_t face, std::uint32_t other) {
        const TextureAtlas& atlas = left[face] ? of_left : of_right;
        const Triangle& t = s.mesh.faces[other];
        const auto weight = [&](std::size_t i) {
          return std::find(t.begin(), t.end(), s.mesh.faces[face][i]) != t.end() ? 0.5 : 0.0;
        };
        return lookup(atlas.pages.at(atlas.model.face_page[face]),
                      texcoord_at(atlas.model, face, weight(0), weight(1)));
      };
      const Color d = color(f, g) - color(g, f);
      largest = std::max<double>(largest, std::max({std::abs(d.r), std::abs(d.g), std::abs(d.b)}));
    }
    return largest;
  }

  std::vector<ViewExposure> exposure_of_the_whole() {
    s.graph = labeling::face_graph(s.mesh);
    s.candidates.first.assign(s.mesh.faces.size() + 1, 0);
    io::PhotoCache photos(s.scene, std::size_t{1} << 28);
    return fit_exposure({s.mesh, s.scene, photos, s.graph, s.labels, s.tags, s.candidates, s.coverage});
  }
};

/// Grey levels by which a step between two runs may exceed that within one: rounding on both sides, and the relative
/// residual to which offsets are solved.
constexpr double kRounding = 1.5;

TEST(Border, PartsMeetAsInTheWhole) {
  CutPlane p;
  const TextureAtlas whole = p.s.build({});
  const double step = p.largest_step(whole, whole);
  const TextureAtlas left = p.build_part(true, 20), right = p.build_part(false, 20);
  EXPECT_LT(p.largest_step(left, right), step + kRounding);
  EXPECT_NEAR(left.statistics.seam_step_after, whole.statistics.seam_step_after, 0.1);
  // Without a border the two runs do not level the cut.
  EXPECT_GT(p.largest_step(p.build_part(true, 0), p.build_part(false, 0)), step + 8);
}

TEST(Border, HasNoTexels) {
  CutPlane p;
  const TextureAtlas whole = p.s.build({});
  const TextureAtlas part = p.build_part(true, 20);
  for (std::size_t f = 0; f < p.left.size(); ++f) EXPECT_EQ(part.model.face_page[f] == io::kNoPage, !p.left[f]) << f;
  EXPECT_LT(part.model.texcoords.size(), 0.6 * static_cast<double>(whole.model.texcoords.size()));
  EXPECT_LT(part.statistics.padded_texels, 0.6 * static_cast<double>(whole.statistics.padded_texels));
  EXPECT_EQ(part.statistics.charts, 2u);
}

/// A border of 8 edges and the exposure of the whole make up for the rest of the mesh, except for what far seams add to
/// the offsets of the cut.
TEST(Border, NarrowBordersNeedTheExposureOfTheWhole) {
  CutPlane p;
  const double step = [&] {
    const TextureAtlas whole = p.s.build({});
    return p.largest_step(whole, whole);
  }();
  const double fitted_apart = p.largest_step(p.build_part(true, 4), p.build_part(false, 4));
  p.s.exposure = p.exposure_of_the_whole();
  const double shared = p.largest_step(p.build_part(true, 4), p.build_part(false, 4));
  EXPECT_LT(shared, step + kRounding + 1);
  EXPECT_GT(fitted_apart, shared + 8);
}

TEST(Border, ExposureOfTheWholeGivesTheSameAtlas) {
  CutPlane p;
  const TextureAtlas fitted = p.s.build({});
  p.s.exposure = p.exposure_of_the_whole();
  const TextureAtlas given = p.s.build({});
  ASSERT_EQ(given.pages.size(), fitted.pages.size());
  for (std::size_t n = 0; n < given.pages.size(); ++n) EXPECT_EQ(given.pages[n].pixels, fitted.pages[n].pixels);
}

TEST(Border, GivenExposureAppliesWithoutSeams) {
  AtlasScene s;
  s.add_plane(2, 2, 1.0);
  s.add_view(1, 1, 10, 200, 200, 500);
  s.photograph(0, [](double, double) { return Color{100, 100, 100}; });
  s.exposure.resize(1);
  s.exposure[0].gain = {1.2f, 1.0f, 0.5f};
  const TextureAtlas atlas = s.build({});
  const Color c = lookup(atlas.pages.at(0), texcoord_at(atlas.model, 0, 0.3, 0.3));
  EXPECT_EQ((std::array{c.r, c.g, c.b}), (std::array{120.0f, 100.0f, 50.0f}));
}

/// Holes and faces seen in parts that lie on the cut are filled from their own side.
TEST(Border, IsNotReadByFilling) {
  CutPlane p;
  for (std::size_t f = 0; f < p.left.size(); ++f) {
    if (std::abs(p.middle[f] - CutPlane::kCut) > 1) continue;
    if (f % 7 == 0) p.s.leave_unseen(f);
    if (f % 7 == 1) p.s.tags[f] = labeling::FaceTag::partial;
  }
  const TextureAtlas whole = p.s.build({});
  const TextureAtlas left = p.build_part(true, 20), right = p.build_part(false, 20);
  EXPECT_EQ(left.statistics.filled_faces + right.statistics.filled_faces, whole.statistics.filled_faces);
  EXPECT_LT(p.largest_step(left, right), p.largest_step(whole, whole) + kRounding);
}

TEST(Border, FacesBehindTheCameraTakePart) {
  CutPlane p;
  const std::size_t last = p.left.size() - 1;  // in the border of the left part
  for (const auto v : p.s.mesh.faces[last]) p.s.mesh.positions[v].z = 20;
  const TextureAtlas left = p.build_part(true, 20);
  EXPECT_EQ(left.model.face_page[last], io::kNoPage);
  p.s.border.assign(p.left.size(), 1);
  EXPECT_TRUE(p.s.build({}).pages.empty());
}

TEST(Border, RefusesListsOfTheWrongLength) {
  CutPlane p;
  p.s.border = {1};
  EXPECT_THROW(p.s.build({}), std::invalid_argument);
  p.s.border.clear();
  p.s.exposure.resize(3);
  EXPECT_THROW(p.s.build({}), std::invalid_argument);
}

}  // namespace
}  // namespace gpvc::atlas
