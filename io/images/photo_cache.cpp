// Photos from files, decoded once while they fit a budget.
#include <algorithm>
#include <functional>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "io/file_hashes.h"
#include "io/images.h"
#include "io/images/image_file.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"
#include "io/photos.h"

namespace gpvc::io {

namespace {

using Photo = std::shared_ptr<const Image>;

/// The memory of the largest photo that was let go, for the next one: the system would have to map and clear new pages
/// for each photo.
class SpareMemory {
 public:
  std::vector<std::uint8_t> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(pixels_, {});
  }
  void give(std::vector<std::uint8_t> pixels) {
    const std::lock_guard lock(mutex_);
    if (pixels.capacity() > pixels_.capacity()) pixels_.swap(pixels);
  }

 private:
  std::mutex mutex_;
  std::vector<std::uint8_t> pixels_;
};

/// Decodes on the calling thread without parallel loops: inside one, this thread could pick up a task that waits for
/// the photo that it is decoding.
Photo decode(const View& view, const std::shared_ptr<SpareMemory>& spare) {
  Image image = read_image(view.photo, spare->take());
  if (image.width / view.reduction != file_width(view.camera) || image.height / view.reduction != view.camera.height)
    throw InputError(view.photo, "",
                     "is " + size_text(image.width, image.height) + " pixels, which does not fit its camera any more");
  if (const std::optional<PhotoExclusion> exclusion = read_whole_exclusion(view)) paint_over(image, *exclusion);
  if (view.reduction != 1) {
    Image reduced = reduce_image(image, view.reduction);
    spare->give(std::move(image.pixels));
    image = std::move(reduced);
  }
  if (is_spherical(view.camera.distortion.model)) {
    Image around = continue_around(image);
    spare->give(std::move(image.pixels));
    image = std::move(around);
  }
  return {new Image(std::move(image)), [spare](Image* photo) {
            spare->give(std::move(photo->pixels));
            delete photo;
          }};
}

/// Per view, the first view that shows the same: the views of a panorama and of a wide fisheye are made from one file.
std::vector<std::size_t> first_of_same_photo(const Scene& scene) {
  std::vector<std::size_t> first(scene.views.size());
  std::map<std::filesystem::path, std::size_t> files;
  for (std::size_t v = 0; v < first.size(); ++v) first[v] = files.emplace(scene.views[v].photo, v).first->second;
  return first;
}

}  // namespace

struct PhotoCache::State {
  State(const Scene& of, std::size_t limit, FileHashes* known)
      : scene(of),
        limit_bytes(limit),
        shown_by(first_of_same_photo(of)),
        hashes(known != nullptr ? *known : own_hashes) {}

  struct Entry {
    std::shared_future<Photo> photo;
    std::size_t bytes = 0;  ///< 0 while it is decoded; such entries are never dropped
    std::list<std::size_t>::iterator age;
  };

  const Scene& scene;
  std::size_t limit_bytes;
  std::vector<std::size_t> shown_by;  ///< per view, see first_of_same_photo
  std::mutex mutex;
  std::unordered_map<std::size_t, Entry> entries;
  std::list<std::size_t> by_age;  ///< least recently used first
  std::size_t bytes = 0;
  std::shared_ptr<SpareMemory> spare = std::make_shared<SpareMemory>();  ///< photos handed out may outlive the cache
  FileHashes own_hashes;
  FileHashes& hashes;  ///< of files as they were first read

  /// Reads something from the view's files, between two looks at them.
  template <typename Read>
  auto read_unchanged(const View& view, const Read& read) {
    const auto look = [&] {
      for (const std::filesystem::path& file : {std::cref(view.photo), std::cref(view.mask)})
        if (!file.empty()) hashes.unchanged(file);
    };
    look();
    auto result = read(view);
    look();
    return result;
  }

  void drop_oldest_beyond_limit() {
    for (auto age = by_age.begin(); bytes > limit_bytes && age != by_age.end();) {
      const auto entry = entries.find(*age);
      if (entry->second.bytes == 0) {
        ++age;
        continue;
      }
      bytes -= entry->second.bytes;
      entries.erase(entry);
      age = by_age.erase(age);
    }
  }
};

PhotoCache::PhotoCache(const Scene& scene, std::size_t limit_bytes, FileHashes* known)
    : state_(std::make_unique<State>(scene, limit_bytes, known)) {}

PhotoCache::~PhotoCache() = default;

std::shared_ptr<const PhotoExclusion> PhotoCache::exclusion(ViewId view) {
  std::optional<PhotoExclusion> exclusion = state_->read_unchanged(state_->scene.views.at(index(view)), read_exclusion);
  return exclusion ? std::make_shared<const PhotoExclusion>(std::move(*exclusion)) : nullptr;
}

std::optional<WorkKey> PhotoCache::key(ViewId view) {
  const View& v = state_->scene.views.at(index(view));
  WorkHash hash;
  hash.add(state_->hashes.unchanged(v.photo).hash);
  hash.add(!v.mask.empty());
  if (!v.mask.empty()) hash.add(state_->hashes.unchanged(v.mask).hash);
  hash.add(v.uses_alpha);
  hash.add(v.reduction);
  return hash.key();
}

void PhotoCache::keep_at_most(std::size_t bytes) {
  const std::lock_guard lock(state_->mutex);
  state_->limit_bytes = bytes;
  state_->drop_oldest_beyond_limit();
  state_->spare->take();
}

std::shared_ptr<const Image> PhotoCache::photo(ViewId view) {
  State& state = *state_;
  const std::size_t key = state.shown_by.at(index(view));
  std::promise<Photo> promise;
  {
    std::unique_lock lock(state.mutex);
    if (const auto found = state.entries.find(key); found != state.entries.end()) {
      state.by_age.splice(state.by_age.end(), state.by_age, found->second.age);
      const std::shared_future<Photo> photo = found->second.photo;
      lock.unlock();
      return photo.get();
    }
    const auto age = state.by_age.insert(state.by_age.end(), key);
    state.entries[key] = {promise.get_future().share(), 0, age};
  }
  try {
    Photo photo =
        state.read_unchanged(state.scene.views.at(key), [&](const View& v) { return decode(v, state.spare); });
    promise.set_value(photo);
    const std::lock_guard lock(state.mutex);
    State::Entry& entry = state.entries.at(key);
    entry.bytes = std::max<std::size_t>(photo->pixels.size(), 1);
    state.bytes += entry.bytes;
    state.drop_oldest_beyond_limit();
    return photo;
  } catch (...) {
    // All waiting threads get the error; the next request tries again.
    {
      const std::lock_guard lock(state.mutex);
      const auto entry = state.entries.find(key);
      state.by_age.erase(entry->second.age);
      state.entries.erase(entry);
    }
    promise.set_exception(std::current_exception());
    throw;
  }
}

}  // namespace gpvc::io
