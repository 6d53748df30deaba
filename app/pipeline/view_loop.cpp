#include "app/pipeline/view_loop.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <array>
#include <string>
#include <utility>

#include "io/photos.h"
#include "labeling/background.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {

std::launch launch_policy() {
  using Control = tbb::global_control;
  return Control::active_value(Control::max_allowed_parallelism) == 1 ? std::launch::deferred : std::launch::async;
}

namespace {

/// Decodes the photos from the n-th view on, only to name all that cannot be in one error.
void refuse_damaged(const Run& run, std::size_t n) {
  std::vector<std::exception_ptr> errors;
  for (; n < run.input.views.size(); ++n) try {
      run.observer.progress(n, run.input.views.size());
      run.photos.photo(run.input.views[n]);
    } catch (const InputError&) {
      errors.push_back(std::current_exception());
    }
  io::throw_together(errors, "photos cannot be decoded", {Cure::skip_bad_photos});
}

}  // namespace

std::optional<visibility::DeviceInfo> look_at_views(const Run& run, const ViewSteps& steps) {
  const auto& [input, settings, photos, observer, kept] = run;
  const auto device = visibility::find_device(settings.visibility, settings.device);
  if (device) observer.detail(fmt::format("device: {} ({})", device->info().renderer, device->info().driver));
  visibility::VisibilityStage visibility(input.mesh, settings.visibility, device.get());
  for (const auto& [name, text] :
       {std::pair{"drawing", visibility.drawing_note()}, {"classifier", visibility.classifier_note()}}) {
    observer.note(fmt::format("{}: {}", name, text));
    observer.figure(name, text);
  }
  const std::launch policy = launch_policy();
  std::array<visibility::ViewVisibility, 2> buffers;  // one is filled while the costs of the other are computed
  labeling::BackgroundFinder background;
  std::future<void> costs;  // waited for before what it uses goes, also where the run is cancelled
  std::size_t n = 0;
  try {
    for (; n < input.views.size(); ++n) {
      observer.progress(n, input.views.size());
      const ViewId id = input.views[n];
      if (steps.known && steps.known(id)) {
        if (costs.valid()) costs.get();
        steps.take(id);
        continue;
      }
      auto decoded = std::async(policy, [&source = run.photos, id] { return source.photo(id); });
      visibility::ViewVisibility& visible = buffers[n % 2];
      visibility.classify(input.scene.views[index(id)], id, photos.exclusion(id).get(), visible);
      if (steps.drawn) steps.drawn(id, visible);
      if (costs.valid()) costs.get();
      costs = std::async(policy, [&, &visible = visible, id, photo = decoded.share()] {
        if (run.settings.costs.background == labeling::Background::automatic) {
          const View& view = run.input.scene.views[index(id)];
          if (background.find(view, *photo.get(), run.photos.exclusion(id).get(), visible.ivm, steps.up))
            visibility::exclude(run.input.mesh, view, id, background.found(), visible);
        }
        steps.decoded(id, *photo.get(), visible);
      });
    }
    if (costs.valid()) costs.get();
  } catch (const InputError&) {
    if (costs.valid()) costs.wait();
    refuse_damaged(run, n == 0 ? 0 : n - 1);  // while the costs of a view are computed, the next one is drawn
    throw;
  }
  return device ? std::optional(device->info()) : std::nullopt;
}

}  // namespace gpvc::pipeline
