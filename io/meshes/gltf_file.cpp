// glTF 2.0, in one binary file or in several. The buffers behind the description are streamed, so that neither the
// geometry nor a page is held twice. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/file_bytes.h"
#include "io/meshes/gltf_geometry.h"
#include "io/meshes/gltf_photos.h"
#include "io/meshes/normals.h"
#include "io/output_file.h"
#include "io/textured_model.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

using Json = nlohmann::json;
using Float3 = std::array<float, 3>;

/// The data to be written; all borrowed.
struct Asset {
  const fs::path& file;
  const TexturedModel& model;
  std::span<const PageFile> pages;
  const ModelOptions& options;
  const GltfGeometry& geometry;
  const std::vector<Float3>& normals;  ///< per position, or empty
  const PhotoTable* photos;            ///< null: none
};

Float3 local_position(const WorldPoint& p, const WorldPoint& offset) {
  return {static_cast<float>(p.x - offset.x), static_cast<float>(p.y - offset.y), static_cast<float>(p.z - offset.z)};
}

/// A range of a buffer; offsets are multiples of four.
struct Part {
  std::size_t buffer = 0, offset = 0, bytes = 0;
};

/// Buffer layout: for each primitive its indices, positions, texture coordinates, normals and rows of the table of photos,
/// one after the other; behind them that table and, in a GLB, the page files. Every buffer is written front to back.
struct Layout {
  enum Array { indices, positions, texcoords, normals, photos, kArrays };
  std::vector<std::array<Part, kArrays>> primitives;
  std::optional<Part> photo_table;  ///< in the last buffer
  std::vector<Part> pages;          ///< one a primitive; empty when pages stay files
  std::vector<std::size_t> buffer_bytes;
};

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

/// GLBs leave out a PNG's colour profile: glTF readers ignore it, and the validator warns of it. write_image puts it
/// directly behind the signature and the IHDR.
constexpr std::size_t kProfileAt = 33;

/// Size of the chunk with the profile, 0 without one; `page` may be just the beginning of the file.
std::size_t profile_bytes(std::string_view page) {
  constexpr std::size_t kAround = 12;  // length, name and check sum
  if (!page.starts_with("\x89PNG") || page.size() < kProfileAt + kAround || page.substr(kProfileAt + 4, 4) != "iCCP")
    return 0;
  std::size_t length = kAround;
  for (std::size_t i = 0, shift = 24; i < 4; ++i, shift -= 8)
    length += std::size_t{static_cast<unsigned char>(page[kProfileAt + i])} << shift;
  return length;
}

/// The page's part of the buffer, from the file's size and first bytes.
std::size_t embedded_bytes(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) throw InputError(file, "", "cannot be read: " + error.message());
  std::array<char, 64> head{};
  std::ifstream(file, std::ios::binary).read(head.data(), head.size());
  return bytes - profile_bytes({head.data(), head.size()});
}

/// A new buffer begins where a primitive would grow one beyond `buffer_limit`.
Layout lay_out(const Asset& asset, bool embed_pages, std::size_t buffer_limit) {
  Layout layout;
  layout.buffer_bytes = {0};
  const auto place = [&](std::size_t bytes) {
    std::size_t& size = layout.buffer_bytes.back();
    const Part part{layout.buffer_bytes.size() - 1, size, bytes};
    size = padded(size + bytes);
    return part;
  };
  for (const GltfPrimitive& p : asset.geometry.primitives) {
    const std::array<std::size_t, Layout::kArrays> bytes{
        p.index_count * sizeof(std::uint32_t), p.vertex_count * sizeof(Float3), p.vertex_count * sizeof(TexCoord),
        asset.normals.empty() ? 0 : p.vertex_count * sizeof(Float3),
        asset.photos == nullptr ? 0 : p.vertex_count * sizeof(float)};
    const std::size_t sum = std::accumulate(bytes.begin(), bytes.end(), std::size_t{0});
    if (layout.buffer_bytes.back() > 0 && layout.buffer_bytes.back() + sum > buffer_limit)
      layout.buffer_bytes.push_back(0);
    auto& parts = layout.primitives.emplace_back();
    for (std::size_t i = 0; i < Layout::kArrays; ++i) parts[i] = place(bytes[i]);
  }
  if (asset.photos != nullptr) layout.photo_table = place(photo_columns(*asset.photos).size());
  if (embed_pages)
    for (const GltfPrimitive& p : asset.geometry.primitives)
      layout.pages.push_back(place(embedded_bytes(asset.pages[p.page].file)));
  return layout;
}

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

