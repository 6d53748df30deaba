#include "io/meshes/gltf_description.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "io/meshes/gltf_extensions.h"
#include "io/meshes/gltf_photos.h"
#include "io/vector.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::json;

/// Appends to one of the arrays of the description; returns its number there.
std::size_t append(Json& array, Json element) {
  array.push_back(std::move(element));
  return array.size() - 1;
}

Json view_of(const Part& part) {
  Json view{{"buffer", part.buffer}, {"byteLength", part.bytes}};
  if (part.offset > 0) view["byteOffset"] = part.offset;
  return view;
}

/// Where arrays lie that EXT_meshopt_compression packs, once they are unpacked: a buffer without bytes of its own.
struct Unpacked {
  std::size_t buffer = 0, bytes = 0;
};

/// One buffer view an accessor.
std::size_t add_accessor(Json& gltf, const GltfAsset& asset, const GltfLayout& layout, std::size_t primitive,
                         GltfArray array, Unpacked& unpacked) {
  constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
  const GltfForm form = form_of(asset, array);
  const std::size_t count = elements_of(asset.data.geometry.primitives[primitive], array);
  Json view = view_of(layout.primitives[primitive][array]);
  if (!asset.data.packed.empty()) {
    Json packed = std::move(view);
    packed.update(
        {{"byteStride", form.bytes}, {"count", count}, {"mode", array == kIndices ? "TRIANGLES" : "ATTRIBUTES"}});
    view = view_of({unpacked.buffer, unpacked.bytes, count * form.bytes});
    view["extensions"] = {{kMeshoptCompression, std::move(packed)}};
    unpacked.bytes += padded(count * form.bytes);
  }
  // Required where an element has padding, or is packed.
  if (array != kIndices && (asset.options.coding != GltfCoding::plain)) view["byteStride"] = form.bytes;
  view["target"] = array == kIndices ? kElementArrayBuffer : kArrayBuffer;
  Json accessor{{"bufferView", append(gltf["bufferViews"], std::move(view))},
                {"componentType", form.component},
                {"count", count},
                {"type", form.type}};
  if (form.normalized) accessor["normalized"] = true;
  return append(gltf["accessors"], std::move(accessor));
}

/// Minimum and maximum of the numbers exactly as they stand in the buffer.
void set_bounds(Json& accessor, const GltfAsset& asset, const GltfPrimitive& range) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  const auto take = [&](const auto& p) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<double>(low[axis], p[axis]);
      high[axis] = std::max<double>(high[axis], p[axis]);
    }
  };
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    const WorldPoint& p =
        asset.model.mesh->written_positions()[asset.data.geometry.vertices[range.first_vertex + v].position];
    if (asset.data.grid)
      take(asset.data.grid->place(p - asset.options.offset));
    else
      take(local_position(p, asset.options.offset));
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(low[axis]) || !std::isfinite(high[axis]))
      throw OutputError(asset.file, "cannot be written: a coordinate is beyond the range of glTF's 32-bit floats");
  accessor["min"] = low;
  accessor["max"] = high;
}

/// A path as a URI: everything but letters, digits and a few marks as %XX.
std::string uri_of(const fs::path& path) {
  constexpr std::string_view kUnescaped = "-._~/", kHex = "0123456789ABCDEF";
  std::string uri;
  for (const char c : path.generic_string()) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x80 && std::isalnum(byte)) || kUnescaped.find(c) != std::string_view::npos)
      uri += c;
    else
      uri.append({'%', kHex[byte >> 4], kHex[byte & 15]});
  }
  return uri;
}

constexpr const char* kUnlit = "KHR_materials_unlit";

const char* mime_type(ImageFormat format) {
  return format == ImageFormat::png ? "image/png" : format == ImageFormat::webp ? "image/webp" : "image/jpeg";
}

/// `page` inside the buffer, or as a file beside the asset where it has no `part` there.
std::size_t add_image(Json& gltf, const fs::path& asset, const fs::path& page, ImageFormat format, const Part* part) {
  Json image;
  if (part != nullptr) {
    image = {{"bufferView", append(gltf["bufferViews"], view_of(*part))}, {"mimeType", mime_type(format)}};
  } else {
    const fs::path folder = fs::absolute(asset).lexically_normal().parent_path();
    image["uri"] = uri_of(fs::absolute(page).lexically_normal().lexically_relative(folder));
    if (format == ImageFormat::webp) image["mimeType"] = mime_type(format);
  }
  return append(gltf["images"], std::move(image));
}

