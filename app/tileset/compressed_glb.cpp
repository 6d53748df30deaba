#include "app/tileset/compressed_glb.h"

#include <meshoptimizer.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/output_file.h"

namespace gpvc::tileset {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExtension = "EXT_meshopt_compression";
constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

struct Glb {
  Json json;
  std::string_view binary;  ///< of the file's bytes
};

Glb read_glb(const std::filesystem::path& file, std::string_view bytes) {
  io::ByteReader in(file, bytes);
  const auto expect = [&](std::uint32_t value, const char* what) {
    if (in.read<std::uint32_t>(what) != value) in.fail(std::string("expected ") + what);
  };
  expect(kMagic, "a GLB");
  expect(2, "version 2 of glTF");
  in.read<std::uint32_t>("the length");
  const auto text = in.read<std::uint32_t>("the description's length");
  expect(kJsonChunk, "the description");
  Glb glb{Json::parse(in.take(text, "the description"), nullptr, false), {}};
  if (!glb.json.is_object()) in.fail("expected JSON");
  const auto binary = in.read<std::uint32_t>("the buffer's length");
  expect(kBinaryChunk, "the buffer");
  glb.binary = in.take(binary, "the buffer");
  return glb;
}

using Bytes = std::vector<unsigned char>;

Bytes encode_indices(std::string_view bytes, std::size_t vertices) {
  std::vector<unsigned int> indices(bytes.size() / sizeof(unsigned int));
  std::memcpy(indices.data(), bytes.data(), bytes.size());
  Bytes encoded(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  encoded.resize(meshopt_encodeIndexBuffer(encoded.data(), encoded.size(), indices.data(), indices.size()));
  return encoded;
}

Bytes encode_vertices(std::string_view bytes, std::size_t count, std::size_t stride) {
  Bytes encoded(meshopt_encodeVertexBufferBound(count, stride));
  encoded.resize(meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), bytes.data(), count, stride));
  return encoded;
}

class Compressor {
 public:
  explicit Compressor(Glb& glb) : json_(glb.json), from_(glb.binary) {}

  /// The new buffer; the description is changed to fit it.
  std::string compress() {
    for (const Json& mesh : json_.at("meshes"))
      for (const Json& primitive : mesh.at("primitives")) {
        const Json& position = json_.at("accessors").at(primitive.at("attributes").at("POSITION").get<std::size_t>());
        replace(primitive.at("indices"), position.at("count").get<std::size_t>(), true);
        for (const auto& attribute : primitive.at("attributes").items()) replace(attribute.value(), 0, false);
      }
    for (const Json& image : json_.value("images", Json::array()))
      if (image.contains("bufferView")) move(image.at("bufferView"));
    for (const Json& table :
         json_.value("/extensions/EXT_structural_metadata/propertyTables"_json_pointer, Json::array()))
      for (const Json& column : table.at("properties"))
        for (const char* part : {"values", "stringOffsets"})
          if (column.contains(part)) move(column.at(part));
    json_["buffers"] = Json::array({{{"byteLength", to_.size()}},
                                    {{"byteLength", decoded_}, {"extensions", {{kExtension, {{"fallback", true}}}}}}});
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) json_[list].push_back(kExtension);
    return std::move(to_);
  }

 private:
  std::string_view bytes_of(const Json& view) const {
    return from_.substr(view.value("byteOffset", std::size_t{0}), view.at("byteLength").get<std::size_t>());
  }
  std::size_t append(const void* data, std::size_t bytes) {
    const std::size_t at = to_.size();
    to_.append(static_cast<const char*>(data), bytes);
    to_.resize(padded(to_.size()), '\0');
    return at;
  }
  void move(const Json& view_number) {
    Json& view = json_.at("bufferViews").at(view_number.get<std::size_t>());
    const std::string_view bytes = bytes_of(view);
    view["byteOffset"] = append(bytes.data(), bytes.size());
  }
  void replace(const Json& accessor_number, std::size_t vertices, bool indices) {
    const Json& accessor = json_.at("accessors").at(accessor_number.get<std::size_t>());
    Json& view = json_.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    const std::string_view bytes = bytes_of(view);
    const auto count = accessor.at("count").get<std::size_t>();
    const std::size_t stride = bytes.size() / count;
    const Bytes encoded = indices ? encode_indices(bytes, vertices) : encode_vertices(bytes, count, stride);
    view["buffer"] = 1;
    if (!indices) view["byteStride"] = stride;
    view["byteOffset"] = decoded_;
    decoded_ = padded(decoded_ + bytes.size());
    view["extensions"][kExtension] = {
        {"buffer", 0},          {"byteOffset", append(encoded.data(), encoded.size())}, {"byteLength", encoded.size()},
        {"byteStride", stride}, {"mode", indices ? "TRIANGLES" : "ATTRIBUTES"},         {"count", count}};
  }

  Json& json_;
  std::string_view from_;
  std::string to_;
  std::size_t decoded_ = 0;  ///< bytes of what readers decode
};

}  // namespace

void compress_geometry(const std::filesystem::path& file) {
  std::string text, binary;
  {
    const io::FileBytes bytes(file);
    Glb glb = read_glb(file, bytes.view());
    try {
      binary = Compressor(glb).compress();
    } catch (const Json::exception& error) {
      throw InputError(file, "", std::string("is no GLB of gpvc: ") + error.what());
    }
    text = glb.json.dump();
  }
  text.resize(padded(text.size()), ' ');
  const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
  const std::array<std::uint32_t, 5> head{kMagic, 2, word(12 + 8 + text.size() + 8 + binary.size()), word(text.size()),
                                          kJsonChunk};
  const std::array<std::uint32_t, 2> chunk{word(binary.size()), kBinaryChunk};
  io::OutputFile out(file);
  out.write(head.data(), sizeof head);
  out.write(text);
  out.write(chunk.data(), sizeof chunk);
  out.write(binary);
  out.commit();
}

}  // namespace gpvc::tileset
