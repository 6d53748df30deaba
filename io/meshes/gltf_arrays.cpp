#include "io/meshes/gltf_arrays.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "io/meshes/normals.h"

namespace gpvc::io {
namespace {

using ByteSink = std::function<void(const void*, std::size_t)>;

/// `value_of(vertex)` of a primitive's vertices, block by block.
template <typename Value>
void write_vertices(const GltfAsset& asset, const GltfPrimitive& range, const ByteSink& write, const Value& value_of) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  const std::vector<GltfVertex>& vertices = asset.data.geometry.vertices;
  std::vector<decltype(value_of(vertices.front()))> values;
  const auto flush = [&] {
    write(values.data(), values.size() * sizeof values[0]);
    values.clear();
  };
  for (std::size_t v = 0; v < range.vertex_count; ++v) {
    values.push_back(value_of(vertices[range.first_vertex + v]));
    if (values.size() == kBlock) flush();
  }
  flush();
}

void write_positions(const GltfAsset& asset, const GltfPrimitive& range, const ByteSink& write) {
  const auto position_of = [&](const GltfVertex& v) -> const WorldPoint& {
    return asset.model.mesh->written_positions()[v.position];
  };
  if (!asset.data.grid)
    return write_vertices(asset, range, write,
                          [&](const GltfVertex& v) { return local_position(position_of(v), asset.options.offset); });
  PositionGrid grid = *asset.data.grid;
  for (auto axis : {&WorldPoint::x, &WorldPoint::y, &WorldPoint::z}) grid.origin.*axis += asset.options.offset.*axis;
  write_vertices(asset, range, write, [&](const GltfVertex& v) {
    const std::array<std::uint16_t, 3> place = grid.place(position_of(v));
    return std::array<std::uint16_t, 4>{place[0], place[1], place[2], 0};
  });
}

void write_texcoords(const GltfAsset& asset, const GltfPrimitive& range, const ByteSink& write) {
  const std::vector<TexCoord>& texcoords = asset.model.texcoords;
  if (!asset.data.short_texcoords)
    return write_vertices(asset, range, write, [&](const GltfVertex& v) { return texcoords[v.texcoord]; });
  const auto number = [](float c) { return static_cast<std::uint16_t>(std::lround(65535.0 * static_cast<double>(c))); };
  write_vertices(asset, range, write, [&](const GltfVertex& v) {
    return std::array<std::uint16_t, 2>{number(texcoords[v.texcoord].u), number(texcoords[v.texcoord].v)};
  });
}

void write_normals(const GltfAsset& asset, const GltfPrimitive& range, const ByteSink& write) {
  const auto& normals = asset.data.normals;
  if (asset.options.coding != GltfCoding::quantized)
    return write_vertices(asset, range, write, [&](const GltfVertex& v) { return normals[v.position]; });
  const auto number = [](float c) { return static_cast<std::int8_t>(std::lround(127.0f * c)); };
  write_vertices(asset, range, write, [&](const GltfVertex& v) {
    const auto& [x, y, z] = normals[v.position];
    return std::array<std::int8_t, 4>{number(x), number(y), number(z), 0};
  });
}

void write_plain(const GltfAsset& asset, const GltfPrimitive& range, GltfArray array, const ByteSink& write) {
  switch (array) {
    case kIndices:
      return write(asset.data.geometry.indices.data() + range.first_index, range.index_count * sizeof(std::uint32_t));
    case kPositions:
      return write_positions(asset, range, write);
    case kTexcoords:
      return write_texcoords(asset, range, write);
    case kNormals:
      return write_normals(asset, range, write);
    default:
      return write_vertices(asset, range, write, [](const GltfVertex& v) { return static_cast<float>(v.photo); });
  }
}

std::string pack(const GltfAsset& asset, const GltfPrimitive& range, GltfArray array) {
  std::string packed;
  const auto to = [&packed] { return reinterpret_cast<unsigned char*>(packed.data()); };
  if (array == kIndices) {
    const std::uint32_t* indices = asset.data.geometry.indices.data() + range.first_index;
    packed.resize(meshopt_encodeIndexBufferBound(range.index_count, range.vertex_count));
    packed.resize(meshopt_encodeIndexBuffer(to(), packed.size(), indices, range.index_count));
    return packed;
  }
  std::string plain;
  write_plain(asset, range, array,
              [&](const void* bytes, std::size_t count) { plain.append(static_cast<const char*>(bytes), count); });
  const std::size_t stride = form_of(asset, array).bytes;
  packed.resize(meshopt_encodeVertexBufferBound(range.vertex_count, stride));
  packed.resize(meshopt_encodeVertexBuffer(to(), packed.size(), plain.data(), range.vertex_count, stride));
  return packed;
}

bool are_on_pages(const TexturedModel& model, const GltfGeometry& geometry) {
  return std::ranges::all_of(geometry.vertices, [&](const GltfVertex& v) {
    const TexCoord& at = model.texcoords[v.texcoord];
    return at.u >= 0 && at.u <= 1 && at.v >= 0 && at.v <= 1;
  });
}

}  // namespace

