#include "io/meshes/gltf_unpack.h"

#include <meshoptimizer.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "io/meshes/gltf_extensions.h"
#include "io/meshes/gltf_reader.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A block of 256 vertices takes at least 4 bytes for each byte of a vertex; indices come to less.
constexpr std::size_t kMostFromByte = 64;

/// A buffer view's extension object, checked.
struct Packed {
  const unsigned char* bytes = nullptr;
  std::size_t size = 0;
  std::size_t stride = 0, count = 0;
  std::string mode, filter;
};

class Unpacker {
 public:
  Unpacker(const fs::path& file, std::string place, const tinygltf::Model& model, const tinygltf::Value& extension)
      : file_(file), place_(std::move(place)) {
    const tinygltf::Buffer& buffer =
        element_at(file, model.buffers, static_cast<int>(number(extension, "buffer", 0x7FFFFFFF)), "buffer");
    const std::size_t offset = number(extension, "byteOffset", buffer.data.size());
    packed_.size = number(extension, "byteLength", buffer.data.size() - offset);
    packed_.bytes = buffer.data.data() + offset;
    packed_.stride = number(extension, "byteStride", 256);
    packed_.count = number(extension, "count", 0xFFFFFFFF);
    packed_.mode = text(extension, "mode");
    packed_.filter = text(extension, "filter");
  }

  std::vector<unsigned char> unpack() const {
    const auto& [bytes, size, stride, count, mode, filter] = packed_;
    const bool attributes = mode == "ATTRIBUTES", indices = mode == "TRIANGLES" || mode == "INDICES";
    const bool sound = attributes ? stride > 0 && stride % 4 == 0
                                  : indices && (stride == 2 || stride == 4) && (mode == "INDICES" || count % 3 == 0);
    if (!sound) fail("is packed in a way that " + std::string(kMeshoptCompression) + " does not know");
    // A triangle and an index take at least a byte.
    const std::size_t most = attributes ? kMostFromByte * size : mode == "INDICES" ? size * stride : 3 * size * stride;
    if (count > most / stride) fail("claims " + std::to_string(count) + " elements, more than its bytes can hold");
    std::vector<unsigned char> to(count * stride);
    const int failed = attributes            ? meshopt_decodeVertexBuffer(to.data(), count, stride, bytes, size)
                       : mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(to.data(), count, stride, bytes, size)
                                             : meshopt_decodeIndexSequence(to.data(), count, stride, bytes, size);
    if (failed != 0) fail("cannot be unpacked, expected whole data of " + std::string(kMeshoptCompression));
    undo_filter(to);
    return to;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place_, reason); }

  /// 0 where it is not stated.
  std::size_t number(const tinygltf::Value& extension, const char* name, std::size_t most) const {
    if (!extension.Has(name)) return 0;
    const tinygltf::Value& value = extension.Get(name);
    const double stated = value.IsNumber() ? value.GetNumberAsDouble() : -1;
    if (!(stated >= 0 && stated <= static_cast<double>(most)))
      fail("states a " + std::string(name) + " that cannot be right");
    return static_cast<std::size_t>(stated);
  }
  static std::string text(const tinygltf::Value& extension, const char* name) {
    return extension.Has(name) && extension.Get(name).IsString() ? extension.Get(name).Get<std::string>() : "";
  }

  void undo_filter(std::vector<unsigned char>& values) const {
    const auto& [bytes, size, stride, count, mode, filter] = packed_;
    if (filter.empty() || filter == "NONE") return;
    const bool octahedral = filter == "OCTAHEDRAL" && (stride == 4 || stride == 8);
    const bool quaternion = filter == "QUATERNION" && stride == 8, exponential = filter == "EXPONENTIAL";
    if (mode != "ATTRIBUTES" || !(octahedral || quaternion || exponential))
      fail("has a filter that " + std::string(kMeshoptCompression) + " does not know");
    (octahedral   ? meshopt_decodeFilterOct
     : quaternion ? meshopt_decodeFilterQuat
                  : meshopt_decodeFilterExp)(values.data(), count, stride);
  }

  const fs::path& file_;
  std::string place_;
  Packed packed_;
};

bool is_only_packed(const Json& buffer) {
  return buffer.is_object() && !buffer.contains("uri") &&
         buffer.value(Json::json_pointer("/extensions/" + std::string(kMeshoptCompression) + "/fallback"), false);
}

void append_word(std::string& to, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  to.append(reinterpret_cast<const char*>(&word), sizeof word);
}

}  // namespace

std::optional<std::string> fill_fallback_buffers(std::string_view file, std::string_view json, bool binary) {
  if (json.find(kMeshoptCompression) == std::string_view::npos) return std::nullopt;
  Json gltf = Json::parse(json, nullptr, false);
  if (!gltf.is_object() || !gltf.contains("buffers") || !gltf["buffers"].is_array()) return std::nullopt;
  bool changed = false;
  for (Json& buffer : gltf["buffers"]) try {
      if (!is_only_packed(buffer)) continue;
      buffer["uri"] = "data:application/octet-stream;base64,AA==";
      buffer["byteLength"] = 1;
      changed = true;
    } catch (const Json::exception&) {  // of another type than it should be: tinygltf says what
    }
  if (!changed) return std::nullopt;
  std::string text = gltf.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (!binary) return text;
  constexpr std::size_t kHead = 20;  // magic, version, length of all, length and type of the JSON
  const std::string_view behind = file.substr(kHead + json.size());
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string glb(file.substr(0, 8));
  append_word(glb, kHead + text.size() + behind.size());
  append_word(glb, text.size());
  glb += file.substr(16, 4);
  glb += text;
  glb += behind;
  return glb;
}

void unpack_views(const fs::path& file, tinygltf::Model& model) {
  // Views do not share bytes, so that all of them together hold no more than that either.
  std::size_t left = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) left += kMostFromByte * buffer.data.size();
  for (std::size_t n = 0; n < model.bufferViews.size(); ++n) {
    tinygltf::BufferView& view = model.bufferViews[n];
    const auto extension = view.extensions.find(kMeshoptCompression);
    if (extension == view.extensions.end()) continue;
    tinygltf::Buffer unpacked;
    const std::string place = "buffer view " + std::to_string(n);
    unpacked.data = Unpacker(file, place, model, extension->second).unpack();
    if (unpacked.data.size() > left)
      throw InputError(file, place, "is packed in bytes of other views, which come to more than they can hold");
    left -= unpacked.data.size();
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteOffset = 0;
    view.byteLength = unpacked.data.size();
    model.buffers.push_back(std::move(unpacked));
  }
}

}  // namespace gpvc::io
