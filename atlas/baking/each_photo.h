// One photo after the other, the next decoded while one is in use.
#pragma once

#include <tbb/task_group.h>

#include <memory>
#include <span>

#include "atlas/atlas.h"

namespace gpvc::atlas {

/// A view with its photo in memory.
struct ViewPhoto {
  ViewId id;
  const View& view;
  const Image& image;
};

/// Calls use(ViewPhoto) for every view of `views`, in order, on the calling thread.
template <typename Use>
void each_photo(const AtlasInput& input, std::span<const std::uint32_t> views, Use&& use) {
  std::shared_ptr<const Image> photo, next;
  if (!views.empty()) next = input.photos.photo(ViewId{views.front()});
  for (std::size_t k = 0; k < views.size(); ++k) {
    photo = std::move(next);
    tbb::task_group ahead;
    if (k + 1 < views.size()) ahead.run([&, k] { next = input.photos.photo(ViewId{views[k + 1]}); });
    use(ViewPhoto{ViewId{views[k]}, input.scene.views[views[k]], *photo});
    ahead.wait();
  }
}

}  // namespace gpvc::atlas
