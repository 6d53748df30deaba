// Looks at the views of a run one after another: while one is drawn and classified, its photo is decoded and the costs of the view
// before are computed.
#pragma once

#include <functional>
#include <future>
#include <optional>

#include "../../visibility/device.h"
#include "../../visibility/result.h"
#include "run.h"

namespace gpvc::pipeline {

/// How work beside other work is started: a run that is limited to one thread does it on that.
std::launch launch_policy();

struct ViewSteps {
  /// Of the scene, see up_direction(): the sky is above.
  WorldPoint up{};
  /// True if what the view sees is known: then take() is called instead of the others. On the caller's thread.
  std::function<bool(ViewId)> known = {};
  /// On the caller's thread, while no decoded() runs.
  std::function<void(ViewId)> take = {};
  /// On the caller's thread.
  std::function<void(ViewId, const visibility::ViewVisibility&)> drawn = {};
  /// On another thread, one view at a time, in their order.
  std::function<void(ViewId, const Image& photo, const visibility::ViewVisibility&)> decoded;
};

/// Draws on the device that the settings name, of which it notes what draws and what classifies. Within a stage; reports its
/// progress. Returns the device; nullopt: views were drawn natively. Takes background
/// that photos show away from what views see, but not from what drawn() is given. Throws GpuError, and what the photos throw: one InputError about all that cannot be decoded.
std::optional<visibility::DeviceInfo> look_at_views(const Run& run, const ViewSteps& steps);

}  // namespace gpvc::pipeline
