#include "app/pipeline/photo_profile.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace gpvc::pipeline {

io::ColorProfile profile_of_photos(const Input& input, Observer& observer) {
  const auto view_of = [&](std::size_t n) -> const View& { return input.scene.views[index(input.views[n])]; };
  const auto profile_of = [&](std::size_t n) {
    return view_of(n).photo.empty() ? io::ColorProfile{} : io::read_color_profile(view_of(n).photo);
  };
  const io::ColorProfile first = profile_of(0);
  std::vector<std::uint8_t> differs(input.views.size(), 0);
  tbb::parallel_for(std::size_t{1}, input.views.size(),
                    [&](std::size_t n) { differs[n] = profile_of(n) != first ? 1 : 0; });
  std::vector<std::string> names;
  for (std::size_t n = 0; n < differs.size(); ++n)
    if (differs[n] != 0) names.push_back(view_of(n).name);
  if (!names.empty())
    observer.warning(
        fmt::format("{} of {} photos have another colour profile than {}, {}: {}; colours are not converted",
                    names.size(), differs.size(), view_of(0).name,
                    first.empty() ? "which has none, so the pages have none" : "whose profile the pages keep",
                    readable_list(names, 5)));
  return first;
}

}  // namespace gpvc::pipeline