GltfData gltf_data(const TexturedModel& model, std::size_t pages, const ModelOptions& options,
                   const PhotoTable* photos) {
  GltfData data;
  data.geometry = split_by_page(model, pages, photos);
  if (options.normals) data.normals = vertex_normals(*model.mesh);
  if (options.coding == GltfCoding::quantized) {
    order_triangles(data.geometry);
    data.grid = position_grid(model, data.geometry, options.offset);
    data.short_texcoords = are_on_pages(model, data.geometry);
  }
  if (options.coding == GltfCoding::plain) return data;
  const std::filesystem::path no_file;
  const GltfAsset asset{no_file, model, {}, options, data, photos};
  std::vector<std::array<std::string, kGltfArrays>> packed;
  for (const GltfPrimitive& primitive : data.geometry.primitives) {
    auto& arrays = packed.emplace_back();
    for (const GltfArray array : kAllArrays)
      if (has_array(asset, array)) arrays[array] = pack(asset, primitive, array);
  }
  data.packed = std::move(packed);
  return data;
}

std::array<float, 3> local_position(const WorldPoint& p, const WorldPoint& offset) {
  return {static_cast<float>(p.x - offset.x), static_cast<float>(p.y - offset.y), static_cast<float>(p.z - offset.z)};
}

bool has_array(const GltfAsset& asset, GltfArray array) {
  return array == kNormals ? !asset.data.normals.empty() : array != kPhotos || asset.photos != nullptr;
}

GltfForm form_of(const GltfAsset& asset, GltfArray array) {
  constexpr int kByte = 5120, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
  const GltfData& data = asset.data;
  switch (array) {
    case kIndices:
      return {kUnsignedInt, "SCALAR", false, 4};
    case kPositions:
      return data.grid ? GltfForm{kUnsignedShort, "VEC3", false, 8} : GltfForm{kFloat, "VEC3", false, 12};
    case kTexcoords:
      return data.short_texcoords ? GltfForm{kUnsignedShort, "VEC2", true, 4} : GltfForm{kFloat, "VEC2", false, 8};
    case kNormals:
      return asset.options.coding == GltfCoding::quantized ? GltfForm{kByte, "VEC3", true, 4}
                                                           : GltfForm{kFloat, "VEC3", false, 12};
    default:
      return {kFloat, "SCALAR", false, 4};
  }
}

bool is_quantized(const GltfData& data, const ModelOptions& options) {
  return options.coding == GltfCoding::quantized && (data.grid || data.short_texcoords || !data.normals.empty());
}

std::size_t elements_of(const GltfPrimitive& primitive, GltfArray array) {
  return array == kIndices ? primitive.index_count : primitive.vertex_count;
}

std::size_t bytes_of(const GltfAsset& asset, std::size_t primitive, GltfArray array) {
  if (!has_array(asset, array)) return 0;
  if (!asset.data.packed.empty()) return asset.data.packed[primitive][array].size();
  return elements_of(asset.data.geometry.primitives[primitive], array) * form_of(asset, array).bytes;
}

void write_array(const GltfAsset& asset, std::size_t primitive, GltfArray array, const ByteSink& write) {
  if (!has_array(asset, array)) return;
  if (asset.data.packed.empty()) return write_plain(asset, asset.data.geometry.primitives[primitive], array, write);
  const std::string& packed = asset.data.packed[primitive][array];
  write(packed.data(), packed.size());
}

}  // namespace gpvc::io
