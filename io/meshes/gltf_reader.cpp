#include "io/meshes/gltf_reader.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/meshes/gltf_extensions.h"
#include "io/meshes/gltf_unpack.h"
#include "io/utf8.h"

namespace gpvc::io {

namespace {

/// Keeps the bytes of images in files and in the JSON; those in a buffer stay there. tinygltf calls this before it
/// checks an image's range against the buffer's size, and its own decoder believes every length that a PNG claims.
bool keep_bytes(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

/// tinygltf and the JSON library below it go one call deeper per bracket.
void check_depth(const fs::path& file, std::string_view json) {
  constexpr int kDeepest = 200;
  int depth = 0;
  bool in_string = false;
  for (std::size_t at = 0; at < json.size(); ++at) {
    const char c = json[at];
    if (in_string) {
      if (c == '\\') ++at;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kDeepest) throw InputError(file, "", "expected a glTF, whose JSON nests less deeply");
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
}

/// The JSON chunk of a GLB. Checks what tinygltf does not: it accepts a BIN chunk that ends up to 8 bytes behind the
/// file.
std::string_view json_of(const fs::path& file, std::string_view glb) {
  ByteReader reader(file, glb);
  constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A;
  const auto word = [&](const char* what) { return reader.read<std::uint32_t>(what); };
  if (word("the GLB's header") != kMagic) throw InputError(file, "byte 0", "expected a GLB, which begins with 'glTF'");
  if (const std::uint32_t version = word("the GLB's header"); version != 2)
    throw InputError(file, "byte 4", "expected a GLB of version 2, found " + std::to_string(version));
  word("the GLB's header");  // the length of all, which tinygltf compares
  const std::uint32_t json_bytes = word("the GLB's JSON chunk");
  if (word("the GLB's JSON chunk") != kJson) throw InputError(file, "byte 16", "expected a GLB's JSON chunk");
  const std::string_view json = reader.take(json_bytes, "the GLB's JSON chunk");
  if (reader.remaining() > 0) {
    const std::uint32_t binary_bytes = word("the GLB's binary chunk");
    word("the GLB's binary chunk");
    reader.take(binary_bytes, "the GLB's binary chunk");
  }
  return json;
}

/// Extensions that a file may require although nothing here knows them: they change how its surface looks, not where it
/// is.
bool is_of_looks(std::string_view extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_") || extension.starts_with("KHR_lights_");
}

constexpr std::string_view kPackings[] = {"KHR_draco_mesh_compression", "KHR_meshopt_compression"};
constexpr std::string_view kReadPackings[] = {kMeshoptCompression, kMeshQuantization};

[[noreturn]] void refuse_packed(const fs::path& file, std::string_view packing) {
  throw InputError(
      file, "", "packs its geometry by " + std::string(packing) + ", expected plain floats or " + kMeshoptCompression);
}

/// Throws for a file that cannot be read right without an extension which is not known here; the specification asks for
/// that.
void check_required(const fs::path& file, const tinygltf::Model& model) {
  for (const std::string& extension : model.extensionsRequired) {
    if (std::ranges::find(kPackings, extension) != std::end(kPackings)) refuse_packed(file, extension);
    if (!is_of_looks(extension) && std::ranges::find(kReadPackings, extension) == std::end(kReadPackings))
      throw InputError(file, "", "requires the extension " + quote(extension) + ", which is not supported");
  }
}

/// Buffers and images in files, read like all other files here.
tinygltf::FsCallbacks file_callbacks() {
  tinygltf::FsCallbacks callbacks{};
  callbacks.FileExists = [](const std::string& name, void*) { return is_file(name); };
  callbacks.ExpandFilePath = [](const std::string& name, void*) { return name; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* out, std::string* error, const std::string& name, void*) {
    try {
      const FileBytes bytes(name);
      out->assign(bytes.view().begin(), bytes.view().end());
      return true;
    } catch (const InputError& found) {
      *error += found.what();
      return false;
    }
  };
  return callbacks;
}

}  // namespace

/// A library's message as the end of our sentence: on one line, without the file's name and final full stops.
std::string reason_of(const fs::path& file, std::string said) {
  const std::string name = file.string();
  for (std::size_t at; (at = said.find(name)) != std::string::npos;) said.erase(at, name.size());
  std::string reason;
  for (const char c : said) {
    const bool blank = static_cast<unsigned char>(c) <= ' ';
    if (!blank) reason += c;
    if (blank && !reason.empty() && reason.back() != ' ') reason += ' ';
  }
  reason.erase(reason.find_last_not_of(" .:") + 1);
  constexpr std::size_t kLongest = 300;
  return reason.size() <= kLongest ? reason : std::string(whole_characters(reason, kLongest)) + "...";
}

tinygltf::Model parse_gltf(const fs::path& file) {
  const FileBytes bytes(file);
  const std::string_view view = bytes.view();
  const bool binary = lower_case(file.extension().string()) == ".glb" || view.starts_with("glTF");
  const std::string expected = binary ? "expected a GLB" : "expected a glTF";
  if (view.empty()) throw InputError(file, "", "is empty, " + expected);
  if (view.size() > 0xFFFFFFFFu) throw InputError(file, "", expected + " of less than 4 GiB");
  const std::string_view json = binary ? json_of(file, view) : view;
  check_depth(file, json);
  const std::optional<std::string> filled = fill_fallback_buffers(view, json, binary);
  const std::string_view given = filled ? *filled : view;
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(keep_bytes, nullptr);
  loader.SetFsCallbacks(file_callbacks());
  tinygltf::Model model;
  std::string error, warning;
  bool good = false;
  try {
    const std::string folder = file.parent_path().string();
    const auto size = static_cast<unsigned>(given.size());
    good = binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                                reinterpret_cast<const unsigned char*>(given.data()), size, folder)
                  : loader.LoadASCIIFromString(&model, &error, &warning, given.data(), size, folder);
  } catch (const std::logic_error& found) {  // of a standard container, at what is empty or out of range
    error += found.what();
  } catch (const std::runtime_error& found) {
    error += found.what();
  }
  if (!good) {
    // tinygltf refuses packed files for the buffers that they do not have.
    for (const std::string_view packing : kPackings)
      if (json.find(packing) != std::string_view::npos) refuse_packed(file, packing);
    throw InputError(file, "", expected + ": " + reason_of(file, error));
  }
  check_required(file, model);
  unpack_views(file, model);
  return model;
}

BufferRange buffer_range(const fs::path& file, const std::string& place, const tinygltf::Model& model, int number) {
  const tinygltf::BufferView& view = element_at(file, model.bufferViews, number, "buffer view");
  const auto& buffer = element_at(file, model.buffers, view.buffer, "buffer").data;
  if (view.byteOffset > buffer.size()) throw InputError(file, place, "reaches beyond its buffer");
  return {view, {reinterpret_cast<const char*>(buffer.data()) + view.byteOffset, buffer.size() - view.byteOffset}};
}

AccessorView::AccessorView(const fs::path& file, const tinygltf::Model& model, int number, int type) {
  const std::string place = "accessor " + std::to_string(number);
  const tinygltf::Accessor& accessor = element_at(file, model.accessors, number, "accessor");
  if (accessor.sparse.isSparse) throw InputError(file, place, "is sparse, expected all of its elements in a row");
  const auto [view, bytes] = buffer_range(file, place, model, accessor.bufferView);
  if (accessor.type != type) throw InputError(file, place, "expected another number of components");
  component_ = accessor.componentType;
  normalized_ = accessor.normalized;
  count = accessor.count;
  const int stride = accessor.ByteStride(view);
  const int size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_)) *
                   tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type));
  if (size <= 0 || stride < size || accessor.byteOffset > bytes.size())
    throw InputError(file, place, "reaches beyond its buffer");
  // The last element need not be followed by its stride's padding.
  const std::size_t room = bytes.size() - accessor.byteOffset, last = static_cast<std::size_t>(size);
  if (count > 0 && (room < last || (room - last) / static_cast<std::size_t>(stride) < count - 1))
    throw InputError(file, place, "reaches beyond its buffer");
  stride_ = static_cast<std::size_t>(stride);
  data_ = bytes.data() + accessor.byteOffset;
}

