// What the readers of glTF 2.0 share: parsing, checked access to buffers, triangles.
#pragma once

#include <tiny_gltf.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"
#include "io/scene.h"

namespace gpvc::io {

/// A library's message as the end of our sentence: on one line, without the file's name and final full stops.
std::string reason_of(const std::filesystem::path& file, std::string said);

/// A GLB or glTF with its buffers, unpacked where EXT_meshopt_compression packs them; images keep their bytes. Throws
/// InputError, also for a file that requires another extension which packs or places geometry.
tinygltf::Model parse_gltf(const std::filesystem::path& file);

/// The element `number` of one of the description's lists, which hold a `what` each.
template <class Element>
const Element& element_at(const std::filesystem::path& file, const std::vector<Element>& list, int number,
                          const char* what) {
  if (number < 0 || static_cast<std::size_t>(number) >= list.size())
    throw InputError(file, what + (" " + std::to_string(number)),
                     "does not exist, expected one of " + std::to_string(list.size()));
  return list[static_cast<std::size_t>(number)];
}

/// A buffer view's bytes and all behind them in its buffer.
struct BufferRange {
  const tinygltf::BufferView& view;
  std::string_view bytes;
};

BufferRange buffer_range(const std::filesystem::path& file, const std::string& place, const tinygltf::Model& model,
                         int number);

/// Typed read access to one accessor, checked against its buffer.
class AccessorView {
 public:
  /// Throws InputError. \param type  TINYGLTF_TYPE_...
  AccessorView(const std::filesystem::path& file, const tinygltf::Model& model, int number, int type);
  /// \pre is_float() or is_short()
  double component(std::size_t element, std::size_t k) const;
  /// \pre is_index()
  std::uint32_t integer(std::size_t element) const {
    std::uint32_t value = 0;
    std::memcpy(&value, data_ + element * stride_,
                static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_))));
    return value;
  }
  bool is_index() const {
    return component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT || component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  }
  bool is_float() const { return component_ == TINYGLTF_COMPONENT_TYPE_FLOAT; }
  /// As KHR_mesh_quantization allows them: integers of 8 or 16 bits.
  bool is_short() const {
    return component_ == TINYGLTF_COMPONENT_TYPE_BYTE || component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           component_ == TINYGLTF_COMPONENT_TYPE_SHORT || component_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  }
  std::size_t count = 0;

 private:
  const char* data_ = nullptr;
  std::size_t stride_ = 0;
  int component_ = 0;
  bool normalized_ = false;
};

/// The number of a texture's image: the one of EXT_texture_webp before a fallback.
int image_of(const tinygltf::Texture& texture);

/// Its positions: floats, or is_short(). Throws InputError.
AccessorView positions_of(const std::filesystem::path& file, const tinygltf::Model& model,
                          const tinygltf::Primitive& primitive);

/// Calls `add` with the corners of each triangle, all below `vertices`, of lists, strips and fans; false for points and
/// lines. Throws InputError.
bool for_each_triangle(const std::filesystem::path& file, const tinygltf::Model& model,
                       const tinygltf::Primitive& primitive, std::size_t vertices,
                       const std::function<void(std::uint32_t, std::uint32_t, std::uint32_t)>& add);

/// Where our own writer keeps what was subtracted from the positions of a node's mesh; nullopt for other nodes.
std::optional<WorldPoint> offset_of(const tinygltf::Node& node);

}  // namespace gpvc::io
