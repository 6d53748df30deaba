
#include "io/clock.h"
#include "visibility/view_tester.h"

namespace gpvc::visibility {
namespace {

IvmRenderer::Options renderer_options(const VisibilityOptions& options, bool staged_reads) {
  IvmRenderer::Options given;
  given.staged_reads = staged_reads;
  given.projection = options.projection;
  if (options.method == Method::shadow_map) given.near = kShadowMapNear;
  return given;
}

}  // namespace

ViewSource::ViewSource(const Mesh& mesh, const VisibilityOptions& options, bool staged_reads, bool opengl)
    : mesh_(mesh), options_(options) {
  if (opengl) renderer_.emplace(mesh, renderer_options(options, staged_reads));
}

ClassifyView ViewSource::prepare(const View& view, ViewId id, ViewVisibility& result) {
  const auto pixels = static_cast<std::uint64_t>(view.camera.width) * static_cast<std::uint64_t>(view.camera.height);
  if (view.camera.width <= 0 || view.camera.height <= 0 || pixels > 0xFFFFFFFFU)
    throw GpuError("an image of " + std::to_string(view.camera.width) + " x " + std::to_string(view.camera.height) +
                   " pixels cannot be drawn");
  result.statistics = {};
  result.ivm.width = view.camera.width;
  result.ivm.height = view.camera.height;
  const bool draw_ivm = options_.draw_ivm || options_.method == Method::gpvc;
  const bool read_depths = options_.method == Method::shadow_map;
  if (!draw_ivm) result.ivm.faces.clear();
  if (!renderer_) {
    result.ivm.faces.resize(pixels);
  } else if (draw_ivm || read_depths) {
    const IvmRenderer::Times times = renderer_->render(
        view.camera, view.pose, {draw_ivm ? &result.ivm.faces : nullptr, read_depths ? &depths_ : nullptr});
    result.statistics.upload_s = times.upload_s;
    result.statistics.render_s = times.render_s;
    result.statistics.readback_s = times.readback_s;
  }
  const auto start = Clock::now();
  if (lens_mask_.camera() != view.camera) lens_mask_ = PhotoMask(view.camera);
  exclusion_ = io::read_exclusion(view);
  mask_ = exclusion_ ? PhotoMask(lens_mask_, *exclusion_) : lens_mask_;
  if (draw_ivm && renderer_) mask_.clear_outside(result.ivm.faces);
  project_vertices(mesh_, view.camera, view.pose, projected_);
  result.statistics.classify_s = seconds_since(start);
  return {mesh_, view.camera, id, mask_, projected_, result.ivm.faces, projection_rounding(view.camera)};
}

}  // namespace gpvc::visibility
