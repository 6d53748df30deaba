#include "atlas/blending/coarse_store.h"

#include <utility>

namespace gpvc::atlas {

CoarseStore::CoarseStore(std::size_t views, const std::filesystem::path& folder, std::size_t most)
    : most_(most), places_(views) {
  if (most > 0) file_.emplace(folder);
}

CoarsePhoto CoarseStore::read(ViewId view) const {
  const Place& place = places_[index(view)];
  Image means{place.width, place.height, 3, {}};
  means.pixels.resize(pixel_index(0, place.height, place.width) * 3);
  file_->read(place.begin, means.pixels.data(), means.pixels.size());
  return CoarsePhoto::of_means(std::move(means));
}

void CoarseStore::keep(ViewId view, const CoarsePhoto& coarse) {
  const Image& means = coarse.means();
  const std::vector<std::uint8_t>& pixels = means.pixels;
  if (has(view) || pixels.size() > most_ - end_) return;
  try {
    file_->write(end_, pixels.data(), pixels.size());
  } catch (const OutputError&) {
    most_ = end_;  // the disk is full: photos are decoded again
    return;
  }
  places_[index(view)] = {end_, means.width, means.height};
  end_ += pixels.size();
}

}  // namespace gpvc::atlas
