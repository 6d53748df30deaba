#include "app/view/pictures.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/error.h"
#include "io/file_bytes.h"

namespace gpvc::view {

namespace fs = std::filesystem;

ScratchFolder::ScratchFolder() {
  std::error_code failed;
  std::string name = (fs::temp_directory_path(failed) / "gpvc-view-XXXXXX").string();
  if (failed || mkdtemp(name.data()) == nullptr)
    throw OutputError(name, fmt::format("cannot be made: {}", std::strerror(errno)));
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string encoded(const ScratchFolder& scratch, const Image& image, io::ImageFormat format, int quality) {
  static std::atomic<unsigned> number = 0;
  const fs::path file = scratch.path() / fmt::format("encoded-{}", number++);
  io::write_image(file, image, format, quality);
  std::string bytes(io::FileBytes(file).view());
  std::error_code ignored;
  fs::remove(file, ignored);
  return bytes;
}

Image at_most(const Image& image, int edge) {
  const int longer = std::max(image.width, image.height), shorter = std::min(image.width, image.height);
  return io::reduce_image(image, std::clamp((longer + edge - 1) / edge, 1, std::max(1, shorter)));
}

std::shared_ptr<const Image> TakenPhotos::photo(const fs::path& file) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(kept_, file, [](const auto& kept) -> const fs::path& { return kept.first; });
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return kept_.front().second;
    }
  }
  auto image = std::make_shared<const Image>(io::read_image(file));
  const std::lock_guard lock(mutex_);
  kept_.emplace_front(file, image);
  std::size_t bytes = 0;
  for (auto at = kept_.begin(); at != kept_.end();) {
    bytes += at->second->pixels.size();
    at = bytes > most_bytes_ && at != kept_.begin() ? kept_.erase(at) : std::next(at);
  }
  return image;
}

}  // namespace gpvc::view
