// Draws and projects a view, by OpenGL or natively.
#include <stdexcept>

#include "io/clock.h"
#include "visibility/classify/view_tester.h"
#include "visibility/device.h"

namespace gpvc::visibility {

ViewSource::ViewSource(const Mesh& mesh, const SourceOptions& options) : mesh_(mesh), options_(options) {
  if (!options.native) renderer_.emplace(mesh, options.opengl);
  if (options.native && options.ivm) hulls_ = FaceHulls(mesh);
}

PreparedView ViewSource::prepare(const View& view, ViewId id, const io::PhotoExclusion* excluded,
                                 ViewVisibility& result) {
  const Camera& camera = view.camera;
  const auto pixels = static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
  if (camera.width <= 0 || camera.height <= 0 || pixels > 0xFFFFFFFFU)
    throw GpuError("an image of " + std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                   " pixels cannot be drawn");
  if (excluded != nullptr && (excluded->width != camera.width || excluded->height != camera.height))
    throw std::invalid_argument("the excluded pixels of a view must have the size of its camera");
  result.statistics = {};
  result.ivm.width = camera.width;
  result.ivm.height = camera.height;
  result.ivm.faces.resize(options_.ivm ? pixels : 0);
  if (renderer_ && (options_.ivm || options_.depths)) draw_with_opengl(view, result);
  const auto start = Clock::now();
  if (lens_mask_.camera() != camera) lens_mask_ = PhotoMask(camera);
  mask_ = excluded != nullptr ? PhotoMask(lens_mask_, *excluded) : lens_mask_;
  if (options_.ivm && renderer_) mask_.clear_outside(result.ivm.faces);
  project_vertices(mesh_, camera, view.pose, projected_);
  result.statistics.classify_s = seconds_since(start);
  const PreparedView prepared{mesh_, camera, id, mask_, projected_, result.ivm.faces};
  if (renderer_ || !options_.ivm) {
    scan_.start(mesh_.faces.size());
  } else {
    const auto drawing = Clock::now();
    hulls_.find_beside(camera, view.pose, beside_);
    ivm_.draw(prepared, options_.doubled, beside_, result.ivm.faces, scan_);
    result.statistics.render_s = seconds_since(drawing);
  }
  return prepared;
}

void ViewSource::draw_with_opengl(const View& view, ViewVisibility& result) {
  const IvmRenderer::Times times = renderer_->render(
      view.camera, view.pose, {options_.ivm ? &result.ivm.faces : nullptr, options_.depths ? &depths_ : nullptr});
  result.statistics.upload_s = times.upload_s;
  result.statistics.render_s = times.render_s;
  result.statistics.readback_s = times.readback_s;
}

}  // namespace gpvc::visibility
