// COLMAP's text encoding: what hands and other programs write of it, and where a file is damaged.
#include <string>

#include "io/scene_files.h"
#include "tests/io/colmap_folder.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::ColmapFolder;
using test::contains;
using test::input_error;
using test::replaced;

TEST(ColmapText, ToleratesWhatHandsWrite) {
  ColmapFolder files;
  const std::string mark = "\xEF\xBB\xBF";  // of Windows editors
  files.folder.write("sparse/0/cameras.txt", mark + "\r\n# by hand\r\n 7\tPINHOLE 64 48 50 51 33 25 \r\n");
  files.folder.write("sparse/0/images.txt",
                     mark + "1 1 0 0 0 0 0 0 7 a with blank.png \r\n" + std::string(100000, ' ') +
                         "1 2 3\r\n2 1 0 0 0 0 0 0 7 b/One.png\n\n\n3 1 0 0 0 0 0 0 7 b/two.png");
  const Scene scene = read_scene(files.folder.path(), {});
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_EQ(scene.views[0].name, "a with blank.png");
}

TEST(ColmapText, TreatsTheAnnouncedCountAsACommentThatMayBeWrong) {
  ColmapFolder files;
  const auto model = files.model(false);
  const std::string cameras = test::read_file(model / "cameras.txt"), images = test::read_file(model / "images.txt");
  files.folder.write("sparse/0/images.txt", replaced(images, "images: 3", "images: 4"));
  Scene scene = read_scene(model, {});
  EXPECT_EQ(scene.views.size(), 3);
  ASSERT_EQ(scene.warnings.size(), 1);
  EXPECT_EQ(scene.warnings[0], "images.txt announces 4 images and holds 3");
  // Both at once are a file that was cut.
  files.folder.write("sparse/0/images.txt",
                     replaced(images.substr(0, images.size() - 1), "images: 3", "images: 4") + "1.5 2.5 -1");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "the file ends inside this line"));
  files.folder.write("sparse/0/images.txt", images);
  files.folder.write("sparse/0/cameras.txt", cameras.substr(0, cameras.size() - 1));
  scene = read_scene(model, {});
  EXPECT_EQ(scene.views.size(), 3);
  ASSERT_EQ(scene.warnings.size(), 1);
  EXPECT_EQ(scene.warnings[0], "the last line of cameras.txt has no end; its last number may be cut short");
}

TEST(ColmapText, ReadsWhatOtherProgramsWrite) {
  ColmapFolder files;
  const auto model = files.model(false);
  files.folder.write("sparse/0/images.txt",
                     "1 1 0 0 0 0 0 0 7 a with blank.png\n1.5 2.5 -1.0 3.5 4.5 12e0\n# between\n"
                     "2 1 0 0 0 0 0 0 7 b\\One.png\n\n3 1 0 0 0 0 0 0 7 b/two.png\n\n");
  const Scene scene = read_scene(model, {});
  ASSERT_EQ(scene.views.size(), 3);
  EXPECT_EQ(scene.views[1].name, "b/One.png");
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(ColmapText, NoticesThatPointLinesWereLeftOut) {
  ColmapFolder files;
  const auto model = files.model(false);
  files.folder.write("sparse/0/images.txt",
                     "1 1 0 0 0 0 0 0 7 a with blank.png\n2 1 0 0 0 0 0 0 7 b/One.png\n3 1 0 0 0 0 0 0 7 b/two.png\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "images.txt: line 2: expected the points"));
  // A name that is a number ends the pose of the second photo as points would end.
  files.folder.write("sparse/0/images.txt", "1 1 0 0 0 0 0 0 7 000001\n2 1 0 0 0 0 0 0 7 000002\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "images.txt: line 2: expected the points"));
}

// Three words more than a pose has are as many as four points have.
TEST(ColmapText, NoticesThatPointLinesWereLeftOutWhereNamesHaveBlanks) {
  ColmapFolder files;
  const auto model = files.model(false);
  const std::string first = "1 1 0 0 0 0 0 0 7 a.png\n", second = "2 0.8 0.6 0 0 0.5 0 0 7 ";
  for (const char* name : {"a photo 12", "10 20 30"}) {
    files.folder.write("sparse/0/images.txt", first + second + name + "\n");
    EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "images.txt: line 2: expected the points"))
        << name;
    files.folder.write("sparse/0/images.txt", first + "\n" + second + name + "\n1.5 2.5 -1\n");
    EXPECT_EQ(read_scene(model, {.allow_missing_photos = true}).views.size(), 2u) << name;
  }
}

// The first could be the pose of a photo that is named "700 800 9", and the second could be points.
TEST(ColmapText, RefusesPointsInThePlaceOfAPose) {
  ColmapFolder files;
  const auto model = files.model(false);
  for (const char* line : {"100 200 5 300 400 -1 500 600 7 700 800 9\n", "2 1 0 0 0 0 0 0 7 10 20 30\n"}) {
    files.folder.write("sparse/0/images.txt", std::string("1 1 0 0 0 0 0 0 7 a.png\n\n") + line);
    EXPECT_TRUE(contains(input_error([&] { read_scene(model, {.allow_missing_photos = true}); }),
                         "images.txt: line 3: expected IMAGE_ID"))
        << line;
  }
}

TEST(ColmapText, SaysWhichLineIsWrong) {
  ColmapFolder files;
  const auto model = files.model(false);
  files.folder.write("sparse/0/cameras.txt", "1 PINHOLE 64 48 50 51 33\n");
  EXPECT_TRUE(
      contains(input_error([&] { read_scene(model, {}); }), "cameras.txt: line 1: expected a camera parameter"));
  files.folder.write("sparse/0/cameras.txt", "\n1 PINHOLE 64 48 50 51 33 25 0.1\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "cameras.txt: line 2: camera model PINHOLE has 4"));
  files.folder.write("sparse/0/cameras.txt", "1 PINHOLE 64 -48 50 51 33 25\n");
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "expected an image height, found '-48'"));
}

}  // namespace
}  // namespace gpvc::io
