// Pictures as the page gets them: encoded, and photos that are decoded once for several questions.
#pragma once

#include <cstddef>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "io/image.h"
#include "io/images.h"

namespace gpvc::view {

/// A folder for files of one run, gone with this value; that of a killed process goes when the next one is made. Throws OutputError.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The bytes of an image file. Throws OutputError.
std::string encoded(const ScratchFolder& scratch, const Image& image, io::ImageFormat format, int quality);

/// At most so many texels along the longer edge.
Image at_most(const Image& image, int edge);

/// The last photos that were asked for, as their files have them. Thread-safe.
class TakenPhotos {
 public:
  explicit TakenPhotos(std::size_t most_bytes) : most_bytes_(most_bytes) {}
  /// Throws InputError.
  std::shared_ptr<const Image> photo(const std::filesystem::path& file);

 private:
  std::size_t most_bytes_;
  std::mutex mutex_;
  std::list<std::pair<std::filesystem::path, std::shared_ptr<const Image>>> kept_;  ///< the last asked for first
};

}  // namespace gpvc::view
