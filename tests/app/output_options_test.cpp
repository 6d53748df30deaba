// gpvc texture on the small scene: masks end to end, and what the output options promise.
#include <gtest/gtest.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "io/mesh.h"
#include "io/textured_model.h"
#include "tests/support/temporary_folder.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::read_file;
using test::TemporaryFolder;

class OutputOptions : public testing::Test {
 protected:
  void SetUp() override {
    if (visibility::list_devices().empty()) GTEST_SKIP() << "no EGL device makes an OpenGL 4.5 context here";
    ASSERT_TRUE(fs::exists(fs::path(GPVC_APP_SCENE) / "run.json")) << "ctest makes the scene: app_scene.synth";
    fs::copy(GPVC_APP_SCENE, scene_, fs::copy_options::recursive);
  }
  /// Exit code of gpvc; what it says goes to said_.
  int gpvc(const std::string& words) {
    const fs::path out = folder_.path() / "said";
    const int status =
        std::system(("'" GPVC_BINARY "' " + words + " > '" + out.string() + "' 2>&1 < /dev/null").c_str());
    said_ = read_file(out);
    return WEXITSTATUS(status);
  }
  int texture(const std::string& more, const std::string& name = "out") {
    out_ = folder_.path() / name;
    return gpvc("texture '" + (scene_ / "colmap").string() + "' '" + (scene_ / "mesh.ply").string() + "' -o '" +
                out_.string() + "' " + more);
  }
  nlohmann::json run_json() const { return nlohmann::json::parse(read_file(out_ / "run.json")); }

  /// Texels of a colour that the city does not have.
  std::size_t magenta_texels() const {
    std::size_t count = 0;
    for (int page = 0; fs::exists(out_ / ("model_" + std::to_string(page) + ".png")); ++page) {
      const Image image = io::read_image(out_ / ("model_" + std::to_string(page) + ".png"));
      for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
        const int r = image.pixels[i], g = image.pixels[i + 1], b = image.pixels[i + 2];
        count += r > g + 60 && b > g + 60 ? 1 : 0;
      }
    }
    return count;
  }
  static bool in_disc(int x, int y) { return std::hypot(x + 0.5 - 110, y + 0.5 - 85) < 22; }
  fs::path photo() const { return scene_ / "images" / "east_001.jpg"; }
  Image spoilt_photo() const {
    Image image = io::read_image(photo());
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (in_disc(x, y)) std::copy_n(std::array<std::uint8_t, 3>{255, 0, 255}.data(), 3, image.at(x, y));
    return image;
  }

  void mask_disc(const Image& image) const {
    Image mask{image.width, image.height, 1, std::vector<std::uint8_t>(image.pixels.size() / 3, 255)};
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if (in_disc(x, y)) *mask.at(x, y) = 0;
    io::write_image(photo().string() + ".mask.png", mask, io::ImageFormat::png, 0);
  }

  TemporaryFolder folder_;
  fs::path scene_ = folder_.path() / "a scene", out_;
  std::string said_;
};

constexpr const char* kOneView = "--texture png --outliers none --views east_001.jpg ";

TEST_F(OutputOptions, MaskedDiscLeavesNoTrace) {
  Image image = spoilt_photo();
  io::write_image(photo(), image, io::ImageFormat::png, 0);  // no JPEG blocks of its own colour around the disc
  ASSERT_EQ(texture(kOneView, "plain"), 0) << said_;
  EXPECT_GT(magenta_texels(), 500u);

  mask_disc(image);
  for (const char* more : {"", "--downscale 2", "--seams none --padding 16"}) {
    ASSERT_EQ(texture(std::string(kOneView) + more + " --force", "masked"), 0) << said_;
    EXPECT_EQ(magenta_texels(), 0u) << more;
    EXPECT_EQ(run_json()["counts"]["masked_views"], 1);
  }
  EXPECT_TRUE(contains(said_, "masks: 1 of 1 photos"));
  ASSERT_EQ(texture(std::string(kOneView) + "--no-masks", "unmasked"), 0) << said_;
  EXPECT_GT(magenta_texels(), 500u);
}

