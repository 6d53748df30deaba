// Reads textured models: OBJ + MTL of any writer, PLY with TextureFile, GLB and glTF of triangles with base colour
// textures.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <string_view>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/images/image_file.h"
#include "io/mesh.h"
#include "io/meshes/gltf_nodes.h"
#include "io/meshes/mesh_file.h"
#include "io/meshes/obj_materials.h"
#include "io/model_pages.h"
#include "io/number_text.h"
#include "io/textured_model.h"

namespace gpvc::io {
namespace {

/// Where pages go: decoded to `take`, or, with `files`, by their paths to that.
struct PageUse {
  const TakePage& take;
  std::vector<fs::path>* files = nullptr;
};

/// Pages in order of first use; several materials may share one file.
class PageList {
 public:
  PageList(const fs::path& model, const PageUse& use) : model_(model), use_(use) {}
  std::uint32_t page(const std::string& name) {
    const fs::path file = image_beside(model_, name);
    const auto [place, fresh] = pages_.try_emplace(file, static_cast<std::uint32_t>(pages_.size()));
    if (!fresh) return place->second;
    if (use_.files) {
      use_.files->push_back(file);
      return place->second;
    }
    Image image;
    try {
      image = read_image(file);
    } catch (const InputError& found) {
      throw InputError(model_, "texture", reason_of(model_, found.what()));
    }
    use_.take(place->second, std::move(image));
    return place->second;
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> all(pages_.size());
    for (const auto& [file, page] : pages_) all[page] = file;
    return all;
  }

