#include "app/ortho/page_store.h"

#include <algorithm>
#include <cmath>

namespace gpvc::ortho {

std::size_t PageStore::take_room(std::size_t number, int width, int height, std::size_t Place::*part,
                                 std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const std::size_t place = std::exchange(end_, end_ + bytes);
  pages_.resize(std::max(pages_.size(), number + 1));
  place_.resize(pages_.size());
  pages_[number] = {width, height};
  place_[number].*part = place;
  return place;
}

void PageStore::take_page(std::size_t number, Image page) {
  const std::size_t place = take_room(number, page.width, page.height, &Place::rgb, page.pixels.size());
  file_.write(place, page.pixels.data(), page.pixels.size());
}

void PageStore::take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) {
  const Samples& samples = page.samples;
  const std::size_t place = take_room(number, samples.width, samples.height, &Place::samples, samples.bytes.size());
  file_.write(place, samples.bytes.data(), samples.bytes.size());
  const std::lock_guard lock(mutex_);
  bands_ = bands;
}

void PageStore::complete() {
  const std::span<const std::uint8_t> bytes = file_.map(end_);
  for (std::size_t n = 0; n < pages_.size(); ++n) {
    pages_[n].rgb = bytes.data() + place_[n].rgb;
    if (place_[n].samples == Place::kNone)
      bands_.reset();
    else
      pages_[n].samples = reinterpret_cast<const std::byte*>(bytes.data() + place_[n].samples);
  }
}

void PageStore::add_samples(const StoredPage& page, double x, double y, std::span<float> sums) const {
  const double u = std::clamp(x - 0.5, 0.0, page.width - 1.0), v = std::clamp(y - 0.5, 0.0, page.height - 1.0);
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const int x1 = std::min(x0 + 1, page.width - 1), y1 = std::min(y0 + 1, page.height - 1);
  const auto across = static_cast<float>(u - x0), down = static_cast<float>(v - y0);
  const auto add = [&](int column, int row, float weight) {
    const std::byte* from = page.samples + pixel_index(column, row, page.width) * bands_->pixel_bytes();
    for (std::size_t b = 0; b < sums.size(); ++b)
      sums[b] += weight * load_sample(from + b * bytes_of(bands_->type), bands_->type);
  };
  add(x0, y0, (1 - across) * (1 - down));
  add(x1, y0, across * (1 - down));
  add(x0, y1, (1 - across) * down);
  add(x1, y1, across * down);
}

}  // namespace gpvc::ortho
