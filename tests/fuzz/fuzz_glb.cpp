#include <fstream>
#include <iterator>
#include <span>

#include "fuzz.h"
#include "io/mesh.h"
#include "io/textured_model.h"

namespace gpvc::fuzz {
namespace {

// A GLB for the web, as our own writer makes it.
std::vector<std::string> web_seeds(const std::filesystem::path&) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
  mesh.faces = {{0, 1, 2}, {3, 2, 1}};
  const io::TexturedModel model{&mesh, {{0, 0}, {1, 0}, {0, 1}, {1, 1}}, mesh.faces, {0, 0}};
  const io::PageFile page{folder() / "page.webp", io::ImageFormat::webp, folder() / "page.jpg"};
  const Image grey{4, 4, 3, std::vector<std::uint8_t>(48, 120)};
  io::write_image(page.file, grey, io::ImageFormat::webp, 85);
  io::write_image(page.fallback, grey, io::ImageFormat::jpg, 75);
  io::ModelOptions options;
  options.normals = true;
  options.coding = io::GltfCoding::quantized;
  io::write_gltf(folder() / "seed", io::GltfContainer::glb, model, std::span(&page, 1), options);
  std::ifstream in(folder() / "seed.glb", std::ios::binary);
  return {std::string(std::istreambuf_iterator<char>(in), {})};
}

}  // namespace

GPVC_FUZZ_TARGET(glb, web_seeds) {
  const auto file = write("model.glb", view(data, size));
  const int result = reads_or_refuses([&] { io::read_textured_model(file); });
  reads_or_refuses([&] { io::read_mesh(file); });
  return result;
}

}  // namespace gpvc::fuzz
