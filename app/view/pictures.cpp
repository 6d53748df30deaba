#include "app/view/pictures.h"

#include <fmt/format.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>
#include <system_error>

#include "io/error.h"
#include "io/file_bytes.h"

namespace gpvc::view {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kName = "gpvc-view-";

// What processes have left that were killed: their number stands in the folder's name.
void remove_abandoned(const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    pid_t process = 0;
    if (!name.starts_with(kName) || entry.is_symlink(ignored)) continue;
    const auto read = std::from_chars(name.data() + kName.size(), name.data() + name.size(), process);
    if (read.ec != std::errc{} || process <= 0 || kill(process, 0) == 0 || errno != ESRCH) continue;
    fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::error_code failed;
  const fs::path temporary = fs::temp_directory_path(failed);
  if (!failed) remove_abandoned(temporary);
  std::string name = (temporary / fmt::format("{}{}-XXXXXX", kName, getpid())).string();
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
