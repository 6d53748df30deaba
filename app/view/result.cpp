#include "app/view/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <numeric>

#include "app/ortho/surface.h"
#include "app/pipeline/texture_files.h"
#include "io/file_bytes.h"
#include "io/npy.h"
#include "io/paths.h"

namespace gpvc::view {
namespace {

namespace fs = std::filesystem;

constexpr int kQuarterQuality = 85, kFullQuality = 95;

// The file of a page that gpvc wrote beside its model; empty: there is none.
fs::path page_file(const fs::path& folder, std::size_t number) {
  for (const auto& [name, format] : io::kImageFormatNames) {
    const fs::path file = folder / pipeline::page_name(number, format);
    if (io::is_file(file)) return file;
  }
  return {};
}

ResultPage stored(const fs::path& folder, std::size_t number, bool beside, const Image& image,
                  const ScratchFolder& scratch) {
  static std::atomic<unsigned> serial = 0;
  ResultPage page;
  page.width = image.width;
  page.height = image.height;
  const std::string name = fmt::format("page-{}", serial++);
  if (beside) page.file = page_file(folder, number);
  if (page.file.empty()) {
    page.file = scratch.path() / (name + ".jpg");
    io::write_image(page.file, image, io::ImageFormat::jpg, kFullQuality);
  }
  page.quarter = scratch.path() / (name + "-quarter.jpg");
  io::write_image(page.quarter, io::reduce_image(image, std::clamp(std::min(image.width, image.height), 1, 4)),
                  io::ImageFormat::jpg, kQuarterQuality);
  page.key = fmt::format("{:016x}", std::hash<std::string_view>{}(io::FileBytes(page.file).view()));
  return page;
}

template <typename T>
std::vector<T> values_of(const fs::path& file, const std::vector<std::uint32_t>& face) {
  const std::vector<T> all = io::read_npy<T>(file).values;
  std::vector<T> values;
  for (const std::uint32_t f : face) {
    if (f >= all.size())
      throw InputError(file, "", fmt::format("has {} faces, and the model beside it shows face {}", all.size(), f));
    values.push_back(all[f]);
  }
  return values;
}

// What gpvc texture writes beside its models; nothing where the files are another program's.
void read_arrays(Result& result) {
  const fs::path& folder = result.folder;
  const std::size_t faces = result.mesh.faces.size();
  result.face.resize(faces);
  std::iota(result.face.begin(), result.face.end(), 0u);
  if (!io::is_file(folder / "labels.npy") || !io::is_file(folder / "tags.npy")) return;
  if (result.model_file.extension() != ".obj") {
    if (!io::is_file(folder / "faces.npy")) return;
    std::vector<std::uint32_t> shown = io::read_npy<std::uint32_t>(folder / "faces.npy").values;
    if (shown.size() != faces) return;
    result.face = std::move(shown);
  }
  result.labels = values_of<std::int32_t>(folder / "labels.npy", result.face);
  result.tags = values_of<std::uint8_t>(folder / "tags.npy", result.face);
}

}  // namespace

Result read_result(const fs::path& from, const ScratchFolder& scratch) {
  const std::vector<fs::path> models = ortho::models_of(from);
  if (models.size() > 1)
    throw InputError(from, "", "is a model in tiles, expected one model or a tileset with its tileset.json");
  Result result;
  result.model_file = models.front();
  result.folder = result.model_file.parent_path();
  const bool beside = result.model_file.filename() == "model.obj";
  std::vector<std::future<ResultPage>> pages;
  io::LoadedModel loaded = io::read_textured_model(result.model_file, [&](std::size_t number, Image page) {
    // Two at a time: the next page is decoded meanwhile, and no third one is held.
    if (pages.size() > 1) pages[pages.size() - 2].wait();
    pages.push_back(std::async(std::launch::async, [&, number, page = std::move(page)] {
      return stored(result.folder, number, beside, page, scratch);
    }));
  });
  for (auto& page : pages) result.pages.push_back(page.get());
  result.mesh = std::move(loaded.mesh);
  result.model = std::move(loaded.model);
  result.offset = loaded.offset;
  if (std::ranges::all_of(result.model.face_page, [](std::uint32_t page) { return page == io::kNoPage; }))
    throw InputError(result.model_file, "", "has no textured face");
  read_arrays(result);
  return result;
}

std::string media_type(const fs::path& image) {
  const io::FileBytes bytes(image, io::FileBytes::Use::in_places);
  const std::string_view head = bytes.view().substr(0, 12);
  if (head.starts_with("\xFF\xD8")) return "image/jpeg";
  if (head.starts_with("\x89PNG")) return "image/png";
  if (head.starts_with("RIFF") && head.ends_with("WEBP")) return "image/webp";
  return "application/octet-stream";
}

}  // namespace gpvc::view