/// One buffer view an accessor, of indices or of floats.
std::size_t add_accessor(Json& gltf, const Part& part, std::size_t count, std::string_view type, bool indices) {
  constexpr int kUnsignedInt = 5125, kFloat = 5126, kArrayBuffer = 34962, kElementArrayBuffer = 34963;
  Json view = view_of(part);
  view["target"] = indices ? kElementArrayBuffer : kArrayBuffer;
  return append(gltf["accessors"], {{"bufferView", append(gltf["bufferViews"], std::move(view))},
                                    {"componentType", indices ? kUnsignedInt : kFloat},
                                    {"count", count},
                                    {"type", type}});
}

/// Minimum and maximum of the floats exactly as they stand in the buffer.
void set_bounds(Json& accessor, const Asset& asset, const GltfPrimitive& range) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    const GltfVertex& vertex = asset.geometry.vertices[range.first_vertex + v];
    const Float3 p = local_position(asset.model.mesh->written_positions()[vertex.position], asset.options.offset);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min<double>(low[axis], p[axis]);
      high[axis] = std::max<double>(high[axis], p[axis]);
    }
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

/// `page` inside the buffer, or as a file beside the asset where it has no `part` there.
std::size_t add_material(Json& gltf, const fs::path& file, const PageFile& page, const Part* part, bool lit) {
  Json image;
  if (part != nullptr) {
    image = {{"bufferView", append(gltf["bufferViews"], view_of(*part))},
             {"mimeType", page.format == ImageFormat::png ? "image/png" : "image/jpeg"}};
  } else {
    const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
    image["uri"] = uri_of(fs::absolute(page.file).lexically_normal().lexically_relative(folder));
  }
  const std::size_t source = append(gltf["images"], std::move(image));
  const std::size_t texture = append(gltf["textures"], {{"sampler", 0}, {"source", source}});
  Json material{{"name", page.file.stem().string()},
                {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}, {"metallicFactor", 0.0}}}};
  if (!lit) material["extensions"] = {{kUnlit, Json::object()}};
  return append(gltf["materials"], std::move(material));
}

Json root_node(const ModelOptions& options) {
  const auto triple = [](const WorldPoint& p) { return Json::array({p.x, p.y, p.z}); };
  Json extras{{"offset", triple(options.offset)}};
  if (!options.srs.empty()) extras["srs"] = options.srs;
  if (!options.srs.empty() || !(options.srs_offset == WorldPoint{})) extras["srs_offset"] = triple(options.srs_offset);
  Json node{{"name", "model"}, {"mesh", 0}, {"extras", std::move(extras)}};
  if (options.up != UpAxis::pos_y) node["rotation"] = gltf_rotation(options.up);
  return node;
}

Json describe_primitive(Json& gltf, const Asset& asset, const Layout& layout, std::size_t number) {
  constexpr int kTriangles = 4;
  const GltfPrimitive& range = asset.geometry.primitives[number];
  const auto& parts = layout.primitives[number];
  const auto floats = [&](Layout::Array array, std::string_view type) {
    return add_accessor(gltf, parts[array], range.vertex_count, type, false);
  };
  Json primitive{{"mode", kTriangles}};
  primitive["indices"] = add_accessor(gltf, parts[Layout::indices], range.index_count, "SCALAR", true);
  primitive["attributes"]["POSITION"] = floats(Layout::positions, "VEC3");
  set_bounds(gltf["accessors"].back(), asset, range);
  primitive["attributes"]["TEXCOORD_0"] = floats(Layout::texcoords, "VEC2");
  if (!asset.normals.empty()) primitive["attributes"]["NORMAL"] = floats(Layout::normals, "VEC3");
  if (asset.photos != nullptr) {
    primitive["attributes"][kFeatureAttribute] = floats(Layout::photos, "SCALAR");
    primitive["extensions"][kMeshFeatures] = photo_features(*asset.photos);
  }
  primitive["material"] = add_material(gltf, asset.file, asset.pages[range.page],
                                       layout.pages.empty() ? nullptr : &layout.pages[number], asset.options.lit);
  return primitive;
}

