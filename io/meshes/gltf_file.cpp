// glTF 2.0, in one binary file or in several: tinygltf describes the asset, the buffers behind the description are
// streamed, so that neither the geometry nor a page is held twice.
// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <utility>

#include "io/files/file_bytes.h"
#include "io/meshes/gltf_geometry.h"
#include "io/meshes/normals.h"
#include "io/output_file.h"
#include "io/textured_model.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

using Float3 = std::array<float, 3>;

/// The data to be written; all borrowed.
struct Asset {
  const fs::path& file;
  const TexturedModel& model;
  std::span<const PageFile> pages;
  const ModelOptions& options;
  const GltfGeometry& geometry;
  const std::vector<Float3>& normals;  ///< per position, or empty
};

Float3 local_position(const WorldPoint& p, const WorldPoint& offset) {
  return {static_cast<float>(p.x - offset.x), static_cast<float>(p.y - offset.y), static_cast<float>(p.z - offset.z)};
}

/// The rotation, as x, y, z, w, that takes the world's up axis to glTF's +y.
std::vector<double> rotation_from(UpAxis up) {
  const double h = std::numbers::sqrt2 / 2;
  switch (up) {
    case UpAxis::pos_x:
      return {0, 0, h, h};
    case UpAxis::neg_x:
      return {0, 0, -h, h};
    case UpAxis::pos_y:
      return {};
    case UpAxis::neg_y:
      return {1, 0, 0, 0};
    case UpAxis::pos_z:
      return {-h, 0, 0, h};
    case UpAxis::neg_z:
      return {h, 0, 0, h};
  }
  return {};
}

/// A range of a buffer; offsets are multiples of four.
struct Part {
  std::size_t buffer = 0, offset = 0, bytes = 0;
};

/// Buffer layout: for each primitive its indices, positions, texture coordinates and normals, one after the other;
/// behind them, in a GLB, the page files. Every buffer is written front to back.
struct Layout {
  enum Array { indices, positions, texcoords, normals, kArrays };
  std::vector<std::array<Part, kArrays>> primitives;
  std::vector<Part> pages;  ///< one a primitive; empty when pages stay files
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
        asset.normals.empty() ? 0 : p.vertex_count * sizeof(Float3)};
    const std::size_t sum = bytes[0] + bytes[1] + bytes[2] + bytes[3];
    if (layout.buffer_bytes.back() > 0 && layout.buffer_bytes.back() + sum > buffer_limit)
      layout.buffer_bytes.push_back(0);
    auto& parts = layout.primitives.emplace_back();
    for (std::size_t i = 0; i < Layout::kArrays; ++i) parts[i] = place(bytes[i]);
  }
  if (embed_pages)
    for (const GltfPrimitive& p : asset.geometry.primitives)
      layout.pages.push_back(place(embedded_bytes(asset.pages[p.page].file)));
  return layout;
}

int add_view(tinygltf::Model& gltf, const Part& part, int target) {
  tinygltf::BufferView view;
  view.buffer = static_cast<int>(part.buffer);
  view.byteOffset = part.offset;
  view.byteLength = part.bytes;
  view.target = target;
  gltf.bufferViews.push_back(std::move(view));
  return static_cast<int>(gltf.bufferViews.size()) - 1;
}

// One buffer view an accessor: tinygltf writes offsets of accessors as int, those of views in full width.
int add_accessor(tinygltf::Model& gltf, const Part& part, std::size_t count, int component, int type) {
  const bool is_index = type == TINYGLTF_TYPE_SCALAR;
  tinygltf::Accessor accessor;
  accessor.bufferView =
      add_view(gltf, part, is_index ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER : TINYGLTF_TARGET_ARRAY_BUFFER);
  accessor.count = count;
  accessor.componentType = component;
  accessor.type = type;
  gltf.accessors.push_back(std::move(accessor));
  return static_cast<int>(gltf.accessors.size()) - 1;
}

/// Minimum and maximum of the floats exactly as they stand in the buffer.
void set_bounds(tinygltf::Accessor& accessor, const Asset& asset, const GltfPrimitive& range) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Float3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    const GltfVertex& vertex = asset.geometry.vertices[range.first_vertex + v];
    const Float3 p = local_position(asset.model.mesh->positions[vertex.position], asset.options.offset);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(low[axis]) || !std::isfinite(high[axis]))
      throw OutputError(asset.file, "cannot be written: a coordinate is beyond the range of glTF's 32-bit floats");
  accessor.minValues.assign(low.begin(), low.end());
  accessor.maxValues.assign(high.begin(), high.end());
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

/// `page` inside the buffer, or as a file beside the asset where it has no place there.
void add_material(tinygltf::Model& gltf, const fs::path& file, const PageFile& page, const Part* part) {
  const int number = static_cast<int>(gltf.materials.size());
  tinygltf::Image image;
  if (part) {
    image.bufferView = add_view(gltf, *part, 0);
    image.mimeType = page.format == ImageFormat::png ? "image/png" : "image/jpeg";
  } else {
    const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
    image.uri = uri_of(fs::absolute(page.file).lexically_normal().lexically_relative(folder));
  }
  gltf.images.push_back(std::move(image));
  tinygltf::Texture texture;
  texture.source = number;
  texture.sampler = 0;
  gltf.textures.push_back(std::move(texture));
  tinygltf::Material material;
  material.name = page.file.stem().string();
  material.pbrMetallicRoughness.baseColorTexture.index = number;
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.extensions["KHR_materials_unlit"] = tinygltf::Value(tinygltf::Value::Object());
  gltf.materials.push_back(std::move(material));
}

// JSON must be UTF-8; text of a scene file may not be.
std::string valid_utf8(const std::string& text) {
  const std::string json = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(json).get<std::string>();
}

