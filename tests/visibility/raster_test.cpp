// Fill rules in pictures, spans against single pixels, and the exact predicates against integers.
#include "visibility/raster/raster.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "visibility/classify/front_faces.h"
#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

/// As for a photo of about 100 pixels.
RasterFace face_of(const ProjectedVertex& a, const ProjectedVertex& b, const ProjectedVertex& c) {
  return raster_face(a, b, c, {300, 0.01});
}

/// A vertex at pixel (x, y) and depth z.
ProjectedVertex at(double x, double y, double z = 1) { return {x * z, y * z, z}; }

/// Rows of the picture, '#' where the face covers the pixel's centre.
std::vector<std::string> picture(const RasterFace& face, int width, int height) {
  std::vector<std::string> rows(static_cast<std::size_t>(height), std::string(static_cast<std::size_t>(width), '.'));
  if (face.facing == Facing::edge_on) return rows;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (covers(face, edge_values(face, x + 0.5, y + 0.5)))
        rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = '#';
  return rows;
}

using Picture = std::vector<std::string>;

TEST(Raster, CoversTheCentresInside) {
  const RasterFace face = face_of(at(0.3, 0.2), at(0.3, 4.7), at(4.8, 4.7));
  EXPECT_EQ(face.facing, Facing::front);
  EXPECT_EQ(picture(face, 6, 6), (Picture{"#.....",  //
                                          "##....",  //
                                          "###...",  //
                                          "####..",  //
                                          "#####.",  //
                                          "......"}));
}

TEST(Raster, LeftAndTopEdgesOwnCentresOnThem) {
  // Corners on pixel centres: the left column and the top row belong, the right and the bottom do not.
  const RasterFace lower = face_of(at(1.5, 1.5), at(1.5, 4.5), at(4.5, 4.5));
  const RasterFace upper = face_of(at(1.5, 1.5), at(4.5, 4.5), at(4.5, 1.5));
  EXPECT_EQ(picture(lower, 6, 6), (Picture{"......",  //
                                           "......",  //
                                           ".#....",  //
                                           ".##...",  //
                                           "......",  //
                                           "......"}));
  EXPECT_EQ(picture(upper, 6, 6), (Picture{"......",  //
                                           ".###..",  //
                                           "..##..",  //
                                           "...#..",  //
                                           "......",  //
                                           "......"}));
}

TEST(Raster, BackFacesCoverWhatTheirFrontsCover) {
  const RasterFace front = face_of(at(0.5, 0.5), at(0.5, 5.5), at(5.5, 3.5));
  const RasterFace back = face_of(at(0.5, 0.5), at(5.5, 3.5), at(0.5, 5.5));
  EXPECT_EQ(front.facing, Facing::front);
  EXPECT_EQ(back.facing, Facing::back);
  EXPECT_EQ(picture(front, 7, 7), picture(back, 7, 7));
}

TEST(Raster, DepthDoesNotMoveTheProjection) {
  const RasterFace near = face_of(at(0.3, 0.2), at(0.3, 4.7), at(4.8, 4.7));
  const RasterFace steep = face_of(at(0.3, 0.2, 0.001), at(0.3, 4.7, 1e6), at(4.8, 4.7, 3));
  EXPECT_EQ(picture(near, 6, 6), picture(steep, 6, 6));
}

TEST(Raster, FaceAcrossTheCameraPlaneEndsAtTheHorizon) {
  // Two corners ahead, one behind the camera and mirrored to (3, 6): the part ahead widens away from there.
  const RasterFace face = face_of(at(2, 4), at(4, 4), {-3, -6, -1});
  ASSERT_NE(face.facing, Facing::edge_on);
  EXPECT_EQ(picture(face, 7, 7), (Picture{"######.",  //
                                          ".####..",  //
                                          ".####..",  //
                                          "..##...",  //
                                          ".......",  //
                                          ".......",  //
                                          "......."}));
  // Behind the camera altogether: nothing.
  const RasterFace behind = face_of({-2, -4, -1}, {-3, -6, -1}, {-5, -4, -1});
  EXPECT_TRUE(pixel_bounds(behind, {0, 0, 7, 7}).empty());
}

