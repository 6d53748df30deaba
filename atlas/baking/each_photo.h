// One photo after the other, the next decoded while one is in use.
#pragma once

#include <tbb/task_group.h>

#include <memory>
#include <vector>

#include "atlas/atlas.h"

namespace gpvc::atlas {

/// A view with its photo in memory.
struct ViewPhoto {
  ViewId id;
  const View& view;
  const Image& image;
};

/// Calls use(ViewPhoto, work[view]) for every view whose work is not empty, in order, on the calling thread.
template <typename Work, typename Use>
void each_photo(const AtlasInput& input, const std::vector<Work>& work, Use&& use) {
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < work.size(); ++v)
    if (!work[v].empty()) views.push_back(v);
  std::shared_ptr<const Image> photo, next;
  if (!views.empty()) next = input.photos.photo(ViewId{views.front()});
  for (std::size_t k = 0; k < views.size(); ++k) {
    photo = std::move(next);
    tbb::task_group ahead;
    if (k + 1 < views.size()) ahead.run([&, k] { next = input.photos.photo(ViewId{views[k + 1]}); });
    use(ViewPhoto{ViewId{views[k]}, input.scene.views[views[k]], *photo}, work[views[k]]);
    ahead.wait();
  }
}

}  // namespace gpvc::atlas