/// The JSON; `buffer_files` is empty for a GLB.
std::string describe(const Asset& asset, const Layout& layout, const std::vector<fs::path>& buffer_files) {
  constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;
  Json gltf{{"asset", {{"version", "2.0"}, {"generator", "gpvc " GPVC_VERSION}}},
            {"samplers", Json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmapLinear},
                                       {"wrapS", kClampToEdge},
                                       {"wrapT", kClampToEdge}}})},
            {"nodes", Json::array({root_node(asset.options)})},
            {"scene", 0},
            {"scenes", Json::array({{{"nodes", {0}}}})}};
  if (!asset.options.copyright.empty()) gltf["asset"]["copyright"] = asset.options.copyright;
  if (!asset.options.lit) gltf["extensionsUsed"].push_back(kUnlit);
  Json primitives = Json::array();
  for (std::size_t i = 0; i < asset.geometry.primitives.size(); ++i)
    primitives.push_back(describe_primitive(gltf, asset, layout, i));
  if (asset.photos != nullptr) {
    for (const char* name : {kMeshFeatures, kStructuralMetadata}) gltf["extensionsUsed"].push_back(name);
    describe_photos(gltf, *asset.photos, layout.photo_table->buffer, layout.photo_table->offset);
  }
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
  return json + "]}";
}

template <typename T>
void write_block(OutputFile& out, std::vector<T>& block) {
  out.write(block.data(), block.size() * sizeof(T));
  block.clear();
}

/// `value_of(vertex)` of a primitive's vertices, block by block, and what aligns the next array.
template <typename Value>
void write_vertices(OutputFile& out, const Asset& asset, const GltfPrimitive& range, const Value& value_of) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  std::vector<decltype(value_of(asset.geometry.vertices.front()))> values;
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    values.push_back(value_of(asset.geometry.vertices[range.first_vertex + v]));
    if (values.size() == kBlock) write_block(out, values);
  }
  write_block(out, values);
}

void write_primitive(OutputFile& out, const Asset& asset, const GltfPrimitive& range) {
  const TexturedModel& model = asset.model;
  out.write(asset.geometry.indices.data() + range.first_index, range.index_count * sizeof(std::uint32_t));
  write_vertices(out, asset, range, [&](const GltfVertex& v) {
    return local_position(model.mesh->written_positions()[v.position], asset.options.offset);
  });
  write_vertices(out, asset, range, [&](const GltfVertex& v) { return model.texcoords[v.texcoord]; });
  if (!asset.normals.empty())
    write_vertices(out, asset, range, [&](const GltfVertex& v) { return asset.normals[v.position]; });
  if (asset.photos != nullptr)
    write_vertices(out, asset, range, [](const GltfVertex& v) { return static_cast<float>(v.photo); });
}

void write_photo_table(OutputFile& out, const Asset& asset) {
  if (asset.photos == nullptr) return;
  std::string columns = photo_columns(*asset.photos);
  columns.resize(padded(columns.size()), '\0');
  out.write(columns);
}

void write_page(OutputFile& out, const fs::path& file, std::size_t expected_bytes) {
  const FileBytes bytes(file);
  const std::string_view page = bytes.view();
  const std::size_t profile = profile_bytes(page), size = page.size() - profile;
  if (profile > page.size() || size != expected_bytes) throw InputError(file, "", "changed while it was read");
  const std::size_t head = profile > 0 ? kProfileAt : 0;
  out.write(page.data(), head);
  out.write(page.data() + head + profile, size - head);
  out.write("\0\0\0", padded(size) - size);
}