TEST(Raster, DegenerateFacesAreEdgeOn) {
  EXPECT_EQ(face_of(at(1, 1), at(1, 1), at(4, 2)).facing, Facing::edge_on);
  EXPECT_EQ(face_of(at(1, 1), at(2, 2), at(3, 3)).facing, Facing::edge_on);
  EXPECT_EQ(face_of(at(0.1, 0.1), at(0.2, 0.2), at(0.3, 0.3)).facing, Facing::edge_on);
  // A plane through the eye.
  EXPECT_EQ(face_of({1, 2, 3}, {2, 4, 6.5}, {1, 2, 9}).facing, Facing::edge_on);
}

TEST(Raster, EveryCentreAroundAVertexBelongsToOneFaceOfItsFan) {
  std::mt19937 random(3);
  const auto pick = [&](int count) { return static_cast<double>(random() % static_cast<unsigned>(count)); };
  for (int trial = 0; trial < 500; ++trial) {
    // Six corners around a vertex, all on pixel centres or corners.
    const ProjectedVertex hub = at(8.5 + pick(2) / 2, 8.5 + pick(2) / 2);
    std::vector<ProjectedVertex> rim;
    for (const auto& [x, y] :
         std::vector<std::pair<double, double>>{{3, 0}, {2, 3}, {-2, 3}, {-3, 0}, {-2, -3}, {2, -3}})
      rim.push_back(at(8.5 + x + pick(2) / 2, 8.5 + y + pick(2) / 2));
    std::vector<std::vector<int>> owners(18, std::vector<int>(18, 0));
    for (std::size_t i = 0; i < rim.size(); ++i) {
      const RasterFace face = face_of(hub, rim[(i + 1) % rim.size()], rim[i]);
      for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 18; ++x) {
          const bool covered = covers(face, edge_values(face, x + 0.5, y + 0.5));
          owners[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] += covered;
          EXPECT_EQ(covered, covers_exactly(face_point(face, x + 0.5, y + 0.5)));
        }
    }
    for (int y = 7; y <= 9; ++y)
      for (int x = 7; x <= 9; ++x)
        EXPECT_EQ(owners[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)], 1) << x << ", " << y;
    for (const auto& row : owners)
      for (const int count : row) EXPECT_LE(count, 1);
  }
}

TEST(SpanWalker, FindsThePixelsThatSingleTestsFind) {
  std::mt19937 random(17);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const PixelBox frame{0, 0, 40, 30};
  std::size_t pixels = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::array<ProjectedVertex, 3> v;
    for (ProjectedVertex& p : v) {
      p = at(uniform(-20, 60), uniform(-20, 50), uniform(0.5, 20));
      if (trial % 2 == 0) p = at(std::round(p.u / p.z * 2) / 2, std::round(p.v / p.z * 2) / 2, 4);
      if (trial % 5 == 0 && random() % 3 == 0) p.z = -p.z;
      if (trial % 7 == 0) p = at(p.u / p.z, 12.5 + 1e-13 * uniform(-1, 1), p.z);
    }
    const RasterFace face = face_of(v[0], v[1], v[2]);
    if (face.facing == Facing::edge_on) continue;
    for (const bool exact : {false, true}) {
      std::vector<Span> spans;
      collect_spans(face, SpanWalker(face, pixel_bounds(face, frame)), exact, spans);
      std::vector<std::string> rows(30, std::string(40, '.'));
      for (const Span& span : spans)
        for (int x = span.x0; x < span.x1; ++x)
          rows[static_cast<std::size_t>(span.y)][static_cast<std::size_t>(x)] = '#';
      Picture expected(30, std::string(40, '.'));
      for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x)
          if (exact ? covers_exactly(face_point(face, x + 0.5, y + 0.5))
                    : covers(face, edge_values(face, x + 0.5, y + 0.5))) {
            expected[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = '#';
            ++pixels;
          }
      ASSERT_EQ(rows, expected) << "trial " << trial;
    }
  }
  EXPECT_GT(pixels, 100000U);
}