double AccessorView::component(std::size_t element, std::size_t k) const {
  const char* const at = data_ + element * stride_;
  const auto as = [&]<typename T>(T value) -> double {
    std::memcpy(&value, at + sizeof value * k, sizeof value);
    if constexpr (std::is_integral_v<T>)
      if (normalized_) return std::max(-1.0, static_cast<double>(value) / std::numeric_limits<T>::max());
    return static_cast<double>(value);
  };
  switch (component_) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return as(std::int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return as(std::uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return as(std::int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return as(std::uint16_t{});
    default:
      return as(float{});
  }
}

int image_of(const tinygltf::Texture& texture) {
  const auto webp = texture.extensions.find(kTextureWebp);
  const bool is_webp =
      webp != texture.extensions.end() && webp->second.Has("source") && webp->second.Get("source").IsInt();
  return is_webp ? webp->second.Get("source").Get<int>() : texture.source;
}

AccessorView positions_of(const fs::path& file, const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) throw InputError(file, "mesh", "expected a POSITION attribute");
  const AccessorView positions(file, model, position->second, TINYGLTF_TYPE_VEC3);
  if (!positions.is_float() && !positions.is_short())
    throw InputError(file, "mesh", "expected positions of floats, or of integers of 8 or 16 bits");
  return positions;
}

bool for_each_triangle(const fs::path& file, const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                       std::size_t vertices,
                       const std::function<void(std::uint32_t, std::uint32_t, std::uint32_t)>& add) {
  const int mode = primitive.mode == -1 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  const bool list = mode == TINYGLTF_MODE_TRIANGLES, strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
  if (!list && !strip && mode != TINYGLTF_MODE_TRIANGLE_FAN) return false;
  std::optional<AccessorView> indices;
  if (primitive.indices >= 0) {
    indices.emplace(file, model, primitive.indices, TINYGLTF_TYPE_SCALAR);
    if (!indices->is_index()) throw InputError(file, "mesh", "expected unsigned indices");
  }
  const auto corner = [&](std::size_t i) {
    const std::uint32_t vertex = indices ? indices->integer(i) : static_cast<std::uint32_t>(i);
    if (vertex >= vertices)
      throw InputError(file, "triangle " + std::to_string(list ? i / 3 : i), "vertex index out of range");
    return vertex;
  };
  const std::size_t count = indices ? indices->count : vertices;
  for (std::size_t i = 0; i + 2 < count; i += list ? 3 : 1) {
    if (strip && i % 2 == 1)  // every second triangle runs the other way
      add(corner(i + 1), corner(i), corner(i + 2));
    else
      add(corner(list || strip ? i : 0), corner(i + 1), corner(i + 2));
  }
  return true;
}

std::optional<WorldPoint> offset_of(const tinygltf::Node& node) {
  if (!node.extras.Has("offset")) return std::nullopt;
  const tinygltf::Value& offset = node.extras.Get("offset");
  if (!offset.IsArray() || offset.ArrayLen() != 3) return std::nullopt;
  return WorldPoint{offset.Get(0).GetNumberAsDouble(), offset.Get(1).GetNumberAsDouble(),
                    offset.Get(2).GetNumberAsDouble()};
}

}  // namespace gpvc::io
