// One photo after the other, the next decoded while one is in use.
#pragma once

#include <tbb/task_group.h>

#include <memory>
#include <span>

#include "io/photos.h"

namespace gpvc::atlas {

/// Calls use(view, photo) for every view of `views`, in order, on the calling thread.
template <typename Use>
void each_photo(io::PhotoSource& photos, std::span<const std::uint32_t> views, Use&& use) {
  std::shared_ptr<const Image> photo, next;
  if (!views.empty()) next = photos.photo(ViewId{views.front()});
  for (std::size_t k = 0; k < views.size(); ++k) {
    photo = std::move(next);
    tbb::task_group ahead;
    if (k + 1 < views.size()) ahead.run([&, k] { next = photos.photo(ViewId{views[k + 1]}); });
    use(views[k], *photo);
    ahead.wait();
  }
}

}  // namespace gpvc::atlas