TEST(SpanWalker, InnerPixelsAreThoseNoEdgeCrosses) {
  std::mt19937 random(23);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (int trial = 0; trial < 1000; ++trial) {
    const RasterFace face = face_of(at(uniform(0, 40), uniform(0, 30)), at(uniform(0, 40), uniform(0, 30)),
                                    at(uniform(0, 40), uniform(0, 30)));
    if (face.facing == Facing::edge_on) continue;
    const SpanWalker walker(face, pixel_bounds(face, {0, 0, 40, 30}));
    std::vector<Span> spans;
    collect_spans(face, walker, true, spans);
    for (const Span& span : spans) {
      const std::optional<Span> inner = walker.inner_run(span.y);
      if (!inner) continue;
      for (std::int32_t x = span.x0; x < span.x1; ++x)
        EXPECT_EQ(crossed_by_edge(face, edge_values(face, x + 0.5, span.y + 0.5)), x < inner->x0 || x >= inner->x1);
    }
  }
}

// --- exact predicates

/// True when a triangle of integer pixel corners (at depth 1) covers the centre of pixel (0, 0), in integers.
bool covers_in_integers(std::array<std::array<std::int64_t, 2>, 3> v) {
  using Wide = __int128;
  const auto x = [&](std::size_t k) { return 2 * Wide{v[k][0]} - 1; };
  const auto y = [&](std::size_t k) { return 2 * Wide{v[k][1]} - 1; };
  const auto cross = [&](std::size_t i, std::size_t j) { return x(j) * y(i) - x(i) * y(j); };
  if (cross(0, 1) + cross(1, 2) + cross(2, 0) < 0) std::swap(v[1], v[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Wide side = cross(i, j);
    if (side < 0) return false;
    if (side > 0) continue;
    // Left edges run down, top edges run left (front faces, y down).
    const bool left = v[j][1] > v[i][1], top = v[j][1] == v[i][1] && v[j][0] < v[i][0];
    if (!left && !top) return false;
  }
  return true;
}

TEST(Exact, EdgesThatMissACentreByTheSmallestStep) {
  // Edges of length up to 2^50 through the centre (1/2, 1/2), and through its neighbours on the integer grid: they miss
  // it by less than 2^-50 px.
  std::mt19937_64 random(41);
  std::size_t covered = 0, on_edge = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const int bits = 4 + static_cast<int>(random() % 46);
    const auto coordinate = [&] {
      return static_cast<std::int64_t>(random() % (std::uint64_t{1} << bits)) - (std::int64_t{1} << (bits - 1));
    };
    const std::int64_t x = coordinate(), y = coordinate();
    // The mirror image of (x, y) in the centre, nudged.
    const std::int64_t nudge_x = static_cast<std::int64_t>(random() % 3) - 1;
    const std::int64_t nudge_y = static_cast<std::int64_t>(random() % 3) - 1;
    const std::array<std::array<std::int64_t, 2>, 3> v{
        {{x, y}, {1 - x + nudge_x, 1 - y + nudge_y}, {coordinate(), coordinate()}}};
    const auto vertex = [&](std::size_t k) {
      return ProjectedVertex{static_cast<double>(v[k][0]), static_cast<double>(v[k][1]), 1};
    };
    const RasterFace face = face_of(vertex(0), vertex(1), vertex(2));
    if (face.facing == Facing::edge_on) continue;
    const bool expected = covers_in_integers(v);
    ASSERT_EQ(covers_exactly(face_point(face, 0.5, 0.5)), expected) << "trial " << trial;
    covered += expected;
    on_edge += nudge_x == 0 && nudge_y == 0;
  }
  EXPECT_GT(covered, 500U);
  EXPECT_GT(on_edge, 100U);
}

