#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "io/files/text_scan.h"
#include "io/images.h"
#include "io/images/image_file.h"
#include "io/photos.h"
#include "io/scenes/photo_files.h"

namespace gpvc::io {

void warn_of_unused_range(SceneFile& scene) {
  std::vector<std::size_t> candidates;  // others than JPEGs, whose headers need not be opened
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const std::string extension = lower_case(scene.views[i].photo.extension().string());
    if (!scene.views[i].photo.empty() && extension != ".jpg" && extension != ".jpeg") candidates.push_back(i);
  }
  constexpr std::size_t kMost = 8;
  const std::size_t count = std::min(candidates.size(), kMost);
  std::array<std::atomic<bool>, 256> used{};
  std::atomic<std::size_t> deep{0}, beyond{0};
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t n) {
    try {
      const std::filesystem::path& photo = scene.views[candidates[n * candidates.size() / count]].photo;
      if (lies_beyond_range(photo)) ++beyond;
      if (sample_bits(photo) <= 8) return;  // floats have none
      for (const std::uint8_t value : read_image(photo).pixels) used[value].store(true, std::memory_order_relaxed);
      ++deep;
    } catch (const InputError&) {
      // told where the photo is used
    }
  });
  if (beyond > 0)
    scene.warnings.push_back(std::to_string(beyond) + " of " + std::to_string(count) +
                             " photos looked at hold floating-point samples that lie beyond 0 to 1 on most of their "
                             "pixels (temperatures?), which become black or white: scale all of them alike to 0 to 1");
  const auto is_used = [](const std::atomic<bool>& level) { return level.load(); };
  const auto first = std::ranges::find_if(used, is_used);
  const auto end = std::find_if(used.rbegin(), used.rend(), is_used).base();
  // Of 12 bits in 16 there are 17 levels left. A dark photo has a light somewhere, which needs its range.
  constexpr std::ptrdiff_t kFew = 64;
  if (deep == 0 || end - first >= kFew) return;
  scene.warnings.push_back("photos of more than 8 bits a sample use the levels " +
                           std::to_string(first - used.begin()) + " to " + std::to_string(end - used.begin() - 1) +
                           " of the 0 to 255 of 8 bits, which they are worked on with (" + std::to_string(deep) +
                           " were looked at): stretch all of them alike over the whole range of their files");
}

}  // namespace gpvc::io