void add_scene(tinygltf::Model& gltf, tinygltf::Mesh&& mesh, const ModelOptions& options) {
  gltf.meshes.push_back(std::move(mesh));
  tinygltf::Node node;
  node.name = "model";
  node.mesh = 0;
  node.rotation = rotation_from(options.up);
  const WorldPoint& o = options.offset;
  tinygltf::Value::Object extras;
  extras["offset"] =
      tinygltf::Value(tinygltf::Value::Array{tinygltf::Value(o.x), tinygltf::Value(o.y), tinygltf::Value(o.z)});
  if (!options.srs.empty()) extras["srs"] = tinygltf::Value(valid_utf8(options.srs));
  if (const WorldPoint& s = options.srs_offset; !options.srs.empty() || !(s == WorldPoint{}))
    extras["srs_offset"] =
        tinygltf::Value(tinygltf::Value::Array{tinygltf::Value(s.x), tinygltf::Value(s.y), tinygltf::Value(s.z)});
  node.extras = tinygltf::Value(std::move(extras));
  gltf.nodes.push_back(std::move(node));
  tinygltf::Scene scene;
  scene.nodes = {0};
  gltf.scenes.push_back(std::move(scene));
  gltf.defaultScene = 0;
}

/// The JSON. Buffers are described without their bytes, which tinygltf would want in memory; `buffer_files` is empty
/// for a GLB.
std::string describe(const Asset& asset, const Layout& layout, const std::vector<fs::path>& buffer_files) {
  tinygltf::Model gltf;
  gltf.asset.version = "2.0";
  gltf.asset.generator = "gpvc " GPVC_VERSION;
  gltf.extensionsUsed = {"KHR_materials_unlit"};
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  gltf.samplers.push_back(std::move(sampler));
  tinygltf::Mesh mesh;
  for (std::size_t i = 0; i < asset.geometry.primitives.size(); ++i) {
    const GltfPrimitive& range = asset.geometry.primitives[i];
    const auto& parts = layout.primitives[i];
    const auto floats = [&](Layout::Array array, int type) {
      return add_accessor(gltf, parts[array], range.vertex_count, TINYGLTF_COMPONENT_TYPE_FLOAT, type);
    };
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.indices = add_accessor(gltf, parts[Layout::indices], range.index_count,
                                     TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
    primitive.attributes["POSITION"] = floats(Layout::positions, TINYGLTF_TYPE_VEC3);
    set_bounds(gltf.accessors.back(), asset, range);
    primitive.attributes["TEXCOORD_0"] = floats(Layout::texcoords, TINYGLTF_TYPE_VEC2);
    if (!asset.normals.empty()) primitive.attributes["NORMAL"] = floats(Layout::normals, TINYGLTF_TYPE_VEC3);
    primitive.material = static_cast<int>(i);
    add_material(gltf, asset.file, asset.pages[range.page], layout.pages.empty() ? nullptr : &layout.pages[i]);
    mesh.primitives.push_back(std::move(primitive));
  }
  add_scene(gltf, std::move(mesh), asset.options);
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&gltf, stream, !buffer_files.empty(), false))
    throw OutputError(asset.file, "cannot be described");
  std::string json = std::move(stream).str();
  while (!json.empty() && json.back() != '}') json.pop_back();
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
    return local_position(model.mesh->positions[v.position], asset.options.offset);
  });
  write_vertices(out, asset, range, [&](const GltfVertex& v) { return model.texcoords[v.texcoord]; });
  if (!asset.normals.empty())
    write_vertices(out, asset, range, [&](const GltfVertex& v) { return asset.normals[v.position]; });
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
  for (std::size_t i = 0; i < layout.pages.size(); ++i)
    write_page(out, asset.pages[asset.geometry.primitives[i].page].file, layout.pages[i].bytes);
  out.commit();
}

void write_buffers(const Asset& asset, const Layout& layout, const std::vector<fs::path>& files) {
  for (std::size_t buffer = 0; buffer < files.size(); ++buffer) {
    OutputFile out(files[buffer]);
    for (std::size_t i = 0; i < layout.primitives.size(); ++i)
      if (layout.primitives[i].front().buffer == buffer) write_primitive(out, asset, asset.geometry.primitives[i]);
    out.commit();
  }
}

}  // namespace

GltfFiles write_gltf(const fs::path& stem, GltfContainer container, const TexturedModel& model,
                     std::span<const PageFile> pages, const ModelOptions& options) {
  check_model(model, pages.size());
  GltfGeometry geometry = split_by_page(model, pages.size());
  const std::vector<Float3> normals = options.normals ? vertex_normals(*model.mesh) : std::vector<Float3>{};
  const auto with_suffix = [&](const std::string& suffix) {
    fs::path file = stem;
    return file += suffix;
  };
  GltfFiles result;
  result.file = with_suffix(".glb");
  if (geometry.faces.empty()) throw OutputError(result.file, "cannot be written: no face has a texture");
  if (container == GltfContainer::glb) {
    const Asset asset{result.file, model, pages, options, geometry, normals};
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
  const Asset asset{result.file, model, pages, options, geometry, normals};
  const Layout layout = lay_out(asset, false, options.buffer_limit_bytes);
  for (std::size_t i = 0; i < layout.buffer_bytes.size(); ++i)
    result.buffers.push_back(with_suffix(i == 0 ? ".bin" : "_" + std::to_string(i) + ".bin"));
  write_buffers(asset, layout, result.buffers);
  OutputFile out(result.file);
  out.write(describe(asset, layout, result.buffers));
  out.commit();
  result.faces = std::move(geometry.faces);
  return result;
}

}  // namespace gpvc::io
