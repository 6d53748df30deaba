#include "io/tie_points.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

struct Point {
  WorldPoint position;
  std::vector<std::uint32_t> images;
};

std::string binary(const std::vector<Point>& points) {
  std::string bytes;
  bytes += test::bytes_of<std::uint64_t>(points.size());
  for (const Point& point : points) {
    bytes += test::bytes_of<std::uint64_t>(77);
    for (const double value : {point.position.x, point.position.y, point.position.z}) bytes += test::bytes_of(value);
    bytes += "rgb";
    bytes += test::bytes_of(0.5);
    bytes += test::bytes_of<std::uint64_t>(point.images.size());
    for (const std::uint32_t image : point.images) {
      bytes += test::bytes_of(image);
      bytes += test::bytes_of<std::uint32_t>(3);
    }
  }
  return bytes;
}

std::string text(const std::vector<Point>& points) {
  std::string lines = "# 3D point list\n\n";
  for (const Point& point : points) {
    lines += "77 " + std::to_string(point.position.x) + ' ' + std::to_string(point.position.y) + ' ' +
             std::to_string(point.position.z) + " 1 2 3 0.5";
    for (const std::uint32_t image : point.images) lines += ' ' + std::to_string(image) + " 3";
    lines += '\n';
  }
  return lines;
}

class TiePoints : public testing::Test {
 protected:
  // Three views beside each other, which look at points 10 m above them; COLMAP's numbers are 12, 11 and 10.
  TiePoints() {
    scene_.format = "COLMAP";
    for (std::uint32_t v = 0; v < 3; ++v) {
      View& view = scene_.views.emplace_back();
      view.number = 12 - v;
      view.pose.centre = {1.0 * v, 0, 0};
    }
  }
  std::vector<TiePoint> read(const std::string& name, const std::string& bytes, std::size_t most = 100) {
    scene_.files = {folder_.write("cameras.bin", ""), folder_.write(name, bytes)};
    return read_tie_points(scene_, most);
  }
  test::TemporaryFolder folder_;
  Scene scene_;
};

TEST_F(TiePoints, AreReadFromTextAndBinary) {
  const std::vector<Point> points{{{1, 0, 10}, {12, 11, 10}}, {{0.5, 0.25, 8}, {10, 11}}};
  for (const auto& found : {read("points3D.bin", binary(points)), read("points3D.txt", text(points)),
                            read("points3D.txt", "\xEF\xBB\xBF" + text(points))}) {
    ASSERT_EQ(found.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(found[i].position, points[i].position);
    EXPECT_EQ(found[0].a, ViewId{0});
    EXPECT_EQ(found[0].b, ViewId{2});  // the farthest
    EXPECT_EQ(found[1].a, ViewId{2});
    EXPECT_EQ(found[1].b, ViewId{1});
  }
}

TEST_F(TiePoints, ThoseOfFewerThanTwoViewsAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(read("points3D.bin", binary({{{1, 0, 10}, {12}},
                                           {{1, 0, 10}, {}},
                                           {{1, 0, 10}, {12, 99}},
                                           {{1, 0, 10}, {12, 12}},
                                           {{nan, 0, 10}, {12, 11}}}))
                  .empty());
}

TEST_F(TiePoints, AreTakenEvenlyFromTheWholeFile) {
  std::vector<Point> points;
  for (int i = 0; i < 1000; ++i) points.push_back({{1.0 * i, 0, 10}, {12, 11}});
  const std::vector<TiePoint> some = read("points3D.bin", binary(points), 60);
  ASSERT_EQ(some.size(), 60u);
  EXPECT_EQ(some[0].position.x, 0);
  for (std::size_t i = 1; i < some.size(); ++i) {
    EXPECT_GE(some[i].position.x - some[i - 1].position.x, 8);
    EXPECT_LE(some[i].position.x - some[i - 1].position.x, 32);
  }
  EXPECT_GT(some.back().position.x, 960);
  EXPECT_EQ(read("points3D.bin", binary(points), 1000).size(), 1000u);
}

TEST_F(TiePoints, BrokenFilesAreNamed) {
  const std::string bytes = binary({{{1, 0, 10}, {12, 11}}});
  const auto error = [&](const char* name, const std::string& broken) {
    return test::input_error([&] { read(name, broken); });
  };
  using test::contains;
  EXPECT_TRUE(contains(error("points3D.bin", bytes.substr(0, bytes.size() - 1)),
                       "points3D.bin: byte 59: the file ends inside the track"));
  EXPECT_TRUE(contains(error("points3D.bin", bytes.substr(0, 20)),
                       "points3D.bin: byte 16: the file ends inside the point list"));
  EXPECT_TRUE(
      contains(error("points3D.txt", "# list\n1 2 3 4 5 6 7 8 9\n"), "points3D.txt: line 2: expected POINT3D_ID"));
  EXPECT_TRUE(contains(error("points3D.txt", "1 2 3 x 5 6 7 8\n"), "points3D.txt: line 1: expected POINT3D_ID X Y Z"));
}

TEST_F(TiePoints, PhotosShowThemWhereTheImageListSays) {
  const std::vector<Point> points{{{1, 0, 10}, {12, 11}}};  // number 77
  std::string images = test::bytes_of<std::uint64_t>(1);
  images += test::bytes_of<std::uint32_t>(12) + std::string(7 * 8, '\0') + test::bytes_of<std::uint32_t>(1);
  images += std::string("a.jpg") + '\0' + test::bytes_of<std::uint64_t>(2);
  for (const std::uint64_t point : {std::uint64_t{77}, ~std::uint64_t{0}})
    images += test::bytes_of(30.5) + test::bytes_of(20.0) + test::bytes_of(point);
  scene_.views[0].reduction = 2;
  scene_.files = {folder_.write("images.bin", images), folder_.write("points3D.bin", binary(points))};
  const auto expect_one = [&] {
    const std::vector<Sighting> found = read_sightings(scene_, 100);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].view, ViewId{0});
    EXPECT_EQ(found[0].at.x, 15.25);
    EXPECT_EQ(found[0].at.y, 10);
    EXPECT_EQ(found[0].point, points[0].position);
  };
  expect_one();
  scene_.files = {folder_.write("images.txt", "# list\n12 1 0 0 0 0 0 0 1 a.jpg\n30.5 20 77 1 2 -1 5 5 -1\n"),
                  folder_.write("points3D.txt", text(points))};
  expect_one();
}

TEST_F(TiePoints, OtherScenesHaveNone) {
  const std::string bytes = binary({{{1, 0, 10}, {12, 11}}});
  EXPECT_EQ(read("points3D.bin", bytes).size(), 1u);
  EXPECT_TRUE(read("cameras.txt", bytes).empty());
  scene_.format = "OpenMVS";
  EXPECT_TRUE(read("points3D.bin", bytes).empty());
}

}  // namespace
}  // namespace gpvc::io
