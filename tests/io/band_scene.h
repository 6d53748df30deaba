// A scene of photos with bands, and what tests of bands fill it with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/samples.h"
#include "io/scene_files.h"
#include "tests/io/colmap_folder.h"
#include "tests/support/tiff_photo.h"

namespace gpvc::test {

/// A scene of some photos, which the test writes.
class BandScene {
 public:
  explicit BandScene(std::vector<std::string> names) : names_(std::move(names)) {
    std::vector<TestImage> images;
    for (const std::string& name : names_)
      images.push_back({static_cast<std::uint32_t>(images.size() + 1), {1, 0, 0, 0}, {1, 2, 3}, 7, name});
    colmap_.model(false, kCameras, images);
  }
  std::filesystem::path place(const std::string& name) const { return colmap_.folder.path() / "images" / name; }
  void write(const std::string& name, const Samples& samples, const TiffLayout& layout = {}) const {
    write_tiff(place(name), samples, layout);
  }
  void write_all(const Samples& samples, const TiffLayout& layout = {}) const {
    for (const std::string& name : names_) write(name, samples, layout);
  }
  Scene read(const io::SceneOptions& options = {}) const { return io::read_scene(colmap_.folder.path(), options); }
  std::filesystem::path folder() const { return colmap_.folder.path(); }

 private:
  std::vector<std::string> names_;
  ColmapFolder colmap_{{}};
};

/// Band b of pixel (x, y) is value(b, x, y).
template <typename Value>
Samples picture(std::size_t bands, SampleType type, const Value& value, int width = kFrameWidth,
                int height = kFrameHeight) {
  Samples samples{width, height, bands, type, {}};
  samples.bytes.resize(pixel_index(0, height, width) * samples.pixel_bytes());
  std::byte* to = samples.bytes.data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (std::size_t b = 0; b < bands; ++b, to += bytes_of(type))
        store_sample(to, type, static_cast<float>(value(b, x, y)));
  return samples;
}

/// Spread over `low` to `high`.
inline Samples spread(std::size_t bands, SampleType type, double low, double high) {
  return picture(bands, type, [&](std::size_t b, int x, int y) {
    const double part = ((x * 7 + y * 13 + static_cast<int>(b) * 5) % 64) / 63.0;
    return low + (high - low) * part;
  });
}

inline bool has_warning(const Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings)
    if (warning.find(part) != std::string::npos) return true;
  return false;
}

inline std::string names_of(const Scene& scene) {
  std::string names;
  for (const Band& band : scene.bands->bands) names += (names.empty() ? "" : ",") + band.name;
  return names;
}

}  // namespace gpvc::test
