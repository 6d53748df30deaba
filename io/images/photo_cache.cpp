// Photos from files, decoded once while they fit a budget.
#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "io/bands/band_photo.h"
#include "io/file_hashes.h"
#include "io/images.h"
#include "io/images/image_file.h"
#include "io/images/kept_photos.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"
#include "io/photos.h"
#include "io/scene_members.h"

namespace gpvc::io {

namespace {

/// A photo as its view takes it, with what is excluded of it where that is found by decoding it.
struct DecodedPhoto {
  Image image;
  std::optional<PhotoExclusion> exclusion{};
  std::optional<Samples> samples{};  ///< of a scene with bands, where they were asked for
  std::size_t bytes() const {
    return image.pixels.size() + (exclusion ? 8 * exclusion->words.size() : 0) + (samples ? samples->bytes.size() : 0);
  }
};
using Photo = std::shared_ptr<const DecodedPhoto>;

/// The memory of photos that were let go, for the next ones: the system would have to map and clear new pages for each photo.
/// What does not fit is freed when other memory is taken, so there is never more than photos have taken at a time.
class SpareMemory {
 public:
  std::vector<std::uint8_t> take(std::size_t bytes) {
    std::vector<std::uint8_t> pixels;
    {
      const std::lock_guard lock(mutex_);
      const auto fits = [&](const auto& s) { return s.capacity() >= bytes && s.capacity() <= bytes + bytes / 8; };
      auto taken = std::ranges::find_if(spare_, fits);
      if (taken == spare_.end()) taken = spare_.begin();
      if (taken != spare_.end()) {
        if (fits(*taken)) pixels.swap(*taken);
        spare_.erase(taken);
      }
    }
    pixels.resize(bytes);
    return pixels;
  }
  void give(std::vector<std::uint8_t> pixels) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(pixels));
  }
  void free() {
    const std::lock_guard lock(mutex_);
    spare_.clear();
  }

 private:
  std::mutex mutex_;
  std::vector<std::vector<std::uint8_t>> spare_;  ///< oldest first
};

/// The photo at its file's size, excluded pixels as they are.
DecodedPhoto decode_whole(const View& view, const PixelRoom& room) {
  std::optional<PhotoExclusion> transparent;
  if (view.uses_alpha) transparent.emplace();
  Image image = read_image(view.photo, room, transparent ? &*transparent : nullptr);
  if (image.width / view.reduction != file_width(view.camera) || image.height / view.reduction != view.camera.height)
    throw InputError(view.photo, "",
                     "is " + size_text(image.width, image.height) + " pixels, which does not fit its camera any more");
  return {std::move(image), read_whole_exclusion(view, std::move(transparent))};
}

/// The same of a scene with bands, whose picture is made of the samples. \param with_samples else they are let go
DecodedPhoto decode_bands(const View& view, const Scene& scene, const PixelRoom& room, bool with_samples) {
  BandPhoto photo = read_band_photo(view, *scene.bands, scene.band_places);
  Image image = composite_of(photo.samples, *scene.bands, photo.linear_light, room);
  DecodedPhoto decoded{std::move(image), std::move(photo.exclusion)};
  if (with_samples) decoded.samples = std::move(photo.samples);
  return decoded;
}

/// Decodes on the calling thread without parallel loops: inside one, this thread could pick up a task that waits for
/// the photo that it is decoding.
Photo decode(const View& view, const Scene& scene, bool with_samples, const std::shared_ptr<SpareMemory>& spare) {
  const PixelRoom room = [&](std::size_t bytes) { return spare->take(bytes); };
  DecodedPhoto photo = scene.bands ? decode_bands(view, scene, room, with_samples) : decode_whole(view, room);
  Image& image = photo.image;
  std::optional<PhotoExclusion>& exclusion = photo.exclusion;
  std::optional<Samples>& samples = photo.samples;
  if (exclusion) paint_over(image, *exclusion);
  if (exclusion && samples) paint_over(*samples, *exclusion);
  const auto replace = [&](Image made) {
    spare->give(image.pixels.release());
    image = std::move(made);
  };
  if (view.reduction != 1) {
    replace(reduce_image(image, view.reduction, room));
    if (samples) samples = reduce_samples(*samples, view.reduction);
  }
  if (is_spherical(view.camera.distortion.model)) {
    replace(continue_around(image, room));
    if (samples) samples = continue_around(*samples);
  }
  exclusion = view.uses_alpha || scene.bands ? fit_to_view(std::move(exclusion), view) : std::nullopt;
  return {new DecodedPhoto(std::move(photo)), [spare](DecodedPhoto* held) {
            spare->give(held->image.pixels.release());
            delete held;
          }};
}

}  // namespace

