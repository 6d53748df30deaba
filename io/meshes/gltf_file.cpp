// glTF 2.0, in one binary file or in several. The buffers behind the description are streamed, so that neither the
// geometry nor a page is held twice. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "io/file_bytes.h"
#include "io/grouping.h"
#include "io/meshes/normals.h"
#include "io/output_file.h"
#include "io/textured_model.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

using Json = nlohmann::json;
using Float3 = std::array<float, 3>;

struct GltfVertex {
  std::uint32_t position, texcoord;
};

/// The triangles of one page: ranges of the vertex and index arrays.
struct GltfPrimitive {
  std::uint32_t page = 0;
  std::size_t first_vertex = 0, vertex_count = 0;
  std::size_t first_index = 0, index_count = 0;
};

struct GltfGeometry {
  std::vector<GltfVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< within their primitive
  std::vector<GltfPrimitive> primitives;
  std::vector<FaceId> faces;  ///< of every triangle
};

/// One vertex for every distinct (position, texture coordinate) of a page, numbered in the order of first use; pages
/// without a face have no primitive, faces without a page are left out. O(faces).
// Vertices with one texture coordinate form a list, newest first; charts share few, so lists are short.
GltfGeometry split_by_page(const TexturedModel& model, std::size_t page_count) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  GltfGeometry out;
  Grouped<FaceId> by_page = group_items<FaceId>(page_count, [&](const auto& add) {
    for (std::size_t f = 0; f < model.face_page.size(); ++f)
      if (model.face_page[f] != kNoPage) add(model.face_page[f], FaceId{static_cast<std::uint32_t>(f)});
  });
  out.faces = std::move(by_page.items);
  out.indices.reserve(3 * out.faces.size());
  std::vector<std::uint32_t> newest(model.texcoords.size(), kNone);  // by texture coordinate: its last vertex
  std::vector<std::uint32_t> older;                                  // by vertex: the one before it in that list
  for (std::size_t page = 0; page < page_count; ++page) {
    if (by_page.first[page] == by_page.first[page + 1]) continue;
    GltfPrimitive primitive{static_cast<std::uint32_t>(page), out.vertices.size(), 0, out.indices.size(), 0};
    for (std::size_t i = by_page.first[page]; i < by_page.first[page + 1]; ++i) {
      const std::size_t face = index(out.faces[i]);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t position = model.mesh->faces[face][corner];
        const std::uint32_t texcoord = model.face_texcoords[face][corner];
        std::uint32_t vertex = newest[texcoord];
        while (vertex != kNone && vertex >= primitive.first_vertex && out.vertices[vertex].position != position)
          vertex = older[vertex];
        if (vertex == kNone || vertex < primitive.first_vertex) {
          vertex = static_cast<std::uint32_t>(out.vertices.size());
          out.vertices.push_back({position, texcoord});
          older.push_back(std::exchange(newest[texcoord], vertex));
        }
        out.indices.push_back(vertex - static_cast<std::uint32_t>(primitive.first_vertex));
      }
    }
    primitive.vertex_count = out.vertices.size() - primitive.first_vertex;
    primitive.index_count = out.indices.size() - primitive.first_index;
    out.primitives.push_back(primitive);
  }
  return out;
}

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

/// One buffer view an accessor.
std::size_t add_accessor(Json& gltf, const Part& part, std::size_t count, std::string_view type) {
  constexpr int kUnsignedInt = 5125, kFloat = 5126, kArrayBuffer = 34962, kElementArrayBuffer = 34963;
  const bool indices = type == "SCALAR";
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

/// The JSON; `buffer_files` is empty for a GLB.
std::string describe(const Asset& asset, const Layout& layout, const std::vector<fs::path>& buffer_files) {
  constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kTriangles = 4;
  Json gltf{{"asset", {{"version", "2.0"}, {"generator", "gpvc " GPVC_VERSION}}},
            {"samplers", Json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmapLinear},
                                       {"wrapS", kClampToEdge},
                                       {"wrapT", kClampToEdge}}})},
            {"nodes", Json::array({root_node(asset.options)})},
            {"scene", 0},
            {"scenes", Json::array({{{"nodes", {0}}}})}};
  if (!asset.options.lit) gltf["extensionsUsed"] = {kUnlit};
  Json primitives = Json::array();
  for (std::size_t i = 0; i < asset.geometry.primitives.size(); ++i) {
    const GltfPrimitive& range = asset.geometry.primitives[i];
    const auto& parts = layout.primitives[i];
    const auto floats = [&](Layout::Array array, std::string_view type) {
      return add_accessor(gltf, parts[array], range.vertex_count, type);
    };
    Json primitive{{"mode", kTriangles}};
    primitive["indices"] = add_accessor(gltf, parts[Layout::indices], range.index_count, "SCALAR");
    primitive["attributes"]["POSITION"] = floats(Layout::positions, "VEC3");
    set_bounds(gltf["accessors"].back(), asset, range);
    primitive["attributes"]["TEXCOORD_0"] = floats(Layout::texcoords, "VEC2");
    if (!asset.normals.empty()) primitive["attributes"]["NORMAL"] = floats(Layout::normals, "VEC3");
    primitive["material"] = add_material(gltf, asset.file, asset.pages[range.page],
                                         layout.pages.empty() ? nullptr : &layout.pages[i], asset.options.lit);
    primitives.push_back(std::move(primitive));
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

std::array<double, 4> gltf_rotation(UpAxis up) {
  constexpr double h = std::numbers::sqrt2 / 2;
  constexpr std::array<std::array<double, 4>, 6> kRotations{
      {{0, 0, h, h}, {0, 0, -h, h}, {0, 0, 0, 1}, {1, 0, 0, 0}, {-h, 0, 0, h}, {h, 0, 0, h}}};
  return kRotations.at(static_cast<std::size_t>(up));
}

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
    result.buffers.push_back(with_suffix((i == 0 ? "" : std::string("_").append(std::to_string(i))) + ".bin"));
  write_buffers(asset, layout, result.buffers);
  OutputFile out(result.file);
  out.write(describe(asset, layout, result.buffers));
  out.commit();
  result.faces = std::move(geometry.faces);
  return result;
}

}  // namespace gpvc::io