std::size_t glb_bytes(const std::string& json, const Layout& layout) {
  return 12 + 8 + padded(json.size()) + 8 + layout.buffer_bytes.front();
}

void write_binary(const Asset& asset, const Layout& layout, std::string json) {
  const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;
  const std::size_t length = glb_bytes(json, layout);
  json.append(padded(json.size()) - json.size(), ' ');
  OutputFile out(asset.file);
  const std::array<std::uint32_t, 5> head{kMagic, 2, word(length), word(json.size()), kJson};
  out.write(head.data(), sizeof head);
  out.write(json);
  const std::array<std::uint32_t, 2> chunk{word(layout.buffer_bytes.front()), kBin};
  out.write(chunk.data(), sizeof chunk);
  for (const GltfPrimitive& primitive : asset.geometry.primitives) write_primitive(out, asset, primitive);
  write_photo_table(out, asset);
  for (std::size_t i = 0; i < layout.pages.size(); ++i)
    write_page(out, asset.pages[asset.geometry.primitives[i].page].file, layout.pages[i].bytes);
  out.commit();
}

void write_buffers(const Asset& asset, const Layout& layout, const std::vector<fs::path>& files) {
  for (std::size_t buffer = 0; buffer < files.size(); ++buffer) {
    OutputFile out(files[buffer]);
    for (std::size_t i = 0; i < layout.primitives.size(); ++i)
      if (layout.primitives[i].front().buffer == buffer) write_primitive(out, asset, asset.geometry.primitives[i]);
    if (buffer + 1 == files.size()) write_photo_table(out, asset);
    out.commit();
  }
}

}  // namespace

std::array<double, 4> gltf_rotation(UpAxis up) {
  constexpr double h = std::numbers::sqrt2 / 2;
  constexpr std::array<std::array<double, 4>, 6> kRotations{
      {{0, 0, h, h}, {0, 0, -h, h}, {0, 0, 0, 1}, {1, 0, 0, 0}, {-h, 0, 0, h}, {h, 0, 0, h}}};
  return kRotations.at(static_cast<std::size_t>(up));
}

GltfFiles write_gltf(const fs::path& stem, GltfContainer container, const TexturedModel& model,
                     std::span<const PageFile> pages, const ModelOptions& options, const PhotoTable* photos) {
  check_model(model, pages.size());
  GltfGeometry geometry = split_by_page(model, pages.size(), photos);
  const std::vector<Float3> normals = options.normals ? vertex_normals(*model.mesh) : std::vector<Float3>{};
  const auto with_suffix = [&](const std::string& suffix) {
    fs::path file = stem;
    return file += suffix;
  };
  GltfFiles result;
  result.file = with_suffix(".glb");
  if (geometry.faces.empty()) throw OutputError(result.file, "cannot be written: no face has a texture");
  if (container == GltfContainer::glb) {
    const Asset asset{result.file, model, pages, options, geometry, normals, photos};
    const Layout layout = lay_out(asset, true, std::numeric_limits<std::size_t>::max());
    std::string json = describe(asset, layout, {});
    constexpr std::size_t kLargest = 0xFFFFFFFFu;
    result.glb_bytes = glb_bytes(json, layout);
    if (result.glb_bytes <= kLargest) {
      write_binary(asset, layout, std::move(json));
      result.faces = std::move(geometry.faces);
      return result;
    }
  }
  result.file = with_suffix(".gltf");
  const Asset asset{result.file, model, pages, options, geometry, normals, photos};
  const Layout layout = lay_out(asset, false, options.buffer_limit_bytes);
  for (std::size_t i = 0; i < layout.buffer_bytes.size(); ++i)
    result.buffers.push_back(with_suffix((i == 0 ? "" : std::string("_").append(std::to_string(i))) + ".bin"));
  write_buffers(asset, layout, result.buffers);
  write_file(result.file, describe(asset, layout, result.buffers));
  result.faces = std::move(geometry.faces);
  return result;
}

}  // namespace gpvc::io
