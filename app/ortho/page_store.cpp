#include "app/ortho/page_store.h"

#include <algorithm>

namespace gpvc::ortho {

void PageStore::take_page(std::size_t number, Image page) {
  std::size_t place = 0;
  {
    const std::lock_guard lock(mutex_);
    place = std::exchange(end_, end_ + page.pixels.size());
    pages_.resize(std::max(pages_.size(), number + 1));
    place_.resize(pages_.size());
    pages_[number] = {page.width, page.height, nullptr};
    place_[number] = place;
  }
  file_.write(place, page.pixels.data(), page.pixels.size());
}

void PageStore::complete() {
  const std::span<const std::uint8_t> bytes = file_.map(end_);
  for (std::size_t n = 0; n < pages_.size(); ++n) pages_[n].rgb = bytes.data() + place_[n];
}

}  // namespace gpvc::ortho