 private:
  fs::path model_;
  const PageUse& use_;
  std::map<fs::path, std::uint32_t> pages_;
};

/// A coordinate of a texture that does not repeat at its rim, of which only what rounding left beyond it is taken.
float within_page(const fs::path& file, const std::string& place, const char* why, float coordinate) {
  constexpr float kRounding = 1e-3f;
  if (coordinate < -kRounding || coordinate > 1 + kRounding)
    throw InputError(file, place,
                     "has the texture coordinate " + general_text(static_cast<double>(coordinate)) +
                         " of a texture that does not repeat (" + why + "), expected 0 to 1");
  return std::clamp(coordinate, 0.0f, 1.0f);
}

/// Puts a face that reaches over the rim of a texture which does not repeat onto it, with corners of its own.
void clamp_face(const fs::path& file, std::size_t face, TexturedModel& model) {
  for (std::uint32_t& corner : model.face_texcoords[face]) {
    const TexCoord& at = model.texcoords[corner];
    const auto within = [&](float c) { return within_page(file, "face " + std::to_string(face), "-clamp on", c); };
    const TexCoord inside{within(at.u), within(at.v)};
    if (inside.u == at.u && inside.v == at.v) continue;
    corner = static_cast<std::uint32_t>(model.texcoords.size());
    model.texcoords.push_back(inside);
  }
}

LoadedModel read_textured_obj(const fs::path& file, const PageUse& use) {
  const FileBytes bytes(file);
  LoadedModel result;
  ObjTexture texture;
  result.mesh = read_obj(file, without_byte_order_mark(bytes.view()), &texture);
  refuse_faceless(file, result.mesh);
  recut_concave(result.mesh, texture.corners);
  PageList pages(file, use);
  std::vector<std::uint32_t> page_of_material(texture.materials.size(), kNoPage);
  std::vector<bool> clamped(texture.materials.size(), false), used(texture.materials.size(), false);
  for (const std::uint32_t material : texture.material)
    if (material < used.size()) used[material] = true;
  for (const ObjMaterial& material : read_materials(file, texture.libraries)) {
    // Libraries of materials are shared, and may name images that are not there for what this file does not use.
    const auto found = texture.materials.find(material.name);
    if (found == texture.materials.end()) continue;
    const std::uint32_t number = found->second;
    if (!used[number] || page_of_material[number] != kNoPage) continue;
    if (!material.image.empty()) page_of_material[number] = pages.page(material.image);
    clamped[number] = material.clamped;
  }
  const auto unused = static_cast<std::uint32_t>(texture.texcoords.size());
  result.model.texcoords = std::move(texture.texcoords);
  result.model.texcoords.push_back({0, 0});
  for (std::size_t f = 0; f < texture.corners.size(); ++f) {
    for (const std::uint32_t t : texture.corners[f])
      if (t != ObjTexture::kNone && t >= unused)
        throw InputError(file, "face " + std::to_string(f),
                         "refers to texture coordinate " + std::to_string(std::uint64_t{t} + 1) + ", the file has " +
                             std::to_string(unused));
    const bool textured = std::ranges::all_of(texture.corners[f], [&](std::uint32_t t) { return t < unused; });
    result.model.face_texcoords.push_back(textured ? texture.corners[f] : Triangle{unused, unused, unused});
    const bool known = textured && texture.material[f] < page_of_material.size();
    result.model.face_page.push_back(known ? page_of_material[texture.material[f]] : kNoPage);
    if (known && clamped[texture.material[f]]) clamp_face(file, f, result.model);
  }
  result.page_files = pages.files();
  result.offset = read_offset(file);
  return result;
}

LoadedModel read_textured_ply(const fs::path& file, const PageUse& use) {
  const FileBytes bytes(file);
  const std::string_view text = without_byte_order_mark(bytes.view());
  if (!text.starts_with("ply")) throw InputError(file, "line 1", "expected 'ply'");
  LoadedModel result;
  PlyTexture texture;
  result.mesh = read_ply(file, text, &texture);
  PageList pages(file, use);
  std::vector<std::uint32_t> page_of_file;
  for (const std::string& name : texture.files) page_of_file.push_back(pages.page(name));
  texture.corners.resize(result.mesh.faces.size(), {});  // strips have none
  texture.page.resize(result.mesh.faces.size(), -1);
  for (std::size_t f = 0; f < result.mesh.faces.size(); ++f) {
    const auto first = static_cast<std::uint32_t>(3 * f);
    result.model.face_texcoords.push_back({first, first + 1, first + 2});
    bool textured = texture.page[f] >= 0 && texture.page[f] < static_cast<std::int64_t>(page_of_file.size());
    for (const TexCoord& corner : texture.corners[f]) textured &= std::isfinite(corner.u) && std::isfinite(corner.v);
    for (const TexCoord& corner : texture.corners[f])
      result.model.texcoords.push_back(textured ? TexCoord{corner.u, 1 - corner.v} : TexCoord{});
    result.model.face_page.push_back(textured ? page_of_file[static_cast<std::size_t>(texture.page[f])] : kNoPage);
  }
  result.page_files = pages.files();
  return result;
}

/// The image that a texture shows, kNoPage for none.
std::uint32_t page_of(const fs::path& file, const tinygltf::Model& model, const tinygltf::TextureInfo& shown) {
  if (shown.index < 0) return kNoPage;
  if (shown.extensions.contains("KHR_texture_transform"))
    throw InputError(file, "texture " + std::to_string(shown.index),
                     "is moved by KHR_texture_transform, expected texture coordinates that need no extension");
  const int image = image_of(element_at(file, model.textures, shown.index, "texture"));
  element_at(file, model.images, image, "image");
  return static_cast<std::uint32_t>(image);
}

/// True for a texture that repeats beyond its page, as it does unless its sampler says otherwise.
bool repeats(const fs::path& file, const tinygltf::Model& model, int texture) {
  const int number = element_at(file, model.textures, texture, "texture").sampler;
  if (number < 0) return true;
  const tinygltf::Sampler& sampler = element_at(file, model.samplers, number, "sampler");
  return sampler.wrapS == TINYGLTF_TEXTURE_WRAP_REPEAT && sampler.wrapT == TINYGLTF_TEXTURE_WRAP_REPEAT;
}

void append_primitive(const fs::path& file, const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                      const GltfMatrix& world, LoadedModel& result) {
  const auto base = static_cast<std::uint32_t>(result.mesh.positions.size());
  const AccessorView positions = positions_of(file, model, primitive);
  tinygltf::TextureInfo shown;
  if (primitive.material >= 0)
    shown = element_at(file, model.materials, primitive.material, "material").pbrMetallicRoughness.baseColorTexture;
  const auto texcoord = primitive.attributes.find("TEXCOORD_" + std::to_string(shown.texCoord));
  const std::uint32_t page = texcoord != primitive.attributes.end() ? page_of(file, model, shown) : kNoPage;
  const bool mirrored = mirrors(world);
  if (!for_each_triangle(file, model, primitive, positions.count,
                         [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
                           if (mirrored) std::swap(b, c);
                           result.mesh.faces.push_back({base + a, base + b, base + c});
                           result.model.face_texcoords.push_back({base + a, base + b, base + c});
                           result.model.face_page.push_back(page);
                         }))
    return;
  for (std::size_t i = 0; i < positions.count; ++i) {
    result.mesh.positions.push_back(placed(world, positions, i));
    result.model.texcoords.push_back({0, 0});
  }
  if (page == kNoPage) return;
  const AccessorView texcoords(file, model, texcoord->second, TINYGLTF_TYPE_VEC2);
  if (!texcoords.is_float() && !texcoords.is_short())
    throw InputError(file, "mesh", "expected texture coordinates of floats, or of integers of 8 or 16 bits");
  if (texcoords.count < positions.count)
    throw InputError(file, "mesh",
                     "has " + std::to_string(texcoords.count) + " texture coordinates for " +
                         std::to_string(positions.count) + " vertices");
  const bool tiled = repeats(file, model, shown.index);
  for (std::size_t i = 0; i < positions.count; ++i) {
    const auto at = [&](std::size_t k) {
      const auto value = static_cast<float>(texcoords.component(i, k));
      return tiled || !std::isfinite(value) ? value
                                            : within_page(file, "vertex " + std::to_string(base + i), "wrapS, wrapT",
                                                          value);  // check_numbers() is next
    };
    result.model.texcoords[base + i] = {at(0), at(1)};
  }
}

std::string_view bytes_of(const fs::path& file, const tinygltf::Model& model, const tinygltf::Image& image,
                          const std::string& part) {
  if (image.bufferView < 0) {
    if (image.image.empty())
      throw InputError(file, part,
                       "cannot be read, expected " + (image.uri.empty() ? "its bytes" : "a file " + image.uri));
    return {reinterpret_cast<const char*>(image.image.data()), image.image.size()};
  }
  const auto [view, bytes] = buffer_range(file, part, model, image.bufferView);
  if (view.byteLength > bytes.size()) throw InputError(file, part, "reaches beyond its buffer");
  return bytes.substr(0, view.byteLength);
}

/// Decodes only the images that faces show; face_page becomes their index among the pages.
void add_pages(const fs::path& file, const tinygltf::Model& model, LoadedModel& result, const TakePage& take_page) {
  std::vector<std::uint32_t> page_of_image(model.images.size(), kNoPage);
  std::uint32_t count = 0;
  for (std::uint32_t& page : result.model.face_page) {
    if (page == kNoPage) continue;
    std::uint32_t& known = page_of_image[page];
    if (known == kNoPage) {
      known = count++;
      const tinygltf::Image& image = model.images[page];
      std::string part = "image " + std::to_string(page);
      if (const std::string& name = image.name.empty() ? image.uri : image.name; !name.empty())
        part += " (" + reason_of(file, name) + ")";
      take_page(known, decode_image(file, part, bytes_of(file, model, image, part)));
      const bool is_inside = image.bufferView >= 0 || !image.image.empty();
      result.page_files.push_back(is_inside ? fs::path() : folder_of(file) / with_slashes(image.uri));
    }
    page = known;
  }
}

LoadedModel read_textured_gltf(const fs::path& file, const TakePage& take_page) {
  const tinygltf::Model model = parse_gltf(file);
  LoadedModel result;
  for_each_primitive(file, model, GltfOffset::left, [&](const tinygltf::Primitive& primitive, const GltfMatrix& world) {
    append_primitive(file, model, primitive, world, result);
  });
  add_pages(file, model, result, take_page);
  for (const tinygltf::Node& node : model.nodes)
    if (const std::optional<WorldPoint> offset = offset_of(node)) result.offset = *offset;
  return result;
}

void check_numbers(const fs::path& file, LoadedModel& loaded) {
  if (!has_place(loaded.offset))
    throw InputError(file, "offset", "is not finite, or above " + shortest_text(kMostCoordinate));
  refuse_faceless(file, loaded.mesh);
  settle_places(file, loaded.mesh);
  for (std::size_t i = 0; i < loaded.model.texcoords.size(); ++i)
    if (!std::isfinite(loaded.model.texcoords[i].u) || !std::isfinite(loaded.model.texcoords[i].v))
      throw InputError(file, "texture coordinate " + std::to_string(i), "is not finite");
}

LoadedModel read_any(const fs::path& file, const PageUse& use) {
  const std::string extension = lower_case(file.extension().string());
  const bool gltf = extension == ".glb" || extension == ".gltf";
  const bool ply = extension == ".ply";
  if (!gltf && !ply && extension != ".obj")
    throw InputError(file, "", "expected a textured model, .obj, .glb, .gltf or .ply");
  LoadedModel loaded = gltf  ? read_textured_gltf(file, use.take)
                       : ply ? read_textured_ply(file, use)
                             : read_textured_obj(file, use);
  check_numbers(file, loaded);
  return loaded;
}

}  // namespace

WorldPoint read_offset(const fs::path& model) {
  const fs::path file = model.parent_path() / "offset.txt";
  refuse_special_file(file);
  std::ifstream in(file);
  WorldPoint offset;
  if (!in) return offset;
  if (!(in >> offset.x >> offset.y >> offset.z)) throw InputError(file, "line 1", "expected three numbers, x y z");
  return offset;
}

bool reaches_beyond_page(const TexturedModel& model, std::size_t face) {
  return std::ranges::any_of(model.face_texcoords[face], [&](std::uint32_t t) {
    const TexCoord& at = model.texcoords[t];
    return std::min(at.u, at.v) < 0 || std::max(at.u, at.v) > 1;
  });
}

LoadedModel read_textured_model(const fs::path& file, const TakePage& take_page) {
  std::vector<Image> pages;
  const TakePage keep = [&pages](std::size_t, Image page) { pages.push_back(std::move(page)); };  // by number
  LoadedModel loaded = read_any(file, {take_page ? take_page : keep});
  loaded.pages = std::move(pages);
  return loaded;
}

LoadedModel read_model_pages(const fs::path& file, const TakePage& take_page, std::vector<fs::path>& files) {
  files.clear();
  return read_any(file, {take_page, &files});
}

}  // namespace gpvc::io
