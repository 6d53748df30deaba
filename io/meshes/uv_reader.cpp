// Reads the texture coordinates of models, without their textures.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/meshes/gltf_nodes.h"
#include "io/meshes/mesh_file.h"
#include "io/meshes/obj_materials.h"
#include "io/uv_layout.h"

namespace gpvc::io {
namespace {

ImageSize size_of(const fs::path& image) {
  try {
    return read_photo_header(image).size;
  } catch (const InputError&) {
    return {};  // of the pages to be made the size alone is missed
  }
}

/// The size of the first tile stands for all of them.
std::string first_tile(std::string name) {
  constexpr std::string_view kTile = "<UDIM>";
  if (const std::size_t at = name.find(kTile); at != std::string::npos) name.replace(at, kTile.size(), "1001");
  return name;
}

StatedUv read_obj_uv(const fs::path& file) {
  const FileBytes bytes(file);
  ObjTexture texture;
  texture.states_all = true;
  Mesh mesh = read_obj(file, without_byte_order_mark(bytes.view()), &texture);
  recut_concave(mesh, texture.corners);
  StatedUv uv;
  uv.texcoords = std::move(texture.stated);
  uv.face_texcoords = std::move(texture.corners);
  uv.face_material = std::move(texture.material);
  uv.materials.resize(texture.materials.size());
  for (const auto& [name, number] : texture.materials) uv.materials[number].name = name;
  for (const ObjMaterial& material : read_materials(file, texture.libraries)) {
    const auto used = texture.materials.find(material.name);
    if (used == texture.materials.end() || material.image.empty()) continue;
    const ImageSize size = size_of(image_beside(file, first_tile(material.image)));
    uv.materials[used->second].width = size.width;
    uv.materials[used->second].height = size.height;
  }
  return uv;
}

StatedUv read_ply_uv(const fs::path& file) {
  const FileBytes bytes(file);
  const std::string_view text = without_byte_order_mark(bytes.view());
  if (!text.starts_with("ply")) throw InputError(file, "line 1", "expected 'ply'");
  PlyTexture texture;
  const Mesh mesh = read_ply(file, text, &texture);
  StatedUv uv;
  const bool has_corners = std::ranges::any_of(texture.corners, [](const auto& c) { return std::isfinite(c[0].u); });
  std::vector<std::array<double, 2>> corners(3 * mesh.faces.size(), {NAN, NAN});  // strips have none
  for (std::size_t at = 0; at < corners.size(); ++at) {
    const std::uint32_t vertex = mesh.faces[at / 3][at % 3];
    TexCoord stated{NAN, NAN};
    if (has_corners && at / 3 < texture.corners.size())
      stated = texture.corners[at / 3][at % 3];
    else if (!has_corners && vertex < texture.vertices.size())
      stated = texture.vertices[vertex];
    corners[at] = {static_cast<double>(stated.u), static_cast<double>(stated.v)};
  }
  set_corners(mesh.faces, corners, uv);
  for (const std::string& name : texture.files) {
    const fs::path image = image_beside(file, first_tile(name));
    const ImageSize size = size_of(image);
    uv.materials.push_back({image.stem().string(), size.width, size.height});
  }
  texture.page.resize(mesh.faces.size(), 0);
  for (const std::int64_t page : texture.page) {
    const bool is_known = page >= 0 && page < static_cast<std::int64_t>(uv.materials.size());
    uv.face_material.push_back(is_known ? static_cast<std::uint32_t>(page) : StatedUv::kNone);
  }
  return uv;
}

// --- glTF

ImageSize size_of(const fs::path& file, const tinygltf::Model& model, int texture) {
  if (texture < 0) return {};
  const int source = image_of(element_at(file, model.textures, texture, "texture"));
  if (source < 0) return {};
  const tinygltf::Image& image = element_at(file, model.images, source, "image");
  try {
    if (image.bufferView < 0 && image.image.empty()) return size_of(folder_of(file) / with_slashes(image.uri));
    std::string_view bytes{reinterpret_cast<const char*>(image.image.data()), image.image.size()};
    if (image.bufferView >= 0) {
      const auto [view, behind] = buffer_range(file, "image", model, image.bufferView);
      bytes = behind.substr(0, view.byteLength);
    }
    const Image decoded = decode_image(file, "image", bytes);
    return {decoded.width, decoded.height};
  } catch (const InputError&) {
    return {};
  }
}

class GltfUv {
 public:
  explicit GltfUv(const fs::path& file) : file_(file), model_(parse_gltf(file)), material_(model_.materials.size()) {
    std::ranges::fill(material_, StatedUv::kNone);
  }

