#include "io/bands/band_range.h"

#include <algorithm>
#include <cmath>

namespace gpvc::io {
namespace {

/// \pre samples are sorted, and there are some
double quantile(const std::vector<float>& samples, double part) {
  return static_cast<double>(
      samples[static_cast<std::size_t>(std::lround(part * static_cast<double>(samples.size() - 1)))]);
}

}  // namespace

std::vector<float> some_samples(const BandPhoto& photo) {
  constexpr std::size_t kMost = 40000;  // pixels
  const Samples& samples = photo.samples;
  const std::size_t pixels = pixel_index(0, samples.height, samples.width), size = bytes_of(samples.type);
  // No divisor of a usual width, so that columns change from row to row.
  const std::size_t step = pixels / kMost / 2 * 2 + 1;
  std::vector<float> some;
  for (std::size_t pixel = 0; pixel < pixels; pixel += step) {
    const auto width = static_cast<std::size_t>(samples.width);
    if (photo.exclusion && photo.exclusion->excludes(static_cast<int>(pixel % width), static_cast<int>(pixel / width)))
      continue;
    const std::byte* from = samples.bytes.data() + pixel * samples.pixel_bytes();
    for (std::size_t band = 0; band < samples.bands; ++band)
      some.push_back(load_sample(from + band * size, samples.type));
  }
  return some;
}

void set_range(BandSet& set, std::vector<float> samples, bool linear_light) {
  const double full = set.type == SampleType::u8 ? 255 : set.type == SampleType::u16 ? 65535 : 1;
  set.black = 0;
  set.white = full;
  if (set.type == SampleType::u8 || samples.empty()) return;
  std::ranges::sort(samples);
  constexpr double kNearlyAll = 1e-4, kMost = 1e-3, kMargin = 0.05, kMuch = 0.25;
  const double least = quantile(samples, kNearlyAll), most = quantile(samples, 1 - kNearlyAll);
  const bool uses_all = !set.radiometric && least >= 0 && most <= full && most - least >= kMuch * full;
  if (linear_light ? quantile(samples, 0.5) <= full : uses_all) return;
  double black = quantile(samples, kMost), white = quantile(samples, 1 - kMost);
  const double margin = kMargin * (white - black);
  black -= margin;
  white += margin;
  if (least >= 0 || linear_light) black = std::max(black, 0.0);
  if (linear_light) black = 0;
  if (set.type == SampleType::u16) {
    black = std::floor(black);
    white = std::min(std::ceil(white), full);
  }
  if (!(white > black)) white = black + 1;
  set.black = black;
  set.white = white;
}

}  // namespace gpvc::io
