#include "app/texrecon/model_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/images.h"

namespace gpvc::texrecon {
namespace {

namespace fs = std::filesystem;

std::string page_ending(std::size_t number, bool samples) {
  return "_material" + four_digits(number) + "_map_Kd" + (samples ? ".tif" : ".png");
}

Image first_channel(const Image& page) {
  Image grey;
  grey.width = page.width;
  grey.height = page.height;
  grey.channels = 1;
  grey.pixels.reserve(page.pixels.size() / 3);
  for (std::size_t i = 0; i < page.pixels.size(); i += 3) grey.pixels.push_back(page.pixels[i]);
  return grey;
}

void apply_gamma(Image& page) {
  std::array<std::uint8_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint8_t>(std::lround(255 * std::pow(static_cast<double>(i) / 255, 1 / 2.2)));
  for (std::uint8_t& value : page.pixels) value = table[value];
}

}  // namespace

std::string four_digits(std::size_t number) { return fmt::format("{:04}", number); }

PrefixedFiles::PrefixedFiles(fs::path prefix) : prefix_(std::move(prefix)) {
  const fs::path folder = prefix_.has_parent_path() ? prefix_.parent_path() : ".";
  std::error_code failed;
  if (!fs::is_directory(folder, failed))
    throw OutputError(folder, "is no folder: OUT_PREFIX begins with an existing one");
  unfinished_ = folder / ("." + prefix_.filename().string() + ".unfinished");
  fs::remove_all(unfinished_, failed);  // of a run that was killed
  fs::create_directory(unfinished_, failed);
  if (failed) throw OutputError(unfinished_, "cannot be made: " + failed.message());
}

PrefixedFiles::~PrefixedFiles() { discard(); }

void PrefixedFiles::discard() noexcept {
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
}

fs::path PrefixedFiles::file(const std::string& ending) {
  names_.push_back(prefix_.filename().string() + ending);
  return unfinished_ / names_.back();
}

void PrefixedFiles::publish() {
  const fs::path folder = prefix_.has_parent_path() ? prefix_.parent_path() : ".";
  std::error_code failed;
  for (const fs::path& name : names_) {
    fs::rename(unfinished_ / name, folder / name, failed);
    if (failed) throw OutputError(folder / name, "cannot be replaced: " + failed.message());
  }
  const std::string stem = prefix_.filename().string() + "_material";
  for (std::size_t number = 0;; ++number) {
    bool any = false;
    for (const char* format : {".png", ".tif"}) {
      const fs::path name = stem + four_digits(number) + "_map_Kd" + format;
      if (std::ranges::find(names_, name) != names_.end())
        any = true;
      else
        any = fs::remove(folder / name, failed) || any;
    }
    if (!any) break;
  }
  discard();
}

std::future<void> ModelFiles::take_model(const io::TexturedModel& model) {
  auto shown = std::make_shared<io::TexturedModel>(model);
  std::vector<std::uint32_t> number(1, io::kNoPage);  // by the atlas's page
  for (std::size_t face = 0; face < model.face_page.size(); ++face) {
    std::uint32_t& page = shown->face_page[face];
    if (written_[face] == 0) page = io::kNoPage;
    if (page == io::kNoPage) continue;
    if (page >= number.size()) number.resize(page + 1, io::kNoPage);
    number[page] = 0;
  }
  std::uint32_t count = 0;
  page_files_.resize(number.size());
  auto pages = std::make_shared<std::vector<io::PageFile>>();
  for (std::size_t page = 0; page < number.size(); ++page) {
    if (number[page] == io::kNoPage) continue;
    number[page] = count;
    page_files_[page] = files_.file(ending_ + page_ending(count++, options_.samples));
    pages->push_back({page_files_[page], io::ImageFormat::png});
  }
  if (count == 0) throw Error("no face of the mesh is shown by a photo: there is nothing to write");
  for (std::uint32_t& page : shown->face_page)
    if (page != io::kNoPage) page = number[page];
  const fs::path obj_file = files_.file(ending_ + ".obj");
  files_.file(ending_ + ".mtl");
  io::ModelOptions options;
  options.pageless_faces = false;
  options.obj_style = io::ObjStyle::texrecon;
  return std::async(std::launch::async, [=] { io::write_obj(obj_file, *shown, *pages, options); });
}

void ModelFiles::take_page(std::size_t number, Image page) {
  if (options_.samples || number >= page_files_.size() || page_files_[number].empty()) return;
  if (options_.gamma) apply_gamma(page);
  if (options_.grey) page = first_channel(page);
  io::write_image(page_files_[number], page, io::ImageFormat::png, 0);
}

void ModelFiles::take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) {
  if (options_.samples && number < page_files_.size() && !page_files_[number].empty())
    io::write_samples(page_files_[number], page.samples, bands);
}

}  // namespace gpvc::texrecon
