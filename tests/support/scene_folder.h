// Folders with scenes and photos for tests of scene formats.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <string_view>

#include "io/images.h"
#include "io/scene.h"
#include "io/scenes/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::test {

inline void write_photo(const std::filesystem::path& file, int width, int height) {
  Image image{width, height, 3, {}};
  image.pixels.assign(static_cast<std::size_t>(3 * width * height), 100);
  std::filesystem::create_directories(file.parent_path());
  io::write_image(file, image, io::ImageFormat::png, 0);  // a PNG under any name: photos are told by content
}

inline const io::SceneFormat& format_named(std::string_view name) {
  for (const io::SceneFormat* format : io::scene_formats())
    if (format->name == name) return *format;
  throw std::logic_error("no such format");
}

inline io::SceneFile parse_as(std::string_view format, std::string_view bytes) {
  return format_named(format).parse("scene.file", bytes);
}

/// Where the photo shows the point, expected to a hundredth of a pixel at least; given here to 1e-6.
inline void expect_photo_point(const View& view, const WorldPoint& world, double x, double y) {
  const CameraPoint camera = camera_from_world(view.pose, world);
  ASSERT_GT(camera.z, 0) << view.name;
  const auto photo = photo_from_pixel(view.camera, pixel_from_camera(view.camera, camera));
  ASSERT_TRUE(photo) << view.name;
  EXPECT_NEAR(photo->x, x, 1e-6) << view.name;
  EXPECT_NEAR(photo->y, y, 1e-6) << view.name;
}

inline const View& view_named(const io::SceneFile& scene, std::string_view name) {
  for (const View& view : scene.views)
    if (view.name == name) return view;
  throw std::logic_error("no view " + std::string(name));
}

/// The camera of a panorama as a reader hands it over, of this many pixels a radian downwards.
inline Camera panorama_of(int width, int height, double down) {
  Camera camera{width, height, width / (2 * std::numbers::pi), down, width / 2.0, height / 2.0, {}};
  camera.distortion.model = LensModel::spherical;
  limit_distortion(camera);
  return camera;
}

/// Every file cut short is refused; `harmless`: bytes at the end without meaning.
inline void expect_cuts_refused(std::string_view format, const std::string& bytes, std::size_t harmless) {
  for (std::size_t size = 0; size + harmless < bytes.size(); ++size)
    EXPECT_THROW(parse_as(format, bytes.substr(0, size)), InputError) << size << " bytes";
}

/// One byte changed anywhere, three times over: views with sound cameras and poses, or an InputError in one sentence.
inline void expect_changes_survived(std::string_view format, const std::string& good) {
  std::mt19937 random(5);
  for (int round = 0; round < 3; ++round)
    for (std::size_t at = 0; at < good.size(); ++at) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(random());
      try {
        for (const View& view : parse_as(format, bytes).views) {
          ASSERT_TRUE(view.camera.fx > 0 && view.camera.fy > 0);
          ASSERT_TRUE(std::isfinite(view.camera.cx + view.camera.cy));
          ASSERT_TRUE(std::isfinite(view.pose.centre.x + view.pose.centre.y + view.pose.centre.z));
          const auto& r = view.pose.rotation;
          ASSERT_NEAR(r[0] * r[0] + r[1] * r[1] + r[2] * r[2], 1, 1e-9);
        }
      } catch (const InputError& error) {
        ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
}

}  // namespace gpvc::test