  StatedUv read() {
    for_each_primitive(
        file_, model_, GltfOffset::left,
        [&](const tinygltf::Primitive& primitive, const GltfMatrix& world) { append(primitive, mirrors(world)); });
    return std::move(uv_);
  }

 private:
  void append(const tinygltf::Primitive& primitive, bool mirrored) {
    const AccessorView positions = positions_of(file_, model_, primitive);
    tinygltf::TextureInfo shown;
    if (primitive.material >= 0)
      shown = element_at(file_, model_.materials, primitive.material, "material").pbrMetallicRoughness.baseColorTexture;
    if (shown.extensions.contains("KHR_texture_transform"))
      throw InputError(file_, "material " + std::to_string(primitive.material),
                       "moves its texture by KHR_texture_transform, expected texture coordinates as they are");
    const auto texcoord = primitive.attributes.find("TEXCOORD_" + std::to_string(shown.texCoord));
    const bool has_any = texcoord != primitive.attributes.end();
    const auto base = static_cast<std::uint32_t>(uv_.texcoords.size());
    const std::uint32_t material = material_of(primitive.material, shown.index);
    for_each_triangle(
        file_, model_, primitive, positions.count, [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
          if (mirrored) std::swap(b, c);
          uv_.face_texcoords.push_back(has_any ? Triangle{base + a, base + b, base + c}
                                               : Triangle{StatedUv::kNone, StatedUv::kNone, StatedUv::kNone});
          uv_.face_material.push_back(material);
        });
    if (!has_any) return;
    const AccessorView texcoords(file_, model_, texcoord->second, TINYGLTF_TYPE_VEC2);
    if (!texcoords.is_float() && !texcoords.is_short())
      throw InputError(file_, "mesh", "expected texture coordinates of floats, or of integers of 8 or 16 bits");
    if (texcoords.count < positions.count)
      throw InputError(file_, "mesh",
                       "has " + std::to_string(texcoords.count) + " texture coordinates for " +
                           std::to_string(positions.count) + " vertices");
    for (std::size_t i = 0; i < positions.count; ++i)
      uv_.texcoords.push_back({texcoords.component(i, 0), 1 - texcoords.component(i, 1)});
  }

  std::uint32_t material_of(int number, int texture) {
    if (number < 0) return StatedUv::kNone;
    std::uint32_t& known = material_[static_cast<std::size_t>(number)];
    if (known != StatedUv::kNone) return known;
    known = static_cast<std::uint32_t>(uv_.materials.size());
    const ImageSize size = size_of(file_, model_, texture);
    uv_.materials.push_back({model_.materials[static_cast<std::size_t>(number)].name, size.width, size.height});
    return known;
  }

  const fs::path& file_;
  tinygltf::Model model_;
  std::vector<std::uint32_t> material_;  ///< per material of the file, its number among those in use
  StatedUv uv_;
};

}  // namespace

StatedUv read_uv(const fs::path& model) {
  const std::string extension = lower_case(model.extension().string());
  if (is_gltf(model)) return GltfUv(model).read();
  if (extension == ".obj") return read_obj_uv(model);
  if (extension == ".ply") return read_ply_uv(model);
  throw InputError(model, "", "expected a model with texture coordinates, .obj, .ply, .glb or .gltf");
}

}  // namespace gpvc::io
