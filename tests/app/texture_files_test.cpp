// The files of a textured model.
#include "app/pipeline/texture_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include "io/images.h"
#include "io/photos.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::pipeline {
namespace {

// A profile of RGB colours as far as anything of it is looked at.
io::ColorProfile profile_filled_with(std::uint8_t value) {
  io::ColorProfile icc(128, value);
  const std::string_view space = "RGB ", signature = "acsp";
  std::ranges::copy(space, icc.begin() + 16);
  std::ranges::copy(signature, icc.begin() + 36);
  return icc;
}

TEST(ProfileOfPhotos, IsThatOfThePhotoThatIsTexturedFrom) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "a.jpg";
  const Image picture{8, 8, 3, std::vector<std::uint8_t>(3 * 8 * 8, 100)};
  io::write_image(file, picture, io::ImageFormat::jpg, 90, profile_filled_with(1));
  Scene scene;
  scene.views.resize(1);
  scene.views[0].photo = file;
  scene.views[0].camera.width = scene.views[0].camera.height = 8;
  const Mesh mesh{};
  const std::vector<ViewId> views{ViewId{0}};
  const Input input{scene, mesh, views};
  const Settings settings;
  Observer observer;
  io::PhotoCache photos(scene);
  const pipeline::Run run{input, settings, photos, observer};
  photos.photo(views[0]);
  EXPECT_EQ(profile_of_photos(run), profile_filled_with(1));
  io::write_image(file, picture, io::ImageFormat::jpg, 90, profile_filled_with(2));
  EXPECT_TRUE(
      test::contains(test::input_error([&] { profile_of_photos(run); }), "a.jpg: has changed since it was first read"));
}

}  // namespace
}  // namespace gpvc::pipeline
