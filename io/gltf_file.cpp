// A binary glTF 2.0: tinygltf describes the asset, the buffer behind the description is streamed, so that
// neither the geometry nor a page is held twice.
// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

#include "io/file_bytes.h"
#include "io/io.h"

namespace gpvc {

namespace {

namespace fs = std::filesystem;

struct Vertex {
  std::uint32_t position, texcoord;
};

/// What one page shows: ranges of the vertex and index arrays.
struct Primitive {
  std::uint32_t page = 0;
  std::size_t first_vertex = 0, vertex_count = 0;
  std::size_t first_index = 0, index_count = 0;
};

struct Geometry {
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  ///< within their primitive
  std::vector<Primitive> primitives;
  std::vector<FaceId> faces;  ///< of every triangle
};

/// Faces by page, in input order within a page: a counting sort.
std::vector<FaceId> faces_by_page(const TexturedModel& model, std::size_t page_count,
                                  std::vector<std::size_t>& page_begin) {
  page_begin.assign(page_count + 1, 0);
  for (const std::uint32_t page : model.face_page) ++page_begin[page + 1];
  for (std::size_t page = 0; page < page_count; ++page) page_begin[page + 1] += page_begin[page];
  std::vector<std::size_t> next(page_begin.begin(), page_begin.end() - 1);
  std::vector<FaceId> faces(model.face_page.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    faces[next[model.face_page[f]]++] = FaceId{static_cast<std::uint32_t>(f)};
  return faces;
}

/// One vertex for every distinct (position, texture coordinate) of a page, numbered in the order of first
/// use. Vertices with one texture coordinate form a list, newest first; charts share few, so lists are short.
Geometry split_by_page(const TexturedModel& model, std::size_t page_count) {
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  Geometry out;
  std::vector<std::size_t> page_begin;
  out.faces = faces_by_page(model, page_count, page_begin);
  out.indices.reserve(3 * out.faces.size());
  std::vector<std::uint32_t> newest(model.texcoords.size(),
                                    kNone);  // by texture coordinate: last vertex with it
  std::vector<std::uint32_t> older;          // by vertex: the one before it in that list
  for (std::size_t page = 0; page < page_count; ++page) {
    if (page_begin[page] == page_begin[page + 1]) continue;
    Primitive primitive{static_cast<std::uint32_t>(page), out.vertices.size(), 0, out.indices.size(), 0};
    for (std::size_t i = page_begin[page]; i < page_begin[page + 1]; ++i) {
      const std::size_t face = index(out.faces[i]);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t position = model.mesh->faces[face][corner];
        const std::uint32_t texcoord = model.face_texcoords[face][corner];
        std::uint32_t vertex = newest[texcoord];
        while (vertex != kNone && vertex >= primitive.first_vertex &&
               out.vertices[vertex].position != position)
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

std::array<float, 3> local_position(const WorldPoint& p, const WorldPoint& offset) {
  return {static_cast<float>(p.x - offset.x), static_cast<float>(p.y - offset.y),
          static_cast<float>(p.z - offset.z)};
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

/// Where the parts of the buffer lie: indices, positions, texture coordinates, then the pages' files, each
/// part at a multiple of four.
struct Layout {
  std::size_t indices = 0, positions = 0, texcoords = 0;
  std::vector<std::size_t> pages;       ///< one a primitive
  std::vector<std::size_t> page_bytes;  ///< one a primitive
  std::size_t size = 0;
};

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

Layout lay_out(const Geometry& geometry, std::span<const PageFile> pages) {
  Layout layout;
  layout.positions = geometry.indices.size() * sizeof(std::uint32_t);
  layout.texcoords = layout.positions + geometry.vertices.size() * sizeof(std::array<float, 3>);
  layout.size = layout.texcoords + geometry.vertices.size() * sizeof(TexCoord);
  for (const Primitive& primitive : geometry.primitives) {
    std::error_code error;
    const fs::path& file = pages[primitive.page].file;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) throw InputError(file, "", "cannot be read: " + error.message());
    layout.pages.push_back(layout.size);
    layout.page_bytes.push_back(bytes);
    layout.size = padded(layout.size + bytes);
  }
  return layout;
}

void add_views(tinygltf::Model& gltf, const Geometry& geometry, const Layout& layout) {
  const auto add = [&](std::size_t offset, std::size_t bytes, int target, std::size_t stride) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = offset;
    view.byteLength = bytes;
    view.byteStride = stride;
    view.target = target;
    gltf.bufferViews.push_back(std::move(view));
  };
  // A view a primitive: tinygltf writes offsets of accessors as int, those of views at full width.
  for (const Primitive& p : geometry.primitives) {
    add(layout.indices + p.first_index * 4, p.index_count * 4, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, 0);
    add(layout.positions + p.first_vertex * 12, p.vertex_count * 12, TINYGLTF_TARGET_ARRAY_BUFFER, 0);
    add(layout.texcoords + p.first_vertex * 8, p.vertex_count * 8, TINYGLTF_TARGET_ARRAY_BUFFER, 0);
  }
  for (std::size_t i = 0; i < layout.pages.size(); ++i) add(layout.pages[i], layout.page_bytes[i], 0, 0);
}

int add_accessor(tinygltf::Model& gltf, std::size_t view, std::size_t count, int component, int type) {
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(view);
  accessor.count = count;
  accessor.componentType = component;
  accessor.type = type;
  gltf.accessors.push_back(std::move(accessor));
  return static_cast<int>(gltf.accessors.size()) - 1;
}

/// Bounds of exactly the floats in the buffer.
void set_bounds(tinygltf::Accessor& accessor, const fs::path& file, const Geometry& geometry,
                const Primitive& range, const TexturedModel& model, const WorldPoint& offset) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::array<float, 3> low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    const Vertex& vertex = geometry.vertices[range.first_vertex + v];
    const std::array<float, 3> p = local_position(model.mesh->positions[vertex.position], offset);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(low[axis]) || !std::isfinite(high[axis]))
      throw OutputError(file, "cannot be written: a coordinate is beyond the range of glTF's 32-bit floats");
  accessor.minValues.assign(low.begin(), low.end());
  accessor.maxValues.assign(high.begin(), high.end());
}

void add_material(tinygltf::Model& gltf, const PageFile& page, std::size_t view) {
  const int number = static_cast<int>(gltf.materials.size());
  tinygltf::Image image;
  image.bufferView = static_cast<int>(view);
  image.mimeType = page.format == ImageFormat::png ? "image/png" : "image/jpeg";
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

void add_scene(tinygltf::Model& gltf, tinygltf::Mesh&& mesh, const ModelOptions& options) {
  gltf.meshes.push_back(std::move(mesh));
  tinygltf::Node node;
  node.name = "model";
  node.mesh = 0;
  node.rotation = rotation_from(options.up);
  const WorldPoint& o = options.offset;
  tinygltf::Value::Object extras;
  extras["offset"] = tinygltf::Value(
      tinygltf::Value::Array{tinygltf::Value(o.x), tinygltf::Value(o.y), tinygltf::Value(o.z)});
  node.extras = tinygltf::Value(std::move(extras));
  gltf.nodes.push_back(std::move(node));
  tinygltf::Scene scene;
  scene.nodes = {0};
  gltf.scenes.push_back(std::move(scene));
  gltf.defaultScene = 0;
}

/// The JSON chunk. The buffer is described without its bytes, which tinygltf would want in memory.
std::string describe(const fs::path& file, const Geometry& geometry, const Layout& layout,
                     const TexturedModel& model, std::span<const PageFile> pages,
                     const ModelOptions& options) {
  tinygltf::Model gltf;
  gltf.asset.version = "2.0";
  gltf.asset.generator = "gpvc " GPVC_VERSION;
  gltf.extensionsUsed = {"KHR_materials_unlit"};
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  gltf.samplers.push_back(std::move(sampler));
  add_views(gltf, geometry, layout);
  tinygltf::Mesh mesh;
  const std::size_t first_page_view = 3 * geometry.primitives.size();
  for (std::size_t i = 0; i < geometry.primitives.size(); ++i) {
    const Primitive& range = geometry.primitives[i];
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.indices = add_accessor(gltf, 3 * i, range.index_count, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                     TINYGLTF_TYPE_SCALAR);
    primitive.attributes["POSITION"] =
        add_accessor(gltf, 3 * i + 1, range.vertex_count, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
    set_bounds(gltf.accessors.back(), file, geometry, range, model, options.offset);
    primitive.attributes["TEXCOORD_0"] =
        add_accessor(gltf, 3 * i + 2, range.vertex_count, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2);
    primitive.material = static_cast<int>(i);
    add_material(gltf, pages[range.page], first_page_view + i);
    mesh.primitives.push_back(std::move(primitive));
  }
  add_scene(gltf, std::move(mesh), options);
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&gltf, stream, false, false))
    throw OutputError(file, "cannot be described");
  std::string json = std::move(stream).str();
  while (!json.empty() && json.back() != '}') json.pop_back();
  json.back() = ',';
  json += "\"buffers\":[{\"byteLength\":" + std::to_string(layout.size) + "}]}";
  json.append(padded(json.size()) - json.size(), ' ');
  return json;
}

template <typename T>
void write_block(OutputFile& out, std::vector<T>& block) {
  out.write(block.data(), block.size() * sizeof(T));
  block.clear();
}

void write_buffer(OutputFile& out, const Geometry& geometry, const Layout& layout, const TexturedModel& model,
                  std::span<const PageFile> pages, const WorldPoint& offset) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  out.write(geometry.indices.data(), geometry.indices.size() * sizeof(std::uint32_t));
  std::vector<std::array<float, 3>> positions;
  for (const Vertex& vertex : geometry.vertices) {
    positions.push_back(local_position(model.mesh->positions[vertex.position], offset));
    if (positions.size() == kBlock) write_block(out, positions);
  }
  write_block(out, positions);
  std::vector<TexCoord> texcoords;
  for (const Vertex& vertex : geometry.vertices) {
    texcoords.push_back(model.texcoords[vertex.texcoord]);
    if (texcoords.size() == kBlock) write_block(out, texcoords);
  }
  write_block(out, texcoords);
  for (std::size_t i = 0; i < geometry.primitives.size(); ++i) {
    const fs::path& file = pages[geometry.primitives[i].page].file;
    const FileBytes bytes(file);
    if (bytes.view().size() != layout.page_bytes[i]) throw InputError(file, "", "changed while it was read");
    out.write(bytes.view().data(), bytes.view().size());
    out.write("\0\0\0", padded(bytes.view().size()) - bytes.view().size());
  }
}

}  // namespace

std::vector<FaceId> write_glb(const fs::path& glb_file, const TexturedModel& model,
                              std::span<const PageFile> pages, const ModelOptions& options) {
  check_model(model, pages.size());
  Geometry geometry = split_by_page(model, pages.size());
  const Layout layout = lay_out(geometry, pages);
  const std::string json = describe(glb_file, geometry, layout, model, pages, options);
  const std::size_t length = 12 + 8 + json.size() + 8 + layout.size;
  if (length > 0xFFFFFFFFu)
    throw OutputError(glb_file, "would be " + std::to_string(length) +
                                    " bytes, a GLB ends at 4 GiB; use fewer or smaller pages");
  const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;
  OutputFile out(glb_file);
  const std::array<std::uint32_t, 5> head{kMagic, 2, word(length), word(json.size()), kJson};
  out.write(head.data(), sizeof head);
  out.write(json);
  const std::array<std::uint32_t, 2> chunk{word(layout.size), kBin};
  out.write(chunk.data(), sizeof chunk);
  write_buffer(out, geometry, layout, model, pages, options.offset);
  out.commit();
  return std::move(geometry.faces);
}

}  // namespace gpvc
