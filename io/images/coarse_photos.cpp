// Coarse photos, made when photos are decoded and kept on disk.
#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "io/images.h"
#include "io/photos.h"
#include "io/scratch_file.h"

namespace gpvc::io {

Image coarse_image(const Image& photo) {
  return reduce_image(photo, std::min({kCoarsePixel, photo.width, photo.height}));
}

std::shared_ptr<const Image> PhotoSource::coarse(ViewId view) {
  return std::make_shared<const Image>(coarse_image(*photo(view)));
}

std::vector<std::uint32_t> photo_of_view(const Scene& scene) {
  std::map<std::filesystem::path, std::uint32_t> first;
  std::vector<std::uint32_t> photos;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const std::filesystem::path& photo = scene.views[v].photo;
    photos.push_back(photo.empty() ? v : first.try_emplace(photo, v).first->second);
  }
  return photos;
}

struct CoarsePhotos::Store {
  /// Where the means are in the file, and how many; none of photos that are not kept.
  struct Place {
    std::size_t begin = 0;
    int width = 0, height = 0;
  };

  Store(const Scene& scene, const std::filesystem::path& folder, std::size_t most_bytes)
      : photo(photo_of_view(scene)), most(most_bytes), places(photo.size()) {
    if (most > 0) file.emplace(folder);
  }

  std::optional<Place> find(ViewId view) {
    const std::lock_guard lock(mutex);
    const Place place = places[photo[index(view)]];
    return place.width > 0 ? std::optional(place) : std::nullopt;
  }

  bool has_room(std::size_t bytes) {
    const std::lock_guard lock(mutex);
    return bytes <= most - end;
  }

  void keep(ViewId view, const Image& means) {
    Place place{0, means.width, means.height};
    {
      const std::lock_guard lock(mutex);
      if (means.pixels.size() > most - end) return;
      place.begin = std::exchange(end, end + means.pixels.size());
    }
    bool written = true;
    try {
      file->write(place.begin, means.pixels.data(), means.pixels.size());
    } catch (const OutputError&) {
      written = false;  // the disk is full: photos are decoded again
    }
    const std::lock_guard lock(mutex);
    if (written)
      places[photo[index(view)]] = place;
    else
      most = end;
  }

  const std::vector<std::uint32_t> photo;  ///< per view
  std::mutex mutex;
  std::size_t most, end = 0;  ///< of the file
  std::vector<Place> places;  ///< per photo
  std::optional<ScratchFile> file;
};

CoarsePhotos::CoarsePhotos(PhotoSource& photos, const Scene& scene, const std::filesystem::path& folder,
                           std::size_t most)
    : photos_(photos), store_(std::make_unique<Store>(scene, folder, most)) {}

CoarsePhotos::~CoarsePhotos() = default;

std::shared_ptr<const Image> CoarsePhotos::photo(ViewId view) {
  std::shared_ptr<const Image> photo = photos_.photo(view);
  if (!store_->find(view) &&
      store_->has_room(pixel_index(0, photo->height / kCoarsePixel, photo->width / kCoarsePixel) * 3))
    store_->keep(view, coarse_image(*photo));
  return photo;
}

std::shared_ptr<const Image> CoarsePhotos::coarse(ViewId view) {
  const std::optional<Store::Place> place = store_->find(view);
  if (!place) {
    Image means = coarse_image(*photos_.photo(view));
    store_->keep(view, means);
    return std::make_shared<const Image>(std::move(means));
  }
  const std::size_t bytes = pixel_index(0, place->height, place->width) * 3;
  const auto read = std::make_shared_for_overwrite<std::uint8_t[]>(bytes);
  store_->file->read(place->begin, read.get(), bytes);
  return std::make_shared<const Image>(
      Image{place->width, place->height, 3, Pixels::borrowed({read.get(), bytes}, read)});
}

}  // namespace gpvc::io
