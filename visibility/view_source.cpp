#include <chrono>

#include "visibility/view_tester.h"

namespace gpvc {

ViewSource::ViewSource(const Mesh& mesh, const VisibilityOptions&) : mesh_(mesh), renderer_(mesh) {}

ClassifyView ViewSource::prepare(const View& view, ViewId id, ViewVisibility& result) {
  const auto pixels =
      static_cast<std::uint64_t>(view.camera.width) * static_cast<std::uint64_t>(view.camera.height);
  if (view.camera.width <= 0 || view.camera.height <= 0 || pixels > 0xFFFFFFFFU)
    throw GpuError("an image of " + std::to_string(view.camera.width) + " x " +
                   std::to_string(view.camera.height) + " pixels cannot be drawn");
  result.statistics = {};
  result.ivm.width = view.camera.width;
  result.ivm.height = view.camera.height;
  const IvmRenderer::Times times = renderer_.render(view.camera, view.pose, result.ivm.faces);
  result.statistics.render_s = times.render_s;
  result.statistics.readback_s = times.readback_s;
  const auto start = std::chrono::steady_clock::now();
  if (mask_.camera() != view.camera) mask_ = PhotoMask(view.camera);
  mask_.clear_outside(result.ivm.faces);
  project_vertices(mesh_, view.camera, view.pose, projected_);
  result.statistics.classify_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {mesh_, view.camera, id, mask_, projected_, result.ivm.faces, projection_rounding(view.camera)};
}

}  // namespace gpvc
