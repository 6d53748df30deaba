#include "app/view/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <numeric>

#include "app/ortho/surface.h"
#include "io/file_bytes.h"
#include "io/model_pages.h"
#include "io/npy.h"
#include "io/paths.h"

namespace gpvc::view {
namespace {

namespace fs = std::filesystem;

constexpr int kQuarterQuality = 85, kFullQuality = 95;

// A page of any number of results, in the folder for what is made of them.
ResultPage new_page(const ScratchFolder& scratch) {
  static std::atomic<unsigned> serial = 0;
  const std::string name = fmt::format("page-{}", serial++);
  ResultPage page;
  page.file = scratch.path() / (name + ".jpg");
  page.quarter = scratch.path() / (name + "-quarter.jpg");
  return page;
}

void describe(ResultPage& page) {
  const io::ImageSize size = io::read_image_size(page.file);
  page.width = size.width;
  page.height = size.height;
  page.key = fmt::format("{:016x}", std::hash<std::string_view>{}(io::FileBytes(page.file).view()));
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
  std::vector<fs::path> files;
  const auto take_page = [&](std::size_t number, const Image& page) {
    if (result.pages.size() <= number) result.pages.resize(number + 1);
    result.pages[number] = new_page(scratch);
    io::write_image(result.pages[number].file, page, io::ImageFormat::jpg, kFullQuality);
  };
  io::LoadedModel loaded = io::read_model_pages(result.model_file, take_page, files);
  for (const fs::path& file : files) {
    result.pages.push_back(new_page(scratch));
    result.pages.back().file = file;
  }
  // Numbers without a page are images of a glTF that no face shows.
  for (ResultPage& page : result.pages)
    if (!page.file.empty()) describe(page);
  result.mesh = std::move(loaded.mesh);
  result.model = std::move(loaded.model);
  result.offset = loaded.offset;
  if (std::ranges::all_of(result.model.face_page, [](std::uint32_t page) { return page == io::kNoPage; }))
    throw InputError(result.model_file, "", "has no textured face");
  read_arrays(result);
  return result;
}

void make_quarter(const ResultPage& page) {
  if (io::is_file(page.quarter)) return;
  const Image image = io::read_image(page.file);
  io::write_image(page.quarter, io::reduce_image(image, std::clamp(std::min(image.width, image.height), 1, 4)),
                  io::ImageFormat::jpg, kQuarterQuality);
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
