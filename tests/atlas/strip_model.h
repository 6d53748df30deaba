// A small textured mesh for tests of the writers.
#pragma once

#include "io/textured_model.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::test {

// Two pages on a strip of four triangles at UTM size; face 3 has no area, vertex 2 has two texture
// coordinates on page 1 and its own on page 0.
//   1---3---5      0: 0 2 1 on page 1     2: 2 4 3 on page 1
//   | \ | \ |      1: 2 3 1 on page 0     3: 4 4 5 on page 1
//   0---2---4
struct StripModel {
  StripModel() {
    for (int i = 0; i < 6; ++i) mesh.positions.push_back({500000 + i / 2 + 0.1, 5400000.3 + i % 2, 1.0 / 3 + i});
    mesh.faces = {{0, 2, 1}, {2, 3, 1}, {2, 4, 3}, {4, 4, 5}};
    model.mesh = &mesh;
    model.texcoords = {{0, 0}, {0.25f, 0}, {0, 0.125f}, {0.5f, 0.5f}, {0.75f, 0.5f}, {0.1f, 0.9f}, {1, 1}};
    model.face_texcoords = {{0, 1, 2}, {3, 4, 5}, {6, 3, 4}, {3, 3, 6}};
    model.face_page = {1, 0, 1, 1};
    Image page{5, 3, 3, std::vector<std::uint8_t>(45)};
    for (std::size_t i = 0; i < 45; ++i) page.pixels[i] = static_cast<std::uint8_t>(5 * i);
    pages = {{folder.path() / "model_0.png", io::ImageFormat::png},
             {folder.path() / "model_1.jpg", io::ImageFormat::jpg}};
    for (const io::PageFile& file : pages) io::write_image(file.file, page, file.format, 90);
  }
  TemporaryFolder folder;
  Mesh mesh;
  io::TexturedModel model;
  std::vector<io::PageFile> pages;
};

/// A GLB under this name; returns the input faces of its triangles.
inline std::vector<FaceId> write_glb(const std::filesystem::path& file, const io::TexturedModel& model,
                                     std::span<const io::PageFile> pages, const io::ModelOptions& options) {
  std::filesystem::path stem = file;
  return io::write_gltf(stem.replace_extension(), io::GltfContainer::glb, model, pages, options).faces;
}

}  // namespace gpvc::test
