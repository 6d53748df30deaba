#include "app/evaluate/photo_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "app/results/observer.h"
#include "io/color_difference.h"
#include "io/order_statistics.h"

namespace gpvc::evaluate {
namespace {

constexpr double kNarrow = 1, kWide = 2;  ///< standard deviations of the two filters, pixels
/// Beyond three standard deviations of the wide filter a tile's border is not felt.
constexpr int kTile = 256, kBorder = 6;

struct Edge {
  float slope, ratio;  ///< after the wide filter; its square against that after the narrow one, squared
};

struct Edges {
  std::vector<Edge> along_x, along_y;  ///< whose slope is along x or y for the most part
};

cv::Mat luma_of(const Image& photo, int x0, int y0, int width, int height) {
  cv::Mat luma(height, width, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* rgb = photo.at(x0 + x, y0 + y);
      luma.at<float>(y, x) = 0.299F * static_cast<float>(rgb[0]) + 0.587F * static_cast<float>(rgb[1]) +
                             0.114F * static_cast<float>(rgb[2]);
    }
  return luma;
}

std::array<float, 2> slope_at(const cv::Mat& m, int x, int y) {
  return {(m.at<float>(y, x + 1) - m.at<float>(y, x - 1)) / 2, (m.at<float>(y + 1, x) - m.at<float>(y - 1, x)) / 2};
}

float squared(const std::array<float, 2>& v) { return v[0] * v[0] + v[1] * v[1]; }

/// Appends the places of a tile where the slope is the largest along its own direction.
void add_edges(const cv::Mat& luma, Edges& edges) {
  cv::Mat narrow, wide;
  cv::GaussianBlur(luma, narrow, {}, kNarrow);
  cv::GaussianBlur(luma, wide, {}, kWide);
  for (int y = kBorder; y < luma.rows - kBorder; ++y)
    for (int x = kBorder; x < luma.cols - kBorder; ++x) {
      const std::array<float, 2> slope = slope_at(wide, x, y);
      const float here = squared(slope);
      const bool along_x = std::abs(slope[0]) > std::abs(slope[1]);
      const int dx = along_x ? 1 : 0, dy = along_x ? 0 : 1;
      if (!(here > squared(slope_at(wide, x - dx, y - dy)) && here >= squared(slope_at(wide, x + dx, y + dy))))
        continue;
      const float finer = squared(slope_at(narrow, x, y));
      (along_x ? edges.along_x : edges.along_y).push_back({here, finer / here});
    }
}

/// The blur of the strongest of the edges, in the median.
double blur_of(std::vector<Edge>& edges) {
  if (edges.empty()) return 0;
  // Weak ones are grain and JPEG's blocks.
  constexpr std::size_t kOneIn = 20;
  const std::size_t strong = (edges.size() + kOneIn - 1) / kOneIn;
  std::nth_element(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(strong - 1), edges.end(),
                   [](const Edge& a, const Edge& b) { return a.slope > b.slope; });
  edges.resize(strong);
  const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(strong / 2);
  std::nth_element(edges.begin(), middle, edges.end(), [](const Edge& a, const Edge& b) { return a.ratio < b.ratio; });
  // ratio = (sigma^2 + wide^2 + span) / (sigma^2 + narrow^2 + span). Differences over two pixels are slopes after a box
  // of that width, which has a variance of 2^2 / 12.
  constexpr double kSpan = 1.0 / 3;
  const double ratio = middle->ratio;
  if (ratio <= 1) return std::numeric_limits<double>::infinity();
  const double variance = (kWide * kWide - ratio * kNarrow * kNarrow) / (ratio - 1) - kSpan;
  return std::sqrt(std::max(0.0, variance));
}

/// Tiles evenly over the photo.
Edges edges_of(const Image& photo) {
  const auto places = [](int size) {
    constexpr int kMostTiles = 8;
    std::vector<int> starts;
    const int count = std::clamp(size / kTile, 1, kMostTiles);
    for (int i = 0; i < count; ++i) starts.push_back(count == 1 ? 0 : (size - kTile) * i / (count - 1));
    return starts;
  };
  Edges edges;
  for (const int y : places(photo.height))
    for (const int x : places(photo.width))
      add_edges(luma_of(photo, x, y, std::min(kTile, photo.width - x), std::min(kTile, photo.height - y)), edges);
  return edges;
}

std::array<double, 256> linear_levels() {
  std::array<double, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = light_of_level(static_cast<double>(i));
  return linear;
}

template <class Value>
double median_of(const std::vector<PhotoQuality>& photos, Value value) {
  std::vector<double> values;
  for (const PhotoQuality& photo : photos) values.push_back(photo.*value);
  return upper_median(std::span(values));
}

}  // namespace

PhotoQuality photo_quality(const Image& photo) {
  Edges edges = edges_of(photo);
  PhotoQuality quality;
  quality.blur = std::max(blur_of(edges.along_x), blur_of(edges.along_y));
  constexpr int kStep = 4;
  static const std::array<double, 256> kLinear = linear_levels();
  constexpr std::uint8_t kTop = 254;  // JPEG moves the last level by one
  std::size_t looked_at = 0, clipped = 0;
  for (int y = 0; y < photo.height; y += kStep)
    for (int x = 0; x < photo.width; x += kStep, ++looked_at) {
      const std::uint8_t* rgb = photo.at(x, y);
      quality.brightness += 0.2126 * kLinear[rgb[0]] + 0.7152 * kLinear[rgb[1]] + 0.0722 * kLinear[rgb[2]];
      clipped += rgb[0] >= kTop || rgb[1] >= kTop || rgb[2] >= kTop ? 1 : 0;
    }
  if (looked_at == 0) return quality;
  quality.brightness /= static_cast<double>(looked_at);
  quality.clipped = static_cast<double>(clipped) / static_cast<double>(looked_at);
  return quality;
}

std::vector<std::string> quality_warnings(const std::vector<PhotoQuality>& photos,
                                          const std::vector<std::string>& names) {
  if (photos.empty()) return {};
  // With the blur of a pixel itself, at twice the width: a photo of half the size would have shown as much.
  constexpr double kBlurred = 2, kPixel = 0.5;
  // Gains of a stop bring noise and burnt-out whites along.
  constexpr double kStop = 2;
  const double blur = std::max(kPixel, median_of(photos, &PhotoQuality::blur));
  const double brightness = median_of(photos, &PhotoQuality::brightness);
  std::vector<std::string> blurred, other;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const PhotoQuality& photo = photos[i];
    if (photo.blur > kBlurred * blur) blurred.push_back(names[i]);
    if (photo.brightness > kStop * brightness || kStop * photo.brightness < brightness) other.push_back(names[i]);
  }
  constexpr std::size_t kNamed = 10;
  std::vector<std::string> lines;
  if (!blurred.empty())
    lines.push_back(
        fmt::format("{} photos are blurred more than twice as much as the others, out of focus or shaken: {}",
                    blurred.size(), results::readable_list(blurred, kNamed)));
  if (!other.empty())
    lines.push_back(fmt::format("{} photos are brighter or darker than the others by more than a stop: {}",
                                other.size(), results::readable_list(other, kNamed)));
  return lines;
}

}  // namespace gpvc::evaluate