/// \param embedded null: the page is a file beside the asset
std::size_t add_material(Json& gltf, const fs::path& file, const PageFile& page, const EmbeddedPage* embedded,
                         bool lit) {
  const std::size_t image =
      add_image(gltf, file, page.file, page.format, embedded != nullptr ? &embedded->page : nullptr);
  Json texture{{"sampler", 0}};
  if (page.format == ImageFormat::webp) {
    texture["extensions"][kTextureWebp]["source"] = image;
    if (!page.fallback.empty())
      texture["source"] = add_image(gltf, file, page.fallback, page.fallback_format,
                                    embedded != nullptr ? &*embedded->fallback : nullptr);
  } else {
    texture["source"] = image;
  }
  const std::size_t number = append(gltf["textures"], std::move(texture));
  Json material{{"name", page.material.empty() ? page.file.stem().string() : page.material},
                {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", number}}}, {"metallicFactor", 0.0}}}};
  if (!lit) material["extensions"] = {{kUnlit, Json::object()}};
  return append(gltf["materials"], std::move(material));
}

Json triple(const WorldPoint& p) { return Json::array({p.x, p.y, p.z}); }

/// The root, whose extras tell what to add to coordinates, and below it the grid that positions are numbers of.
Json nodes_of(const ModelOptions& options, const std::optional<PositionGrid>& grid) {
  Json extras{{"offset", triple(options.offset)}};
  if (!options.srs.empty()) extras["srs"] = options.srs;
  if (!options.srs.empty() || !(options.srs_offset == WorldPoint{})) extras["srs_offset"] = triple(options.srs_offset);
  Json root{{"name", "model"}, {"extras", std::move(extras)}};
  if (options.up != UpAxis::pos_y) root["rotation"] = gltf_rotation(options.up);
  (grid ? root["children"] : root["mesh"]) = grid ? Json::array({1}) : Json(0);
  Json nodes = Json::array({std::move(root)});
  if (grid)
    nodes.push_back(
        {{"mesh", 0}, {"translation", triple(grid->origin)}, {"scale", triple({grid->step, grid->step, grid->step})}});
  return nodes;
}

Json describe_primitive(Json& gltf, const GltfAsset& asset, const GltfLayout& layout, std::size_t number,
                        Unpacked& unpacked) {
  constexpr int kTriangles = 4;
  const GltfPrimitive& range = asset.data.geometry.primitives[number];
  const auto accessor = [&](GltfArray array) { return add_accessor(gltf, asset, layout, number, array, unpacked); };
  Json primitive{{"mode", kTriangles}};
  primitive["indices"] = accessor(kIndices);
  Json& attributes = primitive["attributes"];
  attributes["POSITION"] = accessor(kPositions);
  set_bounds(gltf["accessors"].back(), asset, range);
  attributes["TEXCOORD_0"] = accessor(kTexcoords);
  if (has_array(asset, kNormals)) attributes["NORMAL"] = accessor(kNormals);
  if (has_array(asset, kPhotos)) {
    attributes[kFeatureAttribute] = accessor(kPhotos);
    primitive["extensions"][kMeshFeatures] = photo_features(*asset.photos);
  }
  primitive["material"] = add_material(gltf, asset.file, asset.pages[range.page],
                                       layout.pages.empty() ? nullptr : &layout.pages[number], asset.options.lit);
  return primitive;
}

/// Those that a reader has to know come first.
void list_extensions(Json& gltf, const GltfAsset& asset) {
  std::vector<std::string> required, used;
  if (is_quantized(asset.data, asset.options)) required.push_back(kMeshQuantization);
  if (!asset.data.packed.empty()) required.push_back(kMeshoptCompression);
  bool webp = false, alone = false;
  for (const GltfPrimitive& primitive : asset.data.geometry.primitives)
    if (const PageFile& page = asset.pages[primitive.page]; page.format == ImageFormat::webp) {
      webp = true;
      alone |= page.fallback.empty();
    }
  if (webp) (alone ? required : used).push_back(kTextureWebp);
  if (!asset.options.lit) used.push_back(kUnlit);
  if (asset.photos != nullptr) used.insert(used.end(), {kMeshFeatures, kStructuralMetadata});
  for (const std::string& name : required) gltf["extensionsRequired"].push_back(name);
  for (const auto& names : {required, used})
    for (const std::string& name : names) gltf["extensionsUsed"].push_back(name);
}

}  // namespace

std::string describe(const GltfAsset& asset, const GltfLayout& layout, const std::vector<fs::path>& buffer_files) {
  constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;
  Json gltf{{"asset", {{"version", "2.0"}, {"generator", "gpvc " GPVC_VERSION}}},
            {"samplers", Json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmapLinear},
                                       {"wrapS", kClampToEdge},
                                       {"wrapT", kClampToEdge}}})},
            {"nodes", nodes_of(asset.options, asset.data.grid)},
            {"scene", 0},
            {"scenes", Json::array({{{"nodes", {0}}}})}};
  if (!asset.options.copyright.empty()) gltf["asset"]["copyright"] = asset.options.copyright;
  list_extensions(gltf, asset);
  Unpacked unpacked{layout.buffer_bytes.size()};
  Json primitives = Json::array();
  for (std::size_t i = 0; i < asset.data.geometry.primitives.size(); ++i)
    primitives.push_back(describe_primitive(gltf, asset, layout, i, unpacked));
  if (asset.photos != nullptr)
    describe_photos(gltf, *asset.photos, layout.photo_table->buffer, layout.photo_table->offset);
  gltf["meshes"] = Json::array({{{"primitives", std::move(primitives)}}});
  // Text of a scene file may not be UTF-8, which JSON must be. The buffers stand last.
  std::string json = gltf.dump(buffer_files.empty() ? -1 : 2, ' ', false, Json::error_handler_t::replace);
  json.back() = ',';
  json += "\"buffers\":[";
  for (std::size_t i = 0; i < layout.buffer_bytes.size(); ++i) {
    json += (i == 0 ? "{" : ",{");
    if (!buffer_files.empty()) json += "\"uri\":\"" + uri_of(buffer_files[i].filename()) + "\",";
    json += "\"byteLength\":" + std::to_string(layout.buffer_bytes[i]) + "}";
  }
  if (unpacked.bytes > 0)
    json += ",{\"byteLength\":" + std::to_string(unpacked.bytes) + ",\"extensions\":{\"" + kMeshoptCompression +
            "\":{\"fallback\":true}}}";
  return json + "]}";
}

}  // namespace gpvc::io
