#include "atlas/blending/coarse_photo.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "io/bilinear.h"
#include "io/images.h"

namespace gpvc::atlas {

namespace {

int edge_of_squares(const Image& photo) { return std::min({kCoarsePixel, photo.width, photo.height}); }

}  // namespace

CoarsePhoto::CoarsePhoto(const Image& photo) : image_(io::reduce_image(photo, edge_of_squares(photo))) {}

CoarsePhoto CoarsePhoto::of_means(Image means) {
  CoarsePhoto coarse;
  coarse.image_ = std::move(means);
  return coarse;
}

Color CoarsePhoto::at(const PhotoPoint& q) const {
  const auto rgb = bilinear<float>(image_, q.x / kCoarsePixel, q.y / kCoarsePixel);
  return {rgb[0], rgb[1], rgb[2]};
}

Color coarse_color(const Image& photo, const PhotoPoint& q) {
  const int edge = edge_of_squares(photo);
  const auto mean = [&](int column, int row) {
    std::array<int, 3> sum{};
    for (int y = row * edge; y < (row + 1) * edge; ++y)
      for (int x = column * edge; x < (column + 1) * edge; ++x)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += photo.at(x, y)[c];
    for (int& s : sum) s = (s + edge * edge / 2) / (edge * edge);
    return sum;
  };
  const auto rgb =
      bilinear_of<float>(photo.width / edge, photo.height / edge, q.x / kCoarsePixel, q.y / kCoarsePixel, mean);
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace gpvc::atlas
