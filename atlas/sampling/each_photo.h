// One photo after the other, the next ones decoded while one is in use.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/sampling/layers.h"

namespace gpvc::atlas {

/// A view with its photo in memory.
struct ViewPhoto {
  ViewId id;
  const View& view;
  const Image& image;
  const Samples* samples = nullptr;  ///< of the photo; null where there are none
  Layer layer(std::size_t number) const { return layer_of(image, samples, number); }
};

/// Photos that are decoded, each on one thread, while one is in use. Little is done with a photo for its seams, so all
/// threads decode.
inline std::size_t photos_ahead() {
  constexpr int kMost = 8;  // for memory's sake
  return static_cast<std::size_t>(std::clamp(tbb::this_task_arena::max_concurrency(), 1, kMost));
}

/// A source that caches photos still holds the last ones of the previous pass. Passes in alternating directions meet them first.
enum class PhotoOrder { ascending, descending };

/// How many views have work.
template <typename Work>
std::size_t count_wanted(const std::vector<Work>& work) {
  return static_cast<std::size_t>(std::ranges::count_if(work, [](const Work& mine) { return !mine.empty(); }));
}

/// Calls use(view, fetch(view), work[view]) for every view whose work is not empty, in order, on the calling thread. What is
/// needed next is fetched on other threads.
template <typename Work, typename Fetch, typename Use>
void each_fetched(const std::vector<Work>& work, PhotoOrder order, const Fetch& fetch, Use&& use) {
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < work.size(); ++v)
    if (!work[v].empty()) views.push_back(v);
  if (order == PhotoOrder::descending) std::ranges::reverse(views);
  struct Fetched {
    decltype(fetch(ViewId{})) item{};
    std::exception_ptr error{};  // not left to the group, whose end would throw it while another error unwinds
    tbb::task_group work;        // its end waits for the task, which writes to the item, also where use() throws
  };
  std::deque<Fetched> ahead;
  std::size_t begun = 0;
  for (const std::uint32_t view : views) {
    for (; begun < views.size() && ahead.size() <= photos_ahead(); ++begun) {
      Fetched& next = ahead.emplace_back();
      next.work.run([&fetch, &next, id = ViewId{views[begun]}] {
        try {
          next.item = fetch(id);
        } catch (...) {
          next.error = std::current_exception();
        }
      });
    }
    ahead.front().work.wait();
    if (ahead.front().error) std::rethrow_exception(ahead.front().error);
    use(ViewId{view}, ahead.front().item, work[view]);
    ahead.pop_front();
  }
}

}  // namespace gpvc::atlas
