// glTF 2.0, in one binary file or in several. The buffers behind the description are streamed, so that neither the
// geometry nor a page is held twice. https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/file_bytes.h"
#include "io/meshes/gltf_description.h"
#include "io/meshes/gltf_photos.h"
#include "io/output_file.h"
#include "io/textured_model.h"

namespace gpvc::io {

namespace {

namespace fs = std::filesystem;

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
GltfLayout lay_out(const GltfAsset& asset, bool embed_pages, std::size_t buffer_limit) {
  GltfLayout layout;
  layout.buffer_bytes = {0};
  const auto place = [&](std::size_t bytes) {
    std::size_t& size = layout.buffer_bytes.back();
    const Part part{layout.buffer_bytes.size() - 1, size, bytes};
    size = padded(size + bytes);
    return part;
  };
  const std::vector<GltfPrimitive>& primitives = asset.data.geometry.primitives;
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    std::array<std::size_t, kGltfArrays> bytes{};
    for (const GltfArray array : kAllArrays) bytes[array] = bytes_of(asset, p, array);
    const std::size_t sum = std::accumulate(bytes.begin(), bytes.end(), std::size_t{0});
    if (layout.buffer_bytes.back() > 0 && layout.buffer_bytes.back() + sum > buffer_limit)
      layout.buffer_bytes.push_back(0);
    auto& parts = layout.primitives.emplace_back();
    std::ranges::transform(bytes, parts.begin(), place);
  }
  if (asset.photos != nullptr) layout.photo_table = place(photo_columns(*asset.photos).size());
  if (!embed_pages) return layout;
  for (const GltfPrimitive& primitive : primitives) {
    const PageFile& page = asset.pages[primitive.page];
    EmbeddedPage& embedded = layout.pages.emplace_back();
    embedded.page = place(embedded_bytes(page.file));
    if (!page.fallback.empty()) embedded.fallback = place(embedded_bytes(page.fallback));
  }
  return layout;
}

void write_primitive(OutputFile& out, const GltfAsset& asset, std::size_t primitive) {
  for (const GltfArray array : kAllArrays) {
    std::size_t written = 0;
    write_array(asset, primitive, array, [&](const void* bytes, std::size_t count) {
      out.write(bytes, count);
      written += count;
    });
    out.write("\0\0\0", padded(written) - written);
  }
}

void write_photo_table(OutputFile& out, const GltfAsset& asset) {
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

std::size_t glb_bytes(const std::string& json, const GltfLayout& layout) {
  return 12 + 8 + padded(json.size()) + 8 + layout.buffer_bytes.front();
}

void write_binary(const GltfAsset& asset, const GltfLayout& layout, std::string json) {
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
  for (std::size_t i = 0; i < layout.primitives.size(); ++i) write_primitive(out, asset, i);
  write_photo_table(out, asset);
  for (std::size_t i = 0; i < layout.pages.size(); ++i) {
    const PageFile& page = asset.pages[asset.data.geometry.primitives[i].page];
    write_page(out, page.file, layout.pages[i].page.bytes);
    if (!page.fallback.empty()) write_page(out, page.fallback, layout.pages[i].fallback->bytes);
  }
  out.commit();
}

void write_buffers(const GltfAsset& asset, const GltfLayout& layout, const std::vector<fs::path>& files) {
  for (std::size_t buffer = 0; buffer < files.size(); ++buffer) {
    OutputFile out(files[buffer]);
    for (std::size_t i = 0; i < layout.primitives.size(); ++i)
      if (layout.primitives[i].front().buffer == buffer) write_primitive(out, asset, i);
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
  GltfData data = gltf_data(model, pages.size(), options, photos);
  const auto with_suffix = [&](const std::string& suffix) {
    fs::path file = stem;
    return file += suffix;
  };
  GltfFiles result;
  result.file = with_suffix(".glb");
  if (data.geometry.faces.empty()) throw OutputError(result.file, "cannot be written: no face has a texture");
  if (container == GltfContainer::glb) {
    const GltfAsset asset{result.file, model, pages, options, data, photos};
    const GltfLayout layout = lay_out(asset, true, std::numeric_limits<std::size_t>::max());
    std::string json = describe(asset, layout, {});
    constexpr std::size_t kLargest = 0xFFFFFFFFu;
    result.glb_bytes = glb_bytes(json, layout);
    if (result.glb_bytes <= kLargest) {
      write_binary(asset, layout, std::move(json));
      result.faces = std::move(data.geometry.faces);
      return result;
    }
  }
  result.file = with_suffix(".gltf");
  const GltfAsset asset{result.file, model, pages, options, data, photos};
  const GltfLayout layout = lay_out(asset, false, options.buffer_limit_bytes);
  for (std::size_t i = 0; i < layout.buffer_bytes.size(); ++i)
    result.buffers.push_back(with_suffix((i == 0 ? "" : std::string("_").append(std::to_string(i))) + ".bin"));
  write_buffers(asset, layout, result.buffers);
  write_file(result.file, describe(asset, layout, result.buffers));
  result.faces = std::move(data.geometry.faces);
  return result;
}

std::size_t gltf_geometry_bytes(const TexturedModel& model, std::size_t pages, const ModelOptions& options) {
  check_model(model, pages);
  const fs::path no_file;
  const GltfData data = gltf_data(model, pages, options, nullptr);
  return lay_out({no_file, model, {}, options, data, nullptr}, false, std::numeric_limits<std::size_t>::max())
      .buffer_bytes.front();
}

}  // namespace gpvc::io
