#include "labeling/costs/photo_gradient.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gpvc::labeling {
namespace {

/// Rec. 601 luma in grey levels, with the first and the last pixel repeated.
void luma_row(const Image& photo, int y, std::vector<std::int16_t>& out) {
  const auto width = static_cast<std::size_t>(photo.width);
  const std::uint8_t* in = photo.at(0, std::clamp(y, 0, photo.height - 1));
  for (std::size_t x = 0; x < width; ++x)
    out[x + 1] = static_cast<std::int16_t>((77 * in[3 * x] + 150 * in[3 * x + 1] + 29 * in[3 * x + 2] + 128) >> 8);
  out[0] = out[1];
  out[width + 1] = out[width];
}

void gradient_row(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, std::uint16_t* out,
                  std::size_t width) {
  for (std::size_t x = 0; x < width; ++x) {
    const int dx = above[x + 2] - above[x] + 2 * (here[x + 2] - here[x]) + below[x + 2] - below[x];
    const int dy = below[x] - above[x] + 2 * (below[x + 1] - above[x + 1]) + below[x + 2] - above[x + 2];
    out[x] = static_cast<std::uint16_t>(static_cast<int>(std::sqrt(static_cast<float>(dx * dx + dy * dy)) + 0.5f));
  }
}

}  // namespace

std::vector<std::uint16_t> gradient_magnitude(const Image& photo) {
  const auto width = static_cast<std::size_t>(photo.width);
  std::vector<std::uint16_t> gradient(width * static_cast<std::size_t>(photo.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, photo.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::array<std::vector<std::int16_t>, 3> luma;
    for (auto& row : luma) row.resize(width + 2);
    const auto slot = [](int y) { return static_cast<std::size_t>(y + 3) % 3; };
    luma_row(photo, rows.begin() - 1, luma[slot(rows.begin() - 1)]);
    luma_row(photo, rows.begin(), luma[slot(rows.begin())]);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      luma_row(photo, y + 1, luma[slot(y + 1)]);
      gradient_row(luma[slot(y - 1)].data(), luma[slot(y)].data(), luma[slot(y + 1)].data(),
                   gradient.data() + static_cast<std::size_t>(y) * width, width);
    }
  });
  return gradient;
}

}  // namespace gpvc::labeling