TEST(Exact, DepthOrderOfPlanesOneBitApart) {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (int trial = 0; trial < 300; ++trial) {
    std::array<ProjectedVertex, 3> v{at(-3, -2, uniform(5, 9)), at(-1, 6, uniform(5, 9)), at(7, 1, uniform(5, 9))};
    const RasterFace f = face_of(v[0], v[1], v[2]);
    const FacePoint here = face_point(f, 1.5, 1.5);
    ASSERT_TRUE(covers_exactly(here));
    EXPECT_EQ(compare_depth_exactly(here, here), 0);
    // Corners in another order, which rounds differently.
    const RasterFace turned = face_of(v[2], v[0], v[1]);
    EXPECT_EQ(compare_depth_exactly(here, face_point(turned, 1.5, 1.5)), 0);
    // All corners the same few bits further: the same projection, a plane that is farther by as many.
    const double factor = 1 + 0x1p-52 * static_cast<double>(1 + random() % 3);
    for (ProjectedVertex& p : v)
      p = {std::ldexp(std::round(std::ldexp(p.u, 20)), -20) * factor,
           std::ldexp(std::round(std::ldexp(p.v, 20)), -20) * factor,
           std::ldexp(std::round(std::ldexp(p.z, 20)), -20) * factor};
    std::array<ProjectedVertex, 3> w = v;
    for (ProjectedVertex& p : w) p = {p.u / factor, p.v / factor, p.z / factor};
    const RasterFace farther = face_of(v[0], v[1], v[2]), nearer = face_of(w[0], w[1], w[2]);
    EXPECT_GT(compare_depth_exactly(face_point(farther, 1.5, 1.5), face_point(nearer, 1.5, 1.5)), 0) << trial;
    EXPECT_LT(compare_depth_exactly(face_point(nearer, 1.5, 1.5), face_point(farther, 1.5, 1.5)), 0) << trial;
  }
}

TEST(Exact, CoplanarTrianglesTieWherever) {
  // All in the plane z = 2 + u / 4 of the homogeneous pixel coordinates, exactly representable.
  std::mt19937 random(9);
  const auto corner = [&] {
    const double x = static_cast<double>(random() % 64) - 32, y = static_cast<double>(random() % 64) - 32;
    return ProjectedVertex{x, y, 16 + x / 4};
  };
  std::size_t compared = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const RasterFace f = face_of(corner(), corner(), corner()), g = face_of(corner(), corner(), corner());
    if (f.facing == Facing::edge_on || g.facing == Facing::edge_on) continue;
    for (const double x : {-0.5, 0.5}) {
      const FacePoint a = face_point(f, x, 0.5), b = face_point(g, x, 0.5);
      if (!covers_exactly(a) || !covers_exactly(b)) continue;
      EXPECT_EQ(compare_depth_exactly(a, b), 0);
      ++compared;
    }
  }
  EXPECT_GT(compared, 50U);
}

TEST(Raster, FacesThatCrossTheCameraPlaneBesideTheFrameMissIt) {
  const Camera camera{100, 80, 100, 100, 50, 40, {}};
  std::mt19937 random(8);
  std::uniform_real_distribution<double> anywhere(-300, 300), depth(-3, 5);
  int missing = 0, crossing = 0;
  for (int n = 0; n < 4000; ++n) {
    const auto corner = [&] { return ProjectedVertex{anywhere(random), anywhere(random), depth(random)}; };
    const RasterFace face = face_of(corner(), corner(), corner());
    if (face.facing == Facing::edge_on) continue;
    const bool crosses = std::any_of(face.vertex.begin(), face.vertex.end(), [](const auto& v) { return v.z <= 0; });
    if (!misses_frame(camera, face.vertex)) continue;
    missing += crosses ? 0 : 1;
    crossing += crosses ? 1 : 0;
    for (int y = 0; y <= camera.height; y += 8)
      for (int x = 0; x <= camera.width; x += 5) ASSERT_FALSE(covers_exactly(face_point(face, x, y))) << n;
  }
  EXPECT_GT(missing, 200);
  EXPECT_GT(crossing, 400);
}

}  // namespace
}  // namespace gpvc::visibility
