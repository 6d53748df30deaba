// A COLMAP model of three images and two cameras, in both of COLMAP's encodings, written here from its documentation.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/scene_folder.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::test {

struct TestCamera {
  std::uint32_t id;
  std::int32_t model;
  std::string model_name;
  std::vector<double> parameters;
};

struct TestImage {
  std::uint32_t id;
  std::array<double, 4> q;
  std::array<double, 3> t;
  std::uint32_t camera_id;
  std::string name;
};

inline constexpr int kFrameWidth = 64, kFrameHeight = 48;

/// A quarter turn about the camera's forward axis: x_camera = (-y, x, z) + t. Not normalized on purpose.
inline const std::array<double, 4> kQuarterTurn{2, 0, 0, 2};

inline const std::vector<TestCamera> kCameras{{7, 1, "PINHOLE", {50, 51, 33, 25}},
                                              {3, 4, "OPENCV", {50, 51, 33, 25, -0.1, 0.02, 0.001, -0.002}}};
inline const std::vector<TestImage> kImages{{5, {1, 0, 0, 0}, {1, 2, 3}, 7, "b/two.png"},
                                            {9, kQuarterTurn, {10, 20, 30}, 3, "a with blank.png"},
                                            {2, {0.9, 0.1, -0.2, 0.3}, {-1, 0, 0.5}, 7, "b/One.png"}};

inline std::string cameras_bin(const std::vector<TestCamera>& cameras) {
  std::string bytes = bytes_of<std::uint64_t>(cameras.size());
  for (const TestCamera& camera : cameras) {
    bytes += bytes_of(camera.id) + bytes_of(camera.model) + bytes_of<std::uint64_t>(kFrameWidth) +
             bytes_of<std::uint64_t>(kFrameHeight);
    for (const double p : camera.parameters) bytes += bytes_of(p);
  }
  return bytes;
}

inline std::string images_bin(const std::vector<TestImage>& images) {
  std::string bytes = bytes_of<std::uint64_t>(images.size());
  std::uint64_t points = 0;
  for (const TestImage& image : images) {
    bytes += bytes_of(image.id);
    for (const double q : image.q) bytes += bytes_of(q);
    for (const double t : image.t) bytes += bytes_of(t);
    bytes += bytes_of(image.camera_id) + image.name + '\0' + bytes_of(points);
    for (std::uint64_t i = 0; i < points; ++i) bytes += bytes_of(1.5) + bytes_of(2.5) + bytes_of<std::int64_t>(-1);
    points = 2 - points;
  }
  return bytes;
}

/// A blank and the number with all its digits.
inline std::string spaced(double value) {
  char text[40];
  std::snprintf(text, sizeof text, " %.17g", value);
  return text;
}

inline std::string cameras_txt(const std::vector<TestCamera>& cameras) {
  std::string text =
      "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
      "# Number of cameras: " +
      std::to_string(cameras.size()) + "\n";
  for (const TestCamera& camera : cameras) {
    text += std::to_string(camera.id) + " " + camera.model_name + " " + std::to_string(kFrameWidth) + " " +
            std::to_string(kFrameHeight);
    for (const double p : camera.parameters) text += spaced(p);
    text += "\n";
  }
  return text;
}

inline std::string images_txt(const std::vector<TestImage>& images) {
  std::string text =
      "# Image list with two lines of data per image:\n# Number of images: " + std::to_string(images.size()) +
      ", mean observations per image: 0.6\n";
  bool points = false;
  for (const TestImage& image : images) {
    text += std::to_string(image.id);
    for (const double q : image.q) text += spaced(q);
    for (const double t : image.t) text += spaced(t);
    text += " " + std::to_string(image.camera_id) + " " + image.name + "\n";
    text += points ? "1.5 2.5 -1 3.5 4.5 12\n" : "\n";
    points = !points;
  }
  return text;
}

/// FOLDER/images with the photos and FOLDER/sparse/0 with the model.
class ColmapFolder {
 public:
  explicit ColmapFolder(const std::vector<TestImage>& images = kImages) {
    for (const TestImage& image : images) photo(image.name, kFrameWidth, kFrameHeight);
  }
  void photo(const std::string& name, int width, int height) {
    write_photo(folder.path() / "images" / name, width, height);
  }
  std::filesystem::path model(bool binary, const std::vector<TestCamera>& cameras = kCameras,
                              const std::vector<TestImage>& images = kImages) {
    const std::filesystem::path where = std::filesystem::path("sparse") / "0";
    std::filesystem::remove_all(folder.path() / where);
    folder.write(where / (binary ? "cameras.bin" : "cameras.txt"),
                 binary ? cameras_bin(cameras) : cameras_txt(cameras));
    folder.write(where / (binary ? "images.bin" : "images.txt"), binary ? images_bin(images) : images_txt(images));
    return folder.path() / where;
  }
  TemporaryFolder folder;
};

}  // namespace gpvc::test