struct PhotoCache::State {
  State(const Scene& of, std::size_t limit, FileHashes* known)
      : scene(of),
        shown_by(photo_of_view(of)),
        kept(of.views.size(), limit),
        hashes(known != nullptr ? *known : own_hashes) {}

  const Scene& scene;
  std::vector<std::uint32_t> shown_by;  ///< per view, see photo_of_view
  KeptPhotos<DecodedPhoto> kept;
  std::shared_ptr<SpareMemory> spare = std::make_shared<SpareMemory>();  ///< photos handed out may outlive the cache
  FileHashes own_hashes;
  FileHashes& hashes;  ///< of files as they were first read

  /// The hash of a file, which must be what it was first, be it when the scene was read.
  WorkKey hash_of(const std::filesystem::path& file) {
    const WorkKey hash = hashes.unchanged(file).hash;
    const auto read = std::ranges::find(scene.circle_photos, file, &HashedPhoto::file);
    if (read != scene.circle_photos.end() && read->hash != hash.bits)
      throw InputError(file, "",
                       "has changed since the image circle of its lens was found in it; begin again with the scene");
    return hash;
  }

  /// Reads something from the view's files, between two looks at them.
  template <typename Read>
  auto read_unchanged(const View& view, const Read& read) {
    const auto look = [&] {
      for (const std::filesystem::path& file : files_of(view)) hash_of(file);
    };
    look();
    auto result = read(view);
    look();
    return result;
  }

  Photo fetch(std::size_t view, bool with_samples = false) {
    const auto decode_view = [&](const View& v) { return decode(v, scene, with_samples, spare); };
    return kept.fetch(
        view, [&] { return read_unchanged(scene.views.at(view), decode_view); },
        [with_samples](const DecodedPhoto& photo) { return photo.samples || !with_samples; });
  }
};

PhotoCache::PhotoCache(const Scene& scene, std::size_t limit_bytes, FileHashes* known)
    : state_(std::make_unique<State>(scene, limit_bytes, known)) {}

PhotoCache::~PhotoCache() = default;

std::shared_ptr<const PhotoExclusion> PhotoCache::exclusion(ViewId view) {
  const std::size_t first = state_->shown_by.at(index(view));
  const View &v = state_->scene.views[index(view)], &decoded_as = state_->scene.views[first];
  if ((v.uses_alpha || state_->scene.bands) && v.mask == decoded_as.mask) {
    const Photo photo = state_->fetch(first);
    return photo->exclusion ? std::shared_ptr<const PhotoExclusion>(photo, &*photo->exclusion) : nullptr;
  }
  if (!v.uses_alpha && v.mask.empty()) return nullptr;  // no file tells
  std::optional<PhotoExclusion> exclusion = state_->read_unchanged(v, read_exclusion);
  return exclusion ? std::make_shared<const PhotoExclusion>(std::move(*exclusion)) : nullptr;
}

std::optional<WorkKey> PhotoCache::key(ViewId view) {
  const View& v = state_->scene.views.at(index(view));
  WorkHash hash;
  hash.add(state_->hash_of(v.photo));
  hash.add(!v.mask.empty());
  if (!v.mask.empty()) hash.add(state_->hash_of(v.mask));
  if (state_->scene.bands) {
    for (const std::filesystem::path& file : v.band_files) hash.add(state_->hash_of(file));
    hash.add(v.band_cameras);
    hash.add(*state_->scene.bands);
    hash.add(state_->scene.band_places);
  }
  hash.add(v.uses_alpha);
  hash.add(v.reduction);
  return hash.key();
}

void PhotoCache::keep_at_most(std::size_t bytes) {
  state_->kept.keep_at_most(bytes);
  state_->spare->free();
}

void PhotoCache::free_buffers() { state_->spare->free(); }

PhotoDecodes PhotoCache::decodes() const { return state_->kept.decodes(); }

std::shared_ptr<const Image> PhotoCache::photo(ViewId view) {
  const Photo photo = state_->fetch(state_->shown_by.at(index(view)));
  return {photo, &photo->image};
}

std::shared_ptr<const Samples> PhotoCache::samples(ViewId view) {
  const Photo photo = state_->fetch(state_->shown_by.at(index(view)), true);
  return {photo, &*photo->samples};
}

}  // namespace gpvc::io
