#include "io/meshes/gltf_photos.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace gpvc::io {
namespace {

using Json = nlohmann::json;

// Where names begin, and where the last one ends.
std::vector<std::uint32_t> name_offsets(const PhotoTable& photos) {
  std::vector<std::uint32_t> offsets{0};
  for (const std::string& name : photos.name)
    offsets.push_back(offsets.back() + static_cast<std::uint32_t>(name.size()));
  return offsets;
}

template <typename T>
void append_bytes(std::string& to, const std::vector<T>& values) {
  to.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace

std::string photo_columns(const PhotoTable& photos) {
  std::string bytes;
  append_bytes(bytes, name_offsets(photos));
  append_bytes(bytes, photos.gsd);
  for (const std::string& name : photos.name) bytes += name;
  // A buffer view of no bytes is not allowed.
  bytes += '\0';
  return bytes;
}

void describe_photos(Json& gltf, const PhotoTable& photos, std::size_t buffer, std::size_t offset) {
  const std::vector<std::uint32_t> offsets = name_offsets(photos);
  const auto add_view = [&](std::size_t bytes) {
    gltf["bufferViews"].push_back({{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", bytes}});
    offset += bytes;
    return gltf["bufferViews"].size() - 1;
  };
  const std::size_t of_offsets = add_view(offsets.size() * sizeof offsets[0]);
  const std::size_t of_gsd = add_view(photos.gsd.size() * sizeof photos.gsd[0]);
  const std::size_t of_names = add_view(std::max<std::size_t>(1, offsets.back()));
  const Json name{{"type", "STRING"}, {"noData", ""}, {"description", "The photo that the face shows"}};
  const Json gsd{{"type", "SCALAR"},
                 {"componentType", "FLOAT32"},
                 {"noData", 0},
                 {"description", "What a pixel of the photo covers on these faces, in the scene's units"}};
  gltf["extensions"][kStructuralMetadata] = {
      {"schema", {{"id", "gpvc"}, {"classes", {{"photo", {{"properties", {{"photo", name}, {"gsd", gsd}}}}}}}}},
      {"propertyTables",
       Json::array({{{"class", "photo"},
                     {"count", photos.name.size()},
                     {"properties",
                      {{"photo", {{"values", of_names}, {"stringOffsets", of_offsets}, {"stringOffsetType", "UINT32"}}},
                       {"gsd", {{"values", of_gsd}}}}}}})}};
}

Json photo_features(const PhotoTable& photos) {
  return {{"featureIds",
           Json::array(
               {{{"featureCount", photos.name.size()}, {"attribute", 0}, {"propertyTable", 0}, {"label", "photo"}}})}};
}

}  // namespace gpvc::io