TEST_F(OutputOptions, WhatAMaskCoversDoesNotMatter) {
  const auto page = [&](const Image& image) {
    io::write_image(photo(), image, io::ImageFormat::png, 0);
    EXPECT_EQ(texture("--texture png --outliers none --force", "all views"), 0) << said_;
    return read_file(out_ / "model_0.png");
  };
  const Image clean = io::read_image(photo()), spoilt = spoilt_photo();
  mask_disc(clean);
  EXPECT_TRUE(page(clean) == page(spoilt));
}

TEST_F(OutputOptions, TransparentDiscLeavesNoTrace) {
  const Image image = spoilt_photo();
  Image rgba{image.width, image.height, 4, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      rgba.pixels.insert(rgba.pixels.end(), image.at(x, y), image.at(x, y) + 3);
      rgba.pixels.push_back(in_disc(x, y) ? 0 : 255);
    }
  io::write_image(scene_ / "images" / "east_001.png", rgba, io::ImageFormat::png, 0);
  const fs::path list = scene_ / "colmap" / "images.txt";
  std::string text = read_file(list);
  text.replace(text.find("east_001.jpg"), 12, "east_001.png");
  std::ofstream(list, std::ios::binary) << text;
  ASSERT_EQ(texture("--texture png --outliers none --views east_001.png"), 0) << said_;
  EXPECT_EQ(magenta_texels(), 0u);
  ASSERT_EQ(texture("--texture png --outliers none --views east_001.png --no-masks", "unmasked"), 0) << said_;
  EXPECT_GT(magenta_texels(), 500u);
}

