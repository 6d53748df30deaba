// Which file is the mask of which photo, by their names.
#include <gtest/gtest.h>

#include "io/scene_files.h"
#include "tests/support/scene_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;

/// A COLMAP scene of photos of 70 x 50, as are all masks.
class MaskNames : public testing::Test {
 protected:
  std::filesystem::path place(const std::string& name) const { return folder_.path() / name; }
  void picture(const std::string& name) const { test::write_photo(place(name), 70, 50); }
  void photos(const std::vector<std::string>& names) const {
    folder_.write("sparse/cameras.txt", "1 PINHOLE 70 50 60 60 35 25\n");
    std::string images;
    for (const std::string& name : names) {
      images += std::to_string(images.size() + 1) + " 1 0 0 0 0 0 0 1 " + name + "\n\n";
      picture("images/" + name);
    }
    folder_.write("sparse/images.txt", images);
  }
  Scene scene(const SceneOptions& options = {}) const { return read_scene(place("sparse"), options); }
  test::TemporaryFolder folder_;
};

TEST_F(MaskNames, OfOpenDroneMapAndMetashapeEndInMask) {
  photos({"DJI_0018.JPG", "DJI_0019.JPG"});
  picture("images/DJI_0018_mask.JPG");
  picture("images/DJI_0019_mask.png");
  const Scene beside = scene();
  EXPECT_EQ(beside.views[0].mask, place("images/DJI_0018_mask.JPG"));
  EXPECT_EQ(beside.views[1].mask, place("images/DJI_0019_mask.png"));
  picture("masks/DJI_0018_mask.png");
  SceneOptions options;
  options.masks_dir = place("masks");
  EXPECT_EQ(scene(options).views[0].mask, place("masks/DJI_0018_mask.png"));
  EXPECT_TRUE(scene(options).views[1].mask.empty());
}

TEST_F(MaskNames, OfOtherPhotosAreNone) {
  photos({"X.jpg", "X_mask.jpg"});
  for (const View& view : scene().views) EXPECT_TRUE(view.mask.empty()) << view.name;
  picture("images/X_mask.png");
  EXPECT_EQ(scene().views[0].mask, place("images/X_mask.png"));
  SceneOptions options;
  options.masks_dir = place("images");
  std::filesystem::remove(place("images/X_mask.png"));
  EXPECT_TRUE(contains(input_error([&] { scene(options); }), "holds no mask of any photo"));
}

TEST_F(MaskNames, ThatFitPhotosOfSeveralFoldersAreRefused) {
  photos({"flight1/DJI_0001.JPG", "flight2/DJI_0001.JPG"});
  picture("masks/DJI_0001.png");
  SceneOptions options;
  options.masks_dir = place("masks");
  EXPECT_TRUE(contains(input_error([&] { scene(options); }),
                       "masks/DJI_0001.png: could be the mask of 'flight1/DJI_0001.JPG' or of 'flight2/DJI_0001.JPG': "
                       "expected masks in folders like the photos'"));
  picture("masks/flight1/DJI_0001.png");
  picture("masks/flight2/DJI_0001_mask.png");
  const Scene apart = scene(options);
  EXPECT_EQ(apart.views[0].mask, place("masks/flight1/DJI_0001.png"));
  EXPECT_EQ(apart.views[1].mask, place("masks/flight2/DJI_0001_mask.png"));
}

// transforms.json states masks: one of them, by its path, may be that of all photos, two of one name may not.
TEST_F(MaskNames, StatedForManyPhotosAreOne) {
  const auto state = [&](const std::string& first, const std::string& second) {
    const auto frame = [](const std::string& photo, const std::string& mask) {
      return R"({"file_path":")" + photo + R"(","mask_path":")" + mask +
             R"(","transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
    };
    return folder_.write("t/transforms.json", R"({"w":70,"h":50,"fl_x":60,"fl_y":60,"cx":35,"cy":25,"frames":[)" +
                                                  frame("a/one.jpg", first) + "," + frame("b/two.jpg", second) + "]}");
  };
  picture("t/a/one.jpg");
  picture("t/b/two.jpg");
  picture("masks/all.png");
  SceneOptions options;
  options.masks_dir = place("masks");
  for (const View& view : read_scene(state("m/all.png", "m/all.png"), options).views)
    EXPECT_EQ(view.mask, place("masks/all.png"));
  const auto two = state("m/all.png", "n/all.png");
  EXPECT_TRUE(contains(input_error([&] { read_scene(two, options); }), "masks/all.png: could be the mask of "));
}

}  // namespace
}  // namespace gpvc::io
