#include "visibility/visibility.h"

#include <cmath>

#include "io/clock.h"
#include "visibility/gl/classify_gl.h"
#include "visibility/view_tester.h"

namespace gpvc::visibility {

struct VisibilityStage::State {
  State(GraphicsDevice& graphics, const Mesh& mesh, const VisibilityOptions& options)
      : device(graphics),
        drawing(choose_drawing(graphics.info(), options)),
        source(mesh, options, !graphics.info().software, !drawing.native),
        tester(make_tester(options)) {}

  std::unique_ptr<ViewTester> make_tester(const VisibilityOptions& options) const {
    if ((options.method == Method::shadow_map || options.method == Method::ray) &&
        !(options.epsilon > 0 && std::isfinite(options.epsilon)))
      throw std::invalid_argument("the bias of a visibility test must be above 0 and finite");
    if (options.method == Method::none) return make_no_test(options);
    if (options.method == Method::shadow_map) return make_shadow_map_tester(source, options);
    if (options.method == Method::ray) return make_ray_tester(source, options);
    if (drawing.native) return make_native_gpvc_tester(options);
    GpuLimits limits = gpu_limits();
    limits.staged_reads = !device.info().software;
    return make_gpvc_tester(source, device.info(), options, limits);
  }

  GraphicsDevice& device;
  DrawingChoice drawing;
  ViewSource source;
  std::unique_ptr<ViewTester> tester;
};

VisibilityStage::VisibilityStage(GraphicsDevice& device, const Mesh& mesh, const VisibilityOptions& options) {
  device.make_current();
  state_ = std::make_unique<State>(device, mesh, options);
}

VisibilityStage::~VisibilityStage() { state_->device.make_current(); }

ViewVisibility VisibilityStage::classify(const View& view, ViewId id) {
  ViewVisibility result;
  classify(view, id, result);
  return result;
}

void VisibilityStage::classify(const View& view, ViewId id, ViewVisibility& result) {
  State& state = *state_;
  state.device.make_current();
  const ClassifyView prepared = state.source.prepare(view, id, result);
  VisibilityStatistics& statistics = result.statistics;
  const auto other_s = [&] { return statistics.upload_s + statistics.render_s + statistics.readback_s; };
  const double before = other_s();
  const auto start = Clock::now();
  state.tester->classify(prepared, view, result);
  statistics.classify_s += seconds_since(start) - (other_s() - before);
}

std::string VisibilityStage::classifier_note() const { return state_->tester->note(); }
std::string VisibilityStage::drawing_note() const { return state_->drawing.note; }

}  // namespace gpvc::visibility