TEST_F(OutputOptions, MasksOfAnotherSizeAreRefused) {
  io::write_image(photo().string() + ".mask.png", {3, 2, 1, std::vector<std::uint8_t>(6, 255)}, io::ImageFormat::png,
                  0);
  EXPECT_EQ(texture(""), 1);
  EXPECT_TRUE(contains(said_, "east_001.jpg.mask.png: is 3 x 2 pixels, its photo east_001.jpg is 240 x 160"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_EQ(texture("--masks x --no-masks"), 2);
}

TEST_F(OutputOptions, MemoryLimitChangesNoByte) {
  ASSERT_EQ(texture("--page-size 256", "as much as needed"), 0) << said_;
  std::vector<std::string> before;
  const auto names = run_json()["outputs"].get<std::vector<std::string>>();
  for (const std::string& name : names) before.push_back(name == "run.json" ? "" : read_file(out_ / name));
  ASSERT_EQ(texture("--page-size 256 --memory 4Gi", "much"), 0) << said_;
  for (std::size_t n = 0; n < names.size(); ++n)
    if (names[n] != "run.json") {
      EXPECT_TRUE(read_file(out_ / names[n]) == before[n]) << names[n];
    }
  EXPECT_EQ(texture("--memory 20M", "little"), 1);
  EXPECT_TRUE(contains(
      said_,
      "of memory, and 20 MB may be used (the limit that is set); free some, or allow another amount by --memory SIZE"))
      << said_;
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_EQ(texture("--memory some", "none"), 2);
  EXPECT_TRUE(contains(said_, "'some' is no amount of memory such as 600M or 4G")) << said_;
}

TEST_F(OutputOptions, GltfWithFilesIsPromisedAndReadsBackAsTheGlb) {
  ASSERT_EQ(texture("--normals --texture png --page-size 256", "glb"), 0) << said_;
  const auto glb = io::read_textured_model(out_ / "model.glb");
  const std::string faces = read_file(out_ / "faces.npy");
  ASSERT_EQ(texture("--normals --texture png --page-size 256 --gltf files", "files"), 0) << said_;
  EXPECT_FALSE(fs::exists(out_ / "model.glb"));
  const auto promised = run_json()["outputs"].get<std::vector<std::string>>();
  for (const char* name : {"model.gltf", "model.bin"}) {
    EXPECT_TRUE(fs::exists(out_ / name));
    EXPECT_EQ(std::count(promised.begin(), promised.end(), name), 1) << name;
  }
  EXPECT_EQ(read_file(out_ / "faces.npy"), faces);
  const auto files = io::read_textured_model(out_ / "model.gltf");
  EXPECT_EQ(files.mesh.positions, glb.mesh.positions);
  EXPECT_EQ(files.mesh.faces, glb.mesh.faces);
  EXPECT_EQ(files.model.face_page, glb.model.face_page);
  ASSERT_GT(files.pages.size(), 1u);
  EXPECT_EQ(files.pages.back().pixels, glb.pages.back().pixels);
}

/// A header and one tag, as much as image files ask of a profile.
io::ColorProfile any_profile(std::uint8_t year) {
  io::ColorProfile icc(512, 0);
  for (std::size_t i = 144; i < icc.size(); ++i)
    icc[i] = static_cast<std::uint8_t>(i * i * i / 7);  // libpng wants some bytes left when deflated
  const std::string head("\0\0\2\0\0\0\0\0\4\0\0\0mntrRGB XYZ ", 24), middle("acsp", 4),
      d50("\0\0\xF6\xD6\0\1\0\0\0\0\xD3\x2D", 12);
  std::copy(head.begin(), head.end(), icc.begin());
  std::copy(middle.begin(), middle.end(), icc.begin() + 36);
  std::copy(d50.begin(), d50.end(), icc.begin() + 68);
  const std::string tag("wtpt\0\0\0\x90\0\0\1\x70", 12);
  std::copy(tag.begin(), tag.end(), icc.begin() + 132);
  icc[131] = 1;
  icc[25] = year;
  return icc;
}

TEST_F(OutputOptions, PagesKeepThePhotosProfile) {
  std::vector<fs::path> photos;
  for (const auto& entry : fs::directory_iterator(scene_ / "images")) photos.push_back(entry.path());
  std::sort(photos.begin(), photos.end());
  for (const fs::path& file : photos)
    io::write_image(file, io::read_image(file), io::ImageFormat::jpg, 95, any_profile(1));
  for (const std::string format : {"jpg", "png"}) {
    ASSERT_EQ(texture("--force --texture " + format), 0) << said_;
    EXPECT_EQ(io::read_color_profile(out_ / ("model_0." + format)), any_profile(1));
    EXPECT_EQ(io::read_color_profile(out_ / "preview.png"), any_profile(1));
    EXPECT_FALSE(contains(said_, "warning")) << said_;
    if (format == "jpg") {
      EXPECT_TRUE(contains(read_file(out_ / "model.glb"), read_file(out_ / "model_0.jpg")));
    }
  }
  io::write_image(photos[2], io::read_image(photos[2]), io::ImageFormat::jpg, 95);
  io::write_image(photos[1], io::read_image(photos[1]), io::ImageFormat::jpg, 95, any_profile(2));
  ASSERT_EQ(texture("--force"), 0) << said_;
  EXPECT_TRUE(contains(said_, "warning: 2 of " + std::to_string(photos.size()) +
                                  " photos have another colour profile than " + photos[0].filename().string() +
                                  ", whose profile the pages keep: " + photos[1].filename().string() + ", " +
                                  photos[2].filename().string()));
  EXPECT_EQ(io::read_color_profile(out_ / "model_0.jpg"), any_profile(1));
}

// The mesh of the scene, at UTM size, comes back with every digit and every face.
TEST_F(OutputOptions, ObjHoldsTheInputAndOpenMeshReadsIt) {
  ASSERT_EQ(texture("--normals"), 0) << said_;
  const Mesh input = io::read_mesh(scene_ / "mesh.ply"), output = io::read_mesh(out_ / "model.obj");
  EXPECT_EQ(output.faces, input.faces);
  EXPECT_EQ(output.positions, input.positions);
  // OpenMesh doubles vertices where surfaces touch in one; of both files alike.
  OpenMesh::PolyMesh_ArrayKernelT<> before, after;
  ASSERT_TRUE(OpenMesh::IO::read_mesh(before, (scene_ / "mesh.ply").string()));
  ASSERT_TRUE(OpenMesh::IO::read_mesh(after, (out_ / "model.obj").string()));
  EXPECT_EQ(after.n_vertices(), before.n_vertices());
  EXPECT_EQ(after.n_edges(), before.n_edges());
  EXPECT_EQ(after.n_faces(), input.faces.size());
}

}  // namespace
}  // namespace gpvc
